"""A general FMI co-simulation master: system files, schedule, slaves, recording.

The names below are imported when they are first used: a process that checks an FMU needs none of them, and there are
dozens of those processes.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lockstep.checkpoint.begin import Begin
    from lockstep.checkpoint.file import Checkpoint, read_checkpoint
    from lockstep.checkpoint.request import Checkpoints
    from lockstep.checkpoint.resume import resume
    from lockstep.errors import InputError, RunError
    from lockstep.faults.read import read_scenario
    from lockstep.master import RunSummary, simulate
    from lockstep.results import Signals, read_signals
    from lockstep.ssp import load_system
    from lockstep.ssp_writer import write_ssd
    from lockstep.system import Component, Connection, Connector, System
    from lockstep.units import Unit

__all__ = [
    "Begin",
    "Checkpoint",
    "Checkpoints",
    "Component",
    "Connection",
    "Connector",
    "InputError",
    "RunError",
    "RunSummary",
    "Signals",
    "System",
    "Unit",
    "load_system",
    "read_checkpoint",
    "read_scenario",
    "read_signals",
    "resume",
    "simulate",
    "write_ssd",
]

_HOMES = {
    "checkpoint.begin": ("Begin",),
    "checkpoint.file": ("Checkpoint", "read_checkpoint"),
    "checkpoint.request": ("Checkpoints",),
    "checkpoint.resume": ("resume",),
    "errors": ("InputError", "RunError"),
    "faults.read": ("read_scenario",),
    "master": ("RunSummary", "simulate"),
    "results": ("Signals", "read_signals"),
    "ssp": ("load_system",),
    "ssp_writer": ("write_ssd",),
    "system": ("Component", "Connection", "Connector", "System"),
    "units": ("Unit",),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"lockstep.{module}"), name)
    raise AttributeError(f"module 'lockstep' has no attribute {name!r}")
