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


def recorded(modal, torque):
    """Return signals of these modes and wheels."""
    columns = {f"plant.modal.displacement[{k + 1}]": modal[:, k] for k in range(MODES)}
    columns |= {f"controller.wheel.torque[{k + 1}]": torque[:, k] for k in range(33)}
    return Signals(time=TIME[: len(modal)], columns=columns, units={}, descriptions={})


def modal_of(motion):
    """Return the modal coordinates of the frames."""
    numbers = np.frombuffer(base64.b64decode(motion["modal"]), dtype="<i2").reshape(motion["frames"], motion["modes"])
    return numbers * motion["scale"]


def test_motion_data_give_every_recorded_row_where_there_is_room(designs, tmp_path):
    config = configuration("distributed")
    shape = structure_of(config).deflection[:, 2]
    modal = np.random.default_rng(5).normal(size=(1000, MODES)) * np.logspace(-4, -7, MODES)
    torque = np.sin(TIME[:1000, None] + np.arange(33))
    run = Run(folder=tmp_path, configuration="distributed", slew=False, seed=1)
    write_flown(tmp_path, flown_part(designs["distributed"]))

    motion = motion_data(recorded(modal, torque), run, budget=(2 * MODES + 45) * 1000)

    assert (motion["frames"], motion["modes"], "band" in motion) == (1000, MODES, False)
    assert_allclose(motion["step"], 0.005, rtol=1e-12)
    room = np.abs(shape) @ np.abs(modal).max(axis=0) / 65534.0  # half a step of each mode
    assert np.all(np.abs((modal_of(motion) - modal) @ shape.T) <= room + 1e-15)
    read = np.frombuffer(base64.b64decode(motion["torque"]), dtype="i1").reshape(1000, 33) / 127.0
    assert_allclose(read * motion["largest_torque"], torque, atol=0.5 / 127.0 + 1e-9)
    assert "error" not in motion


def test_motion_with_fewer_frames_has_no_alias_of_fast_vibration(designs, tmp_path):
    """A mode at .3 Hz vibrates slowly, and at 63 Hz, which every tenth row would show as a vibration of 3 Hz."""
    modal = np.zeros((len(TIME), MODES))
    modal[:, 0] = 2e-6 * np.sin(2.0 * np.pi * 0.3 * TIME) + 1.5e-6 * np.sin(2.0 * np.pi * 63.0 * TIME)
    torque = np.tile(0.2 + 0.1 * np.sin(2.0 * np.pi * 63.0 * TIME)[:, None], 33)
    run = Run(folder=tmp_path, configuration="distributed", slew=False, seed=1)
    write_flown(tmp_path, flown_part(designs["distributed"]))

    frequency = flown_part(designs["distributed"]).frequency / (2.0 * np.pi)
    budget = 1000 * (2 * np.count_nonzero(frequency < 10.0) + 45)

    motion = motion_data(recorded(modal, torque), run, budget)

    stride = round(motion["step"] / 0.005)
    assert (stride, motion["frames"]) == (10, 1000)
    assert_allclose(motion["band"], 10.0)
    assert motion["modes"] == np.count_nonzero(frequency < 10.0)
    slow = 2e-6 * np.sin(2.0 * np.pi * 0.3 * TIME[::stride])
    inner = slice(20, -20)  # the filter reaches ten frames to either side
    assert_allclose(modal_of(motion)[inner, 0], slow[inner], atol=2e-9)  # a thousandth: its ripple
    read = np.frombuffer(base64.b64decode(motion["torque"]), dtype="i1").reshape(-1, 33) / 127.0
    assert_allclose(read[inner] * motion["largest_torque"], 0.2, atol=2e-3)
    assert_allclose(motion["share"], 2.0 / np.hypot(2.0, 1.5), rtol=5e-3)


def test_a_structure_with_other_modes_does_not_move(designs, tmp_path):
    """Its mode shapes are not known."""
    flown = flown_part(designs["distributed"])
    write_flown(tmp_path, replace(flown, frequency=1.01 * flown.frequency))
    columns = {f"plant.modal.displacement[{k + 1}]": np.zeros(len(TIME)) for k in range(MODES)}
    signals = Signals(time=TIME, columns=columns, units={}, descriptions={})
    run = Run(folder=tmp_path, configuration="distributed", slew=False, seed=1)

    assert motion_data(signals, run, budget=1000) is None
