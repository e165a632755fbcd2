"""The comparison as tables of text, with a verdict for each quantity and an answer, both from the intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ARCSECOND, DEFAULT_DESIGN, ConfigurationName

from ...campaign.statistics.percentiles import CONFIDENCE
from ...runs.windows import COARSE_BAND
from .outcome import QUANTITIES, ComparedQuantity
from .plan import Comparison
from .statistics import Estimate, difference, mean, ratio
from .wheels import ROWS

DESIGN = "controller.design"
QUESTION = "Does distributing the wheels pay?"  # of the paper's layouts
PERCENT = f"{100.0 * CONFIDENCE:g} %"


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonRow:
    """One quantity of both layouts, in SI."""

    quantity: ComparedQuantity
    layouts: Sequence[ConfigurationName]  # two: the second is compared with the first
    means: Mapping[ConfigurationName, Estimate | None]  # of the runs that are not lost; None: of none
    unsettled: Mapping[ConfigurationName, int]  # runs without a value
    contrast: Estimate | None  # of pairs in which both have a value; None for none
    is_ratio: bool  # else a difference

    @property
    def better(self) -> ConfigurationName | None:
        """The layout with the lower values; None if the interval does not show which, or there is none."""
        same = 1.0 if self.is_ratio else 0.0
        if self.contrast is None or not self.contrast.excludes(same):
            return None
        first, second = self.layouts
        return second if self.contrast.value < same else first


def header(comparison: Comparison) -> tuple[str, ...]:
    """Return the titles of the columns of `cells`."""
    first, second = comparison.plan.layouts
    return ("quantity", "unit", first, second, f"{second} / {first}", "pairs")


def wheels_header(comparison: Comparison) -> tuple[str, ...]:
    """Return the titles of the columns of `wheel_rows`."""
    return ("wheels", "unit", *comparison.plan.layouts)


def having(name: ConfigurationName) -> str:
    """Return a layout as it stands after `with`: of the paper's, with its wheels."""
    return f"{name} wheels" if name in CONFIGURATIONS else name


def compare(comparison: Comparison) -> list[ComparisonRow]:
    """Return a row for each quantity that was simulated. Lost runs are in no number."""
    rows, layouts = [], comparison.plan.layouts
    for quantity in QUANTITIES:
        if quantity.scenario not in comparison.plan.duration:
            continue
        kept = {
            name: {
                seed: one.numbers[quantity.key]
                for seed, one in comparison.of(name, quantity.scenario).items()
                if not one.lost
            }
            for name in layouts
        }
        values = {name: {s: v for s, v in of.items() if v is not None} for name, of in kept.items()}
        pairs = [seed for seed in values[layouts[0]] if seed in values[layouts[1]]]
        first, second = (np.array([values[name][seed] for seed in pairs]) for name in layouts)
        is_ratio = quantity.compared == "ratio" and bool(np.all(first > 0.0) and np.all(second > 0.0))
        rows.append(
            ComparisonRow(
                quantity=quantity,
                layouts=layouts,
                means={name: mean(list(of.values())) if of else None for name, of in values.items()},
                unsettled={name: len(kept[name]) - len(values[name]) for name in layouts},
                contrast=(ratio if is_ratio else difference)(first, second) if pairs else None,
                is_ratio=is_ratio,
            )
        )
    return rows


def cells(row: ComparisonRow) -> tuple[str, ...]:
    """Return the texts of a row, `header` its columns."""
    scale = row.quantity.scale
    means = [_text(row.means[name], scale) for name in row.layouts]
    contrast = _text(row.contrast, 1.0 if row.is_ratio else scale)
    if not row.is_ratio and row.contrast is not None:
        contrast += f" {row.quantity.unit}, difference"
    return (row.quantity.label, row.quantity.unit, *means, contrast, str(row.contrast.count if row.contrast else 0))


