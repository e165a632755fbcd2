"""Windows follow slews and faults, fit short runs, and settling is the last entry into a stated band."""

from __future__ import annotations

import numpy as np
import pytest

from flexbench.runs.loop_numbers import LoopNumbers, WindowNumbers
from flexbench.runs.slews import Slew
from flexbench.runs.windows import Window, settling_time, settlings, windows_of

INTERVAL, BAND = 0.1, 1.0
STEP = 1e-6  # s: times of rows are sums of a tenth of a second


def run(duration: float, error=lambda time: 0.0 * time, start: float = 0.0):
    """Return times and errors of a run."""
    time = start + np.arange(round(duration / INTERVAL)) * INTERVAL
    return time, error(time)


def spans(windows) -> dict[str, tuple[float, float]]:
    """Return begin and end of each window by name."""
    return {window.name: (window.spans[0][0], window.spans[-1][1]) for window in windows}


@pytest.mark.parametrize(("duration", "start", "expected"), [
    (300.0, 0.0, 150.0), (400.0, 0.0, 150.0), (200.0, 0.0, 100.0), (2.0, 0.0, 1.0), (100.0, 50.0, 100.0),
])  # fmt: skip
def test_without_a_slew_the_steady_part_begins_at_150_s_or_half_way(duration, start, expected):
    time, error = run(duration, start=start)
    found = spans(windows_of(time, error, (), (), BAND))
    assert found == {"steady part": pytest.approx((expected, start + duration), abs=STEP)}


def test_after_a_slew_the_window_begins_where_the_error_has_settled():
    slews = (Slew(start=5.0, end=105.9),)
    time, error = run(300.0, lambda time: np.where(time < 120.0, 2.0, 0.5))

    assert spans(windows_of(time, error, slews, (), BAND)) == {
        "slew": (5.0, 105.9), "settled": pytest.approx((120.0, 300.0), abs=STEP),
    }  # fmt: skip
    (settling,) = settlings(time, error, slews, (), BAND)
    assert (settling.since, settling.time) == pytest.approx((105.9, 14.1), abs=STEP)


def test_a_run_that_does_not_settle_has_no_settling_time_and_the_second_half_after_the_slew():
    slews = (Slew(start=5.0, end=100.0),)
    time, error = run(200.0, lambda time: 2.0 + 0.0 * time)

    assert spans(windows_of(time, error, slews, (), BAND)) == {
        "slew": (5.0, 100.0), "second half after the slew": pytest.approx((150.0, 200.0), abs=STEP),
    }  # fmt: skip
    assert [one.time for one in settlings(time, error, slews, (), BAND)] == [None]


@pytest.mark.parametrize("slew", [Slew(start=249.3, end=None), Slew(start=249.3, end=352.0)])
def test_a_run_that_ends_in_a_slew_has_no_settling_time(slew):
    """Not 0: nothing has settled yet."""
    time, error = run(252.0)
    assert list(spans(windows_of(time, error, (slew,), (), BAND))) == ["slew"]
    assert settlings(time, error, (slew,), (), BAND) == ()


def test_several_slews_share_a_window_and_the_last_one_counts():
    slews = (Slew(start=5.0, end=20.0), Slew(start=40.0, end=60.0))
    time, error = run(100.0)
    windows = windows_of(time, error, slews, (), BAND)

    assert windows[0] == Window(name="2 slews", spans=((5.0, 20.0), (40.0, 60.0)))
    assert not windows[0].rows(np.array([4.9, 20.0, 30.0, 60.0])).any()
    assert windows[0].rows(np.array([5.0, 19.9, 40.0])).all()
    assert spans(windows)["settled"] == pytest.approx((60.0, 100.0), abs=STEP)
    assert settlings(time, error, slews, (), BAND)[0].after == "the last slew's end"


def test_a_commanded_step_has_a_response_up_to_its_settling():
    slews = (Slew(start=10.0, end=10.0),)
    time, error = run(100.0, lambda time: np.where((time >= 10.0) & (time < 25.0), 3.0, 0.0))

    assert spans(windows_of(time, error, slews, (), BAND)) == {
        "response to the step": pytest.approx((10.0, 25.0), abs=STEP),
        "settled": pytest.approx((25.0, 100.0), abs=STEP),
    }
    assert settlings(time, error, slews, (), BAND)[0].time == pytest.approx(15.0, abs=STEP)


def test_faults_have_windows_before_during_and_after_them():
    time, error = run(100.0, lambda time: np.where((time >= 40.0) & (time < 70.0), 3.0, 0.0))
    faults = [(40.0, 45.0), (50.0, 60.0)]

    assert spans(windows_of(time, error, (), faults, BAND)) == {
        "before the faults": pytest.approx((20.0, 40.0), abs=STEP), "during the faults": (40.0, 60.0),
        "after the faults": pytest.approx((60.0, 100.0), abs=STEP),
    }  # fmt: skip
    (settling,) = settlings(time, error, (), faults, BAND)
    assert (settling.after, settling.time) == ("the last fault's end", pytest.approx(10.0, abs=STEP))


def test_a_fault_without_an_end_lasts_to_the_end_of_the_run():
    time, error = run(10.0)
    assert spans(windows_of(time, error, (), [(4.0, None)], BAND)) == {
        "before the fault": pytest.approx((2.0, 4.0), abs=STEP), "during the fault": pytest.approx((4.0, 10.0)),
    }  # fmt: skip
    assert settlings(time, error, (), [(4.0, None)], BAND) == ()
    assert list(spans(windows_of(time, error, (), [(0.0, None)], BAND))) == ["during the fault"]


@pytest.mark.parametrize(("history", "expected"), [
    ([2, 2, 0, 0, 0], 2.0),  # enters at 2 and stays
    ([2, 0, 2, 0, 0], 3.0),  # the last entry counts
    ([0, 0, 0, 0, 0], 0.0),
    ([1, 1, 1, 1, 1], 0.0),  # the band belongs to it
    ([0, 0, 0, 0, 2], None),
    ([0, 0, 0, 0, np.nan], None),
])  # fmt: skip
def test_settling_is_the_last_entry_into_the_band(history, expected):
    assert settling_time(np.arange(5.0), np.array(history, float), 0.0, BAND) == expected


def test_what_was_before_does_not_count_for_settling():
    assert settling_time(np.arange(5.0), np.array([9.0, 9.0, 0.0, 0.0, 0.0]), 2.0, BAND) == 0.0
    assert settling_time(np.arange(5.0), np.zeros(5), 7.0, BAND) is None


@pytest.mark.parametrize(("end", "error", "last"), [
    (20.0, 0.0, "settled"), (20.0, 3.0, "second half after the slew"), (None, 3.0, None), (50.0, 3.0, None),
])  # fmt: skip
def test_a_run_that_does_not_settle_has_a_steady_window_unless_it_ends_in_the_slew(end, error, last):
    time, errors = run(40.0, lambda time: np.full(len(time), error))
    slews = (Slew(start=5.0, end=end),)
    windows = [WindowNumbers(window=one, rms={}, peak={}) for one in windows_of(time, errors, slews, (), BAND)]
    numbers = LoopNumbers(configuration="centralised", reference="", slews=slews, settlings=(),
                          windows=tuple(windows), end=float(time[-1]))  # fmt: skip
    assert (numbers.steady and numbers.steady.window.name) == last
