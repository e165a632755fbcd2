"""The times that a host gives: rounding is accepted, gaps and what makes no sense are refused."""

import math
import re

import pytest

from flexsat.fmu.python.communication_points import CommunicationPoints


def points(start=0.0, stop=None):
    made = CommunicationPoints()
    made.set_up(start, stop, None)
    return made


@pytest.mark.parametrize(
    ("setup", "reason"),
    [
        ((math.nan, None, None), "the start time must be finite, got nan s"),
        ((-math.inf, None, None), "the start time must be finite, got -inf s"),
        ((0.0, math.nan, None), "the stop time must be finite and not before the start time 0.0 s, got nan s"),
        ((2.0, 1.0, None), "the stop time must be finite and not before the start time 2.0 s, got 1.0 s"),
        ((0.0, None, math.nan), "the tolerance must be finite and >= 0, got nan"),
        ((0.0, None, -1e-6), "the tolerance must be finite and >= 0, got -1e-06"),
    ],
)
def test_experiments_that_make_no_sense_are_refused(setup, reason):
    with pytest.raises(ValueError, match=f"^{re.escape(reason)}$"):
        CommunicationPoints().set_up(*setup)


def test_rounding_of_times_and_steps_is_accepted_and_does_not_accumulate():
    """A million steps of 1 ms, added up: 1.6e-7 s off at the end. And differences of times at 1e6 s."""
    summed, time, h = points(stop=1000.0), 0.0, 1e-3
    for _ in range(999_990):
        summed.check_step(time, h, h, None)
        summed.advance(time, h)
        time += h
    assert 1e-9 < abs(time - 999.99) < 1e-6
    far = points(1e6)
    for k in range(1000):
        now, then = 1e6 + k * h, 1e6 + (k + 1) * h
        far.check_step(now, then - now, h, None)
        far.advance(now, then - now)


@pytest.mark.parametrize("gap", [-1e-3, -1e-6, 1e-6, 1e-3, 5.0])
def test_gaps_in_time_are_refused(gap):
    made = points(stop=10.0)
    made.advance(0.0, 1e-3)
    with pytest.raises(ValueError, match=r"^a step begins at the present communication point, 0\.001 s$"):
        made.check_step(1e-3 + gap, 1e-3, None, None)


def test_steps_past_the_stop_time_are_refused_and_the_last_one_is_not():
    made = points(stop=0.3)
    for k in range(3):
        made.check_step(k * 0.1, 0.1, None, None)
        made.advance(k * 0.1, 0.1)  # 0.2 + 0.1 is more than 0.3
    with pytest.raises(ValueError, match=r"^a step to 0\.4\d* s passes the stop time 0\.3 s$"):
        made.check_step(0.3, 0.1, None, None)
