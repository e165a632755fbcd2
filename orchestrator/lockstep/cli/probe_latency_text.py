"""Measured delays as text, folded by arrays, and as JSON."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import asdict

from lockstep.array_names import array_of
from lockstep.check.latency.probe_latency import LatencyReport, Pair
from lockstep.errors import compact

NARROWEST = 60  # characters of a terminal
LISTED = 12  # contradictions, by arrays
LEGEND = (
    "k: answers after k steps, 0 being the step that sees the change; k-m: depending on when it samples;",
    "f: direct feedthrough, within the step and not vanishing with it; . no answer; ? claimed, but not excited;",
    "! contradicts the claim",
)


def as_json(report: LatencyReport) -> str:
    """Return the report as JSON; a pair that is missing did not answer, and is not declared to."""
    content = asdict(report)
    content["contradictions"] = len(report.of("contradicted"))
    return json.dumps(content, indent=1) + "\n"


def as_lines(report: LatencyReport, width: int) -> list[str]:
    """Return a title, the matrix of delays by arrays, and the comparison with the declared dependencies."""
    step = f"step {report.step:g} s ({report.step_source})"
    lines = [f"{report.file}: {report.model}, {step}, {report.window} steps watched after each change"]
    if report.kind is not None and not report.any_step:
        other = "" if report.kind == "continuous" else "; --kind continuous if its outputs are true at a step's end"
        lines.append(f"it makes one step only: taken as {report.kind}{other}")
    lines += ["", *_matrix(report, max(width, NARROWEST)), "", *LEGEND, "", *_claims(report)]
    if report.together:
        lines.append("arrays were changed as a whole, for lack of time: --time-limit gives more")
    if report.untried:
        lines.append(f"inputs not tried for lack of time: {report.untried}; --time-limit gives more")
    lines += [f"not to be changed: {line}" for line in report.refused]
    if report.texts:
        lines.append(f"Strings are not changed: {compact(report.texts)}")
    if report.unmoved:
        lines.append(f"nothing answered to: {compact(report.unmoved)}; other values (--set, --amplitude) may excite it")
    if report.smaller:
        inputs = compact(report.smaller)
        lines.append(
            f"answers to {inputs} come within the step where Reals change by a hundredth, and later where by more"
        )
    if report.blocked_by:
        settings = " ".join(f"--set {name}={value:g}" for name, value in report.blocked_by.items())
        lines.append(f"more inputs have an answer with {settings}; the start values block it")
    if report.unrepeatable:
        lines.append(f"differ between two equal runs, so that no delay can be given: {compact(report.unrepeatable)}")
    return lines


def _matrix(report: LatencyReport, width: int) -> list[str]:
    groups: defaultdict[tuple[str, str], list[Pair]] = defaultdict(list)
    for pair in report.pairs:
        groups[array_of(pair.output), array_of(pair.input)].append(pair)
    rows, columns = _folded(report.outputs), _folded(report.inputs)
    numbers = {name: str(number) for number, name in enumerate(columns, start=1)}
    cells = {key: _cell(pairs) for key, pairs in groups.items()}
    size = 2 + max(map(len, [*cells.values(), *numbers.values()]))
    left = 2 + max(len(text) for text in [*rows.values(), "output"])
    across = max(1, (width - left) // size)
    lines = ["inputs:", *_wrapped([f"{numbers[name]} {text}" for name, text in columns.items()], width)]
    names = list(columns)
    for first in range(0, len(names), across):
        part = names[first : first + across]
        lines += ["", "output".ljust(left) + "".join(numbers[name].rjust(size) for name in part)]
        for row, text in rows.items():
            lines.append(text.ljust(left) + "".join(cells.get((row, name), ".").rjust(size) for name in part))
    return lines


def _cell(pairs: Sequence[Pair]) -> str:
    """Return delays over all elements, whether any is feedthrough, and the worst agreement."""
    answering = [pair for pair in pairs if pair.least is not None]
    agreements = {pair.agreement for pair in pairs}
    if not answering:
        return "?"
    # couplings that are hardly above rounding are seen late, and say nothing about the array
    counted = [pair for pair in answering if pair.clear] or answering
    least = [pair.least for pair in counted if pair.least is not None]
    most = [pair.most for pair in counted if pair.most is not None]
    text = str(min(least)) if min(least) == max(most) else f"{min(least)}-{max(most)}"
    return text + "f" * any(pair.feedthrough for pair in pairs) + "!" * ("contradicted" in agreements)


def _claims(report: LatencyReport) -> list[str]:
    claimed = [pair for pair in report.pairs if pair.claimed]
    seen = [pair for pair in claimed if pair.feedthrough]
    parts = [f"{len(seen)} claimed and seen"]
    silent, vanishing = report.of("not excited"), report.of("not confirmed")
    parts += [f"{len(silent)} claimed, but not excited"] if silent else []
    parts += [f"{len(vanishing)} claimed, but later or vanishing with the step"] if vanishing else []
    undeclared = [pair for pair in report.of("no claim") if pair.feedthrough]
    parts += [f"{len(undeclared)} seen where the model description makes no claim"] if undeclared else []
    contradictions = report.of("contradicted")
    parts.append(f"{len(contradictions)} contradict the claim" if contradictions else "no contradiction")
    lines = [f"feedthrough, by pairs of output and input: {', '.join(parts)}"]
    groups: defaultdict[tuple[str, str, str], list[Pair]] = defaultdict(list)
    for pair in contradictions:
        groups[array_of(pair.output), array_of(pair.input), _contradiction(pair)].append(pair)
    for (_, _, contradiction), pairs in list(groups.items())[:LISTED]:
        outputs, inputs = (list(dict.fromkeys(getattr(pair, end) for pair in pairs)) for end in ("output", "input"))
        lines.append(f"  contradicted: {compact(outputs)} <- {compact(inputs)}: {contradiction}")
    if len(groups) > LISTED:
        lines.append(f"  and {len(groups) - LISTED} more: --json lists all")
    for name, listed in (("not excited", silent), ("later or vanishing", vanishing)):
        ends = list(dict.fromkeys(f"{array_of(pair.output)} <- {array_of(pair.input)}" for pair in listed))
        lines += [f"  {name}: {', '.join(ends[:6])}" + (f" and {len(ends) - 6} more" if len(ends) > 6 else "")] * bool(
            ends
        )
    return lines


def _contradiction(pair: Pair) -> str:
    if pair.claimed:
        steps = "1 step" if pair.least == 1 else f"{pair.least} steps"
        return f"claimed as feedthrough, but answers after {steps} at the earliest"
    return "not claimed, but " + ("answers at once, without a step" if pair.direct else "answers within its step")


def _folded(names: Iterable[str]) -> dict[str, str]:
    """Return the arrays by name, with the number of their elements."""
    counts: dict[str, int] = {}
    for name in names:
        counts[array_of(name)] = counts.get(array_of(name), 0) + 1
    return {name: f"{name}[{count}]" if count > 1 else name for name, count in counts.items()}


def _wrapped(parts: Sequence[str], width: int) -> list[str]:
    lines = [""]
    for part in parts:
        joined = f"{lines[-1]},  {part}" if lines[-1] else f"  {part}"
        if len(joined) > width and lines[-1]:
            lines.append(f"  {part}")
        else:
            lines[-1] = joined
    return lines
