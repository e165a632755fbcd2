"""A foreign controller's adapter, written as standard SSP: the closed loop is that with the adapter."""

import shutil

import numpy as np
import pytest

from fmus.vendor.vendor_fmu import ADAPTER, vendor_fmu
from lockstep import read_signals

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the foreign controller is compiled with gcc")
QUATERNION = ("--source", "star_tracker.mrp=sensors.star_tracker.quaternion")


def test_the_loop_is_that_with_the_adapter(flexsat, fmus, tmp_path):
    adapter, package = tmp_path / "vendor.toml", tmp_path / "vendor.ssp"
    given = ("--replace", f"controller={vendor_fmu(tmp_path, units=False)}", "--adapter", adapter)
    adapter.write_text(ADAPTER)
    system, stop = fmus / "centralised" / "fine_pointing.ssd", ("--stop-time", 0.5)

    refused = flexsat("write-ssp", system, *given, "--out", package)
    assert refused.returncode == 2
    assert "--source star_tracker.mrp=COMPONENT.ARRAY connects it" in refused.stderr
    assert not package.exists()
    written = flexsat("write-ssp", system, *given, *QUATERNION, "--out", package)
    assert (written.returncode, written.stdout) == (0, f"{package}\n"), written.stderr
    runs = {"adapter": (system, *given), "written": (package,)}
    for name, arguments in runs.items():
        done = flexsat("run", *arguments, *stop, "--record", "plant.*", "--out", tmp_path / name)
        assert done.returncode == 0, done.stderr

    one, two = (read_signals(tmp_path / name) for name in runs)
    assert np.ptp(one["plant.wheel.speed"], axis=0).min() > 1e-5  # it does command torques
    for port in ("attitude.mrp", "rate", "modal.velocity", "wheel.speed"):
        largest = np.max(np.abs(one[f"plant.{port}"]))
        # rounding of the conversions; the quaternion is measured instead of computed from the MRP
        assert np.max(np.abs(two[f"plant.{port}"] - one[f"plant.{port}"])) < 1e-12 * largest, port
