"""The equivalence gate for three spacecraft that are not the paper's: native FMUs against the steppers in Python.

A pyramid of equal wheels on an aperture; wheels of three kinds between two arrays, with all that a wheel and a sensor
can have; five wheels, one of them on an array that turns.
"""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from flexbench.loop.equivalence import compare_run
from flexbench.loop.scenarios import scalar_overrides, scenario_parameters
from flexbench.loop.spacecraft import design_file, read_file, write_start
from flexbench.loop.systems import write_systems
from flexsat.design.chain import Designs
from flexsat.fmu.build import configuration_parts
from flexsat.fmu.build_native import build_native_configuration
from flexsat.variants import CORRECTED, PUBLISHED
from fmus.turning_array import write_files
from lockstep import load_system, simulate

SECONDS = 0.3  # the controller steps sixty times, the star tracker three times
RATE = (1e-4, -2e-4, 3e-4)  # rad/s: far above what rounding of wheel speeds does, 1e-15
UNEQUAL = """\
name = "unequal"
wheels = [
  { at = "bus", axes = [[1, 0, 1], [-1, 0, 1]] },
  { at = "tower", kind = "small", axes = [[0, -1, -1]] },
  { at = "tip", kind = "light", axes = [[0, 1, -1]] },
]
gyros = [{ at = "bus", axes = ["+x", "+y"] }, { at = "tip", axes = ["+z"] }]
accelerometers = [{ at = "tip", axes = ["+x"] }]
[sites]
tower = { on_bus = [0.1, 0, 0.5] }
tip = { node = "north.tip" }
[bus]
mass = 300
inertia = [60, 70, 80, 3, 0, 0]
[[appendages]]
name = "north"
file = "array.npz"
at = [0, 0.5, 0]
orientation = [0, 0, "90 deg"]
[[appendages]]
name = "south"
file = "array.npz"
at = [0, -0.5, 0]
orientation = [0, 0, "-90 deg"]
[modes]
plant = 7
design = 5
[wheel]
inertia = 0.3
torque_limit = 0.5
[wheel_kinds.small]
inertia = 0.1
torque_limit = "200 mN.m"
full_torque_speed = "800 rpm"
speed_limit = "1500 rpm"
friction_torque = 1e-4
harmonics = [{ order = 2, force = "1e-8 N/rpm2", phase = "90 deg" }, { order = 3.4, torque = "1e-8 N.m/rpm2" }]
[wheel_kinds.light]
inertia = 0.05
torque_limit = 0.1
factor = 0.5
[slew]
gyroscopic = true
[sensor_errors]
gyro_bias = "0.1 deg/h"
gyro_bias_walk = "0.1 deg/h/rth"
gyro_scale_error = 1e-4
gyro_misalignment = "1 arcsec"
low_frequency_error = "1 arcsec"
"""
WEIGHTS = """\
[controller]
mrp = 1e3
rate = 10.0
torque = 10.0
"""  # slow: a loop at its torque limits would enlarge rounding

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="native FMUs need a C compiler")


def described(name, folder):
    """Return the path of a spacecraft's file."""
    path = folder / f"{name}.toml"
    if name == "pyramid":
        write_start(path)
        path.write_text(path.read_text(encoding="utf-8").replace("plant = 60", "plant = 7"), encoding="utf-8")
        return path
    turning = write_files(folder, modes=6)
    text = UNEQUAL if name == "unequal" else turning.read_text(encoding="utf-8")
    path.write_text(text + WEIGHTS, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["pyramid", "unequal", "turning"])
def test_native_fmus_of_other_spacecraft_are_the_python_steppers(tmp_path, name):
    path = described(name, tmp_path)
    designs = design_file(read_file(path), path)
    folder = tmp_path / "fmus"
    build_native_configuration(designs, folder, configuration_parts(designs))
    write_systems(designs, folder / name / "native")
    parameters = scenario_parameters("fine_pointing", seed=3)
    parameters["plant"]["initial.rate"] = RATE
    simulate(
        load_system(folder / name / "native" / "fine_pointing.ssd"),
        tmp_path / "run",
        stop_time=SECONDS,
        overrides=scalar_overrides(parameters),
        record=("outputs:*",),
    )
    found = compare_run(tmp_path / "run", designs, parameters, SECONDS, native=True)
    assert len(found) > 25
    assert [one for one in found if not one.met] == []
    assert any(one.relative > 0.0 for one in found)

    if name == "unequal":  # the gate closes
        inertia = designs.corrected.plant.wheel_inertia * (1.0 + 1e-7)
        off = replace(designs.corrected, plant=replace(designs.corrected.plant, wheel_inertia=inertia))
        others = Designs({CORRECTED: off, PUBLISHED: designs.published})
        noticed = compare_run(tmp_path / "run", others, parameters, SECONDS, native=True)
        assert any(not one.met for one in noticed)
        assert np.max([one.relative for one in noticed]) < 1e-3
