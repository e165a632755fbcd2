"""Probabilities of 1e-5 by subset simulation against known ones, with the scatter that it states."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_discrete_lyapunov
from scipy.stats import norm

from flexbench.campaign.statistics.subset_simulation import subset_simulation
from lockstep import InputError

RARE = 1e-5
SEEDS = range(100)


def check(found):
    """Compare estimates of several seeds with the known probability and with the deviation that they state."""
    estimates = np.array([one.probability for one in found])
    stated = np.mean([one.deviation for one in found])
    most = np.mean([one.deviation_most for one in found])
    assert all(one.reached and one.runs <= 3000 for one in found)
    # the mean of as many estimates: within three of its standard deviations
    assert abs(estimates.mean() / RARE - 1.0) < 3.0 * estimates.std() / RARE / math.sqrt(len(found))
    # levels are correlated: the scatter lies between that of independent ones and that of full correlation;
    # a scatter from 100 values is itself uncertain by 1 / sqrt(200), twice that is allowed below
    assert (1.0 - 2.0 / math.sqrt(200.0)) * stated < estimates.std() / RARE < most
    inside = [one.bounds()[0] <= RARE <= one.bounds()[1] for one in found]
    assert np.mean(inside) >= 0.9  # 95 %, less two standard deviations of a share of 100


@pytest.mark.parametrize("dimension", [2, 50])
def test_a_plane_in_standard_normal_space(dimension):
    direction = np.ones(dimension) / math.sqrt(dimension)
    threshold = norm.isf(RARE)
    check([subset_simulation(lambda x: x @ direction, dimension, threshold, seed=seed) for seed in SEEDS])


def test_an_oscillator_under_noise_at_its_end():
    """Its displacement is normal, with the covariance of Lyapunov's equation."""
    damping, step, steps = 0.05, 0.3, 60
    a = np.array([[1.0, step], [-step, 1.0 - 2.0 * damping * step]])
    a[0] += step * a[1] - [0.0, step]  # semi-implicit Euler: stable
    b = np.array([step, 1.0]) * 0.1
    powers = [np.linalg.matrix_power(a, steps - 1 - k) @ b for k in range(steps)]
    gains = np.array(powers)[:, 0]
    stationary = solve_discrete_lyapunov(a, np.outer(b, b))[0, 0]
    assert 0.7 < gains @ gains / stationary < 1.0  # it has nearly settled
    threshold = norm.isf(RARE) * math.sqrt(gains @ gains)
    check([subset_simulation(lambda x: x @ gains, steps, threshold, seed=seed) for seed in SEEDS])


def test_noise_of_a_seed_is_redrawn_or_kept():
    """A coordinate that stands for the seed of noise: its neighbours have nothing in common."""

    def response(x):
        noise = norm.ppf(np.clip((norm.cdf(x[:, 0]) * 1e7) % 1.0, 1e-12, 1.0 - 1e-12))
        return math.sqrt(0.8) * x[:, 1] + math.sqrt(0.2) * noise

    check([subset_simulation(response, 2, norm.isf(RARE), seed=seed, redrawn=[0]) for seed in SEEDS])


def test_every_run_of_the_last_level_shows_the_event_and_runs_are_counted():
    calls = []

    def response(x):
        calls.append(len(x))
        return np.where(x[:, 1] > 3.0, np.nan, x[:, 0])  # lost runs are events: here a probability of 0.00135

    found = subset_simulation(response, 2, 3.0, samples=1000, seed=2)
    true = 1.0 - (1.0 - norm.sf(3.0)) ** 2
    assert abs(math.log(found.probability / true)) < 3.0 * found.deviation
    assert found.runs == sum(calls) == sum(level.runs for level in found.levels)
    assert calls[0] == 1000
    assert set(calls[1:]) == {100}
    assert np.all((found.points[:, 0] > 3.0) | (found.points[:, 1] > 3.0))
    assert_allclose(found.levels[-1].threshold, 3.0)


def test_an_event_that_is_not_rare_takes_one_level_and_one_out_of_reach_says_so():
    (level,) = subset_simulation(lambda x: x[:, 0], 1, 1.0, samples=1000, seed=1).levels
    assert_allclose(level.probability, norm.sf(1.0), atol=0.04)
    assert_allclose(level.deviation, math.sqrt((1.0 - level.probability) / level.probability / 1000))

    out_of_reach = subset_simulation(lambda x: x[:, 0], 1, 40.0, samples=100, most_runs=500, seed=1)
    assert not out_of_reach.reached
    assert out_of_reach.runs <= 500
    assert len(out_of_reach.points) == 0
    flat = subset_simulation(lambda x: np.zeros(len(x)), 1, 1.0, samples=100, most_runs=500, seed=1)
    assert not flat.reached


def test_settings_out_of_range_are_refused():
    for settings, message in (
        ({"samples": 105}, "105 runs a level with share 0.1 are no whole chains; .* for example 100"),
        ({"share": 1.5}, "share 1.5 of 500 runs; must be between 0 and 1"),
        ({"most_runs": 400}, "500 runs a level exceed all 400 runs"),
    ):
        with pytest.raises(InputError, match=message):
            subset_simulation(lambda x: x[:, 0], 1, 1.0, **settings)
