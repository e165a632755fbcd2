"""A system with an adapter, written as standard SSP, gives the same run; compiled FMUs stand for both sides."""

import io
import subprocess
import sys
import zipfile
from pathlib import Path
from uuid import NAMESPACE_OID, uuid5

import fmpy
import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd
from lxml import etree
from pyssp_standard.ssm import SSM
from pyssp_standard.ssp import SSP
from pyssp_standard.ssv import SSV

from fmus.c_fmu import compile_library, pack_fmu, quoted
from lockstep import Component, Connection, InputError, System, load_system, read_signals, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.adapter.component import with_replacements
from lockstep.ssp.adapted_package import standard_package

TESTS = Path(__file__).parents[2]
SOURCE = TESTS / "bench" / "wide.c"  # y = u / 2 + 1, value references 0 to WIDTH - 1 and on
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
TICK = 1_000_000  # [ns]
UNITS = """<UnitDefinitions><Unit name="rad/s"><BaseUnit rad="1" s="-1"/></Unit>
  <Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit></UnitDefinitions>"""

ADAPTER = """\
step = 0.002
ignore = ["Temperature"]

[[input]]
port = "rate"
variable = "w[*]"
index_base = 0
unit = "deg/s"
order = [2, 3, 1]

[[input]]
port = "target"
variable = "goal[*]"
index_base = 0
unit = "deg/s"
sign = -1
offset = 0.5

[[output]]
port = "torque"
variable = "T[*]"
index_base = 0
unit = "mN.m"
frame = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]

[constants]
gain = 3.0

[substitutes]
health = 0.25
"""


def fmu(folder, name, inputs, outputs):
    """Compile and zip an FMU with these ports: (name, unit)."""
    width = max(len(inputs), len(outputs))
    ports = [(*port, "input", k) for k, port in enumerate(inputs)]
    ports += [(*port, "output", width + k) for k, port in enumerate(outputs)]
    rows = ""
    for port, unit, causality, reference in ports:
        attributes = ' start="0"' if causality == "input" else ""
        attributes += f' unit="{unit}"' if unit else ""
        rows += f'<ScalarVariable name="{port}" valueReference="{reference}" causality="{causality}">'
        rows += f"<Real{attributes}/></ScalarVariable>"
    unknowns = "".join(f'<Unknown index="{len(inputs) + k + 1}"/>' for k in range(len(outputs)))
    library, guid = folder / f"{name}.so", uuid5(NAMESPACE_OID, name)  # libcosim knows an FMU by its GUID
    compile_library(library, [SOURCE], defines=[quoted("GUID", str(guid)), f"WIDTH={width}"])
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?><fmiModelDescription fmiVersion="2.0" modelName="{name}" '
        f'guid="{guid}"><CoSimulation modelIdentifier="{name}"/>{UNITS}<ModelVariables>{rows}</ModelVariables>'
        f"<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
        "</ModelStructure></fmiModelDescription>"
    )
    return pack_fmu(folder / f"{name}.fmu", description, library)


