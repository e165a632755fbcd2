"""What a metric is taken from: a ramp and a vector whose values are known, times that came or not, counted events."""

import math
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from flexbench.campaign.measure import Measured, metric
from flexbench.campaign.metrics import read_metrics
from flexbench.runs.loop_numbers import LoopNumbers, WindowNumbers
from flexbench.runs.windows import Settling, Window
from flexbench.studies.budget.evaluate import IndexWindows
from lockstep import InputError, Signals

TIME = np.arange(101) / 10.0  # s


def numbers(settled):
    """Return what is known of a loop that slews to 4 s and is steady from 5 s on, and settles then or not."""
    windows = [Window(name="slew 1", spans=((0.0, 4.0),)), Window(name="settled", spans=((5.0, 10.1),))]
    return LoopNumbers(
        configuration="distributed",
        reference="the command",
        slews=(),
        settlings=(Settling(after="slew 1", since=4.0, band=1e-6, time=settled),),
        windows=tuple(WindowNumbers(window=one, rms={}, peak={}) for one in windows),
        end=10.0,
    )


def taken(entry, settled=1.5, found=()):
    """Return a metric of a run with a ramp a.y = t, and a vector a.v of length 5 t."""
    columns = {"a.y": TIME, "a.v[1]": 3.0 * TIME, "a.v[2]": -4.0 * TIME}
    run = Measured(Path("nowhere"))
    vars(run).update(
        signals=Signals(time=TIME, columns=columns, units={}, descriptions={}),
        numbers=numbers(settled),
        record=MappingProxyType({"found": found}),
    )
    return metric(run, read_metrics({"m": entry}, "a.toml")[1]["m"])


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ({"take": "mean"}, 5.0),
        ({"take": "max"}, 10.0),
        ({"take": "min", "window": [2.0, 3.0]}, 2.0),
        ({"take": "last", "window": [2.0, 3.0]}, 3.0),
        ({"take": "p95"}, 9.5),
        ({"take": "p95", "window": [0.0, 1.0]}, 1.0),  # of 11 rows the last: no value between two
        # of t at n = 101 instants k / 10: the sum of squares is n (n - 1) (2 n - 1) / 600
        ({"take": "rms"}, math.sqrt(100.0 * 201.0 / 600.0)),
        ({"take": "max", "window": "slew"}, 3.9),
        ({"take": "min", "window": "steady"}, 5.0),
        ({"take": "max", "window": [20.0, 30.0]}, None),
    ],
)
def test_a_history_is_taken_in_its_window(entry, value):
    assert taken({"of": "a.y", **entry}) == (value if value is None else pytest.approx(value, rel=1e-14))


def test_of_a_vector_the_length_is_taken():
    assert taken({"of": "a.v", "take": "max"}) == pytest.approx(50.0, rel=1e-15)


@pytest.mark.parametrize(("settled", "value"), [(1.5, 1.5), (None, math.inf)])
def test_a_settling_time_that_does_not_come_is_infinite(settled, value):
    assert taken({"of": "settling"}, settled) == value


def test_the_settling_time_is_that_of_the_last_slew():
    run, slews = Measured(Path("nowhere")), numbers(1.5)
    first = Settling(after="slew 0", since=1.0, band=1e-6, time=0.5)
    vars(run).update(numbers=replace(slews, settlings=(first, *slews.settlings)))
    assert metric(run, read_metrics({"m": {"of": "settling"}}, "a.toml")[1]["m"]) == 1.5


def test_an_observation_is_at_least_as_long_as_the_window_it_holds():
    def times(**given):
        source = read_metrics({"m": {"of": "budget", "index": "RPE", **given}}, "a.toml")[1]["m"]
        return source.windows.window, source.windows.observation

    usual = IndexWindows().observation
    assert times(window=0.5 * usual) == (0.5 * usual, usual)
    assert times(window=2.0 * usual) == (2.0 * usual, 2.0 * usual)


@pytest.mark.parametrize("take", ["p0", "p100", "p-5", "95", "median"])
def test_what_is_no_percentile_is_refused(take):
    with pytest.raises(InputError, match=f"take = '{take}': must be rms, mean, max, min, last, or a percentile"):
        read_metrics({"m": {"of": "a.y", "take": take}}, "a.toml")


SATURATION = {"event": "torque-saturation", "count": 3, "seconds": 0.4}
WHEEL = {"event": "speed-band-left", "count": 1, "seconds": 2.0}


@pytest.mark.parametrize(
    ("entry", "found", "value"),
    [
        ({"event": "torque-saturation", "take": "count"}, (SATURATION, WHEEL, SATURATION), 6.0),
        ({"event": "torque-saturation", "take": "seconds"}, (SATURATION, WHEEL), 0.4),
        ({"event": "limit-cycle", "take": "count"}, (SATURATION, WHEEL), 0.0),
    ],
)
def test_events_are_counted(entry, found, value):
    assert taken({"of": "event", **entry}, found=found) == value


@pytest.mark.parametrize(
    ("found", "value"),
    [
        ((), 0.0),
        ((SATURATION, WHEEL), 0.0),
        ((SATURATION | {"until_the_end": True},), 1.0),
        ((WHEEL | {"until_the_end": True},), 0.0),
        ((WHEEL, {"event": "limit-cycle", "count": 1, "seconds": 1.0}), 1.0),
        (({"event": "divergence", "count": 1, "seconds": 1.0},), 1.0),
    ],
)
def test_a_loop_is_lost_by_a_limit_cycle_divergence_or_saturation_to_the_end(found, value):
    assert taken({"of": "lost"}, found=found) == value
