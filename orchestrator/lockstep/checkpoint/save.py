"""Save the state of a run between two ticks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lockstep.checkpoint.bus_values import saved_bus
from lockstep.checkpoint.check_content import WAITING
from lockstep.checkpoint.file import FOLDER, checkpoint_name, write_checkpoint
from lockstep.checkpoint.identity import identity
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.checkpoint.states import saved_states
from lockstep.errors import InputError
from lockstep.fmi.slave import Slave, Stateful
from lockstep.plan.plan import Plan
from lockstep.results.recorder import Recorder
from lockstep.results.run_record import Events
from lockstep.run.exchange import Exchange
from lockstep.system.clock import seconds, stored_nanoseconds


@dataclass(frozen=True, slots=True, kw_only=True)
class Saver:
    """Saves a run, after the `ticks` of its schedule."""

    schedule: CheckpointSchedule
    ticks: list[int]
    plan: Plan
    slaves: Mapping[str, Slave]
    exchange: Exchange
    temporary: Path

    def __post_init__(self) -> None:
        for name, slave in self.slaves.items():
            if self.ticks and name not in self.schedule.without and not isinstance(slave, Stateful):
                raise InputError(f"{name}: cannot save its state; leave it out with --checkpoint-without {name}")

    def save(
        self,
        tick: int,
        folder: Path,
        recorder: Recorder,
        events: Events,
        run: Mapping[str, object],
        wall_time: float,
    ) -> Path:
        """Write the checkpoint before a tick; RunError if a component fails to save its state, OSError for the disk."""
        plan, time = self.plan, self.plan.schedule.time(tick)
        able = (name for name, slave in self.slaves.items() if isinstance(slave, Stateful))
        names = [name for name in able if name not in self.schedule.without]
        states = saved_states(names, self.slaves, self.exchange, seconds(time), self.temporary)
        bus, outputs = saved_bus(plan, self.exchange, tick)
        path = folder / FOLDER / checkpoint_name(time)
        events.add("checkpoint", file=f"{FOLDER}/{path.name}")
        rows = recorder.saved()
        header = {
            "tick": tick,
            "time": stored_nanoseconds(time),
            "wall_time": wall_time,
            "identity": identity(plan),
            "run": run,
            "outputs": outputs,
            "rows": rows.written,
            "events": events.saved(),
            "faults": None if self.exchange.faults is None else self.exchange.faults.saved(),
            "checkpoints": {
                "times": [str(time) for time in self.schedule.times],
                "every": None if self.schedule.every is None else str(self.schedule.every),
                "without": list(self.schedule.without),
            },
        }
        write_checkpoint(path, header, bus | {WAITING: np.frombuffer(rows.waiting, np.uint8)}, states)
        return path
