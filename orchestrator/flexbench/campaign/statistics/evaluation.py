"""Evaluate the runs of one system: metrics, requirements with verdicts, worst runs, rank correlations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .describe import Description, describe, worst
from .percentiles import CONFIDENCE
from .proportions import Proportion, Verdict, proportion, runs_to_show
from .sample import Metric, MetricRequirement, Sample, direction
from .sensitivities import RankCorrelation, rank_correlations

WORST = 10  # runs of each metric


@dataclass(frozen=True, slots=True, kw_only=True)
class RequirementResult:
    """A requirement over all runs of a system."""

    requirement: MetricRequirement
    found: Proportion
    verdict: Verdict | None  # None: no probability is required
    needed: int | None  # total number of runs that would show it; None if it is shown, or no number would


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """What the runs of one system say."""

    sample: Sample
    metrics: tuple[Metric, ...]
    descriptions: tuple[Description, ...]  # of each metric
    judgements: tuple[RequirementResult, ...]
    worst: tuple[tuple[int, ...], ...]  # of each metric: indices of runs, the worst first
    correlations: tuple[tuple[RankCorrelation, ...], ...]  # of each metric


def evaluate(sample: Sample, metrics: Sequence[Metric], requirements: Sequence[MetricRequirement]) -> Evaluation:
    """Return the evaluation of the runs of one system, at least one."""
    columns = [(one, sample.metrics[one.name], direction(one.name, requirements)) for one in metrics]
    return Evaluation(
        sample=sample,
        metrics=tuple(metrics),
        descriptions=tuple(describe(one.name, values, unit=one.unit, worse=worse) for one, values, worse in columns),
        judgements=tuple(judge(one, sample) for one in requirements),
        worst=tuple(tuple(worst(values, WORST, worse)) for _, values, worse in columns),
        correlations=tuple(tuple(rank_correlations(sample.inputs, values)) for _, values, _ in columns),
    )


def judge(requirement: MetricRequirement, sample: Sample) -> RequirementResult:
    """Return the probability with which a requirement is met, its bounds, and the runs still needed to show it."""
    met = int(requirement.met(sample.metrics[requirement.metric]).sum())
    confidence = requirement.confidence or CONFIDENCE
    found = proportion(met, len(sample), confidence)
    required = requirement.probability
    if required is None:
        return RequirementResult(requirement=requirement, found=found, verdict=None, needed=None)
    verdict = found.verdict(required)
    needed = runs_to_show(len(sample) - met, len(sample), required, confidence) if verdict == "open" else None
    return RequirementResult(requirement=requirement, found=found, verdict=verdict, needed=needed)
