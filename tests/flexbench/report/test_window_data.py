"""Windows with every row: where they are, what they hold, and that they keep to their bytes."""

import base64
from itertools import pairwise

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.report.history_data import History
from flexbench.report.window_data import MOST_WINDOWS, FullRate, full_rate_data, windows_about

TIME = np.arange(60_001) * 0.005


def mark(time, text="slew", kind="slew"):
    return {"time": time, "text": text, "kind": kind}


def history(name, values):
    return History(name=name, group=name, element="", unit="m", description="", values=values)


def test_windows_lie_about_slews_and_faults_and_at_the_end():
    marks = [mark(5.0), mark(106.0, "end"), mark(40.0, "wheel 3 stuck", "fault"), mark(106.5, "torque", "saturation")]

    found = windows_about(marks, TIME)

    assert [(one.name, one.begin, one.end) for one in found] == [
        ("slew begins", 4.5, 6.5), ("wheel 3 stuck", 39.5, 41.5), ("slew ends", 105.5, 107.5),
        ("end of the run", 298.0, 300.0),
    ]  # fmt: skip  # the saturation is inside another


def test_windows_are_few_and_inside_the_record():
    many = windows_about([mark(3.0 * k, f"event {k}", "saturation") for k in range(120)] + [mark(0.1)], TIME)

    assert len(many) == MOST_WINDOWS
    assert (many[0].name, many[0].begin) == ("slew begins", 0.0)  # before other events, and cut at the start
    assert all(a.end < b.begin for a, b in pairwise(many))
    assert many[-1].end == 300.0


def test_every_row_of_the_first_histories_is_kept_within_the_bytes():
    values = np.random.default_rng(4).normal(size=(3, len(TIME)))
    histories = [history("a", values[0]), history("still", np.ones(len(TIME))), history("b", values[1]),
                 history("c", values[2])]  # fmt: skip
    windows = [FullRate(name="one", begin=4.5, end=6.5), FullRate(name="two", begin=298.0, end=300.0)]

    data = full_rate_data(TIME, histories, windows, budget=2 * 4 * 802)

    assert list(data["data"]) == ["a", "b"]  # a constant needs none
    rows = np.concatenate([np.arange(900, 1301), np.arange(59_600, 60_001)])
    for k, name in enumerate(("a", "b")):
        read = np.frombuffer(base64.b64decode(data["data"][name]), dtype="<f4")
        assert_array_equal(read, values[k][rows].astype(np.float32))
    assert [(one["begin"], one["time"]["count"], one["time"]["stride"]) for one in data["windows"]] == [
        (4.5, 401, 1), (298.0, 401, 1),
    ]  # fmt: skip
    assert full_rate_data(TIME, histories, windows, budget=100)["windows"] == []


def test_a_window_begins_and_ends_with_rows():
    between = [FullRate(name="between rows", begin=4.5012, end=6.4987),
               FullRate(name="rounded", begin=298.0 + 1e-12, end=300.0)]  # fmt: skip

    data = full_rate_data(TIME, [history("a", TIME)], between, budget=10_000)

    found = [(one["begin"], one["end"], one["time"]["count"]) for one in data["windows"]]
    assert_allclose(found, [(4.505, 6.495, 399), (298.0, 300.0, 401)], rtol=1e-12)
