"""Histories on the page: every sample or the extremes of intervals, within a budget of bytes."""

import base64

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.report.history_data import (
    FLOAT,
    LEAST_INTERVALS,
    SHARES,
    History,
    extremes,
    histories_within,
    history_data,
    stride_for,
    time_base,
)

TIME = np.arange(10_000) * 0.005


def history(name, values, group=""):
    return History(name=name, group=group or name, element="", unit="m", description="", values=values)


def floats(text):
    return np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float)


ROUNDING = 1e-14  # relative, of a share times a step


@pytest.mark.parametrize("stride", [2, 7, 10_000, 20_000])
def test_every_sample_lies_between_the_extremes_of_its_interval(stride):
    values = np.random.default_rng(1).normal(size=len(TIME)) * 1e-7
    values[4321], values[17] = 3e-5, -2e-5

    low, high = extremes(values, stride).values.T

    owner, room = np.arange(len(values)) // stride, ROUNDING * 5e-5
    assert np.all((low[owner] <= values + room) & (values <= high[owner] + room))
    assert_allclose((low.min(), high.max()), (-2e-5, 3e-5), rtol=ROUNDING)
    exact = np.array([[part.min(), part.max()] for part in np.split(values, range(stride, len(values), stride))])
    assert np.abs(np.column_stack([low, high]) - exact).max() <= 5e-5 / SHARES  # a share of the range


def test_small_values_of_a_norm_keep_their_digits_on_a_logarithmic_axis():
    values = np.abs(np.sin(TIME)) ** 3 + 1e-6
    values[500] = 0.0  # as at the start of a run

    low, high = extremes(values, 5, logarithmic=True).values.T

    owner = np.arange(len(values)) // 5
    assert np.all((low[owner] <= values * (1.0 + ROUNDING)) & (values <= high[owner] * (1.0 + ROUNDING)))
    share = np.log(1e6) / SHARES
    assert_allclose(high, values.reshape(-1, 5).max(axis=1), rtol=1.1 * share)
    assert low[100] == 0.0


def test_short_history_keeps_every_sample():
    values = np.sin(TIME)
    description, data = history_data(history("y", values), stride=1)

    assert description["kind"] == "samples"
    assert_allclose(floats(data), values, rtol=1e-7, atol=1e-9)


def test_constant_history_has_no_data():
    assert history_data(history("y", np.full(5, 2.5)), stride=1) == (
        {"name": "y", "group": "y", "element": "", "unit": "m", "description": "", "constant": 2.5},
        "",
    )


@pytest.mark.parametrize(
    ("rows", "changing", "budget"), [(60_000, 226, 3_800_000), (60_000, 7, 2_000_000), (10, 1, 100)]
)
def test_data_fit_the_budget(rows, changing, budget):
    stride = stride_for(rows, changing, budget)
    size = FLOAT * -(-rows // stride)
    assert size * changing <= budget * 1.01


def test_histories_that_do_not_fit_are_listed():
    histories = [history(f"y[{k}]", np.sin(TIME + k), group="y") for k in range(30)]
    histories += [history(f"z[{k}]", np.sin(TIME + k), group="z") for k in range(30)]
    budget = 30 * FLOAT * LEAST_INTERVALS

    packed = histories_within(TIME, histories, budget)
    fewer = histories_within(TIME, histories, budget // 2)

    assert packed["left_out"] == ["z"]
    assert fewer["left_out"] == ["y (but the first 15 of 30)", "z"]
    assert {one["group"] for one in packed["histories"]} == {"y"}
    assert sum(len(base64.b64decode(text)) for text in packed["data"]) <= 1.05 * budget


def test_times_are_start_and_step_or_a_list():
    assert time_base(TIME, 4) == {
        "count": 2500, "end": pytest.approx(49.995), "stride": 4, "start": 0.0, "step": pytest.approx(0.02),
    }  # fmt: skip
    uneven = np.array([0.0, 0.1, 0.4, 0.5, 2.0])
    base = time_base(uneven, 2)
    assert_array_equal(np.frombuffer(base64.b64decode(base["times"])), [0.0, 0.4, 2.0])
