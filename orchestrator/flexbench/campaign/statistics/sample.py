"""The runs of one system of a campaign as arrays: inputs, metrics, requirements, and which runs were lost."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array

from .describe import Worse
from .percentiles import CONFIDENCE


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """A number of each run, in SI; shown as value / scale in another unit."""

    name: str
    unit: str
    shown_unit: str = ""
    scale: float = 1.0
    worse: Worse = "high"


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricRequirement:
    """Limits of a metric in SI, and the probability with which they are to be kept."""

    name: str
    metric: str
    most: float | None = None
    least: float | None = None
    probability: float | None = None
    confidence: float = CONFIDENCE

    def met(self, values: Array) -> NDArray[np.bool_]:
        """Return in which runs it is met; a lost run does not meet it."""
        good = np.isfinite(values)
        if self.most is not None:
            good &= values <= self.most
        if self.least is not None:
            good &= values >= self.least
        return good


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Runs of one system, by number."""

    system: str
    numbers: NDArray[np.int64]  # (runs,)
    inputs: Mapping[str, Array]  # (runs,) each
    choices: Mapping[str, Sequence[str]]  # inputs that are texts: (runs,) each
    units: Mapping[str, str]  # of the inputs
    metrics: Mapping[str, Array]  # (runs,) each; NaN: the run failed or has none; inf: a time that did not come
    causes: Sequence[str]  # (runs,): why a run failed, "" if it was completed

    def __len__(self) -> int:
        return len(self.numbers)

    def first(self, count: int) -> Sample:
        """Return the first runs alone."""
        return dataclasses.replace(
            self,
            numbers=self.numbers[:count],
            inputs={name: column[:count] for name, column in self.inputs.items()},
            choices={name: column[:count] for name, column in self.choices.items()},
            metrics={name: column[:count] for name, column in self.metrics.items()},
            causes=self.causes[:count],
        )


def direction(metric: str, requirements: Sequence[MetricRequirement]) -> Worse:
    """Return which end of a metric is the worse: the low one if requirements limit it from below alone."""
    own = [one for one in requirements if one.metric == metric]
    return "low" if own and all(one.most is None and one.least is not None for one in own) else "high"
