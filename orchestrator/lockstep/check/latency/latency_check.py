"""Check how late each output answers to each input, against the dependencies that the model description declares."""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, output_names, unlike
from lockstep.check.latency.response_bench import (
    MOMENT,
    REDUCED,
    SHORTER,
    WINDOW,
    Bench,
    Change,
    base_name,
    bases,
    changes_of,
    folded,
    grouped,
    lasting,
)
from lockstep.errors import RunError

LINES = 60
ENUMERATED = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputResponse:
    """How the outputs answer to a change of one input, or of all elements of an array."""

    inputs: tuple[str, ...]
    first: NDArray[np.int64]  # of each output: steps, or -1 for no answer
    direct: NDArray[np.bool_]
    feedthrough: NDArray[np.bool_]  # within the step, and not vanishing with it
    sure: NDArray[np.bool_]  # whether an answer within the step is more than rounding


def latency(task: ProbeTask) -> ProbeResult:
    """Change each input in turn, or whole arrays when that would take too long."""
    if not (task.experiment.inputs and task.experiment.outputs):
        return ProbeResult(status="skipped", message="no inputs or no outputs")
    steps = task.options["steps"]
    bench = Bench(task, moment=min(MOMENT, steps // 2), window=min(WINDOW, steps))
    began = time.monotonic()
    base, shortened = bases(bench, [])
    each = time.monotonic() - began
    changes = changes_of(bench.instance)
    if each * len(changes) > task.options["seconds"]:
        changes = grouped(changes)
    responses, broken, late = [], [], 0
    # what a flag such as `valid` gates answers only while the flag is up: so once more with every flag turned over
    write = bench.instance.write
    flags = [part for change in changes.values() for part in change if write[part[0]].scalar == "Boolean"]
    for context in ([], flags) if flags else ([],):
        deadline = time.monotonic() + task.options["seconds"]  # each time: on a busy machine the first takes all of it
        try:
            about = (base, shortened) if not context else bases(bench, context)
        except RunError:
            bench.renew()
            break
        for inputs, change in changes.items():
            if time.monotonic() > deadline:
                late += not context
                continue
            if context and change[0] in flags:
                continue
            try:
                responses.append(_response(bench, inputs, change, context, *about))
            except RunError as error:
                broken += [] if context else [f"{folded(inputs)}: a small change is refused: {error}"]
                bench.renew()
    return latency_result(task, responses, broken, late, bench.window)


def _response(
    bench: Bench, inputs: tuple[str, ...], change: Change, context: Change, base: Any, shortened: Any
) -> OutputResponse:
    before, after = bench.watch(context + change, bench.window)
    changed = unlike(after, base[1])
    direct = unlike(before, base[0])[0]
    first = np.where(changed.any(axis=0), changed.argmax(axis=0), -1)
    feedthrough = first == 0
    if shortened is None:
        sure = _sure(bench, change, context, after[:1], base[1][:1], short=False)
    else:
        _, brief = bench.watch(context + change, 1, short=True)
        sure = _sure(bench, change, context, brief, shortened[1], short=True)
        names = output_names(bench.task.experiment)
        feedthrough &= lasting(after[:1], base[1][:1], brief, shortened[1], names) & sure
        if feedthrough.any():  # or the parts of an answer cancelled over the whole step
            (_, without), (_, briefest) = (
                bench.watch(c, 1, short=True, share=SHORTER) for c in (context, context + change)
            )
            feedthrough &= lasting(brief, shortened[1], briefest, without, names)
    return OutputResponse(inputs=inputs, first=first, direct=direct, feedthrough=feedthrough | direct, sure=sure)


def _sure(
    bench: Bench, change: Change, context: Change, answer: Trajectory, base: Trajectory, *, short: bool
) -> NDArray[np.bool_]:
    """Return which answers shrink with the change: rounding, as of a conserved sum of large parts, does not."""
    sure = np.ones(unlike(answer, base).shape[1], bool)
    if all(bench.instance.write[setter].scalar == "Real" for setter, _, _ in change):
        small = [(setter, column, REDUCED * amount) for setter, column, amount in change]
        _, reduced = bench.watch(context + small, 1, short=short)
        with np.errstate(all="ignore"):
            whole, part = (np.abs(run.reals - base.reals)[0] for run in (answer, reduced))
            sure[: len(whole)] = (part > 0.0) & (REDUCED * whole >= 0.5 * part)
    return sure


def latency_result(
    task: ProbeTask, responses: list[OutputResponse], broken: list[str], late: int, window: int
) -> ProbeResult:
    """Compare the responses with the declared dependencies; `late` inputs were not tried."""
    ports = {port.name: port for port in task.experiment.outputs}
    names = output_names(task.experiment)
    pairs: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
    fed: set[tuple[str, str]] = set()
    hidden: list[str] = []
    within: list[str] = []
    promised: dict[tuple[str, str], None] = {}  # pairs declared as feedthrough, in order
    for response in responses:
        for column, name in enumerate(names):
            feeds = ports[name].feeds
            declared = feeds is None or not set(feeds).isdisjoint(response.inputs)
            answer = int(response.first[column])
            key = base_name(name), base_name(response.inputs[0])
            if answer >= 0:
                pairs[key].append(answer)
                fed |= {key} if response.feedthrough[column] else set()
            if feeds is not None and declared:
                promised[key] = None
            if not declared and response.direct[column]:
                hidden.append(f"{name} <- {folded(response.inputs)}")
            elif not declared and response.feedthrough[column] and response.sure[column]:
                within.append(f"{name} <- {folded(response.inputs)}")
    numbers: dict[str, float] = {}
    for (output, _), answers in pairs.items():
        named = f"{output} [steps]"
        numbers[named] = min(numbers.get(named, float(answers[0])), *map(float, answers))
    unanswered = [pair for pair in promised if pair not in pairs]
    vanishing = [pair for pair in promised if pair in pairs and pair not in fed]
    details = list(broken)
    details += [f"{output} <- {source}: declared, but no answer within {window} steps" for output, source in unanswered]
    details += [f"{output} <- {source}: declared, but not seen as feedthrough" for output, source in vanishing]
    details += _lines(pairs, fed)
    shown = tuple(details[:LINES]) + ((f"and {len(details) - LINES} lines more",) if len(details) > LINES else ())
    summary = _summary(pairs, fed, broken, late)
    if unanswered:
        summary += f", {len(unanswered)} declared without an answer within {window} steps"
    if vanishing:
        summary += f", {len(vanishing)} declared that are no feedthrough here"
    if hidden:
        text = f"undeclared feedthrough, seen without a step: {_some(hidden)}; {summary}"
        return ProbeResult(status="error", message=text, details=shown, numbers=numbers)
    if within:
        kind = "" if task.experiment.any_step else " (or outputs that are true at the end of a fixed step)"
        return ProbeResult(status="warning", message=f"undeclared feedthrough within the step{kind}: {_some(within)}; "
                       f"{summary}", details=shown, numbers=numbers)  # fmt: skip
    return ProbeResult(status="info", message=summary, details=shown, numbers=numbers)


def _lines(pairs: dict[tuple[str, str], list[int]], fed: set[tuple[str, str]]) -> list[str]:
    lines = []
    for (output, source), answers in sorted(pairs.items(), key=lambda item: (min(item[1]), item[0])):
        low, high = min(answers), max(answers)
        words = str(low) if low == high else f"{low} to {high}"
        feedthrough = ", feedthrough" if (output, source) in fed else ""
        lines.append(f"{output} <- {source}: {words} step{'s' * (high != 1)}{feedthrough}")
    return lines


def _summary(pairs: Any, fed: set[tuple[str, str]], broken: list[str], late: int) -> str:
    at_once = sum(min(answers) == 0 for answers in pairs.values())
    parts = [f"pairs of output and input: {at_once} answer within the step, {len(fed)} of them by feedthrough",
             f"{len(pairs) - at_once} later"]  # fmt: skip
    if broken:
        parts.append(f"inputs that refuse a small change: {len(broken)}")
    if late:
        parts.append(f"inputs not tried for lack of time: {late}")
    return ", ".join(parts)


def _some(found: list[str]) -> str:
    rest = f" and {len(found) - ENUMERATED} more" if len(found) > ENUMERATED else ""
    return ", ".join(found[:ENUMERATED]) + rest
