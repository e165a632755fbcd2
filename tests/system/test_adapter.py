"""A foreign controller takes the place of ours by configuration alone, and ours survives foreign conventions."""

import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from lockstep import read_signals

VENDOR = Path(__file__).parents[1] / "fmus" / "vendor"
sys.path.append(str(VENDOR))
from vendor_fmu import ADAPTER, FOREIGN_ADAPTER, foreign_fmu, vendor_fmu  # noqa: E402

sys.path.remove(str(VENDOR))

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
SYSTEM = Path("centralised", "fine_pointing.ssd")


@pytest.fixture(scope="module")
def vendor(tmp_path_factory):
    """Return a folder with the controller with units, without units, and its adapter."""
    folder = tmp_path_factory.mktemp("vendor")
    vendor_fmu(folder)
    vendor_fmu(folder / "bare", units=False)
    (folder / "vendor.toml").write_text(ADAPTER)
    return folder


@pytest.fixture
def replaced(flexsat, fmus, tmp_path):
    """Return a function that runs the system with another controller and returns its signals."""

    def run(fmu, adapter, *options, stop=2):
        out = tmp_path / (f"{Path(fmu).parent.name}-{stop}" if fmu else "ours")
        given = ("--replace", f"controller={fmu}", "--adapter", adapter) if fmu else ()
        done = flexsat("run", fmus / SYSTEM, *given, "--stop", stop, "--out", out, *options)
        assert done.returncode == 0, done.stderr
        return read_signals(out), tomllib.loads((out / "run.toml").read_text())

    return run


def test_a_foreign_controller_holds_the_attitude_with_its_own_step(vendor, replaced):
    tuned = ("--set", "controller.kp=0.15", "--set", "controller.kd=0.5")  # settles within the test
    run, manifest = replaced(vendor / "vendor.fmu", vendor / "vendor.toml", *tuned, stop=12)
    error = np.linalg.norm(run["plant.attitude.mrp"], axis=1)
    torque = run["controller.wheel.torque"]

    assert np.max(error[run.time > 10.0]) < 0.25 * error[0]  # of 0.25 arcsec; left alone it stays where it began
    assert np.array_equal(torque[0::2], torque[1::2])  # recorded every 5 ms, held for 10
    assert torque.shape[1] == 6
    component = next(c for c in manifest["component"] if c["name"] == "controller")
    assert (component["period"], component["model"]) == (0.01, "vendor")
    assert component["parameters"] == {"kp": 0.15, "kd": 0.5}
    assert component["adapter"] == str(vendor / "vendor.toml")
    assert component["stands_for"].endswith("controller.fmu")


def test_units_of_the_adapter_stand_in_for_those_that_the_fmu_does_not_declare(vendor, replaced):
    told, _ = replaced(vendor / "vendor.fmu", vendor / "vendor.toml", stop=0.2)
    bare, _ = replaced(vendor / "bare" / "vendor.fmu", vendor / "vendor.toml", stop=0.2)

    assert np.any(told["controller.wheel.torque"])
    assert np.array_equal(told["controller.wheel.torque"], bare["controller.wheel.torque"])


def test_our_controller_in_foreign_conventions_gives_the_same_run(fmus, tmp_path, replaced):
    foreign, adapter = tmp_path / "foreign" / "foreign.fmu", tmp_path / "foreign.toml"
    foreign.parent.mkdir()
    foreign_fmu(foreign, fmus / "centralised" / "controller.fmu")
    adapter.write_text(FOREIGN_ADAPTER)
    theirs, _ = replaced(foreign, adapter)
    ours, _ = replaced(None, None, "--record", "all")

    limit = 4.4  # N.m; the other three are in rad, rad/s and modal units, all far below 1
    for name, scale in (("attitude.mrp", 1.0), ("rate", 1.0), ("modal.velocity", 1.0), ("wheel.torque", limit)):
        port = f"{'controller' if name == 'wheel.torque' else 'plant'}.{name}"
        assert np.any(ours[port])
        # rounding of the conversions, 1e-16 of a reading, times gains up to 2e5 N.m.s
        assert np.max(np.abs(theirs[port] - ours[port])) < 1e-12 * scale, port


def test_what_does_not_fit_is_refused_in_one_line(vendor, fmus, flexsat, tmp_path):
    adapter = tmp_path / "bad.toml"

    def refused(text, *options):
        adapter.write_text(text)
        given = options or ("--replace", f"controller={vendor / 'vendor.fmu'}", "--adapter", adapter)
        done = flexsat("run", fmus / SYSTEM, *given, "--out", tmp_path / "none")
        assert done.returncode == 2, done.stderr
        assert done.stderr.count("\n") == 1
        assert not (tmp_path / "none").exists()
        return done.stderr

    assert "unit = 'degs' is unknown" in refused(ADAPTER.replace('"deg/s"', '"degs"'))
    assert "needs wheel.torque[1..6] of controller; add an [[output]], or [substitutes]" in refused(
        ADAPTER.partition("[[output]]")[0].replace('["StatusWord"]', '["*"]') + "[constants]\nMode = 2\n"
    )
    assert "needs --replace COMPONENT=FMU beside it" in refused(ADAPTER, "--adapter", adapter)
