"""A foreign controller replaces the LQG by configuration alone, and the LQG works behind foreign conventions."""

import json
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flexbench.adapt.contracts import contracts_of
from flexbench.adapt.excitation_of_design import excitation_of
from flexbench.adapt.verdict import check_adapter
from flexbench.adapt.verdict_text import describe_verdict
from flexbench.cli.parser import main
from fmus.vendor.vendor3_fmu import ADAPTER3, vendor3_fmu
from fmus.vendor.vendor_fmu import ADAPTER, FOREIGN_ADAPTER, foreign_fmu, vendor_fmu
from lockstep import read_signals
from lockstep.adapter.read import read_adapter

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
SYSTEM = Path("centralised", "fine_pointing.ssd")


@pytest.fixture(scope="module")
def vendor(tmp_path_factory):
    """Return a folder with the controller with units, without units, and as FMI 3.0, and their adapters."""
    folder = tmp_path_factory.mktemp("vendor")
    vendor_fmu(folder)
    vendor_fmu(folder / "bare", units=False)
    vendor3_fmu(folder / "three")
    (folder / "vendor.toml").write_text(ADAPTER)
    (folder / "three" / "vendor.toml").write_text(ADAPTER3)
    return folder


@pytest.fixture
def replaced(flexsat, fmus, tmp_path):
    """Return a function that runs the system with another controller and returns its signals."""

    def run(fmu, adapter, *options, stop=2):
        out = tmp_path / (f"{Path(fmu).parent.name}-{stop}" if fmu else "original")
        given = ("--replace", f"controller={fmu}", "--adapter", adapter) if fmu else ()
        given += ("--seed", "0")  # an initial error of 0.25 arcsec
        done = flexsat("run", fmus / SYSTEM, *given, "--stop-time", stop, "--out", out, *options)
        assert done.returncode == 0, done.stderr
        return read_signals(out), tomllib.loads((out / "run.toml").read_text())

    return run


@pytest.mark.parametrize("variant", ["", "three"], ids=["FMI 2.0", "FMI 3.0"])
def test_a_foreign_controller_holds_the_attitude_with_its_own_step(vendor, replaced, variant):
    tuned = (
        "--set",
        "controller.kp=0.15",
        "--set",
        "controller.kd=0.5",
        "--set",
        "plant.modes=25",
    )  # settles within the test; with 198 modes it would be unstable
    given = (vendor / variant / "vendor.fmu", vendor / variant / "vendor.toml", *tuned, "--native")
    run, manifest = replaced(*given, stop=12)
    error = np.linalg.norm(run["plant.attitude.mrp"], axis=1)
    torque = run["controller.wheel.torque"]

    assert np.max(error[run.time > 10.0]) < 0.25 * error[0]  # without control it stays as it was
    held = torque[:-1]  # recorded every 5 ms, held for 10; the last row is that of the stop time
    assert np.array_equal(held[0::2], held[1::2])
    assert torque.shape[1] == 6
    assert not np.any(run["controller.reference.mrp"])
    component = next(c for c in manifest["component"] if c["name"] == "controller")
    assert (component["period"], component["model"]) == (0.01, "vendor")
    assert component["parameters"] == {"kp": 0.15, "kd": 0.5}
    assert component["adapter"] == str(vendor / variant / "vendor.toml")
    assert component["stands_for"].endswith("controller.fmu")


def test_our_controller_in_foreign_conventions_gives_the_same_run(fmus, tmp_path, replaced, excitation):
    foreign, adapter = tmp_path / "foreign" / "foreign.fmu", tmp_path / "foreign.toml"
    foreign.parent.mkdir()
    foreign_fmu(foreign, fmus / "centralised" / "controller.fmu")
    adapter.write_text(FOREIGN_ADAPTER)
    adapted, _ = replaced(foreign, adapter)
    original, _ = replaced(None, None, "--record", "all")

    limit = 4.4  # N.m; the other three are in rad, rad/s and modal units, all far below 1
    for name, scale in (("attitude.mrp", 1.0), ("rate", 1.0), ("modal.velocity", 1.0), ("wheel.torque", limit)):
        port = f"{'controller' if name == 'wheel.torque' else 'plant'}.{name}"
        assert np.any(original[port])
        # rounding of the conversions, 1e-16 of a reading, times gains up to 2e5 N.m.s
        assert np.max(np.abs(adapted[port] - original[port])) < 1e-12 * scale, port
    assert check_adapter(foreign, read_adapter(adapter), excitation).right


def test_what_does_not_fit_is_refused_in_one_line(vendor, fmus, tmp_path, capsys):
    adapter = tmp_path / "bad.toml"

    def refused(text, *replace):
        adapter.write_text(text)
        given = ("run", fmus / SYSTEM, *replace, "--adapter", adapter, "--out", tmp_path / "none")
        assert main([str(argument) for argument in given]) == 2
        assert not (tmp_path / "none").exists()
        result = capsys.readouterr().err
        assert result.count("\n") == 1
        return result

    given = ("--replace", f"controller={vendor / 'vendor.fmu'}")
    assert "unit = 'degs' is unknown" in refused(ADAPTER.replace('"deg/s"', '"degs"'), *given)
    assert "needs wheel.torque[1..6] of controller; add an [[output]], or [substitutes]" in refused(
        ADAPTER.partition("[[output]]")[0].replace('["StatusWord"]', '["*"]') + "[constants]\nMode = 2\n", *given
    )
    assert "needs --replace COMPONENT=FMU as well" in refused(ADAPTER)
    assert "control: no such component; there are" in refused(ADAPTER, "--replace", "control=x.fmu")


