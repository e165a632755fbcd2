"""Measure after how many steps each output answers to each input, from several moments; runs in a process of its own.

What samples every P steps answers at once when it samples in the step of the change, and up to P - 1 steps later when
it does not. So every change is made before two steps that follow each other, and before further ones as long as answers
come closer: the least delay is the true one, the largest is how long a change may wait for a sample.

What a change does to the last digits of large numbers is no answer: see `_answered`.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.probe_process import ProbeResult, ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, output_names, unlike
from lockstep.check.latency.response_bench import (
    MOMENT,
    REDUCED,
    ULPS,
    Bench,
    Change,
    bases,
    changes_of,
    folded,
    grouped,
    lasting,
)
from lockstep.errors import RunError
from lockstep.fmi.slave import FATAL

RESULT, PROGRESS = "latency.json", "progress"
SWEEP = 12  # moments at most: sampling periods up to this, and those that divide MOMENT, are seen in full
USUAL_MOMENTS = 3
EARLY_MOMENT = 20  # for an FMU that has to start again for every change
NOTHING = 1e-9  # relative: smaller differences are no answer

Inputs = tuple[str, ...]
Answers = NDArray[np.int64]  # of each output: steps, or -1 for none


@dataclass(slots=True)
class LateAnswer:
    """How one output answers to one change, over all moments."""

    least: int
    most: int
    direct: bool = False
    within: int = 0  # moments at which it answered within the step
    lasting: int = 0  # of these: at which the answer did not vanish with the step
    clear: bool = False  # whether it is large at any time


@dataclass(slots=True)
class Measurement:
    """What was measured so far, by change and number of the output."""

    answers: dict[tuple[Inputs, int], LateAnswer] = field(default_factory=dict)
    last: dict[tuple[Inputs, int], int] = field(default_factory=dict)  # delays at the moment before

    def add(
        self,
        inputs: Inputs,
        first: Answers,
        direct: NDArray[np.bool_],
        stays: NDArray[np.bool_],
        clear: NDArray[np.bool_],
    ) -> bool:
        """Add the answers to a change at one moment; return whether one came sooner than at the moment before."""
        closer = False
        for column in np.flatnonzero(first >= 0):
            key, delay = (inputs, int(column)), int(first[column])
            found = self.answers.setdefault(key, LateAnswer(delay, delay))
            found.least = min(found.least, delay)
            found.direct |= bool(direct[column])
            found.within += delay == 0
            found.lasting += bool(delay == 0 and stays[column])
            if clear[column]:
                found.clear = True
                found.most = max(found.most, delay)
                closer |= delay < self.last.get(key, delay)
            self.last[key] = delay
        return closer


def measure(task: ProbeTask) -> ProbeResult:
    """Measure, and write what was found."""
    bench, unrepeatable = _bench(task)
    began = time.monotonic()
    unchanged = bases(bench, [])
    each = 2.0 * (time.monotonic() - began)
    changes = changes_of(bench.instance)
    flags = [part for change in changes.values() for part in change if _kind(bench, part) == "Boolean"]
    budget = task.options["seconds"]
    together = each * len(changes) * (2 if flags else 1) * USUAL_MOMENTS > budget
    if together:
        changes = grouped(changes)
    measurement = Measurement()
    broken, late = _at_all_moments(bench, changes, flags, unchanged, began + budget, measurement)
    names = output_names(task.experiment)
    found = {
        "window": bench.window,
        "together": together,
        "tried": [list(inputs) for inputs in changes],
        "amounts": {
            name: part[2] for inputs, change in changes.items() for name, part in zip(inputs, change, strict=True)
        },
        "refused": broken,
        "untried": late,
        "unrepeatable": [name for name, moves in zip(names, unrepeatable, strict=True) if moves],
        "answers": [
            {
                "inputs": list(inputs),
                "output": names[column],
                "least": answer.least,
                "most": answer.most,
                "direct": answer.direct,
                "clear": answer.clear,
                # rounding may look like it once, but not most of the time
                "feedthrough": answer.direct or 2 * answer.lasting > answer.within,
            }
            for (inputs, column), answer in measurement.answers.items()
            if not unrepeatable[column]
        ],
    }
    (task.work / RESULT).write_text(json.dumps(found), encoding="utf-8")
    return ProbeResult(message="measured")


def _kind(bench: Bench, part: tuple[int, int, float]) -> str:
    return bench.instance.write[part[0]].scalar


def _bench(task: ProbeTask) -> tuple[Bench, NDArray[np.bool_]]:
    """Return a bench that comes back in the fastest way that works, and which outputs differ without a cause.

    A way works if the same steps give the same outputs twice; where even two new instances differ, the outputs do.
    """
    window = task.options["steps"]
    ways = [(True, True)] * task.experiment.saves_state + [(False, True)]
    ways += [(False, False)]
    for state, resets in ways:
        options = {**task.options, "state": state, "resets": resets}
        bench = Bench(replace(task, options=options), moment=MOMENT if resets else EARLY_MOMENT, window=window)
        try:
            first, second = (bench.watch([], window)[1] for _ in range(2))
        except RunError:
            if not resets or bench.instance.worst >= FATAL:
                raise
        else:
            unrepeatable: NDArray[np.bool_] = np.asarray(unlike(first, second).any(axis=0))
            if not unrepeatable.any() or not resets:
                break
        bench.instance.close()
    return bench, unrepeatable


def _at_all_moments(
    bench: Bench, changes: dict[Inputs, Change], flags: Change, unchanged: Any, deadline: float, found: Measurement
) -> tuple[list[str], int]:
    """Make the changes at one moment after the other; return complaints, and how many were not tried."""
    broken: dict[Inputs, str] = {}
    late, wanted = 0, changes
    for number in range(SWEEP):
        if number:
            bench.advance(bench.moment + 1)
            unchanged = bases(bench, [])
        closer: set[Inputs] = set()
        # what a flag such as `valid` gates answers only while the flag is up: so once more with every flag turned over
        for context in ([], flags) if flags else ([],):
            try:
                about = bases(bench, context) if context else unchanged
            except RunError:
                bench.renew()
                break
            for made, (inputs, change) in enumerate(wanted.items(), start=1):
                if time.monotonic() > deadline:
                    late += number == 0 and not context
                    continue
                if inputs in broken or (context and change[0] in flags):
                    continue
                text = f"step {bench.moment}: change {made} of {len(wanted)}" + ", flags turned over" * bool(context)
                (bench.task.work / PROGRESS).write_text(text, encoding="utf-8")
                try:
                    if found.add(inputs, *_answers(bench, change, context, *about)):
                        closer.add(inputs)
                except RunError as error:
                    if not context:
                        broken[inputs] = f"{folded(inputs)}: a small change is refused: {error}"
                    bench.renew()
        if number == 0:
            answering = {inputs for inputs, _ in found.answers}
            wanted = {inputs: change for inputs, change in changes.items() if inputs in answering}
        else:
            wanted = {inputs: change for inputs, change in wanted.items() if inputs in closer}
        if not wanted or time.monotonic() > deadline:
            break
    return list(broken.values()), late


def _answers(
    bench: Bench, change: Change, context: Change, base: Any, shortened: Any
) -> tuple[Answers, NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Return after how many steps each output answers, whether it does without any, whether it lasts, and is large.

    An answer lasts if it does not vanish with the step, or if no shorter step can be made.
    """
    before, after = bench.watch(context + change, bench.window)
    reduced = None
    if all(_kind(bench, part) == "Real" for part in change):
        small = [(setter, column, REDUCED * amount) for setter, column, amount in change]
        _, reduced = bench.watch(context + small, bench.window)
    changed = unlike(after, base[1])
    reals = after.reals.shape[1]
    answered, sure, large = _answered(after, reduced, base[1])
    changed[:, :reals] = answered
    clear = np.ones(changed.shape[1], bool)
    clear[:reals] = large
    first = np.where(changed.any(axis=0), changed.argmax(axis=0), -1)
    direct = unlike(before, base[0])[0]
    stays = np.ones(len(first), bool)
    stays[:reals] = sure
    if shortened is not None:
        _, brief = bench.watch(context + change, 1, short=True)
        stays &= lasting(after[:1], base[1][:1], brief, shortened[1], output_names(bench.task.experiment))
    return first, direct, stays, clear


