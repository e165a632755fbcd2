"""Write the evaluation of a campaign as tables of text and as plain values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from .evaluation import Evaluation, RequirementResult
from .sample import Metric, Sample
from .sensitivities import SobolIndex

Table = tuple[list[str], list[list[str]]]  # header and rows
_STRONGEST = 5  # correlations of each metric in a table


def number(value: float) -> str:
    """Return a number with four digits; a dash where there is none, `lost` for one among the lost runs."""
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "lost"  # a percentile among the lost runs
    return f"{value:.4g}"


def bounds(low: float, high: float) -> str:
    """Return bounds as text; one that so few runs do not have is a question mark."""
    texts = ["?" if math.isinf(one) or math.isnan(one) else number(one) for one in (low, high)]
    return " to ".join(texts)


def metric_table(found: Sequence[Evaluation]) -> Table:
    """Return mean, deviation, 95th percentile (5th where low is worse) with bounds, and worst value of each metric."""
    rows = []
    for one in found:
        for metric, about in zip(one.metrics, one.descriptions, strict=True):
            s, low_is_worse = metric.scale, metric.worse == "low"
            top = next(p for p in about.percentiles if p.share == (0.05 if low_is_worse else 0.95))
            text = f"{share_text(top.share)} {number(top.value / s)} ({bounds(top.low / s, top.high / s)})"
            worst = number((about.least if low_is_worse else about.most) / s)
            rows.append([_of(one, found, metric.name), metric.shown_unit, number(about.mean / s),
                         number(about.deviation / s), text, worst, str(about.lost)])  # fmt: skip
    return ["metric", "unit", "mean", "deviation", "percentile (95 % bounds)", "worst", "lost"], rows


def percentile_table(found: Sequence[Evaluation]) -> Table:
    """Return all percentiles of each metric with their bounds."""
    rows = []
    for one in found:
        for metric, about in zip(one.metrics, one.descriptions, strict=True):
            s = metric.scale
            name = _of(one, found, metric.name)
            rows.append([name, metric.shown_unit, "mean", number(about.mean / s),
                         bounds(about.mean_low / s, about.mean_high / s), str(about.count - about.lost)])  # fmt: skip
            rows += [
                [name, metric.shown_unit, share_text(p.share), number(p.value / s), bounds(p.low / s, p.high / s),
                 str(p.count)]
                for p in about.percentiles
            ]  # fmt: skip
    return ["metric", "unit", "statistic", "value", "95 % bounds", "runs"], rows


def requirement_table(found: Sequence[Evaluation]) -> Table:
    """Return each requirement with the probability that it is met, its bounds, the verdict and the runs needed."""
    rows = []
    for one in found:
        metrics = {metric.name: metric for metric in one.metrics}
        for judged in one.judgements:
            required = judged.requirement.probability
            rows.append(
                [_of(one, found, judged.requirement.name), limit_text(judged, metrics[judged.requirement.metric]),
                 "-" if required is None else percent(required), f"{judged.found.met} of {judged.found.count}",
                 f"{percent(judged.found.low)} to {percent(judged.found.high)}", verdict_text(judged)]
            )  # fmt: skip
    return ["requirement", "limit", "required", "met", "probability", "verdict"], rows


def worst_table(one: Evaluation, metric: int, most: int, strongest: int = 3) -> Table:
    """Return the worst runs of a metric with the inputs that it depends on most, or the first ones."""
    names = [each.input for each in one.correlations[metric]] or list(one.sample.inputs)
    names = [*names[:strongest], *list(one.sample.choices)[:1]]
    about = one.metrics[metric]
    header = ["run", f"{about.name} [{about.shown_unit}]" if about.shown_unit else about.name, *names]
    rows = []
    for i in one.worst[metric][:most]:
        value = one.sample.metrics[about.name][i] / about.scale
        cause = one.sample.causes[i]
        text = f"failed: {cause}" if math.isnan(value) and cause else "never" if math.isinf(value) else number(value)
        rows.append([str(one.sample.numbers[i]), text, *(_input_text(one.sample, name, i) for name in names)])
    return header, rows


def _input_text(sample: Sample, name: str, run: int) -> str:
    return number(float(sample.inputs[name][run])) if name in sample.inputs else sample.choices[name][run]


def run_text(value: float | None, metric: Metric) -> str:
    """Return a metric of one run with its unit; `none` if the run does not have it."""
    if value is None:
        return "none"
    return "never" if math.isinf(value) else f"{number(value / metric.scale)} {metric.shown_unit}".rstrip()


def correlation_table(found: Sequence[Evaluation]) -> Table:
    """Return the strongest rank correlations of each metric that the runs show."""
    rows = [
        [_of(one, found, metric.name), each.input, f"{each.value:+.2f}", f"{each.low:+.2f} to {each.high:+.2f}"]
        for one in found
        for metric, correlations in zip(one.metrics, one.correlations, strict=True)
        for each in correlations[:_STRONGEST]
        if each.visible
    ]
    return ["metric", "input", "rank correlation", "95 % bounds"], rows


def sobol_table(metric: str, indices: Sequence[SobolIndex]) -> Table:
    """Return the Sobol indices of a metric, the largest total index first."""
    rows = [
        [metric, one.input, f"{one.first:.3f}", f"{one.first_low:.3f} to {one.first_high:.3f}", f"{one.total:.3f}",
         f"{one.total_low:.3f} to {one.total_high:.3f}"]
        for one in sorted(indices, key=lambda each: -each.total)
    ]  # fmt: skip
    return ["metric", "input", "first order", "95 % bounds", "total", "95 % bounds"], rows


def share_text(share: float) -> str:
    """Return a percentile's name."""
    return f"p{100.0 * share:.6g}"