SIGN = ADAPTER.replace('unit = "mN.m"', 'unit = "mN.m"\nsign = -1')
PERMUTED = ADAPTER.replace('unit = "deg/s"', 'unit = "deg/s"\norder = [2, 3, 1]')


@pytest.fixture(scope="module")
def excitation():
    """Return what excites the centralised controller."""
    found = next(c for c in contracts_of("centralised") if c.component == "controller")
    return excitation_of(found)


@pytest.mark.parametrize(
    ("adapter", "fmu", "message"),
    [
        (ADAPTER, "vendor.fmu", "right: the torque opposes each attitude and rate error about its own axis"),
        (ADAPTER, "bare/vendor.fmu", "right: the torque opposes each attitude and rate error about its own axis"),
        (SIGN, "vendor.fmu", "wrong: wrong sign: output 1 (TauCmd[*]): write sign = 1"),
        (
            ADAPTER.replace('"first"', '"last"'),
            "vendor.fmu",
            'wrong: wrong quaternion order: input 1 (q_IB[*]): write scalar = "first"',
        ),
        (
            ADAPTER.replace("inertial-from-body", "body-from-inertial"),
            "vendor.fmu",
            'wrong: inverse rotation: input 1 (q_IB[*]): write direction = "inertial-from-body"',
        ),
        (
            ADAPTER.replace('unit = "deg/s"', ""),
            "bare/vendor.fmu",
            'wrong: missing unit, degrees for radians: input 2 (w_meas[*]): write unit = "deg/s"',
        ),
        (
            ADAPTER.replace('unit = "mN.m"', ""),
            "bare/vendor.fmu",
            'wrong: missing unit, mN.m for N.m: output 1 (TauCmd[*]): write unit = "mN.m"',
        ),
        (PERMUTED, "vendor.fmu", "wrong: permuted or reversed axes of rate: x for z, y for x, z for y"),
        (ADAPTER3, "three/vendor.fmu", "right: the torque opposes each attitude and rate error about its own axis"),
        (
            ADAPTER3.replace('"first"', '"last"'),
            "three/vendor.fmu",
            'wrong: wrong quaternion order: input 1 (q_IB[*]): write scalar = "first"',
        ),
    ],
    ids=[
        "right",
        "undeclared",
        "sign",
        "order",
        "inverse",
        "rate-unit",
        "torque-unit",
        "permuted",
        "right-3",
        "order-3",
    ],
)
def test_a_wrong_convention_is_named(vendor, tmp_path, excitation, adapter, fmu, message):
    (tmp_path / "vendor.toml").write_text(adapter)
    file = tmp_path / "vendor.toml"
    verdict = check_adapter(vendor / fmu, read_adapter(file), excitation)
    printed = describe_verdict(verdict, excitation, vendor / fmu, file)

    assert [line for line in printed if line.startswith(("right", "wrong", "or:"))] == [
        line for line in printed if line.startswith(message)
    ]
    assert any(line.startswith(message) for line in printed), printed
    assert verdict.right == message.startswith("right")


def test_a_controller_that_cannot_be_judged_is_refused_in_one_line(vendor, tmp_path, capsys):
    (tmp_path / "vendor.toml").write_text(ADAPTER)
    given = ["check-adapter", str(vendor / "vendor.fmu"), "--adapter", str(tmp_path / "vendor.toml")]

    assert main([*given, "--like", "plant"]) == 2
    assert "--like plant: only a controller can be excited" in capsys.readouterr().err
    assert main([*given, "--json", str(tmp_path / "found.json")]) == 0
    assert "as controller:centralised" in capsys.readouterr().out  # the variant that the adapter fits
    table = json.loads((tmp_path / "found.json").read_text())["tables"][0]
    own = {(error, about): row["xyz".index(about)] for error, about, *row, _ in table["rows"]}
    assert len(own) == 6
    assert all(share > 0.1 for share in own.values()), own
    (tmp_path / "vendor.toml").write_text(ADAPTER.replace("step = 0.01", "step = 0.005"))
    assert main(given) == 1
    assert "fmi2DoStep returned fmi2Error: the step must be 10 ms" in capsys.readouterr().err


@pytest.mark.parametrize("variant", ["", "three"], ids=["FMI 2.0", "FMI 3.0"])
def test_a_draft_becomes_an_adapter_by_what_it_says_it_could_not_decide(vendor, tmp_path, excitation, capsys, variant):
    path, fmu = tmp_path / "draft.toml", vendor / variant / "vendor.fmu"
    assert main(["adapt", str(fmu), "--like", "controller:centralised", "--out", str(path)]) == 0
    undecided = capsys.readouterr().err
    for doubt in (
        "q_IB[*]: direction",
        "w_meas[*]: port: it has 3 elements, and the port 23",
        "q_ok: true",
        "Mode: no port is like it",
    ):
        assert f"undecided: {doubt}" in undecided
    assert "unit" not in undecided
    text = path.read_text()
    assert "# reference.*: left out, so that errors are counted from the commanded attitude." in text
    for draft, decided in (
        ('direction = "body-from-inertial"', 'direction = "inertial-from-body"'),
        ("true = 1", "true = 3"),
        ('"Mode" = 0', '"Mode" = 2'),
    ):
        assert draft in text
        text = text.replace(draft, decided)
    path.write_text(text)

    assert check_adapter(fmu, read_adapter(path), excitation).right


def test_a_draft_marks_units_that_the_fmu_does_not_declare(vendor, capsys):
    assert main(["adapt", str(vendor / "bare" / "vendor.fmu"), "--like", "controller:centralised"]) == 0

    result = capsys.readouterr()
    assert result.err.count("unit: the FMU declares none; this is that of the port") == 3
    assert 'variable = "TauCmd[*]"\nindex_base = 0\nunit = "N.m"  # UNDECIDED' in result.out