def _answered(
    full: Trajectory, reduced: Trajectory | None, base: Trajectory
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return where real outputs answer, (steps, outputs), which answer in the first step for sure, and which are large.

    What is large answers. What is small does if it shrinks with its cause, or if the smaller cause shows nothing at
    all, as with a quantised output. Of what answers, differences much smaller than the later ones do not count.
    """
    with np.errstate(all="ignore"):
        whole = np.where(np.isnan(full.reals) != np.isnan(base.reals), np.inf, np.abs(full.reals - base.reals))
        part = np.zeros_like(whole) if reduced is None else np.abs(reduced.reals - base.reals)
        size = np.abs(base.reals)
        top, rounding = whole.max(axis=0), ULPS * np.spacing(size.max(axis=0))
        clear = whole > NOTHING * np.maximum(1.0, size.max(axis=0))
        shrinks = whole > rounding if reduced is None else (part > 0.0) & (REDUCED * whole >= 0.5 * part)
        much = part.max(axis=0)
        excited = clear.any(axis=0) | np.where(much > 0.0, REDUCED * top >= 0.5 * much, top > rounding)
        answered = excited & (whole > np.maximum(NOTHING * top, ULPS / 8.0 * np.spacing(size)))
        return np.asarray(answered), np.asarray(clear[0] | shrinks[0]), np.asarray(clear.any(axis=0))
