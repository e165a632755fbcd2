"""After how many of its steps does each output answer to each input, and does it say so in its dependencies?

An input is changed by a little before step `MOMENT` and stays changed. An output answers

- *directly* if it changes when it is read before any step: no FMI importer can miss that;
- *within the step* (latency 0) if it is changed after the step that saw the input first;
- after k steps otherwise.

An answer within the step is feedthrough for an FMU that samples (inputs count at the step's beginning, outputs hold
from there), but not for one that integrates (inputs are held, outputs are true at the step's end): there it vanishes
with the step. So an FMU that takes any step makes a short one too, and what does not vanish is feedthrough.
"""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.experiment import PERIOD, Port
from lockstep.check.dynamic.fmi2_instance import FATAL, WARNING, Failed, Instance
from lockstep.check.dynamic.probe_process import Task, Verdict
from lockstep.check.dynamic.probes_state import free_state, get_state, set_state
from lockstep.check.dynamic.trajectory import Trajectory, unlike
from lockstep.check.latency.report import Response, base_name, folded, judged

MOMENT = 100  # the first changed step: one in which what samples every 2, 4, 5, 10, 20, 25, 50 or 100 steps samples
WINDOW = 104  # steps watched
SHORT = 1.0 / 16.0  # of the step
KEPT = 0.5  # share of the answer that is left after a short step, from which on it is feedthrough
REDUCED = 1.0 / 64.0  # of a change: what answers in proportion, or to a higher power, answers so much less
ULPS = 64.0  # answers smaller than this are rounding

Change = list[tuple[int, int, float]]  # setter, column, amount


@dataclass(slots=True)
class Bench:
    """Brings an instance back to the moment of the change, as often as needed."""

    task: Task
    moment: int
    window: int
    instance: Instance = field(init=False)
    _state: Any = None

    def __post_init__(self) -> None:
        self._new()

    def rewind(self) -> Instance:
        """Return the instance as it is before the moment."""
        if self._state is not None:
            set_state(self.instance, self._state)
        elif self.instance.worst > WARNING or not self.task.options["resets"]:
            self.instance.close()
            self._new()
        else:
            self.instance.reset()
            self.instance.initialise()
            self.instance.run(0, self.moment)
        return self.instance

    def renew(self) -> None:
        """Give an instance up that a change broke."""
        if self.instance.worst >= FATAL:
            raise Failed("a changed input ends every instance in the process")
        self.instance.close()
        self._new()

    def _new(self) -> None:
        self.instance = self.task.started()
        self.instance.run(0, self.moment)
        self._state = get_state(self.instance) if self.task.options["state"] else None

    def advance(self, moment: int) -> None:
        """Go on to a later moment."""
        if self._state is not None:
            instance = self.rewind()
            instance.run(self.moment, moment)
            free_state(instance, self._state)
            self._state = get_state(instance)
        self.moment = moment

    def watch(self, change: Change, steps: int, short: bool = False) -> tuple[Trajectory, Trajectory]:
        """Return the outputs before any step, and after each of some steps, or after one short one."""
        instance = self.rewind()
        tables = [table.copy() for table in instance.stimuli()]
        for setter, column, amount in change:
            tables[setter][:, column] += np.asarray(amount).astype(tables[setter].dtype)
        instance.put([table[self.moment % PERIOD] for table in tables])
        experiment = self.task.experiment
        before = Trajectory.of_rows([instance.row()], experiment)
        if short:
            instance.step(experiment.time(self.moment), SHORT * experiment.step)
            return before, Trajectory.of_rows([instance.row()], experiment)
        return before, instance.run(self.moment, self.moment + steps, tables=tables)


