"""Stop rules: their grammar, when they are satisfied, and how often the bounds hold where they stop."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.campaign.statistics.percentiles import percentile
from flexbench.campaign.statistics.sample import MetricRequirement, Sample
from flexbench.campaign.statistics.stop_rule import next_look, parse_rule, states
from lockstep import InputError

REQUIREMENTS = (
    MetricRequirement(name="line of sight", metric="pointing", most=2.0, probability=0.95),
    MetricRequirement(name="bare", metric="pointing", most=2.0),
)


def sample_of(values):
    values = np.asarray(values, dtype=float)
    return Sample(system="loop", numbers=np.arange(1, len(values) + 1), inputs={}, choices={}, units={},
                  metrics={"pointing": values}, causes=[""] * len(values))  # fmt: skip


def rule(text):
    return parse_rule(text, ["pointing", "settling"], REQUIREMENTS)


def test_a_rule_is_read():
    first, second, third = rule("p99.5( pointing ) within 5% and mean(settling) within 2.5 %  and"
                                " requirement(line of sight) decided")  # fmt: skip
    assert (first.what, first.name, first.within) == ("percentile", "pointing", 0.05)
    assert_allclose(first.share, 0.995)
    assert (second.what, second.name, second.within) == ("mean", "settling", 0.025)
    assert (third.what, third.name) == ("requirement", "line of sight")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", r"`nothing` is no condition; accepted: p95\(METRIC\) within 5 %"),
        ("p95(pointing)", r"`p95\(pointing\)` is no condition; accepted"),
        ("p95(pointing) within 5", "is no condition; accepted"),
        ("p95(aim) within 5 %", "no metric `aim`; the campaign has pointing, settling"),
        ("probability(aim) within 5 %", "no requirement `aim`; the campaign has line of sight, bare"),
        ("p100(pointing) within 5 %", "p100; must be above p0 and below p100"),
        ("p95(pointing) within 0 %", "within 0 %; must be above 0"),
        ("p95(pointing) decided", r"write p95\(NAME\) within 5 %"),
        ("requirement(bare) within 5 %", r"write requirement\(NAME\) decided"),
        ("requirement(bare) decided", "requirement `bare` has no probability"),
        ("mean(pointing) within 5 % or mean(settling) within 5 %", "join conditions by `and`"),
        ("mean(pointing) within 5 % and", "`and` after"),
    ],
)
def test_what_is_no_rule_is_refused(text, reason):
    with pytest.raises(InputError, match=reason) as refused:
        rule(text)
    assert "\n" not in str(refused.value)


def looks(most):
    """Return all looks of a campaign of so many runs."""
    found = [next_look(0)]
    while found[-1] < most:
        found.append(min(most, next_look(found[-1])))
    return found


def test_looks_grow_by_a_quarter():
    assert looks(1000)[:4] == [50, 63, 79, 99]
    assert next_look(100_000) == 125_000


def test_a_condition_is_satisfied_where_its_bounds_are_close_enough():
    rng = np.random.default_rng(1)
    values = rng.lognormal(0.0, 0.3, 4000)
    (condition,) = rule("p95(pointing) within 5 %")
    reached = [states([condition], sample_of(values).first(n), ())[0].satisfied for n in looks(4000)]
    widths = [percentile(np.sort(values[:n]), 0.95).half_width for n in looks(4000)]
    assert reached == [width <= 0.05 for width in widths]
    assert (reached[0], reached[-1]) == (False, True)

    early = states([condition], sample_of(values[:64]), ())[0]
    assert (early.text, early.needed) == ("no bound yet", 72)
    few = states([condition], sample_of(values[:200]), ())[0]
    assert 0.5 < few.needed / looks(4000)[reached.index(True)] < 2.5


def test_requirements_are_decided_or_narrow_enough():
    decided, narrow = rule("requirement(line of sight) decided and probability(line of sight) within 2 %")
    good, bad = np.ones(1000), np.full(1000, 3.0)
    for values, expected in ((good, "shown"), (bad, "not met"), (np.r_[good[:96], bad[:4]], "open")):
        state = states([decided], sample_of(values), REQUIREMENTS)[0]
        assert (state.text, state.satisfied) == (expected, expected != "open")
    state = states([narrow], sample_of(np.r_[good[:96], bad[:4]]), REQUIREMENTS)[0]
    assert not state.satisfied
    enough = np.r_[np.ones(round(0.96 * state.needed)), np.full(round(0.04 * state.needed), 3.0)]
    assert states([narrow], sample_of(enough), REQUIREMENTS)[0].satisfied
    lost = states([decided], sample_of(np.full(100, np.nan)), REQUIREMENTS)[0]
    assert lost.text == "not met"  # a lost run does not meet a requirement


def test_bounds_hold_where_the_rule_stops():
    """Stopping where a sample happens to look narrow costs coverage: 90 of 100 remain (Chow and Robbins, 1965)."""
    (condition,) = rule("p95(pointing) within 5 %")
    true, held, counts = np.exp(0.3 * 1.6448536), [], []
    for seed in range(200):
        sample = sample_of(np.random.default_rng(seed).lognormal(0.0, 0.3, 4000))
        stop = next(n for n in looks(4000) if states([condition], sample.first(n), ())[0].satisfied)
        found = percentile(np.sort(sample.metrics["pointing"][:stop]), 0.95)
        held.append(found.low <= true <= found.high)
        counts.append(stop)
    assert np.mean(held) >= 0.9
    assert 300 < np.median(counts) < 1000  # 0.3 * 1.96 * sqrt(0.95 * 0.05) / 0.103 / 0.05, squared: 706