def verdict(row: ComparisonRow) -> str:
    """Return what the interval shows, in a sentence."""
    label, contrast = row.quantity.label, row.contrast
    if any(row.unsettled.values()):
        counts = " and ".join(f"{count} of {name}" for name, count in row.unsettled.items())
        label += f" (not settled at the end: {counts}; without these)"
    if contrast is None:
        return f"{label}: no pair of runs to compare."
    if np.isnan(contrast.low):
        return f"{label}: one pair of runs shows no scatter, so nothing about others."
    if row.better is None:
        return f"{label}: no difference shown ({_contrast(row)})."
    second = row.layouts[1]
    word = "lower" if row.better == second else "higher"
    return f"{label}: {word} with {having(second)}, {_how_much(row)}."


def _how_much(row: ComparisonRow) -> str:
    """Return by how much the better layout is lower: a factor above one, or a difference."""
    assert row.contrast is not None
    value, low, high = row.contrast.value, row.contrast.low, row.contrast.high
    if row.is_ratio:
        if value < 1.0:
            value, low, high = 1.0 / value, 1.0 / high, 1.0 / low
        return f"by a factor of {value:.3g} ({PERCENT}: {low:.3g} to {high:.3g})"
    bounds = sorted(abs(one) / row.quantity.scale for one in (low, high))
    value = abs(value) / row.quantity.scale
    return f"by {value:.3g} {row.quantity.unit} ({PERCENT}: {bounds[0]:.3g} to {bounds[1]:.3g})"


def _contrast(row: ComparisonRow) -> str:
    assert row.contrast is not None
    value, low, high = row.contrast.value, row.contrast.low, row.contrast.high
    first, second = row.layouts
    if row.is_ratio:
        return f"{second} / {first} {value:.3g}, {PERCENT}: {low:.3g} to {high:.3g}"
    scale, unit = row.quantity.scale, row.quantity.unit
    if value == low == high == 0.0:
        return "equal in every pair"
    return f"{second} less {first} {value / scale:+.3g} {unit}, {PERCENT}: {low / scale:+.3g} to {high / scale:+.3g}"


def answer(comparison: Comparison, rows: Sequence[ComparisonRow]) -> list[str]:
    """Return the answer in a few sentences: what distributing the wheels lowers, raises, and leaves; and its cost."""
    first, second = comparison.plan.layouts
    paper = comparison.plan.layouts == CONFIGURATIONS
    groups: dict[ConfigurationName | None, list[str]] = {second: [], first: [], None: []}
    for row in rows:
        if row.contrast is not None and not np.isnan(row.contrast.low):
            how = "" if row.better is None else f" {_how_much(row)}"
            groups[row.better].append(f"the {row.quantity.label}{how}")
    lower, higher, open_ = (groups[name] for name in (second, first, None))
    question = QUESTION if paper else f"Is {second} better than {first}?"
    sentences = [f"{question} {_lead(lower, higher, open_)}"]
    for texts, begin in (
        (lower, "Distributing lowers" if paper else f"With {second} these are lower:"),
        (higher, "It raises" if paper else "These are higher:"),
        (open_, "No difference is shown in"),
    ):
        if texts:
            sentences.append(f"{begin} {listed(texts)}.")
    return [*sentences, lost_text(comparison), cost_text(comparison)]


def listed(texts: Sequence[str]) -> str:
    """Return texts as a list in a sentence."""
    return " and ".join(part for part in (", ".join(texts[:-1]), texts[-1]) if part)


def _lead(lower: Sequence[str], higher: Sequence[str], open_: Sequence[str]) -> str:
    count = len(lower) + len(higher) + len(open_)
    if not count:
        return "These runs cannot show it: there are no pairs to compare."
    if not lower:
        return f"Not in any of the {count} quantities compared."
    if not higher:
        return f"In {len(lower)} of {count} quantities; in none is it shown to be worse."
    return f"In {len(lower)} of {count} quantities, at the expense of {len(higher)}."


