"""Motion on the page: deflections and torques to the precision of their integers."""

import base64
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

from flexbench.report.motion_data import motion_data
from flexbench.runs.run_folder import Run
from flexsat.parameters import configuration
from flexsat.structure.mesh import record_mesh
from flexsat.structure.modes import build_structure
from lockstep import Signals

TIME = np.arange(10_000) * 0.005


def test_motion_data_give_the_recorded_deflections_and_torques():
    config = configuration("distributed")
    shape = build_structure(record_mesh(config.aperture), config.plate).shape[::3]
    modal = np.random.default_rng(5).normal(size=(len(TIME), 25)) * np.logspace(-4, -7, 25)
    torque = np.sin(TIME[:, None] + np.arange(33))
    columns = {f"plant.modal.displacement[{k + 1}]": modal[:, k] for k in range(25)}
    columns |= {f"controller.wheel.torque[{k + 1}]": torque[:, k] for k in range(33)}
    signals = Signals(time=TIME, columns=columns, units={}, descriptions={})
    run = Run(folder=Path(), configuration="distributed", as_published=False, slew=False, seed=1)

    motion = motion_data(signals, run, budget=95 * 1000)

    frames = motion["frames"]
    rows = np.arange(frames) * round(motion["step"] / 0.005)
    assert 900 <= frames <= 1000
    read = np.frombuffer(base64.b64decode(motion["modal"]), dtype="<i2").reshape(frames, 25) * motion["scale"]
    room = np.abs(shape) @ np.abs(modal).max(axis=0) / 65534.0  # half a step of each mode
    assert np.all(np.abs((read - modal[rows]) @ shape.T) <= room + 1e-15)
    read = np.frombuffer(base64.b64decode(motion["torque"]), dtype="i1").reshape(frames, 33) / 127.0
    assert_allclose(read * motion["largest_torque"], torque[rows], atol=0.5 / 127.0 + 1e-9)
    assert "error" not in motion
