"""What a bundle declares: its ports with types, units and start values, its capabilities, and its files."""

import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace

import pytest
from fmpy.validation import validate_fmu

from fmus.bundle_host import MS, bundled
from fmus.cell.cell_fmu import cell_fmu
from lockstep import Component, System
from lockstep.bundle.ports import Choice
from lockstep.system.system import Feed, SystemInput
from lockstep.system.transformation import Hop
from lockstep.system.units import Unit


def described(path):
    """Return the root of the model description, and the variables by name: element, and element of the type."""
    root = ET.fromstring(zipfile.ZipFile(path).read("modelDescription.xml"))
    return root, {v.get("name"): (v, v[0]) for v in root.iter("ScalarVariable")}


@pytest.fixture(scope="module")
def path(cells, tmp_path_factory):
    """Return the bundle with the ports that it has by itself."""
    return bundled(cells, tmp_path_factory.mktemp("described") / "four.fmu", Choice())


def test_ports_are_the_connectors_and_parameters_those_of_the_components(path):
    root, variables = described(path)
    kinds = {name: one.get("causality") for name, (one, _) in variables.items()}

    assert validate_fmu(str(path)) == []
    assert {n for n, kind in kinds.items() if kind == "input"} == {"push", "order", "number"}
    assert {n for n, kind in kinds.items() if kind == "output"} == {"angle", "reply", "count"}
    parameters = {name for name, kind in kinds.items() if kind == "parameter"}
    assert parameters == {f"{part}.{name}" for part in ("fast", "slow", "body", "arm")
                          for name in ("gain", "trim", "fail_at", "end_at", "nan_at", "fatal_at", "label")}  # fmt: skip
    assert (root.get("modelName"), root.get("fmiVersion")) == ("four cells", "2.0")
    assert root.find("CoSimulation").get("modelIdentifier") == "four_cells"
    assert root.find("DefaultExperiment").attrib == {"startTime": "0.0", "stopTime": "0.04", "stepSize": "0.001"}


def test_start_values_units_and_ranges_are_carried(path):
    root, variables = described(path)

    assert variables["fast.gain"][1].get("start") == "1.5"
    assert variables["arm.gain"][1].get("start") == "0.5"
    assert variables["fast.label"][1].attrib == {"start": "quick"}
    assert variables["slow.trim"][0].get("variability") == "tunable"
    assert variables["slow.trim"][1].attrib == {"unit": "rad", "min": "-1.0", "max": "1.0", "start": "0.25"}
    assert variables["push"][1].attrib == {"unit": "deg", "start": "0.0"}
    assert variables["number"][1].attrib == {"start": "0"}
    assert {u.get("name"): u[0].attrib for u in root.iter("Unit")} == {
        "deg": {"rad": "1", "factor": "0.017453292519943295"},
        "rad": {"rad": "1"},
    }


@pytest.mark.parametrize(("flags", "state", "expected"), [
    ("", True, {}),
    ("", False, {"canGetAndSetFMUstate": "false", "canSerializeFMUstate": "false"}),
    ('canGetAndSetFMUstate="true"', False, {"canSerializeFMUstate": "false"}),
    ('needsExecutionTool="true"', True, {"needsExecutionTool": "true"}),
    ('canBeInstantiatedOnlyOncePerProcess="true"', True, {"canBeInstantiatedOnlyOncePerProcess": "true"}),
])  # fmt: skip
def test_capabilities_are_those_that_every_component_has(tmp_path, flags, state, expected):
    part = Component(name="only", source=cell_fmu(tmp_path, flags=flags, state=state), period=MS)
    root, _ = described(bundled(System(name="one", tick=MS, components=(part,)), tmp_path / "one.fmu"))
    usual = {"needsExecutionTool": "false", "canBeInstantiatedOnlyOncePerProcess": "false",
             "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}  # fmt: skip

    found = root.find("CoSimulation").attrib
    assert {key: found[key] for key in usual} == usual | expected
    assert found["canHandleVariableCommunicationStepSize"] == "false"


def test_a_connector_is_converted_to_the_units_of_all_that_it_feeds(cells, tmp_path):
    from fmus.bundle_host import Host

    unit = Unit(name="rad", exponents=(0,) * 7 + (1,))
    feeds = (Feed(component="arm", input="u[3]", hops=(Hop(),)),
             Feed(component="slow", input="u[3]", hops=(Hop(factor=2.0, offset=1.0),)))  # fmt: skip
    system = replace(cells, ports=cells.ports[3:], inputs=(SystemInput(name="both", unit=unit, feeds=feeds),))
    path = bundled(system, tmp_path / "both.fmu", Choice())
    _, variables = described(path)
    with Host(path, tmp_path / "unpacked") as host:
        host.start(both=0.5)
        host.run(0, 12)
        angle, reply = host.get("angle", "reply")

    degrees = 0.5 / 0.017453292519943295
    assert variables["both"][1].get("unit") == "rad"
    assert angle == pytest.approx(degrees, abs=0.02)  # and the sine of the time
    assert reply == pytest.approx(2.0 * degrees + 1.0, abs=0.02)


def test_outputs_depend_on_the_inputs_that_reach_their_component_in_the_tick(path):
    root, _ = described(path)
    names = [variable.get("name") for variable in root.iter("ScalarVariable")]
    found = {
        names[int(one.get("index")) - 1]: [names[int(k) - 1] for k in one.get("dependencies").split()]
        for one in root.find("ModelStructure/Outputs")
    }

    # slow reads fast in the same tick; arm is continuous
    assert found == {"angle": [], "reply": ["order", "number"], "count": ["number"]}


def test_files_are_what_the_fmus_need_to_run_once_for_components_of_one_fmu(path):
    names = set(zipfile.ZipFile(path).namelist())
    assert names == {
        "modelDescription.xml",
        "binaries/linux64/four_cells.so",
        "documentation/index.html",
        "documentation/licenses/0_fast/license.txt",
        "resources/program.bin",
        "resources/0_fast/modelDescription.xml",
        "resources/0_fast/binaries/linux64/cell.so",
        "resources/0_fast/resources/table.txt",
    }


def test_equal_systems_give_equal_bytes(cells, path, tmp_path):
    again = bundled(cells, tmp_path / "again.fmu", Choice())
    other = bundled(cells, tmp_path / "other.fmu", Choice(), overrides={"arm.gain": 2.0})

    assert again.read_bytes() == path.read_bytes()
    assert described(other)[0].get("guid") != described(path)[0].get("guid")
