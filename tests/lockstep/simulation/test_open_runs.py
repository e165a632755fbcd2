"""Runs that are open side by side in one process, and runs that a component or Ctrl-C ends."""

import re
import signal
import threading

import numpy as np
import pytest

import lockstep
from fmus.vendor.vendor_fmu import vendor_fmu
from lockstep import Component, InputError, System, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule


def test_an_fmu_that_allows_one_instance_is_in_one_open_run(tmp_path):
    part = Component(name="vendor", source=vendor_fmu(tmp_path), period=10_000_000, isolated=False)
    system = System(name="one", tick=10_000_000, stop_time=1_000_000_000, components=(part,))
    refused = ("vendor: the FMU allows one instance per process, and vendor of one, a run that is open, is it already; "
               "run one of them in a process of its own")  # fmt: skip
    with lockstep.open(system) as run:
        with pytest.raises(InputError, match=re.escape(refused)):
            lockstep.open(system)
        with lockstep.open(system.with_isolation("vendor", None)) as other:  # decided by itself
            assert other.system.component("vendor").isolated
            other.step()
        run.step()
    simulate(system)  # as the other one is closed


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_component_ends_the_run(reference_fmu, version):
    """The end comes instead of the 11th step; see test_models.py for whole runs."""
    part = Component(name="stair", source=reference_fmu("stair", version), period=125_000_000, isolated=False)
    with lockstep.open({"stair": part}, stop_time=10.0) as run:
        assert run.ended is None
        assert list(run)[-1] == run.time == 1.25
        assert "asked for the end of the simulation" in run.ended
        for call in (run.step, lambda: run.step(2), lambda: run.run_until(2.0), run.snapshot):
            with pytest.raises(InputError, match=r"the run has ended: stair: .* asked for the end of the simulation"):
                call()
        assert run["stair.counter"] == 10
        assert len(run.signals.time) == 11
    assert run.summary.terminated == run.ended


@pytest.mark.parametrize("tick", ["c", "python"])
def test_after_ctrl_c_between_two_ticks_the_run_goes_on_bit_by_bit(triple, tmp_path, tick):
    """Nothing is saved that is due later."""
    options = {"tick": tick, "record": ["p.y", "b.steps"], "record_period": 0.005}
    before, far = signal.getsignal(signal.SIGINT), 1e5  # [s], which no machine reaches meanwhile
    schedule = CheckpointSchedule(times=[str(far)])
    with lockstep.open(triple, tmp_path / "out", stop_time=far, checkpoints=schedule, **options) as run:
        threading.Timer(0.2, signal.raise_signal, [signal.SIGINT]).start()
        with pytest.raises(KeyboardInterrupt):
            run.run_until(far)
        reached = run.time
        assert 0.0 < reached < far
        run.step(60)
        assert run.time == pytest.approx(reached + 0.06, abs=1e-9)
        with pytest.raises(KeyboardInterrupt):  # outside a step it acts at once
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
    assert not (tmp_path / "out/checkpoints").exists()
    whole = simulate(triple, stop_time=f"{run.time:.3f}", **options)
    for name in whole:
        np.testing.assert_array_equal(run.signals[name], whole[name])
