"""Splitting along time: walks with known probabilities of first passage; equal responses; what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, norm

from flexbench.campaign.statistics.splitting import _between_families, path_of, splitting
from lockstep import InputError

STEPS = 60
REPEATED = 24


class Process:
    """A process whose steps depend on its value and on noise alone."""

    def __init__(self, follow):
        self.follow, self.values, self.runs = follow, {}, 0

    def __call__(self, first, branches):
        found = []
        for number, branch in enumerate(branches, start=first):
            before = [] if branch.parent is None else self.values[branch.parent][: branch.tick]
            noise = np.random.default_rng(branch.seed)
            after = self.follow(before[-1] if before else 0.0, STEPS - branch.tick, noise)
            self.values[number] = before + after
            found.append(path_of(np.arange(branch.tick, STEPS), np.array(after)))
            self.runs += 1
        return found


def walk(value, steps, noise):
    return (value + np.cumsum(2 * noise.integers(0, 2, steps) - 1)).tolist()


def relaxing(value, steps, noise):
    """An Ornstein-Uhlenbeck process, sampled: exact for its step."""
    values = []
    for one in noise.standard_normal(steps).tolist():
        value = 0.9 * value + math.sqrt(1.0 - 0.81) * one
        values.append(value)
    return values


def passage_of_walk(level):
    """Probability that a walk of steps of one reaches a level: reflection principle (level and STEPS even)."""
    ups = (STEPS + level) // 2
    return 2.0 * binom.sf(ups, STEPS, 0.5) + binom.pmf(ups, STEPS, 0.5)


def passage_of_relaxing(level):
    """One minus the probability to stay below in each step, by quadrature: the density is smooth."""
    grid = np.linspace(-8.0, level, 801)
    weight = np.full(801, grid[1] - grid[0])
    weight[[0, -1]] *= 0.5
    deviation = math.sqrt(1.0 - 0.81)
    density = norm.pdf(grid / deviation) / deviation
    kernel = norm.pdf((grid[:, None] - 0.9 * grid) / deviation) / deviation
    for _ in range(STEPS - 1):
        density = kernel @ (weight * density)
    return 1.0 - float(weight @ density)


@pytest.mark.parametrize(
    ("follow", "threshold", "exact"),
    [(walk, 33.5, passage_of_walk(34)), (relaxing, 5.0, passage_of_relaxing(5.0))],
    ids=["walk of steps of one, many equal responses", "Ornstein-Uhlenbeck"],
)
def test_one_in_a_hundred_thousand_without_bias_with_at_most_3000_runs(follow, threshold, exact):
    assert 0.7e-5 < exact < 1.3e-5
    repeated = []
    for seed in range(101, 101 + REPEATED):
        process = Process(follow)
        found = splitting(process, threshold, STEPS - 1, samples=250, seed=seed)
        assert found.reached
        assert found.runs == process.runs == sum(level.runs for level in found.levels) <= 3000
        assert found.responses.min() > threshold
        repeated.append(found)
    estimates = np.array([one.probability for one in repeated]) / exact
    stated = np.array([one.deviation for one in repeated])

    assert estimates.mean() == pytest.approx(1.0, abs=3.5 * estimates.std() / math.sqrt(REPEATED))
    assert estimates.std() < 0.75
    assert 0.5 < np.median(stated) / estimates.std() < 2.0  # known to 15 %, and estimates are skew
    held = [low < exact < high for low, high in (one.bounds() for one in repeated)]
    assert sum(held) >= 22  # of 24; of 300 97 %: tests/bench/splitting.py


def test_an_event_that_is_not_rare_is_counted_and_one_out_of_reach_is_said():
    often = splitting(Process(walk), 1.5, STEPS - 1, samples=400)
    assert often.runs == 400
    assert often.probability == pytest.approx(passage_of_walk(2), abs=0.08)  # four standard deviations
    never = splitting(Process(walk), 59.5, STEPS - 1, samples=20, most_runs=100)
    assert not never.reached
    assert never.runs <= 100
    with pytest.raises(InputError, match="splitting: 1 runs"):
        splitting(Process(walk), 3.0, STEPS - 1, samples=1)


def test_a_run_that_comes_nearest_with_its_last_row_has_no_branch_after_it():
    asked = []

    def simulate(_first, branches):  # noise decides the last row alone
        asked.extend(branch.tick for branch in branches)
        return [path_of(np.arange(b.tick, 3), np.array([0.0, 0.0, b.seed / 2**31])[b.tick :]) for b in branches]

    found = splitting(simulate, 0.9, 2, samples=100)
    assert asked == [0] * 100
    assert found.runs == 100
    assert found.probability == pytest.approx(0.1, abs=0.1)


def test_deviations_between_independent_families_are_known_from_few_runs_too():
    """The mean of the stated variances is the variance: of independent runs, each with a number of descendants."""
    rng = np.random.default_rng(3)
    samples, repeated = 40, 4000
    descendants = rng.exponential(size=(repeated, samples)) * (rng.random((repeated, samples)) < 0.25)
    totals = descendants.sum(axis=1)
    relative = (totals.std() / totals.mean()) ** 2  # 0.175
    counts = np.round(descendants * 100).astype(int)
    stated = [_between_families(np.repeat(np.arange(samples), row), samples) for row in counts[:1000]]
    variances = np.array([deviation**2 for deviation, _ in stated])

    assert np.median(variances) == pytest.approx(relative, rel=0.15)
    families = np.array([effective for _, effective in stated])
    assert ((families >= 1.0) & (families <= np.count_nonzero(counts[:1000], axis=1) + 1e-9)).all()


def test_bounds_of_branches_are_those_of_an_estimate_without_bias_and_none_with_one_family():
    deviation, families = _between_families([1, 1, 2, 2, 3, 3, 4, 4], 100)
    assert families == 4.0
    assert deviation == pytest.approx(math.sqrt((0.25 - 0.01) / 0.75))
    event = splitting(Process(walk), 1.5, STEPS - 1, samples=100)
    given = replace(event, probability=1e-5, deviation=deviation, deviation_most=deviation, families=families)
    low, high = given.bounds()
    middle, quantile = 1e-5 * math.sqrt(1.0 + deviation**2), 2.7764451  # Student's, 4 degrees of freedom
    assert math.sqrt(low * high) == pytest.approx(middle)  # the mean of a lognormal estimate is 1e-5 there
    assert math.log(high / low) == pytest.approx(2.0 * quantile * math.sqrt(math.log1p(deviation**2)))
    one = replace(given, **dict.fromkeys(("deviation", "deviation_most"), _between_families([7, 7, 7], 100)[0]))
    assert one.bounds() == (0.0, 1.0)
