"""The whole state of a run between two ticks, to go back to or to branch from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lockstep.checkpoint.identity import identity
from lockstep.checkpoint.schedule import saves_state
from lockstep.checkpoint.states import State, restore_state, saved_states
from lockstep.errors import InputError, compact
from lockstep.faults.inject import KeptFaults
from lockstep.fmi.slave import Buffer, Scalar
from lockstep.results.recorder import KeptRows, SavedRows
from lockstep.results.run_record import KeptEvents
from lockstep.simulation.open_run import OpenRun
from lockstep.system.clock import seconds

Branch = tuple[tuple[int, int], ...]  # number of each branch and the tick at which it began, the first one first


@dataclass(frozen=True, slots=True, kw_only=True, repr=False, eq=False)
class Snapshot:
    """What `Run.snapshot` returns and `Run.restore` takes, also that of another run of the same system.

    It can be pickled. A pickled one holds no recorded rows: those of a run that restores it begin at its time.
    """

    time: float  # [s]
    tick: int
    states: Mapping[str, State]
    bus: Mapping[Scalar, Buffer]
    faults: KeptFaults | None
    events: KeptEvents | None
    rows: KeptRows | SavedRows | None
    branch: Branch
    of: Mapping[str, Any]  # what the run has to be

    @property
    def size(self) -> int:
        """Bytes of the states of the FMUs."""
        return sum(len(content) for state in self.states.values() for content in state.values())

    def __repr__(self) -> str:
        """Describe the snapshot in one line."""
        return f"<Snapshot at {self.time:.9g} s of {compact(self.states, 4)}: {self.size} bytes>"

    def __getstate__(self) -> tuple[Any, ...]:
        """Return all but the rows and events, for pickle."""
        return (self.time, self.tick, self.states, self.bus, self.faults, self.branch, self.of)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        """Restore what `__getstate__` returned."""
        names = ("time", "tick", "states", "bus", "faults", "branch", "of")
        for name, value in (*zip(names, state, strict=True), ("events", None), ("rows", None)):
            object.__setattr__(self, name, value)


def take_snapshot(run: OpenRun, branch: Branch) -> Snapshot:
    """Return the state of a run between two ticks; InputError if a component cannot save its state."""
    plan, exchange, recorder, tick = run.plan, run.exchange, run.recorder, run.run.loop.done
    unable = [c.name for c in plan.system.components if not saves_state(c, plan)]
    if unable:
        raise InputError(f"{compact(unable)}: cannot save its state (canGetAndSetFMUstate, canSerializeFMUstate), so "
                         "there can be no snapshot; use FMUs that can")  # fmt: skip
    time = seconds(plan.schedule.time(tick))
    return Snapshot(
        time=time,
        tick=tick,
        states=saved_states(run.saver.slaves, run.saver.slaves, exchange, time, run.saver.temporary),
        bus={scalar: values.copy() for scalar, values in exchange.bus.items()},
        faults=None if exchange.faults is None else exchange.faults.kept(),
        events=run.run.events.kept(),
        rows=recorder.kept() if run.run.folder is None else recorder.saved(),
        branch=branch,
        of=_must_be(run),
    )


def check_snapshot(run: OpenRun, snapshot: Snapshot, branch: Branch) -> None:
    """Refuse a snapshot of another system, and one whose rows the folder of the run does not hold."""
    if run.run.observed is not None:
        raise InputError("restore: a run with `watch` cannot go back, as what it has seen cannot; open it without")
    here = _must_be(run)
    differing = [what for what, value in snapshot.of.items() if value != here[what]]
    if differing:
        found = ", another ".join(differing)
        raise InputError(f"{snapshot!r}: its run had another {found}; restore it in a run that is opened alike")
    if isinstance(snapshot.rows, SavedRows) and snapshot.branch[0] == branch[0]:
        depth = len(snapshot.branch)
        later = branch[depth][1] if len(branch) > depth else snapshot.tick
        if branch[:depth] != snapshot.branch or later < snapshot.tick:
            raise InputError(
                f"{snapshot!r}: its rows were replaced when the run went back before it; keep runs with several "
                "branches in memory, without a folder"
            )


def restore_snapshot(run: OpenRun, snapshot: Snapshot, branch: Branch) -> None:
    """Bring a run to a snapshot that was checked."""
    same_run = snapshot.branch[0] == branch[0]
    exchange, temporary = run.exchange, run.saver.temporary
    for name, slave in run.saver.slaves.items():
        restore_state(name, slave, snapshot.states[name], exchange, snapshot.time, temporary)
    for scalar, values in snapshot.bus.items():
        exchange.bus[scalar][:] = values
    if exchange.faults is not None and snapshot.faults is not None:
        exchange.faults.put_back(snapshot.faults)
    if snapshot.events is not None and same_run:
        run.run.events.put_back(snapshot.events)
    else:
        run.run.events.add("restored")
    rows = snapshot.rows
    if type(rows) is not (KeptRows if run.run.folder is None else SavedRows) or not same_run:
        rows = run.recorder.nothing()  # the rows are in another folder, or were pickled
    if isinstance(rows, KeptRows):
        run.recorder.put_back(rows)
        run.go_back(snapshot.tick)
    else:
        run.go_back(snapshot.tick)
        run.replace_recorder(rows)


def _must_be(run: OpenRun) -> dict[str, Any]:
    """Return by name what has to be equal in a run that restores the snapshot."""
    if run.identity:
        return run.identity
    plan = run.plan
    faults = run.run.record.get("faults", [])
    same = identity(plan)
    for name, part in same["components"].items():
        variables = plan.descriptions[name].variables
        part.pop("source")
        part["parameters"] = {  # the states hold the others
            key: value
            for key, value in part["parameters"].items()
            if key in variables and (variables[key].causality, variables[key].variability) == ("parameter", "fixed")
        }
    run.identity = {
        "system": same,
        "recording": ([signal.name for signal in plan.signals], plan.layout.record_ticks),
        "faults": [scenario["sha256"] for scenario in faults] if isinstance(faults, list) else [],
    }
    return run.identity
