"""Run an instance again and again from one moment, with an input changed, and compare the outputs.

An input is changed by a little before step `MOMENT` and stays changed. An output answers

- *directly* if it changes when it is read before any step: no FMI importer can miss that;
- *within the step* (latency 0) if it is changed after the step that saw the input first;
- after k steps otherwise.

An answer within the step is feedthrough for an FMU that samples (inputs count at the step's beginning, outputs hold
from there), but not for one that integrates (inputs are held, outputs are true at the step's end): there it vanishes
with the step. So an FMU that takes any step makes a short one too, and what does not vanish is feedthrough.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.array_names import array_of
from lockstep.check.dynamic.checked_instance import CheckedInstance
from lockstep.check.dynamic.experiment import PERIOD, Port
from lockstep.check.dynamic.probe_process import ProbeTask
from lockstep.check.dynamic.trajectory import Trajectory, unlike
from lockstep.errors import RunError
from lockstep.fmi.slave import FATAL, WARNING

MOMENT = 100  # the first changed step: one in which what samples every 2, 4, 5, 10, 20, 25, 50 or 100 steps samples
WINDOW = 104  # steps watched
SHORT = 1.0 / 16.0  # of the step
SHORTER = SHORT / 8.0
KEPT = 0.5  # share of the answer that is left after a short step, from which on it is feedthrough
REDUCED = 1.0 / 64.0  # of a change: what answers in proportion, or to a higher power, answers so much less
ULPS = 64.0  # answers smaller than this are rounding
OF_ARRAY = 1e-9  # of the largest answer of an array: less is rounding too

Change = list[tuple[int, int, float]]  # setter, column, amount


@dataclass(slots=True)
class Bench:
    """Returns an instance to the moment before the change, as often as needed."""

    task: ProbeTask
    moment: int
    window: int
    instance: CheckedInstance = field(init=False)
    _state: Any = None

    def __post_init__(self) -> None:
        self._new()

    def rewind(self) -> CheckedInstance:
        """Return the instance as it is before the moment."""
        if self._state is not None:
            self.instance.set_state(self._state)
        elif self.instance.worst > WARNING or not self.task.options["resets"]:
            self.instance.close()
            self._new()
        else:
            self.instance.reset()
            self.instance.initialise()
            self.instance.run(0, self.moment)
        return self.instance

    def renew(self) -> None:
        """Replace an instance that failed after a change."""
        if self.instance.worst >= FATAL:
            raise RunError("a changed input ends every instance in the process")
        self.instance.close()
        self._new()

    def _new(self) -> None:
        self.instance = self.task.started()
        self.instance.run(0, self.moment)
        self._state = self.instance.get_state() if self.task.options["state"] else None

    def advance(self, moment: int) -> None:
        """Move to a later moment."""
        if self._state is not None:
            instance = self.rewind()
            instance.run(self.moment, moment)
            instance.free_state(self._state)
            self._state = instance.get_state()
        self.moment = moment

    def watch(
        self, change: Change, steps: int, short: bool = False, share: float = SHORT
    ) -> tuple[Trajectory, Trajectory]:
        """Return the outputs before any step, and after each of some steps, or after one short one of this share."""
        instance = self.rewind()
        tables = [table.copy() for table in instance.stimuli()]
        for setter, column, amount in change:
            tables[setter][:, column] += np.asarray(amount).astype(tables[setter].dtype)
        instance.put([table[self.moment % PERIOD] for table in tables])
        experiment = self.task.experiment
        before = Trajectory.of_rows([instance.row()], experiment)
        if short:
            instance.step(experiment.time(self.moment), share * experiment.step)
            return before, Trajectory.of_rows([instance.row()], experiment)
        return before, instance.run(self.moment, self.moment + steps, tables=tables)


def bases(bench: Bench, context: Change) -> tuple[Any, Any]:
    """Return the outputs without the change; also those after a short step, for an FMU that makes one."""
    any_step = bench.task.experiment.any_step
    return bench.watch(context, bench.window), bench.watch(context, 1, short=True) if any_step else None


def changes_of(instance: CheckedInstance) -> dict[tuple[str, ...], Change]:
    """Return a change of each input that can be changed, by its name alone."""
    found: dict[tuple[str, ...], Change] = {}
    for setter, port_call in enumerate(instance.write):
        for column, port in enumerate(port_call.ports):
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


def lasting(
    full: Trajectory, full_base: Trajectory, brief: Trajectory, brief_base: Trajectory, names: Sequence[str]
) -> NDArray[np.bool_]:
    """Return which answers do not vanish with the step; `names` of the outputs, the Reals first."""
    with np.errstate(all="ignore"):
        whole = np.abs(full.reals - full_base.reals)[0]
        short = np.abs(brief.reals - brief_base.reals)[0]
        rounding = ULPS * np.spacing(np.abs(brief_base.reals[0]))
    # what is computed from common coordinates, as modes are, answers with the rounding of the whole array's answer
    rounding = np.maximum(rounding, OF_ARRAY * _largest_of_array(short, names))
    discrete = unlike(brief, brief_base)[0][len(whole) :]
    return np.concatenate([(short >= KEPT * whole) & (short > rounding), discrete])


def _largest_of_array(values: NDArray[np.float64], names: Sequence[str]) -> NDArray[np.float64]:
    """Return for each value the largest finite one of its array."""
    arrays = [base_name(name) for name in names[: len(values)]]
    largest: dict[str, float] = defaultdict(float)
    for array, value in zip(arrays, values.tolist(), strict=True):
        if value > largest[array] and np.isfinite(value):
            largest[array] = value
    return np.array([largest[array] for array in arrays])


@lru_cache(maxsize=2**14)  # asked for every output after every change of an input
def base_name(name: str) -> str:
    """Return the name of the array that an element belongs to."""
    return array_of(name)


def folded(names: Sequence[str]) -> str:
    """Return the names of some elements of one array in few words."""
    return names[0] if len(names) == 1 else base_name(names[0])