def latency(task: Task) -> Verdict:
    """Change each input in turn, or whole arrays when that would take too long."""
    if not (task.experiment.inputs and task.experiment.outputs):
        return Verdict(status="skipped", message="it has no inputs, or no outputs")
    steps = task.options["steps"]
    bench = Bench(task, moment=min(MOMENT, steps // 2), window=min(WINDOW, steps))
    began = time.monotonic()
    base, shortened = bases(bench, [])
    each = time.monotonic() - began
    changes = changes_of(bench.instance)
    if each * len(changes) > task.options["seconds"]:
        changes = grouped(changes)
    deadline = began + task.options["seconds"]
    responses, broken, late = [], [], 0
    # what a flag such as `valid` gates answers only while the flag is up: so once more with every flag turned over
    flags = [part for change in changes.values() for part in change if bench.instance.write[part[0]][3] == "Boolean"]
    for context in ([], flags) if flags else ([],):
        try:
            about = (base, shortened) if not context else bases(bench, context)
        except Failed:
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
            except Failed as error:
                broken += [] if context else [f"{folded(inputs)}: a small change is refused: {error}"]
                bench.renew()
    return judged(task, responses, broken, late, bench.window)


def bases(bench: Bench, context: Change) -> tuple[Any, Any]:
    """Return the outputs without the change; also those after a short step, for an FMU that makes one."""
    any_step = bench.task.experiment.any_step
    return bench.watch(context, bench.window), bench.watch(context, 1, short=True) if any_step else None


def changes_of(instance: Instance) -> dict[tuple[str, ...], Change]:
    """Return a change of each input that can be changed, by its name alone."""
    found: dict[tuple[str, ...], Change] = {}
    for setter, (_, _, _, kind) in enumerate(instance.write):
        for column, port in enumerate(instance.experiment.of_kind("inputs", kind)):
            amount = _amount(port)
            if amount:
                found[(port.name,)] = [(setter, column, amount)]
    return found


def _amount(port: Port) -> float:
    """Return a change that stays within the range."""
    if port.kind == "Boolean":
        return 1.0 - 2.0 * port.start
    margin = port.nudge * (1.0 + port.swings)
    if port.start + margin <= port.maximum:
        return port.nudge
    return -port.nudge if port.start - margin >= port.minimum else 0.0


def grouped(changes: dict[tuple[str, ...], Change]) -> dict[tuple[str, ...], Change]:
    """Return one change of each array instead."""
    groups: defaultdict[str, list[str]] = defaultdict(list)
    parts: defaultdict[str, Change] = defaultdict(list)
    for (name,), change in changes.items():
        groups[base_name(name)].append(name)
        setter, column, amount = change[0]
        # unequal changes, so that they do not cancel in a sum or a difference
        share = 1.0 - 0.5 * (len(parts[base_name(name)]) * 0.6180339887498949 % 1.0)
        parts[base_name(name)].append((setter, column, amount * share if amount % 1.0 else amount))
    return {tuple(names): parts[base] for base, names in groups.items()}


def _response(
    bench: Bench, inputs: tuple[str, ...], change: Change, context: Change, base: Any, shortened: Any
) -> Response:
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
        feedthrough &= lasting(after[:1], base[1][:1], brief, shortened[1]) & sure
    return Response(inputs=inputs, first=first, direct=direct, feedthrough=feedthrough | direct, sure=sure)


def _sure(
    bench: Bench, change: Change, context: Change, answer: Trajectory, base: Trajectory, *, short: bool
) -> NDArray[np.bool_]:
    """Tell which answers shrink with the change: rounding, as of a conserved sum of large parts, does not."""
    sure = np.ones(unlike(answer, base).shape[1], bool)
    if all(bench.instance.write[setter][3] == "Real" for setter, _, _ in change):
        small = [(setter, column, REDUCED * amount) for setter, column, amount in change]
        _, reduced = bench.watch(context + small, 1, short=short)
        with np.errstate(all="ignore"):
            whole, part = (np.abs(run.reals - base.reals)[0] for run in (answer, reduced))
            sure[: len(whole)] = (part > 0.0) & (REDUCED * whole >= 0.5 * part)
    return sure


def lasting(full: Trajectory, full_base: Trajectory, brief: Trajectory, brief_base: Trajectory) -> NDArray[np.bool_]:
    """Tell which answers do not vanish with the step."""
    with np.errstate(all="ignore"):
        whole = np.abs(full.reals - full_base.reals)[0]
        short = np.abs(brief.reals - brief_base.reals)[0]
        rounding = ULPS * np.spacing(np.abs(brief_base.reals[0]))
    discrete = unlike(brief, brief_base)[0][len(whole) :]
    return np.concatenate([(short >= KEPT * whole) & (short > rounding), discrete])
