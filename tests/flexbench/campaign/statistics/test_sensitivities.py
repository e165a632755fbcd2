"""Sobol indices of Ishigami's function in closed form and beside SALib's; rank correlations of normal pairs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from SALib.analyze import sobol as salib

from flexbench.campaign.statistics.sensitivities import rank_correlations, saltelli_points, sobol
from lockstep import InputError

A, B = 7.0, 0.1


def ishigami(unit):
    """Return Ishigami and Homma's function of points in the unit cube."""
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def closed_form():
    """Return the first-order and total indices of that function (Homma and Saltelli, 1996)."""
    interaction = B**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    alone = np.array([0.5 * (1.0 + B * np.pi**4 / 5.0) ** 2, A**2 / 8.0, 0.0])
    variance = alone.sum() + interaction
    return alone / variance, (alone + np.array([interaction, 0.0, interaction])) / variance


def test_indices_of_ishigamis_function_are_those_in_closed_form():
    first, total = closed_form()
    found = sobol(["x1", "x2", "x3"], ishigami(saltelli_points(3, 4096, seed=3)))

    # the error of the estimator at 4096 points, by its bootstrap, is below 0.01
    assert_allclose([one.first for one in found], first, atol=0.015)
    assert_allclose([one.total for one in found], total, atol=0.015)
    assert all(one.first_low <= value <= one.first_high for one, value in zip(found, first, strict=True))
    assert all(one.total_low <= value <= one.total_high for one, value in zip(found, total, strict=True))
    assert all(one.first_high - one.first_low < 0.12 for one in found)


def test_indices_are_those_of_salib():
    base = 256
    values = ishigami(saltelli_points(3, base, seed=1))
    blocks = values.reshape(5, base)
    rows = np.column_stack([blocks[0], blocks[2], blocks[3], blocks[4], blocks[1]]).ravel()  # A, AB, B of each point
    problem = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[0, 1]] * 3}
    independent = salib.analyze(problem, rows, calc_second_order=False, num_resamples=2, seed=1)
    found = sobol(["x1", "x2", "x3"], values)

    # the same estimators; SALib scales by the standard deviation of all blocks, SciPy by that of A and B
    assert_allclose([one.first for one in found], independent["S1"], atol=0.02)
    assert_allclose([one.total for one in found], independent["ST"], atol=0.02)


def test_a_design_that_is_not_whole_is_refused():
    values = ishigami(saltelli_points(3, 8, seed=1))
    with pytest.raises(InputError, match="39 runs of 3 inputs are no Saltelli design"):
        sobol(["a", "b", "c"], values[:-1])
    values[3] = np.nan
    with pytest.raises(InputError, match="1 of 40 runs have no value"):
        sobol(["a", "b", "c"], values)
    with pytest.raises(InputError, match="base 100; must be a power of two, for example 128"):
        saltelli_points(3, 100, seed=1)


def test_rank_correlation_of_a_normal_distribution_and_its_bounds():
    """Spearman's coefficient of a normal pair is 6/pi asin(r/2) (Pearson, 1907)."""
    r, held = 0.6, []
    true = 6.0 / np.pi * np.arcsin(r / 2.0)
    rng = np.random.default_rng(6)
    for _ in range(200):
        x, noise = rng.standard_normal((2, 200))
        y = np.exp(r * x + np.sqrt(1.0 - r**2) * noise)  # ranks do not see the exponential
        inputs = {"still": np.ones(200), "other": rng.standard_normal(200), "x": x}
        first, second = rank_correlations(inputs, y)
        assert (first.input, second.input) == ("x", "other")
        assert first.visible
        held.append(first.low <= true <= first.high)
    assert 0.92 <= np.mean(held) <= 0.98


def test_lost_runs_and_too_few_have_no_rank_correlation():
    x = np.arange(40.0)
    y = -x
    y[::4] = np.inf
    (found,) = rank_correlations({"x": x}, y)
    assert_allclose(found.value, -1.0)
    assert rank_correlations({"x": x[:9]}, x[:9]) == []
    assert rank_correlations({"x": x}, np.ones(40)) == []
