"""Faults at run time: bound where they act, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from lockstep.faults.resolve import Group, Resolved
from lockstep.fmi.slave import DTYPES, Buffer, Scalar, Slave
from lockstep.system.component import Value

Call = Callable[[], int]
Step = Callable[[float], None]
Check = Callable[[str, str, float, int], None]  # of a call's status: component, call, time, status


class Note(Protocol):
    """Writes an event at the present simulated time: `lockstep.results.run_record.Events.add`."""

    def __call__(self, event: str, **details: object) -> None:
        """Write it."""
        ...


class Faults:
    """All faults of one run, with what they remember."""

    def __init__(self, resolved: Resolved, note: Note) -> None:
        self._resolved, self._note = resolved, note
        self._waiting = list(reversed(resolved.lines))  # the next one last
        self._tick = 0
        self._settings: dict[str, list[Step]] = {}
        self._present: dict[tuple[str, Scalar], dict[int, Value]] = {}  # parameters, by reference

    def begin_tick(self, time: float) -> None:
        """Take the time of a tick, and write the events that belong to it. Called before all else in a tick."""
        self._tick = tick = round(time * 1e9 / self._resolved.tick)
        waiting = self._waiting
        while waiting and waiting[-1].tick <= tick:
            self._note("fault", **waiting.pop().details)

    def finish(self) -> None:
        """Write that what acts to the end of the run ends with it."""
        while self._waiting:
            self._note("fault", **self._waiting.pop().details)

    def saved(self) -> dict[str, Any]:
        """Return what the faults remember, and which parameters are not what they are without them; for JSON."""
        groups = (*self._resolved.transfers, *self._resolved.settings)
        altered = [
            [group.component, group.scalar, reference, name, original]
            for group in self._resolved.settings
            for reference, name, original in zip(group.references, group.names, group.originals, strict=True)
            if self._present.get((group.component, group.scalar), {}).get(reference, original) != original
        ]
        present = [[*key, [list(item) for item in values.items()]] for key, values in self._present.items()]
        return {"memory": [group.effect.saved() for group in groups], "altered": altered, "present": present}

    def go_on(self, saved: Mapping[str, Any], tick: int) -> None:
        """Take up what the same faults remembered before a tick. Events before it have been written."""
        groups = (*self._resolved.transfers, *self._resolved.settings)
        for group, memory in zip(groups, saved["memory"], strict=True):
            group.effect.restore(memory)
        self._present = {(name, scalar): dict(items) for name, scalar, items in saved["present"]}
        self._waiting = [line for line in self._waiting if line.tick >= tick]

    def begin_at(self, tick: int) -> None:
        """Begin at a tick: what ended before it is not told, and what acts there begins there."""
        ended = [line.details for line in self._waiting if line.details["state"] == "end" and line.tick <= tick]
        keys = [(details["name"], details["component"]) for details in ended]
        self._waiting = [
            line for line in self._waiting if (line.details["name"], line.details["component"]) not in keys
        ]

    def on_transfer(self, name: str, scalar: Scalar, targets: Sequence[int], buffer: Buffer, call: Call) -> Call:
        """Return a call that alters a component's inputs in the buffer, then sets them by `call`.

        It is `call` itself where no fault acts. `targets` are the inputs' references, in the order of the buffer.
        """
        place = {target: k for k, target in enumerate(targets)}
        works = [
            (group, np.array([place[reference] for reference in group.references], np.intp))
            for group in self._resolved.transfers
            if (group.component, group.scalar) == (name, scalar) and group.references[0] in place
        ]
        if not works:
            return call

        def altered() -> int:
            tick = self._tick
            for group, places in works:
                if tick < group.end:
                    values = buffer[places]
                    group.effect.see(tick, values)
                    if tick >= group.begin:
                        buffer[places] = group.effect.act(tick, values)
            return call()

        return altered

    def on_step(self, name: str, slave: Slave, check: Check) -> list[Step]:
        """Return what has to be called before each step of a component to set its parameters; the same each time."""
        if name not in self._settings:
            groups = [group for group in self._resolved.settings if group.component == name]
            self._settings[name] = [
                self._setting(name, scalar, [group for group in groups if group.scalar == scalar], slave, check)
                for scalar in dict.fromkeys(group.scalar for group in groups)
            ]
        return self._settings[name]

    def _setting(self, name: str, scalar: Scalar, groups: Sequence[Group], slave: Slave, check: Check) -> Step:
        originals = {r: v for group in groups for r, v in zip(group.references, group.originals, strict=True)}
        present = self._present.setdefault((name, scalar), dict(originals))
        last = max(group.end for group in groups)

        def setting(time: float) -> None:
            tick = self._tick
            if tick >= last and present == originals:
                return
            wanted = _altered(tick, groups, originals)
            changed = {r: v for r, v in wanted.items() if v != present[r]}  # NaN differs from itself: set each time
            if changed:
                present.update(changed)
                check(name, f"Set{scalar}", time, slave.set_start(changed, scalar))

        return setting


def _altered(tick: int, groups: Sequence[Group], originals: Mapping[int, Value]) -> dict[int, Value]:
    values = dict(originals)
    for group in groups:
        if group.begin <= tick < group.end:
            before: Buffer = np.array([values[reference] for reference in group.references], DTYPES[group.scalar])
            group.effect.see(tick, before)
            after = group.effect.act(tick, before).tolist()
            values |= dict(zip(group.references, after, strict=True))
    return values