def lost_text(comparison: Comparison) -> str:
    """Return how many runs were lost, and which; they are in no mean and no ratio."""
    lost = [one for one in comparison.outcomes if one.lost]
    if not lost:
        return f"None of {len(comparison.outcomes)} runs was lost."
    named = "; ".join(
        f"{one.configuration}, {one.scenario.replace('_', ' ')}, seed {one.seed}: {one.lost}" for one in lost
    )
    return (
        f"{len(lost)} of {len(comparison.outcomes)} runs were lost, and are excluded from means and ratios, with"
        f" their pairs from ratios: {named}."
    )


def cost_text(comparison: Comparison) -> str:
    """Return what distributing costs in wheels."""
    layouts = comparison.plan.layouts
    if len(comparison.wheels) < len(layouts):
        return "Every run of a layout was lost: its wheels are not compared."
    one, many = (comparison.wheels[name] for name in layouts)
    return (
        f"What it costs: {many.count} wheels in place of {one.count}, with {many.inertia:.3g} kg.m2 in all against"
        f" {one.inertia:.3g} and {many.momentum:.3g} N.m.s stored at nominal speed against {one.momentum:.3g}."
        f" {'The paper takes both sets as equally heavy; r' if layouts == CONFIGURATIONS else 'R'}otors of one shape"
        " and material would weigh"
        f" {many.weight / one.weight:.2g} times as much."
    )


def wheel_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Return what the wheels are, `wheels_header` the columns."""
    return [
        (title, unit, *(f"{getattr(comparison.wheels[name], key) / scale:.3g}" for name in comparison.plan.layouts))
        for title, unit, key, scale in ROWS
        if len(comparison.wheels) == len(comparison.plan.layouts)
    ]


def notes(comparison: Comparison) -> list[str]:
    """Return what was simulated, and how the numbers are formed."""
    plan = comparison.plan
    seeds = listed([str(seed) for seed in plan.seeds])
    windows: dict[str, str] = {}
    for one in comparison.outcomes:
        if one.windows:
            windows.setdefault(one.scenario, "; ".join(one.windows))
    modes = " and ".join(dict.fromkeys(map(str, comparison.modes)))
    design = plan.overrides.get(DESIGN, DEFAULT_DESIGN)
    changed = "".join(f", {name} = {value}" for name, value in plan.overrides.items() if name != DESIGN)
    found = [
        f"Seeds {seeds}; each layout with its {design} design on a plant of {modes}"
        f" modes{changed}. Both layouts of a seed have the same errors of the structure, drawn evenly:"
        f" {plan.dispersion.text()};"
        " with less inertia the modes carry less of it. Sensors, jitter and initial attitude have the seed too."
    ]
    found += [
        f"{scenario.replace('_', ' ').capitalize()}: runs of {plan.duration[scenario]:g} s; windows of seed"
        f" {plan.seeds[0]}, {plan.layouts[0]}: {windows.get(scenario, 'none, as all are lost')}"
        + (f"; settled within {(plan.band or COARSE_BAND) / ARCSECOND:g} arcsec; without wheel jitter, with the coarse"
           " star tracker." if scenario == "slew" else
           "; with wheel jitter and the fine guidance sensor.")
        for scenario in plan.duration
    ]  # fmt: skip
    found.append(
        "RMS values in these windows; torque is the sum of its magnitudes over the wheels."
        f" Means have their {PERCENT} intervals (Student); ratios are geometric means over pairs, with the interval of"
        " their logarithm. Each interval holds by itself: of twenty, one may miss the true value."
    )
    return found


def _text(estimate: Estimate | None, scale: float) -> str:
    if estimate is None:
        return "-"
    value = f"{estimate.value / scale:.3g}"
    if np.isnan(estimate.low):
        return value
    return f"{value} ({estimate.low / scale:.3g} to {estimate.high / scale:.3g})"
