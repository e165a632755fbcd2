"""Lone FMUs run over the experiment that they suggest, with the values of their models at each communication point."""

from dataclasses import replace

import numpy as np
import pytest

from lockstep import read_signals
from lockstep.simulation import simulate
from lockstep.ssp.lone_fmu import lone_fmu
from lockstep.ssp.step_times import Timing


@pytest.fixture
def run_alone(reference_fmu, tmp_path):
    """Return a function that runs a reference FMU of a version alone, in this process, and returns its signals."""

    def run(model, version, stop_time=None, **times):
        system = lone_fmu(reference_fmu(model, version), Timing(**times))
        system = replace(system, components=tuple(replace(c, isolated=False) for c in system.components))
        simulate(system, tmp_path / "run", stop_time=stop_time)
        return read_signals(tmp_path / "run")

    return run


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_decay_falls_by_a_tenth_in_each_step(run_alone, version):
    found = run_alone("dahlquist", version)
    expected = [1.0]  # closed form of the explicit Euler method, with its rounding
    while len(expected) < len(found.time):
        expected.append(expected[-1] - expected[-1] / 10)

    assert len(found.time) >= 100  # 10 s in steps of 0.1 s, as the FMU suggests
    assert np.allclose(found.time, 0.1 * np.arange(len(found.time)), rtol=1e-15)  # a unit in the last place
    assert found["dahlquist.x"].tolist() == expected


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_discrete_output_is_true_at_the_end_of_its_step(run_alone, version):
    """The stair counts its steps: after k of them it stands at k, and at 0 in the beginning."""
    found = run_alone("stair", version, stop_time=1.6, period=200_000_000)

    assert found["stair.counter"].tolist() == list(range(len(found.time)))
    assert found.time[1] == 0.2
