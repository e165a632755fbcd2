"""Snapshots of the delivered loop in C, with sensor noise and wheel jitter: branches are bitwise the run."""

import pickle

import numpy as np

import lockstep
from lockstep import simulate

STOP = 0.4  # [s]


def test_branches_of_the_native_loop_are_bitwise_the_run(delivered):
    path = delivered / "distributed" / "native" / "fine_pointing.ssd"
    options = {"stop_time": STOP, "overrides": {"plant.seed": 3, "sensors.seed": 3}, "record_period": 0.001}
    whole = simulate(path, **options).signals
    with lockstep.open(path, **options) as run:
        run.run_until(0.123)
        kept = run.snapshot()
        run.run_until(0.2)
        noise = run["sensors.gyro.rate"]
        run.restore(kept)
        run.step(77)
        np.testing.assert_array_equal(run["sensors.gyro.rate"], noise)
        run.restore(pickle.loads(pickle.dumps(kept)))
        for _ in run:
            pass
    assert np.ptp(whole["plant.wheel.speed"][:, 0]) > 0.0
    assert len(run.signals.time) == 401 - 123  # a pickled snapshot has no rows
    for name in whole:
        np.testing.assert_array_equal(run.signals[name].view(np.int64), whole[name][123:].view(np.int64), name)
