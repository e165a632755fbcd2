"""Where a run begins that goes on from a checkpoint, and how its components get there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockstep.checkpoint.bus_values import restore_bus
from lockstep.checkpoint.file import WAITING, Checkpoint
from lockstep.checkpoint.identity import changes, refuse_other
from lockstep.errors import InputError
from lockstep.fmi.slave import Scalar, Slave, Stateful
from lockstep.plan.overrides import Override
from lockstep.plan.plan import Plan
from lockstep.results.recorder import Kept
from lockstep.results.results_folder import make_folder
from lockstep.results.run_record import write_manifest
from lockstep.run.exchange import Exchange
from lockstep.system.clock import seconds, seconds_text
from lockstep.system.component import Value
from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class Restart:
    """A checkpoint to go on from; `reinitialised` components start there from their initial state."""

    checkpoint: Checkpoint
    reinitialised: tuple[str, ...] = ()
    again: bool = False  # the same run goes on in its folder, behind the rows that it had

    @property
    def kept(self) -> Kept | None:
        """What the recorder goes on with; None: it begins a file of its own."""
        if not self.again:
            return None
        checkpoint = self.checkpoint
        return Kept(written=int(checkpoint.header["rows"]), waiting=checkpoint.arrays[WAITING].tobytes())

    def take_folder(self, folder: Path, manifest: dict[str, object]) -> None:
        """Make the results folder of a branch, or take that of the run again; note in run.toml where it began."""
        told = {"checkpoint": str(self.checkpoint.path), "sha256": self.checkpoint.sha256}
        place = told | {"time": seconds(self.checkpoint.time)}
        if not self.again:
            manifest["branch"] = place | {"reinitialised": list(self.reinitialised)}
            make_folder(folder, manifest)
            return
        before = self.checkpoint.run
        manifest["resumed"] = [*before.get("resumed", []), place | {"started": manifest["started"]}]
        manifest["started"] = before["started"]
        if "branch" in before:
            manifest["branch"] = before["branch"]
        write_manifest(folder, manifest)

    def plan(
        self,
        system: System,
        stop_time: float | str | None,
        overrides: Mapping[str, Override],
        record: Sequence[str] | None,
        record_period: float | str | None = None,
    ) -> tuple[Plan, dict[str, Override]]:
        """Return the run, with what held in the one of the checkpoint unless other is given; and all its overrides."""
        before = self.checkpoint.run
        given = {**before["overrides"], **overrides}
        if not self.reinitialised:  # another FMU may not have what was recorded
            record = before["record"] if record is None else record
            record_period = before["record_period"] if record_period is None else record_period
        stop = before["stop_time"] if stop_time is None else stop_time
        return Plan(system, stop, given, record, record_period), given

    def check(self, plan: Plan) -> None:
        """Refuse by name, before any FMU is started, a run that cannot go on from this checkpoint."""
        name, time = self.checkpoint.path.name, self.checkpoint.time
        identity = self.checkpoint.header["identity"]
        refuse_other(identity, plan, self.reinitialised, name)
        for component in plan.system.components:
            if component.name not in self.reinitialised and component.name not in self.checkpoint.states:
                remedy = f"give --reinitialise {component.name}"
                raise InputError(f"{component.name}: {name} holds no state of it; {remedy}")
        changes(identity, plan, self.reinitialised, name)
        if plan.stop_time <= time:
            times = f"stop time {seconds_text(plan.stop_time)} s"
            raise InputError(f"{times}: not after {name}, which is of {seconds_text(time)} s; choose a later one")

    def restore(self, plan: Plan, slaves: Mapping[str, Slave], exchange: Exchange, temporary: Path) -> None:
        """Bring the components to the checkpoint, all but the reinitialised ones, and the bus too."""
        checkpoint, time = self.checkpoint, seconds(self.checkpoint.time)
        old = [task.name for task in plan.schedule.tasks if task.name not in self.reinitialised]
        for number, name in enumerate(old):
            slave = slaves[name]
            if not isinstance(slave, Stateful):
                raise InputError(f"{name}: cannot take a state; give --reinitialise {name}")
            place = temporary / f"state-{number}"
            place.mkdir()
            for file, content in checkpoint.states[name].items():
                (place / file).write_bytes(content)
            exchange.check(name, "SetFMUstate", time, slave.restore_state(str(place)))
        restore_bus(checkpoint, plan, exchange, exchange.present, self.reinitialised)
        self._restore_faults(slaves, exchange)
        for name, values in changes(
            checkpoint.header["identity"], plan, self.reinitialised, checkpoint.path.name
        ).items():
            for scalar, part in _by_type(plan, name, values).items():
                exchange.check(name, f"Set{scalar}", time, slaves[name].set_start(part, scalar))
        for name in old:
            exchange.fetch_present(name)

    def _restore_faults(self, slaves: Mapping[str, Slave], exchange: Exchange) -> None:
        """Take up the faults of the run again, or undo for a branch what they had made of parameters."""
        tick, saved = self.checkpoint.tick, self.checkpoint.header["faults"]
        if self.again:
            if exchange.faults is not None:
                exchange.faults.go_on(saved, tick)
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