def array(name, unit, base=1):
    """Return three ports."""
    return [(f"{name}[{k + base}]", unit) for k in range(3)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a closed loop, a foreign FMU, and its adapter."""
    folder = tmp_path_factory.mktemp("write")
    body = fmu(folder, "body", [*array("torque", "N.m"), ("health", "")], array("rate", "rad/s"))
    outputs = [*array("torque", "N.m"), ("health", "")]
    original = fmu(folder, "original", [*array("rate", "rad/s"), *array("target", "rad/s")], outputs)
    inputs = [*array("w", "", 0), *array("goal", "", 0), ("gain", "")]
    fmu(folder, "foreign", inputs, [*array("T", "", 0), ("Temperature", "")])
    ends = [("body", f"rate[{k}]", "controller", f"rate[{k}]", 1) for k in (1, 2, 3)]
    ends += [("controller", port, "body", port, 0) for port in ("torque[1]", "torque[2]", "torque[3]", "health")]
    system = System(
        name="loop",
        tick=TICK,
        stop_time=20 * TICK,
        components=(
            Component(name="controller", source=original, period=TICK, kind="sampled", isolated=False,
                      parameters={f"target[{k}]": 0.1 * k for k in (1, 2, 3)}),
            Component(name="body", source=body, period=TICK, kind="sampled", isolated=False),
        ),
        connections=tuple(
            Connection(from_component=a, output=y, to_component=b, input=u, delay=delay, factor=1.0 + 0.5 * delay)
            for a, y, b, u, delay in ends
        ),
        record=("body.*", "controller.torque"),
    )  # fmt: skip
    write_ssd(system, folder / "loop.ssd")
    (folder / "foreign.toml").write_text(ADAPTER)
    return folder


@pytest.fixture(scope="module")
def package(folder):
    """Return the written package."""
    given = ("--replace", f"controller={folder / 'foreign.fmu'}", "--adapter", folder / "foreign.toml")
    command = ["write-ssp", folder / "loop.ssd", *given, "--out", folder / "out" / "loop.ssp"]
    assert main([str(part) for part in command]) == 0
    return folder / "out" / "loop.ssp"


def adapted(folder, text=None):
    """Return the system with the adapter in folder."""
    adapter = folder / "foreign.toml"
    if text is not None:
        adapter = folder / "other.toml"
        adapter.write_text(text)
    return with_replacements(load_system(folder / "loop.ssd"), [f"controller={folder / 'foreign.fmu'}"], [str(adapter)])


def test_package_gives_the_run_of_the_adapter(folder, package, tmp_path):
    simulate(adapted(folder), tmp_path / "adapter")
    simulate(load_system(package), tmp_path / "plain")
    one, two = read_signals(tmp_path / "adapter"), read_signals(tmp_path / "plain")

    assert list(two.columns) == ["controller.T[0]", "controller.T[1]", "controller.T[2]",
                                 "body.rate[1]", "body.rate[2]", "body.rate[3]"]  # fmt: skip
    assert np.ptp(one["body.rate"], axis=0).min() > 0.02
    np.testing.assert_allclose(two["body.rate"], one["body.rate"], rtol=0.0, atol=1e-12)
    expected = 1e3 * np.column_stack([one["controller.torque[2]"], -one["controller.torque[1]"],
                                      one["controller.torque[3]"]])  # fmt: skip
    np.testing.assert_allclose(two["controller.T"], expected, rtol=1e-12)


def test_values_are_in_the_files_of_ports_and_variables(package):
    system = load_system(package)
    controller, body = system.component("controller"), system.component("body")
    degrees = 180.0 / np.pi
    assert controller.period == 2 * TICK
    assert controller.parameters["gain"] == 3.0
    for k in range(3):
        np.testing.assert_allclose(controller.parameters[f"goal[{k}]"], 0.5 - degrees * 0.1 * (k + 1), rtol=1e-15)
    assert body.parameters == {"health": 0.25}
    ways = {(c.output, c.input): (c.factor, c.offset, c.delay, c.convert_units) for c in system.connections}
    assert ways["rate[2]", "w[0]"] == (1.5 * degrees, 0.0, 1, False)
    assert ways["T[1]", "torque[1]"] == (-1e-3, 0.0, 0, False)
    assert len(ways) == 6


def test_package_is_standard_ssp_to_other_readers(package, tmp_path):
    with zipfile.ZipFile(package) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    assert {Path(name).name for name in files} == {
        "SystemStructure.ssd", "body.fmu", "foreign.fmu", "controller_ports.ssv", "controller_ports.ssm",
        "controller_variables.ssv",
    }  # fmt: skip
    schemas = {"ssd": "Description", "ssv": "ParameterValues", "ssm": "ParameterMapping"}
    for name, content in files.items():
        if not name.endswith(".fmu"):
            schema = SCHEMAS / f"SystemStructure{schemas[name[-3:]]}.xsd"
            etree.XMLSchema(etree.parse(schema)).assertValid(etree.fromstring(content))
    with zipfile.ZipFile(package) as archive:
        archive.extractall(tmp_path)
    with SSM(tmp_path / "resources" / "controller_ports.ssm") as mapping:
        mapping.__check_compliance__()
        assert [(e.source, e.target) for e in mapping.mappings] == [
            (f"target[{k + 1}]", f"goal[{k}]") for k in range(3)
        ]
    with SSV(tmp_path / "resources" / "controller_ports.ssv") as values:
        values.__check_compliance__()
        assert [p["name"] for p in values.parameters] == [f"target[{k}]" for k in (1, 2, 3)]
    with SSP(package) as independent:
        assert len(independent.resources) == 5
    read = read_ssd(str(package))
    controller = next(element for element in read.system.elements if element.name == "controller")
    assert [b.source for b in controller.parameterBindings] == [
        "resources/controller_variables.ssv", "resources/controller_ports.ssv"
    ]  # fmt: skip


def test_same_system_gives_the_same_bytes(folder, package):
    assert standard_package(adapted(folder), {})[0] == package.read_bytes()


def test_written_package_can_be_written_again(package, tmp_path):
    again = tmp_path / "again.ssp"
    assert main(["write-ssp", str(package), "--step-size", "controller=0.004", "--out", str(again)]) == 0
    one, two = load_system(package), load_system(again)

    assert two.component("controller").period == 4 * TICK
    assert two.component("controller").parameters == one.component("controller").parameters
    assert two.connections == one.connections
    with zipfile.ZipFile(package) as first, zipfile.ZipFile(again) as second:
        for name in ("resources/body.fmu", "resources/foreign.fmu"):
            assert first.read(name) == second.read(name)


HELD = ADAPTER.replace("order = [2, 3, 1]", "frame = [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]")


def test_entry_without_a_connection_is_listed_and_refused_or_left_out(folder, tmp_path, capsys):
    path, out = tmp_path / "a.toml", tmp_path / "loop.ssp"
    path.write_text(HELD)
    command = ["write-ssp", folder / "loop.ssd", "--replace", f"controller={folder / 'foreign.fmu'}", "--adapter", path,
               "--out", out]  # fmt: skip
    command = [str(part) for part in command]

    assert main(command) == 2
    message = "a.toml: input 1 (w[*]): a rotation that mixes axes: element 1 of the variable is made of 2 of the port"
    assert capsys.readouterr().err.splitlines() == [
        f"not in SSP: {message}",
        f"lockstep: {out}: not written: SSP cannot express 1 entry of an adapter; --partial leaves them out",
    ]
    assert list(tmp_path.iterdir()) == [path]
    assert main([*command, "--partial"]) == 0
    assert capsys.readouterr().err == f"left out: {message}\n"
    assert sorted(c.input for c in load_system(out).connections) == ["torque[1]", "torque[2]", "torque[3]"]
    with zipfile.ZipFile(io.BytesIO(out.read_bytes())) as archive:
        assert archive.testzip() is None


OTHERS = {
    "libcosim": """
import os, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
for _ in range(7):
    assert execution.step()
for name, count in (("controller", 10), ("body", 3)):
    index = execution.slave_index_from_instance_name(name)
    print(*observer.last_real_values(slave_index=index, variable_references=list(range(count))))
sys.stdout.flush()
os._exit(0)  # libcosim frees the FMUs after the interpreter is gone
""",
    "ecos": """
import sys
from ecospy.EcosSimulation import EcosSimulation
with EcosSimulation(step_size=1e-3, ssp_path=sys.argv[1]) as simulation:
    assert simulation.init(parameter_set="initialValues")
    for _ in range(7):
        simulation.step()
    threes = [f"controller::{name}[{k}]" for name in ("w", "goal") for k in range(3)]
    outputs = [f"controller::T[{k}]" for k in range(3)]
    print(*map(simulation.get_real, [*threes, "controller::gain", *outputs]))
    print(*(simulation.get_real(f"body::torque[{k}]") for k in (1, 2, 3)))
    simulation.terminate()
""",
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_masters_apply_transformations_and_values(package, name, require_master):
    require_master(name)
    done = subprocess.run([sys.executable, "-c", OTHERS[name], package], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    controller, body = ([float(x) for x in line.split()] for line in done.stdout.splitlines()[-2:])
    goals, gain, torque = controller[3:6], controller[6], controller[7:]

    np.testing.assert_allclose(goals, 0.5 - 180.0 / np.pi * 0.1 * np.arange(1, 4), rtol=1e-15)  # by the .ssv: no .ssm
    assert gain == 3.0
    np.testing.assert_allclose(body, [-1e-3 * torque[1], 1e-3 * torque[0], 1e-3 * torque[2]], rtol=1e-12)
    assert 50.0 < controller[0] < 150.0  # a rate of about 1 rad/s, 1.5 times, in degrees


@pytest.mark.parametrize(
    ("sources", "message"),
    [
        (["rate=body.rate"], "--source rate: no attitude port"),
        (["rate"], "--source rate: write ARRAY=COMPONENT.ARRAY"),
    ],
)
def test_source_without_an_attitude_port_is_refused_in_one_line(folder, tmp_path, capsys, sources, message):
    given = ["--replace", f"controller={folder / 'foreign.fmu'}", "--adapter", str(folder / "foreign.toml")]
    options = [part for source in sources for part in ("--source", source)]
    command = ["write-ssp", str(folder / "loop.ssd"), *given, *options, "--out", str(tmp_path / "loop.ssp")]
    assert main(command) == 2
    printed = capsys.readouterr().err
    assert message in printed
    assert printed.count("\n") == 1
    with pytest.raises(InputError, match="needs --replace and --adapter"):
        standard_package(load_system(folder / "loop.ssd"), {"rate": ("body", "rate")})


def test_package_must_end_with_ssp(folder, tmp_path, capsys):
    assert main(["write-ssp", str(folder / "loop.ssd"), "--out", str(tmp_path / "loop.zip")]) == 2
    assert "a system package ends with .ssp" in capsys.readouterr().err
