"""Decide when a campaign has enough runs, by rules such as `p95(pointing) within 5 %`.

    rule      = condition, { "and", condition } ;
    condition = quantity, "within", number, "%" | "requirement", "(", NAME, ")", "decided" ;
    quantity  = ( percentile | "mean" ), "(", METRIC, ")" | "probability", "(", NAME, ")" ;
    percentile = "p", number ;

`within` is half of the distance between the bounds, relative to the value, for a probability in points of percent;
`decided` means that the bounds of the probability lie on one side of that required.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

from lockstep import InputError

from .describe import describe, ordered
from .percentiles import percentile, runs_for_bound, runs_for_width
from .proportions import proportion, runs_to_show
from .sample import MetricRequirement, Sample, direction

FIRST_LOOK = 50  # runs
_GROWTH = 1.25  # from one look to the next
ACCEPTED = "p95(METRIC) within 5 %, mean(METRIC) within 2 %, probability(REQUIREMENT) within 1 %," \
           " requirement(REQUIREMENT) decided; several with `and`"  # fmt: skip
_CONDITION = re.compile(
    r"(?P<what>p(?P<share>\d+(?:\.\d+)?)|mean|probability|requirement)\s*\(\s*(?P<name>[^()]+?)\s*\)\s*"
    r"(?:within\s+(?P<within>\d+(?:\.\d+)?|\.\d+)\s*%|(?P<decided>decided))"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One condition of a rule."""

    text: str
    what: str  # percentile, mean, probability, requirement
    name: str  # of a metric or a requirement
    share: float = 0.0  # of a percentile, 0 to 1
    within: float = 0.0  # 0.05 is 5 %


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """How far a condition is after some runs of a system."""

    condition: Condition
    system: str
    satisfied: bool
    text: str  # what the condition has come to
    needed: int | None  # about how many runs satisfy it; None if nothing can be said


def parse_rule(text: str, metrics: Sequence[str], requirements: Sequence[MetricRequirement]) -> tuple[Condition, ...]:
    """Return the conditions of a rule.

    Raises
    ------
    InputError
        If the text is no rule, or names a metric or requirement that the campaign does not have.
    """
    conditions = []
    names = [one.name for one in requirements]
    position = 0
    while True:
        found = _CONDITION.match(text, position)
        if found is None:
            _refuse(text, f"`{text[position:].strip() or 'nothing'}` is no condition; accepted: {ACCEPTED}")
        condition = _condition(text, found)
        known = metrics if condition.what in ("percentile", "mean") else names
        if condition.name not in known:
            kind = "metric" if known is metrics else "requirement"
            _refuse(text, f"no {kind} `{condition.name}`; the campaign has {', '.join(known) or 'none'}")
        if (
            condition.what == "requirement"
            and next(o for o in requirements if o.name == condition.name).probability is None
        ):
            _refuse(text, f"requirement `{condition.name}` has no probability, which `decided` needs; give it one")
        conditions.append(condition)
        rest = text[found.end() :]
        if not rest.strip():
            return tuple(conditions)
        if (joint := re.match(r"\s+and\s+", rest)) is None:
            _refuse(text, f"`{rest.strip()}` after `{condition.text}`; join conditions by `and`")
        position = found.end() + joint.end()


def states(conditions: Sequence[Condition], sample: Sample, requirements: Sequence[MetricRequirement]) -> list[State]:
    """Return how far each condition is after the runs of a sample."""
    return [_state(one, sample, requirements) for one in conditions]


def next_look(runs: int) -> int:
    """Return after how many runs a rule is looked at again: first after 50, then each time after a quarter more.

    The numbers are set beforehand, so that where a campaign stops depends on its cases alone: neither on workers nor on
    what finished first. Growing steps keep the number of looks small, each of which could stop by chance.
    """
    return max(FIRST_LOOK, math.ceil(runs * _GROWTH))


def _condition(text: str, found: re.Match[str]) -> Condition:
    """Return the condition that matched, with values in range."""
    what, whole = found["what"], found[0]
    if (what == "requirement") != (found["decided"] is not None):
        accepted = "requirement(NAME) decided" if what == "requirement" else f"{what}(NAME) within 5 %"
        _refuse(text, f"`{whole}`; write {accepted}")
    within = float(found["within"] or 0.0) / 100.0
    if what != "requirement" and not 0.0 < within < 1.0:
        _refuse(text, f"within {found['within']} %; must be above 0 and below 100 %")
    share = float(found["share"] or 0.0) / 100.0
    if found["share"] is None:
        return Condition(text=whole, what=what, name=found["name"], within=within)
    if not 0.0 < share < 1.0:
        _refuse(text, f"p{found['share']}; must be above p0 and below p100")
    return Condition(text=whole, what="percentile", name=found["name"], share=share, within=within)


def _refuse(text: str, reason: str) -> NoReturn:
    raise InputError(f"stop rule `{text}`: {reason}")


def _state(condition: Condition, sample: Sample, requirements: Sequence[MetricRequirement]) -> State:
    """Return the state of one condition; one of a percentile or mean without runs is not satisfied."""
    if condition.what in ("probability", "requirement"):
        return _of_requirement(condition, sample, next(one for one in requirements if one.name == condition.name))
    count = len(sample)
    values = sample.metrics[condition.name]
    if condition.what == "percentile":
        found = percentile(ordered(values, direction(condition.name, requirements)), condition.share)
        half_width = found.half_width
        needed: int | None = runs_for_width(found, condition.within) or max(runs_for_bound(condition.share), count + 1)
    else:
        half_width = describe(condition.name, values, shares=()).mean_error
        needed = math.ceil(count * (half_width / condition.within) ** 2) if math.isfinite(half_width) else None
    text = f"within {100.0 * half_width:.3g} %" if math.isfinite(half_width) else "no bound yet"
    return State(condition=condition, system=sample.system, satisfied=half_width <= condition.within, text=text,
                 needed=needed)  # fmt: skip


def _of_requirement(condition: Condition, sample: Sample, requirement: MetricRequirement) -> State:
    """Return the state of a condition of a requirement's probability."""
    met, count = int(requirement.met(sample.metrics[requirement.metric]).sum()), len(sample)
    found = proportion(met, count, requirement.confidence)
    if condition.what == "probability":
        half_width = 0.5 * (found.high - found.low)
        needed = math.ceil(count * (half_width / condition.within) ** 2)
        return State(condition=condition, system=sample.system, satisfied=half_width <= condition.within,
                     text=f"within {100.0 * half_width:.3g} %", needed=needed)  # fmt: skip
    required = requirement.probability or 0.0  # `parse_rule` refuses a requirement without
    verdict = found.verdict(required)
    total = count if verdict != "open" else runs_to_show(count - met, count, required, requirement.confidence)
    return State(condition=condition, system=sample.system, satisfied=verdict != "open", text=verdict, needed=total)
