"""Motion on the page: deflections and torques to the precision of their integers."""

import base64
from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from flexbench.report.motion_data import motion_data
from flexbench.runs.flown_design import flown_part, write_flown
from flexbench.runs.run_folder import Run
from flexsat.description.built_in import configuration
from flexsat.spacecraft.flexible import structure_of
from lockstep import Signals

MODES = 198
TIME = np.arange(10_000) * 0.005


def test_motion_data_give_the_recorded_deflections_and_torques(designs, tmp_path):
    config = configuration("distributed")
    shape = structure_of(config).deflection[:, 2]
    modal = np.random.default_rng(5).normal(size=(len(TIME), MODES)) * np.logspace(-4, -7, MODES)
    torque = np.sin(TIME[:, None] + np.arange(33))
    columns = {f"plant.modal.displacement[{k + 1}]": modal[:, k] for k in range(MODES)}
    columns |= {f"controller.wheel.torque[{k + 1}]": torque[:, k] for k in range(33)}
    signals = Signals(time=TIME, columns=columns, units={}, descriptions={})
    run = Run(folder=tmp_path, configuration="distributed", as_published=False, slew=False, seed=1)
    write_flown(tmp_path, flown_part(designs["distributed"]))

    motion = motion_data(signals, run, budget=(2 * MODES + 45) * 1000)

    frames = motion["frames"]
    rows = np.arange(frames) * round(motion["step"] / 0.005)
    assert 900 <= frames <= 1000
    read = np.frombuffer(base64.b64decode(motion["modal"]), dtype="<i2").reshape(frames, MODES) * motion["scale"]
    room = np.abs(shape) @ np.abs(modal).max(axis=0) / 65534.0  # half a step of each mode
    assert np.all(np.abs((read - modal[rows]) @ shape.T) <= room + 1e-15)
    read = np.frombuffer(base64.b64decode(motion["torque"]), dtype="i1").reshape(frames, 33) / 127.0
    assert_allclose(read * motion["largest_torque"], torque[rows], atol=0.5 / 127.0 + 1e-9)
    assert "error" not in motion


def test_a_structure_with_other_modes_does_not_move(designs, tmp_path):
    """Its mode shapes are not known."""
    flown = flown_part(designs["distributed"])
    write_flown(tmp_path, replace(flown, frequency=1.01 * flown.frequency))
    columns = {f"plant.modal.displacement[{k + 1}]": np.zeros(len(TIME)) for k in range(MODES)}
    signals = Signals(time=TIME, columns=columns, units={}, descriptions={})
    run = Run(folder=tmp_path, configuration="distributed", as_published=False, slew=False, seed=1)

    assert motion_data(signals, run, budget=1000) is None
