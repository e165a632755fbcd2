"""Start a run from a checkpoint: the same run again in its folder, or a branch with other values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

from lockstep.array_names import name_and_arrays
from lockstep.checkpoint.bus_values import restore_bus
from lockstep.checkpoint.check_content import WAITING
from lockstep.checkpoint.file import Checkpoint
from lockstep.checkpoint.identity import changes, refuse_other
from lockstep.checkpoint.states import restore_state
from lockstep.errors import InputError
from lockstep.fmi.slave import Scalar, Slave
from lockstep.plan.input_files import Paths, unchanged
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.results.recorder import SavedRows, waiting_rows
from lockstep.results.results_folder import ResultsFolder
from lockstep.results.run_record import Events, write_run_record
from lockstep.run.exchange import Exchange
from lockstep.shadow.component import with_shadow_components
from lockstep.system.clock import nanoseconds, seconds, seconds_text, stored_seconds
from lockstep.system.component import Value
from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class Restart:
    """A checkpoint to start from; `reinitialised` components start there from their initial state."""

    checkpoint: Checkpoint
    reinitialised: tuple[str, ...] = ()
    same_run: bool = False  # resume the run in its own folder, after the rows that it had recorded

    @property
    def saved_rows(self) -> SavedRows | None:
        """Rows that the recorder continues after; None: it starts a file of its own."""
        if not self.same_run:
            return None
        checkpoint = self.checkpoint
        return SavedRows(written=int(checkpoint.header["rows"]), waiting=checkpoint.arrays[WAITING].tobytes())

    @property
    def wall_time_before(self) -> float:
        """Wall time of the same run before the checkpoint [s]."""
        return float(self.checkpoint.header["wall_time"]) if self.same_run else 0.0

    def prepare_folder(self, folder: ResultsFolder | None, record: dict[str, object]) -> None:
        """Make the results folder of a branch, or reuse that of the same run; note the checkpoint in run.toml.

        Without a folder, which only a branch can be, it is noted in the record alone.
        """
        checkpoint = self.checkpoint
        start = {
            "checkpoint": str(checkpoint.path),
            "sha256": checkpoint.sha256,
            "time": stored_seconds(checkpoint.time),
        }
        if not self.same_run:
            record["branch"] = start | {"reinitialised": list(self.reinitialised)}
            if folder is not None:
                folder.fill(record)
            return
        assert folder is not None
        before = checkpoint.run
        record["resumed"] = [*before.get("resumed", []), start | {"started": record["started"]}]
        record["started"] = before["started"]
        if "branch" in before:
            record["branch"] = before["branch"]
        write_run_record(folder.path, record)

    def open_events(self, events: Events, folder: Path | None, stop_time: float) -> None:
        """Open the events of the run, and note in them that it starts from the checkpoint."""
        start = {"checkpoint": str(self.checkpoint.path), "stop_time": stop_time}
        if self.same_run:
            assert folder is not None
            events.open_again(folder, self.checkpoint.header["events"])
            events.add("resume", **start)
        else:
            if folder is not None:
                events.open(folder)
            events.add("branch", **start, reinitialised=list(self.reinitialised))

    def plan(
        self,
        system: System,
        stop_time: float | str | None,
        overrides: Mapping[str, Override],
        record: Sequence[str] | None,
        record_period: float | str | None = None,
        *,
        strict_inputs: bool = False,
        strict: bool = False,
        inputs: Paths | None = None,
    ) -> tuple[Plan, dict[str, Override]]:
        """Return the plan, with the settings of the checkpoint's run where none are given; and all its overrides."""
        before = self.checkpoint.run
        earlier = {k: v for k, v in before["overrides"].items() if not overrides.keys() & set(name_and_arrays(k))}
        given = {**earlier, **overrides}
        if not self.reinitialised:  # another FMU may lack the signals that were recorded
            record = before["record"] if record is None else record
            record_period = before["record_period"] if record_period is None else record_period
        stop = before["stop_time"] if stop_time is None else stop_time
        files = unchanged(before.get("inputs", [])) if inputs is None else inputs
        return Plan(system, stop, given, record, record_period, strict_inputs, strict, files), given

    def tolerances(self, system: System) -> dict[str, float]:
        """Return the tolerances of the checkpoint's run that the components of a system lack, by component."""
        entries = self.checkpoint.run["component"]
        entries = [part for entry in entries for part in (entry, entry.get("shadow", {}))]
        saved = {part["name"]: part["tolerance"] for part in entries if "tolerance" in part}
        return {
            component.name: saved[component.name]
            for component in with_shadow_components(system)
            if component.tolerance is None and component.name in saved and component.name not in self.reinitialised
        }

    def check(self, plan: Plan) -> None:
        """Refuse by name, before any FMU is started, a run that cannot start from this checkpoint."""
        name, time = self.checkpoint.path.name, self.checkpoint.time
        identity = self.checkpoint.header["identity"]
        refuse_other(identity, plan, self.reinitialised, name)
        for component in plan.system.components:
            if component.name not in self.reinitialised and component.name not in self.checkpoint.states:
                remedy = f"give --reinitialise {component.name}"
                raise InputError(f"{component.name}: {name} holds no state of it; {remedy}")
        changes(identity, plan, self.reinitialised, name)
        if self.same_run:
            self._check_rows(plan)
        if plan.stop_time < time or (plan.stop_time == time and not self.same_run):
            times = f"stop time {seconds_text(plan.stop_time)} s"
            raise InputError(f"{times}: not after {name}, which is of {seconds_text(time)} s; choose a later one")

    def _check_rows(self, plan: Plan) -> None:
        """Refuse a checkpoint that has not all rows of its run: those on disk, and those that were waiting."""
        assert self.saved_rows is not None
        checkpoint, every = self.checkpoint, plan.layout.record_ticks
        try:
            waiting = waiting_rows(self.saved_rows, plan.signals)
        except ValueError as error:
            raise InputError(f"{checkpoint.path}: is a damaged checkpoint ({error}); use another one") from None
        start, branch = plan.system.start_time, checkpoint.run.get("branch")
        began = start if branch is None else nanoseconds(branch["time"], f"{checkpoint.path}: branch: time")
        first = (began - start) // plan.system.tick
        needed = -(-checkpoint.tick // every) - -(-first // every)
        if (rows := self.saved_rows.written + waiting) != needed:
            raise InputError(f"{checkpoint.path}: has {rows} rows of {needed} until its time; use another one")

    def restore(self, plan: Plan, slaves: Mapping[str, Slave], exchange: Exchange, temporary: Path) -> None:
        """Bring the components to the checkpoint, all but the reinitialised ones, and the bus too."""
        checkpoint, time = self.checkpoint, seconds(self.checkpoint.time)
        old = [task.name for task in plan.schedule.tasks if task.name not in self.reinitialised]
        for name in old:
            with self._refusing_damage(f"the state of {name}"):
                restore_state(name, slaves[name], checkpoint.states[name], exchange, time, temporary)
        restore_bus(checkpoint, plan, exchange, exchange.present, self.reinitialised)
        with self._refusing_damage("the memory of its faults"):
            self._restore_faults(slaves, exchange)
        changed = changes(checkpoint.header["identity"], plan, self.reinitialised, checkpoint.path.name)
        for name, values in changed.items():
            for scalar, part in _by_type(plan, name, values).items():
                exchange.check(name, f"Set{scalar}", time, slaves[name].set_start(part, scalar))
        for name in old:
            exchange.fetch_present(name)

    @contextmanager
    def _refusing_damage(self, what: str) -> Iterator[None]:
        """Raise InputError where what the checkpoint holds is not what was saved."""
        try:
            yield
        except InputError:
            raise
        except (ValueError, KeyError, TypeError, IndexError, EOFError, OSError, BadZipFile) as error:
            reason = f"{what}: {type(error).__name__}: {error}"
            raise InputError(f"{self.checkpoint.path}: is a damaged checkpoint ({reason}); use another one") from error

    def _restore_faults(self, slaves: Mapping[str, Slave], exchange: Exchange) -> None:
        """Restore the faults of the same run; for a branch, restore the parameters that they had changed."""
        tick, saved = self.checkpoint.tick, self.checkpoint.header["faults"]
        if self.same_run:
            if exchange.faults is not None:
                exchange.faults.resume(saved, tick)
            return
        for name, scalar, reference, _, original in saved["altered"] if saved else ():
            if name not in self.reinitialised:
                status = slaves[name].set_start({reference: original}, scalar)
                exchange.check(name, f"Set{scalar}", seconds(self.checkpoint.time), status)
        if exchange.faults is not None:
            exchange.faults.begin_at(tick)


def _by_type(plan: Plan, name: str, values: Mapping[str, Value]) -> dict[Scalar, dict[int, Value]]:
    found: dict[Scalar, dict[int, Value]] = {}
    for key, value in values.items():
        variable = plan.descriptions[name].variables[key]
        if variable.scalar is not None:
            found.setdefault(variable.scalar, {})[variable.reference] = value
    return found
