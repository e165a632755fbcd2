"""A general FMI 2.0 co-simulation master: system files, schedule, slaves, recording."""

from lockstep.errors import InputError, RunError
from lockstep.master import RunSummary, simulate
from lockstep.results import Signals, read_signals
from lockstep.ssp import load_system
from lockstep.ssp_writer import write_ssd
from lockstep.system import Component, Connection, Connector, System
from lockstep.units import Unit

__all__ = [
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
    "read_signals",
    "simulate",
    "write_ssd",
]
