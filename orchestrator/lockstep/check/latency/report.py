"""What measured latencies mean: answers within the step against the declared dependencies, and a summary."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.probe_process import Task, Verdict
from lockstep.check.dynamic.trajectory import output_names

LINES = 60
ENUMERATED = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """How the outputs answer to a change of one input, or of all elements of an array."""

    inputs: tuple[str, ...]
    first: NDArray[np.int64]  # of each output: steps, or -1 for no answer
    direct: NDArray[np.bool_]
    feedthrough: NDArray[np.bool_]  # within the step, and not vanishing with it
    sure: NDArray[np.bool_]  # whether an answer within the step is more than rounding


def base_name(name: str) -> str:
    """Return the name of the array that an element belongs to."""
    return name.partition("[")[0]


def folded(names: Sequence[str]) -> str:
    """Return the names of some elements of one array in few words."""
    return names[0] if len(names) == 1 else base_name(names[0])


def judged(task: Task, responses: list[Response], broken: list[str], late: int, window: int) -> Verdict:
    """Return what the responses mean; `late` inputs were not tried."""
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
    silent = [pair for pair in promised if pair not in pairs]
    vanishing = [pair for pair in promised if pair in pairs and pair not in fed]
    details = list(broken)
    details += [f"{output} <- {source}: declared, but no answer within {window} steps" for output, source in silent]
    details += [f"{output} <- {source}: declared, but not seen as feedthrough" for output, source in vanishing]
    details += _lines(pairs, fed)
    shown = tuple(details[:LINES]) + ((f"and {len(details) - LINES} lines more",) if len(details) > LINES else ())
    told = _summary(pairs, fed, broken, late)
    if silent:
        told += f", {len(silent)} declared without an answer within {window} steps"
    if vanishing:
        told += f", {len(vanishing)} declared that are no feedthrough here"
    if hidden:
        return Verdict(status="error", message=f"undeclared feedthrough, seen without a step: {_some(hidden)}; {told}",
                       details=shown, numbers=numbers)  # fmt: skip
    if within:
        kind = "" if task.experiment.any_step else " (or outputs that are true at the end of a fixed step)"
        return Verdict(status="warning", message=f"undeclared feedthrough within the step{kind}: {_some(within)}; "
                       f"{told}", details=shown, numbers=numbers)  # fmt: skip
    return Verdict(status="info", message=told, details=shown, numbers=numbers)


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
