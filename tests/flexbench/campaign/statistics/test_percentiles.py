"""Bounds of percentiles and probabilities cover as often as they claim, and are those of SciPy."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import binom, binomtest, expon, lognorm, norm, quantile_test

from flexbench.campaign.statistics.describe import describe, distribution, distribution_band, worst
from flexbench.campaign.statistics.percentiles import percentile, ranks, runs_for_bound, runs_for_width
from flexbench.campaign.statistics.proportions import proportion, runs_to_show

CAMPAIGNS = 200


@pytest.mark.parametrize(("share", "runs"), [(0.5, 100), (0.5, 1000), (0.95, 500), (0.95, 1000), (0.99, 2000)])
@pytest.mark.parametrize("law", [norm(3.0, 2.0), lognorm(1.0), expon()], ids=["normal", "lognormal", "exponential"])
def test_bounds_of_percentiles_hold_in_92_to_98_of_100_campaigns(share, runs, law):
    samples = np.sort(law.rvs((CAMPAIGNS, runs), random_state=np.random.default_rng(7)), axis=1)
    found = [percentile(one, share) for one in samples]

    covered = sum(one.low <= law.ppf(share) <= one.high for one in found) / CAMPAIGNS
    assert 0.92 <= covered <= 0.98
    estimates = np.array([one.value for one in found])
    # the estimate is as often above the percentile as below: within four standard deviations
    assert abs(np.mean(estimates > law.ppf(share)) - 0.5) < 4.0 * 0.5 / math.sqrt(CAMPAIGNS)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95, 0.9973])
def test_bounds_of_percentiles_are_those_of_scipy(share):
    for runs in (5, 59, 300, 2000):
        values = np.sort(np.random.default_rng(runs).standard_normal(runs))
        one = percentile(values, share)
        low, high = quantile_test(values, q=0.0, p=share).confidence_interval(0.95)
        assert [one.low, one.high] == [-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high]


def test_the_probability_that_the_bounds_hold_is_at_least_that_claimed_and_they_are_no_wider_than_needed():
    for runs in (20, 100, 473, 3000):
        for share in (0.5, 0.9, 0.95):
            low, high = ranks(runs, share)
            if low is None or high is None:
                continue
            assert binom.cdf(low - 1, runs, share) <= 0.025 < binom.cdf(low, runs, share)
            assert binom.sf(high - 1, runs, share) <= 0.025 < binom.sf(high - 2, runs, share)


def test_too_few_runs_have_no_bound_and_the_number_needed_is_exact():
    assert runs_for_bound(0.95) == 72  # 0.95^72 <= 0.025 < 0.95^71
    for share in (0.5, 0.95, 0.99, 0.05):
        least = runs_for_bound(share)
        assert None not in ranks(least, share)
        assert None in ranks(least - 1, share)
    assert percentile(np.arange(71.0), 0.95).high == math.inf


def test_the_runs_for_a_width_reach_it():
    rng = np.random.default_rng(2)
    first = percentile(np.sort(rng.lognormal(0.0, 0.3, 400)), 0.95)
    needed = runs_for_width(first, 0.02)
    widths = [percentile(np.sort(rng.lognormal(0.0, 0.3, needed)), 0.95).half_width for _ in range(20)]
    assert_allclose(np.mean(widths), 0.02, rtol=0.3)  # the width at 400 runs is itself uncertain by a fifth
    assert runs_for_width(percentile(np.arange(10.0), 0.95), 0.02) is None


def test_lost_runs_count_as_the_worst_in_percentiles_and_not_in_the_mean():
    values = np.arange(1.0, 1001.0)
    lost = values.copy()
    lost[::10] = np.nan
    description = describe("error", lost, shares=(0.5, 0.95))

    assert (description.count, description.lost) == (1000, 100)
    assert_allclose(description.mean, np.nanmean(lost))
    assert_allclose(description.deviation, np.nanstd(lost, ddof=1))
    # the median of all is at the rank 500 of the 900 that have a value
    assert_allclose(description.percentiles[0].value, np.sort(lost)[:900][499], atol=1.0)
    assert description.percentiles[1].value == math.inf
    assert describe("margin", lost, worse="low", shares=(0.05,)).percentiles[0].value == -math.inf
    assert worst(lost, 102)[:2] == [0, 10]
    assert worst(lost, 102)[100:] == [999, 998]
    assert worst(np.array([3.0, 1.0, np.nan, 1.0]), 4, "low") == [2, 1, 3, 0]


def test_bounds_of_the_mean_hold_in_92_to_98_of_100_campaigns():
    samples = np.random.default_rng(4).normal(5.0, 2.0, (CAMPAIGNS, 50))
    found = [describe("x", one) for one in samples]
    assert 0.92 <= np.mean([one.mean_low <= 5.0 <= one.mean_high for one in found]) <= 0.98


def test_the_band_of_the_distribution_holds_all_of_it():
    held = []
    for sample in np.random.default_rng(5).standard_normal((CAMPAIGNS, 200)):
        values, share = distribution(sample)
        true = norm.cdf(values)
        band = distribution_band(200)
        held.append(np.all(np.abs(true - share) <= band) and np.all(np.abs(true - share + 1.0 / 200) <= band))
    assert 0.92 <= np.mean(held) <= 1.0  # Massart's constant is an upper bound


@pytest.mark.parametrize(("met", "count"), [(0, 10), (10, 10), (64, 64), (990, 1000), (3, 7)])
def test_bounds_of_a_probability_are_clopper_and_pearsons(met, count):
    found = proportion(met, count)
    # their definition: each bound is the probability at which so many, or so few, become as unlikely as 2.5 %
    for side, bound in (("greater", found.low), ("less", found.high)):
        if 0.0 < bound < 1.0:
            assert_allclose(binomtest(met, count, bound, alternative=side).pvalue, 0.025, rtol=1e-6)
    assert (found.low == 0.0) == (met == 0)
    assert (found.high == 1.0) == (met == count)


def test_bounds_of_a_probability_hold_at_least_as_often_as_claimed():
    for true in (0.9, 0.99):
        met = binom.rvs(300, true, size=CAMPAIGNS, random_state=np.random.default_rng(8))
        found = {int(one): proportion(int(one), 300) for one in set(met)}
        assert np.mean([found[int(one)].low <= true <= found[int(one)].high for one in met]) >= 0.92


def test_runs_to_show_a_probability():
    assert runs_to_show(0, 10, 0.95) == 72  # as the upper bound of that percentile
    assert runs_to_show(0, 100, 0.95) == 100  # shown already
    assert runs_to_show(5, 100, 0.95) is None  # as many fail as may
    needed = runs_to_show(1, 200, 0.99)
    failures = math.ceil(needed / 200)
    assert proportion(needed - failures, needed).low >= 0.99
    assert proportion(needed - 1 - math.ceil((needed - 1) / 200), needed - 1).low < 0.99
    assert [proportion(200, 200).verdict(p) for p in (0.95, 0.999)] == ["shown", "open"]
    assert proportion(150, 200).verdict(0.95) == "not met"
