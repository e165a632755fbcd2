"""A general FMI co-simulation master: system files, schedule, slaves, recording.

The names below are imported when they are first used: a process that checks an FMU needs none of them, and there are
dozens of those processes.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lockstep.checkpoint.file import Checkpoint, read_checkpoint
    from lockstep.checkpoint.restart import Restart
    from lockstep.checkpoint.schedule import CheckpointSchedule
    from lockstep.errors import InputError, RunError
    from lockstep.faults.read import read_scenario
    from lockstep.results.read import Signals, read_signals
    from lockstep.simulation import Run, RunOptions, RunSummary, Snapshot, open, resume, simulate
    from lockstep.ssp.load import load_system
    from lockstep.ssp.write import write_ssd
    from lockstep.system.component import Component, Connector
    from lockstep.system.system import Connection, System
    from lockstep.system.units import Unit

__all__ = [
    "Checkpoint",
    "CheckpointSchedule",
    "Component",
    "Connection",
    "Connector",
    "InputError",
    "Restart",
    "Run",
    "RunError",
    "RunOptions",
    "RunSummary",
    "Signals",
    "Snapshot",
    "System",
    "Unit",
    "load_system",
    "open",
    "read_checkpoint",
    "read_scenario",
    "read_signals",
    "resume",
    "simulate",
    "write_ssd",
]

_HOMES = {
    "checkpoint.restart": ("Restart",),
    "checkpoint.file": ("Checkpoint", "read_checkpoint"),
    "checkpoint.schedule": ("CheckpointSchedule",),
    "errors": ("InputError", "RunError"),
    "faults.read": ("read_scenario",),
    "simulation": ("Run", "RunOptions", "RunSummary", "Snapshot", "open", "resume", "simulate"),
    "results.read": ("Signals", "read_signals"),
    "ssp.load": ("load_system",),
    "ssp.write": ("write_ssd",),
    "system.component": ("Component", "Connector"),
    "system.system": ("Connection", "System"),
    "system.units": ("Unit",),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"lockstep.{module}"), name)
    raise AttributeError(f"module 'lockstep' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
