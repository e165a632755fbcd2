"""Slews are found in references of known shape."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexbench.runs.slews import Slew, slews_of
from lockstep import Signals

INTERVAL = 0.01
TIME = np.arange(6000) * INTERVAL  # 60 s
RAMP, RATE = 2.0, 1e-3  # s, rad/s


def reference(*slews: tuple[float, float], residual: float = 0.05, time: Any = TIME, **left_out: bool) -> Signals:
    """Return a reference about x: trapezoids of rate from a start to an end, each followed by an oscillation."""
    rate, torque = np.zeros(len(time)), np.zeros(len(time))
    for start, end in slews:
        rate += RATE * np.clip(np.minimum((time - start) / RAMP, (end - time) / RAMP), 0.0, 1.0)
        pulses = [(start, start + RAMP, 1.0), (end - RAMP, end, -1.0)]
        for begin, stop, sign in pulses:
            torque[(time > begin - 1e-9) & (time < stop - 1e-9)] = sign
        after = time >= end
        rate[after] += residual * RATE * np.cos(2.0 * np.pi * (time[after] - end) / 2.5)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])
    columns = {f"controller.reference.mrp[{i}]": np.tan(0.25 * angle) * (i == 1) for i in (1, 2, 3)}
    if not left_out.get("rate"):
        columns |= {f"controller.reference.rate[{i}]": rate * (i == 1) for i in (1, 2, 3)}
    if not left_out.get("torque"):
        columns |= {f"controller.reference.torque[{i}]": torque * (i == 1) for i in (1, 2)}
    return Signals(time=time, columns=columns, units={}, descriptions={})


def times(signals: Signals) -> list[tuple[float, float | None]]:
    """Return begin and end of each slew, rounded to the rows."""
    return [(round(slew.start, 6), None if slew.end is None else round(slew.end, 6)) for slew in slews_of(signals)]


def test_a_slew_lasts_from_its_first_torque_to_its_last_and_the_oscillation_afterwards_is_none():
    assert times(reference((5.0, 25.0))) == [(5.0, 25.0)]


def test_a_second_slew_is_one_of_its_own_after_a_long_rest_and_a_short_one():
    assert times(reference((5.0, 20.0), (30.0, 50.0))) == [(5.0, 20.0), (30.0, 50.0)]
    assert times(reference((5.0, 20.0), (22.0, 50.0))) == [(5.0, 20.0), (22.0, 50.0)]


@pytest.mark.parametrize(("first", "last", "expected"), [
    (0.0, 15.0, [(5.0, None)]),  # ends in the coast
    (0.0, 24.0, [(5.0, None)]),  # ends in the second pulse
    (12.0, 40.0, [(12.0, 25.0)]),  # begins in the coast, as after a checkpoint
    (12.0, 20.0, [(12.0, None)]),  # all of it in the coast
    (0.0, 4.0, []),
    (30.0, 60.0, []),
])  # fmt: skip
def test_a_run_may_begin_and_end_in_a_slew(first, last, expected):
    whole = reference((5.0, 25.0))
    rows = (first <= TIME) & (last > TIME)
    part = Signals(time=TIME[rows], columns={k: v[rows] for k, v in whole.columns.items()}, units={}, descriptions={})
    assert times(part) == expected


def test_without_torque_the_rate_shows_the_slew():
    (found,) = slews_of(reference((5.0, 25.0), residual=0.0, torque=True))
    assert found.start == pytest.approx(5.0, abs=0.02 * RAMP)
    assert found.end == pytest.approx(25.0, abs=0.02 * RAMP)


def test_a_reference_that_jumps_is_a_slew_without_a_length():
    columns = {f"controller.reference.mrp[{i}]": np.where(TIME >= 7.0, 0.1 * i, 0.0) for i in (1, 2, 3)}
    columns |= {f"controller.reference.rate[{i}]": np.zeros(len(TIME)) for i in (1, 2, 3)}
    assert slews_of(Signals(time=TIME, columns=columns, units={}, descriptions={})) == (Slew(start=7.0, end=7.0),)


def test_nothing_recorded_and_a_reference_at_rest_are_no_slews():
    assert slews_of(Signals(time=TIME, columns={}, units={}, descriptions={})) == ()
    assert slews_of(reference()) == ()