def percent(share: float) -> str:
    """Return a probability in percent, with the digits that distinguish it from 100."""
    if share in (0.0, 1.0):
        return f"{100.0 * share:.0f} %"
    digits = max(1, 1 - math.floor(math.log10(min(share, 1.0 - share) * 100.0)))
    return f"{100.0 * share:.{min(digits, 6)}f} %"


def limit_text(judged: RequirementResult, metric: Metric) -> str:
    """Return the limits of a requirement, in the unit in which its metric is shown."""
    limits = [
        f"{sign} {number(value / metric.scale)}"
        for sign, value in ((">=", judged.requirement.least), ("<=", judged.requirement.most))
        if value is not None
    ]
    return f"{' and '.join(limits)} {metric.shown_unit}".strip()


def verdict_text(judged: RequirementResult) -> str:
    """Return what the runs say on a requirement, and how many would show it."""
    if judged.verdict is None:
        return "-"
    if judged.verdict == "open":
        return "open" if judged.needed is None else f"open; {judged.needed} runs"
    return judged.verdict


def answer(found: Sequence[Evaluation]) -> list[str]:
    """Return what a campaign shows, as sentences: runs lost, then each requirement."""
    sentences = []
    for one in found:
        lost = sum(bool(cause) for cause in one.sample.causes)
        where = f" with {one.sample.system}" if len(found) > 1 else ""
        sentences.append(f"{len(one.sample)} runs{where}, {lost or 'none'} of them failed.")
        for judged in one.judgements:
            name, found_ = judged.requirement.name, judged.found
            text = (f"{name}{where}: met in {found_.met} of {found_.count} runs, a probability of"
                    f" {percent(found_.low)} to {percent(found_.high)}")  # fmt: skip
            required = judged.requirement.probability
            if required is not None and judged.verdict is not None:
                text += f"; {percent(required)} is required"
                text += {"shown": " and shown", "not met": " and not reached"}.get(judged.verdict, "")
                if judged.verdict == "open":
                    text += (f" and not yet decided: about {judged.needed} runs in total would show it"
                             if judged.needed else " and not yet decided")  # fmt: skip
            sentences.append(f"{text}.")
    return sentences


def sampling_note(sampling: str) -> str:
    """Return what the sampling of a campaign means for its bounds; nothing for independent draws."""
    if sampling in ("latin-hypercube", "sobol"):
        return (f"The cases were drawn by {sampling} sampling, so that they are not independent, as the bounds assume."
                " Where a metric rises or falls with its inputs, its mean and probabilities scatter less than bounds"
                " say; only random sampling makes them exact.")  # fmt: skip
    if sampling in ("grid", "one-at-a-time", "table", "saltelli"):
        return (f"The cases are a design ({sampling}), not random draws: percentiles, probabilities and bounds describe"
                " these cases, not a population.")  # fmt: skip
    return ""


def plain_values(found: Sequence[Evaluation]) -> list[dict[str, Any]]:
    """Return everything as plain values in SI, for JSON; null where there is no number."""
    return [_plain(one) for one in found]


def _plain(one: Evaluation) -> dict[str, Any]:
    sample = one.sample
    return {
        "system": sample.system,
        "runs": len(sample),
        "failed": sum(bool(cause) for cause in sample.causes),
        "metrics": [
            {"name": about.name, "unit": about.unit, "runs": about.count, "lost": about.lost,
             "mean": finite(about.mean), "mean_low": finite(about.mean_low), "mean_high": finite(about.mean_high),
             "deviation": finite(about.deviation), "least": finite(about.least), "most": finite(about.most),
             "percentiles": [{"share": p.share, "value": finite(p.value), "low": finite(p.low), "high": finite(p.high)}
                             for p in about.percentiles],
             "worst_runs": [int(sample.numbers[i]) for i in indices],
             "rank_correlations": [{"input": each.input, "value": each.value, "low": each.low, "high": each.high}
                                   for each in correlations]}
            for about, indices, correlations in zip(one.descriptions, one.worst, one.correlations, strict=True)
        ],
        "requirements": [
            {"name": judged.requirement.name, "metric": judged.requirement.metric, "most": judged.requirement.most,
             "least": judged.requirement.least, "required": judged.requirement.probability,
             "confidence": judged.requirement.confidence, "met": judged.found.met, "runs": judged.found.count,
             "probability": judged.found.value, "low": judged.found.low, "high": judged.found.high,
             "verdict": judged.verdict, "runs_needed": judged.needed}
            for judged in one.judgements
        ],
    }  # fmt: skip


def finite(value: float) -> float | None:
    """Return a number, or None if it is not finite: JSON has no other."""
    return value if math.isfinite(value) else None


def _of(one: Evaluation, found: Sequence[Evaluation], name: str) -> str:
    """Return a name with its system where there are several."""
    return f"{name}, {one.sample.system}" if len(found) > 1 else name
