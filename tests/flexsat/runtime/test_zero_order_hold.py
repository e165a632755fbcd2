"""Sampling against closed forms and SciPy's exponential."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from flexsat.runtime import zero_order_hold as module
from flexsat.runtime.zero_order_hold import matrix_exponential, transition, transition_and_half, zero_order_hold


def test_held_undamped_mode_matches_closed_form():
    omega, period = 3.0, 0.2  # [rad/s], [s]: 0.6 rad per sample, far from small-angle
    a = np.array([[0.0, 1.0], [-(omega**2), 0.0]])
    b = np.array([[0.0], [1.0]])
    c, s = np.cos(omega * period), np.sin(omega * period)

    ad, bd = zero_order_hold(a, b, period)

    few_ulp = 1e-14  # the method is exact, so only rounding is allowed
    assert_allclose(ad, [[c, s / omega], [-omega * s, c]], rtol=few_ulp)
    assert_allclose(bd, [[(1.0 - c) / omega**2], [s / omega]], rtol=few_ulp)


def test_exponential_of_nilpotent_and_zero():
    assert_allclose(matrix_exponential(np.zeros((3, 3))), np.eye(3), rtol=0.0)  # nothing to round
    chain = np.diag([4.0, 6.0], k=1)
    exact = [[1.0, 4.0, 12.0], [0.0, 1.0, 6.0], [0.0, 0.0, 1.0]]
    assert_allclose(matrix_exponential(chain), exact, rtol=1e-15)  # the series ends: binary fractions, no rounding


@pytest.mark.parametrize("norm", [1e-8, 0.3, 1.0, 7.0, 50.0])
def test_exponential_of_random_matrices(norm):
    matrix = np.random.default_rng(2).standard_normal((12, 12))
    matrix *= norm / np.linalg.norm(matrix, 1)
    exact = expm(matrix)
    # rounding of the 12-term products, doubled by each squaring, that is times the norm
    assert np.linalg.norm(matrix_exponential(matrix) - exact) < 1e-14 * (1.0 + norm) * np.linalg.norm(exact)


@pytest.mark.parametrize("period", [0.0005, 0.001, 0.005, 0.1])
def test_exponential_of_the_plant(design, period):
    """Frequencies to 500 rad/s in the filter, couplings over ten orders of magnitude."""
    matrix = period * design.model.a
    found, expected = matrix_exponential(matrix), expm(matrix)
    # squarings amplify rounding by the norm: 1e-16 times |A| h, and both err so
    bound = 1e-15 * (1.0 + np.linalg.norm(matrix, 1))
    assert np.linalg.norm(found - expected, 1) < bound * np.linalg.norm(expected, 1)


@pytest.mark.parametrize("exponent", [-0.5, 0.5, 0.4, -1.0, 2.0])
def test_series_is_long_enough_for_rounding_alone(exponent):
    """One number: exp(x), and its integral from 0 to 1, (exp(x) - 1) / x; 1/2 is the largest scaled norm."""
    whole, integral = transition(np.array([[exponent]]), 1.0)
    rounding = 2e-15  # some terms of the series, doubled by at most two squarings; 12 terms would leave 1e-14
    assert_allclose(whole, [[math.exp(exponent)]], rtol=rounding)
    assert_allclose(integral, [[math.expm1(exponent) / exponent]], rtol=rounding)


def test_hold_composes(design):
    """Two halves of a period make one: exact for held inputs."""
    a, b = design.model.a, design.model.b_torque
    whole, whole_input = zero_order_hold(a, b, 0.005)
    half, half_input = zero_order_hold(a, b, 0.0025)
    # rounding, at the scale of each matrix's largest entries
    assert_allclose(half @ half, whole, atol=1e-13 * np.abs(whole).max())
    assert_allclose(half @ half_input + half_input, whole_input, atol=1e-13 * np.abs(whole_input).max())


def test_invalid_arguments_are_refused():
    with pytest.raises(ValueError, match=r"a must be \(3, 3\) to match b \(3, 1\), got \(2, 2\)"):
        zero_order_hold(np.eye(2), np.zeros((3, 1)), 0.1)
    for period in (0.0, -0.1, np.nan):
        with pytest.raises(ValueError, match="period must be > 0 s"):
            zero_order_hold(np.eye(2), np.zeros((2, 1)), period)


@pytest.mark.parametrize("norm", [0.1, 0.4, 0.5, 0.6, 1.0, 37.0])
def test_a_period_and_its_half_have_the_bits_of_each_alone(norm):
    a = np.random.default_rng(5).normal(size=(7, 7))
    period = norm / np.linalg.norm(a, 1)

    together = transition_and_half(a, period)

    for pair, alone in zip(together, (transition(a, period), transition(a, 0.5 * period)), strict=True):
        np.testing.assert_array_equal(pair, alone)


def scattered(sizes, seed=3):
    """Return a matrix of systems that do not act on each other, one of them a chain, their states mixed up."""
    random, total = np.random.default_rng(seed), sum(sizes)
    a, start = np.zeros((total, total)), 0
    for size in sizes:
        block = slice(start, start + size)
        a[block, block] = random.standard_normal((size, size)) / np.sqrt(size)
        start += size
    chain = slice(total - sizes[-1], total)
    a[chain, chain] = np.diag(random.standard_normal(sizes[-1] - 1), k=1)  # acts in one direction
    order = random.permutation(total)
    return a[np.ix_(order, order)]


@pytest.mark.parametrize("sizes", [(module.SMALL + 1, module.SMALL + 8, 1, 2, 9), (2,) * 40 + (5,), (70, 4)])
@pytest.mark.parametrize("period", [0.1, 3.0])
def test_states_that_do_not_act_on_each_other_are_sampled_apart_to_the_same_bits(monkeypatch, sizes, period):
    a = scattered(sizes)

    apart = [*transition(a, period), *(part for pair in transition_and_half(a, period) for part in pair)]

    groups = module._groups(a)
    assert sorted(np.concatenate(groups)) == list(range(len(a)))
    assert 1 < len(groups) <= len(sizes)
    assert max(map(len, groups)) <= max(*sizes, 2 * module.SMALL)
    assert_allclose(apart[0], expm(period * a), atol=1e-12)  # as of random matrices above
    monkeypatch.setattr(module, "SMALL", len(a))  # all together
    together = [*transition(a, period), *(part for pair in transition_and_half(a, period) for part in pair)]
    assert [part.tobytes() for part in apart] == [part.tobytes() for part in together]
