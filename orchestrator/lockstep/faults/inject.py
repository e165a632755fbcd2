"""Apply faults at run time, to the transfers and parameters that they name."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.faults.effects import Change, Delay, Stuck
from lockstep.faults.resolve import FaultEvent, Group, Resolved
from lockstep.fmi.slave import DTYPES, Buffer, Scalar, Slave
from lockstep.system.component import Value
from lockstep.tick.operations import ALWAYS, Alter, Operation, Python

CheckStatus = Callable[[str, str, float, int], None]  # component, call, time, status


class AddEvent(Protocol):
    """Record an event at the present simulated time: `lockstep.results.run_record.Events.add`."""

    def __call__(self, event: str, **details: object) -> None:
        """Record the event."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptFaults:
    """The memory of the faults of a run at some time, and the events that are still to come, the next one last."""

    memory: Mapping[str, Any]
    waiting: tuple[FaultEvent, ...]


class Faults:
    """Hold all faults of one run, with their memory."""

    def __init__(self, resolved: Resolved, add_event: AddEvent) -> None:
        self._resolved, self._add_event = resolved, add_event
        self._waiting = list(reversed(resolved.events))  # the next one last
        self._time, self._tick = math.nan, 0  # the newest time, and its tick
        # the first operation of each tick: it acts where an event is due
        self.at_tick = Python(call=self.begin_tick, following=self._next_event)
        self._start, self._length = float(resolved.start), float(resolved.tick)  # [ns]
        self._settings: dict[str, list[Operation]] = {}
        self._present: dict[tuple[str, Scalar], dict[int, Value]] = {}  # parameters, by reference

    def begin_tick(self, time: float) -> None:
        """Record the events of a tick. Called first in each tick."""
        tick = self._at(time)
        waiting = self._waiting
        while waiting and waiting[-1].tick <= tick:
            self._add_event("fault", **waiting.pop().details)

    def _next_event(self) -> int:
        return self._waiting[-1].tick if self._waiting else ALWAYS

    def _at(self, time: float) -> int:
        """Return the tick of a time."""
        if time != self._time:
            self._time, self._tick = time, round((time * 1e9 - self._start) / self._length)
        return self._tick

    def act_on(self, name: str) -> bool:
        """Return whether a component's inputs or parameters are altered at any time."""
        return any(group.component == name for group in (*self._resolved.transfers, *self._resolved.settings))

    @property
    def set_parameters(self) -> frozenset[tuple[str, Scalar, int]]:
        """The parameters that faults set: component, type and reference."""
        return frozenset((g.component, g.scalar, r) for g in self._resolved.settings for r in g.references)

    def finish(self) -> None:
        """Record the end of the faults that last to the end of the run."""
        while self._waiting:
            self._add_event("fault", **self._waiting.pop().details)

    def saved(self) -> dict[str, Any]:
        """Return the memory of the faults, and the parameters that they have altered, in types of JSON."""
        groups = (*self._resolved.transfers, *self._resolved.settings)
        altered = [
            [group.component, group.scalar, reference, name, original]
            for group in self._resolved.settings
            for reference, name, original in zip(group.references, group.names, group.originals, strict=True)
            if self._present.get((group.component, group.scalar), {}).get(reference, original) != original
        ]
        present = [[*key, [list(item) for item in values.items()]] for key, values in self._present.items()]
        return {"memory": [group.effect.saved() for group in groups], "altered": altered, "present": present}

    def resume(self, saved: Mapping[str, Any], tick: int) -> None:
        """Restore the memory of the same faults at a tick. Events before it have been recorded."""
        groups = (*self._resolved.transfers, *self._resolved.settings)
        for group, memory in zip(groups, saved["memory"], strict=True):
            group.effect.restore(memory)
        self._present = {(name, scalar): dict(items) for name, scalar, items in saved["present"]}
        self._waiting = [line for line in self._waiting if line.tick >= tick]

    def kept(self) -> KeptFaults:
        """Return the memory of the faults and the events to come, to go back to in the same run."""
        return KeptFaults(memory=self.saved(), waiting=tuple(self._waiting))

    def put_back(self, kept: KeptFaults) -> None:
        """Go back to what `kept` returned, with all calls that are bound."""
        groups = (*self._resolved.transfers, *self._resolved.settings)
        for group, memory in zip(groups, kept.memory["memory"], strict=True):
            group.effect.restore(memory)
        for name, scalar, items in kept.memory["present"]:
            present = self._present[name, scalar]  # which the calls hold
            present.clear()
            present.update(items)
        self._waiting = list(kept.waiting)

    def begin_at(self, tick: int) -> None:
        """Begin at a tick: faults that ended before it are not recorded, and those that act there begin there."""
        ended = [line.details for line in self._waiting if line.details["state"] == "end" and line.tick <= tick]
        keys = [(details["name"], details["component"]) for details in ended]
        self._waiting = [
            line for line in self._waiting if (line.details["name"], line.details["component"]) not in keys
        ]

    def on_transfer(self, name: str, scalar: Scalar, targets: Sequence[int], buffer: Buffer) -> list[Operation]:
        """Return what alters a component's inputs in the buffer before they are set.

        `targets` are the inputs' references, in the order of the buffer.
        """
        position = {target: k for k, target in enumerate(targets)}
        return [
            self._altered(group, np.array([position[reference] for reference in group.references], np.intp), buffer)
            for group in self._resolved.transfers
            if (group.component, group.scalar) == (name, scalar) and group.references[0] in position
        ]

    def _altered(self, group: Group, index: NDArray[np.intp], buffer: Buffer) -> Operation:
        """Return the operation of a group of values that are transferred together."""
        effect, begin, end = group.effect, group.begin, group.end

        def alter(time: float) -> None:
            tick = self._at(time)
            if tick < end:
                values = buffer[index]
                effect.observe(tick, values)
                if tick >= begin:
                    buffer[index] = effect.act(tick, values)

        if isinstance(effect, Change) and effect.linear is not None:
            kind, amounts = effect.linear
            return Alter(call=alter, kind=kind, buffer=buffer, index=index, first=begin, last=end, amounts=amounts)
        if buffer.dtype != object and isinstance(effect, Stuck):
            held = effect.prepare(buffer[index])
            return Alter(call=alter, kind="hold", buffer=buffer, index=index, first=begin, last=end, values=held,
                         history=effect.history)  # fmt: skip
        if buffer.dtype != object and isinstance(effect, Delay):
            transfers = effect.prepare(buffer[index], min(effect.ticks, end) + 2)  # at most one a tick
            return Alter(call=alter, kind="delay", buffer=buffer, index=index, first=begin, last=end, values=transfers,
                         history=effect.history)  # fmt: skip
        if isinstance(effect, Stuck | Delay):  # texts, which are observed before the window too
            return Python(call=alter, last=end)
        return Python(call=alter, first=begin, last=end)

    def on_step(self, name: str, slave: Slave, check: CheckStatus) -> list[Operation]:
        """Return what sets a component's parameters before each of its steps; the same operations each time."""
        if name not in self._settings:
            groups = [group for group in self._resolved.settings if group.component == name]
            self._settings[name] = [
                self._setting(name, scalar, [group for group in groups if group.scalar == scalar], slave, check)
                for scalar in dict.fromkeys(group.scalar for group in groups)
            ]
        return self._settings[name]

    def _setting(
        self, name: str, scalar: Scalar, groups: Sequence[Group], slave: Slave, check: CheckStatus
    ) -> Operation:
        originals = {r: v for group in groups for r, v in zip(group.references, group.originals, strict=True)}
        present = self._present.setdefault((name, scalar), dict(originals))
        last = max(group.end for group in groups)

        def setting(time: float) -> None:
            tick = self._at(time)
            if tick >= last and present == originals:
                return
            wanted = _altered(tick, groups, originals)
            changed = {r: v for r, v in wanted.items() if v != present[r]}  # NaN differs from itself: set each time
            if changed:
                present.update(changed)
                check(name, f"Set{scalar}", time, slave.set_start(changed, scalar))

        def following() -> int:  # what was altered is restored at the first step after all windows
            return ALWAYS if self._tick >= last and present == originals else 0

        first = min(group.begin for group in groups)
        return Python(call=setting, first=0 if present != originals else first, following=following)


def _altered(tick: int, groups: Sequence[Group], originals: Mapping[int, Value]) -> dict[int, Value]:
    values = dict(originals)
    for group in groups:
        if group.begin <= tick < group.end:
            before: Buffer = np.array([values[reference] for reference in group.references], DTYPES[group.scalar])
            group.effect.observe(tick, before)
            after = group.effect.act(tick, before).tolist()
            values |= dict(zip(group.references, after, strict=True))
    return values
