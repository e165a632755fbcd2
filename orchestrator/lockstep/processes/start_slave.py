"""Start FMUs in the master's process, or in processes of their own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import Slave
from lockstep.fmi.sums_slave import SumsSlave
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.watched_process import Limits
from lockstep.system.component import Component


def start_slave(component: Component, description: Description, folder: Path, log: Log, limits: Limits) -> Slave:
    """Instantiate the FMU of a component; if it is isolated, only start its process."""
    if component.sums is not None:
        return SumsSlave(component.name, component.sums)
    if component.adapter is not None or component.shadow is not None:
        description = read_description(component)  # the given one has interface ports, or those of the shadow too
    if component.isolated:
        return RemoteSlave(component, description, folder, log, limits)
    return instantiate(component, description, folder, log)


def wait_until_ready(slaves: Iterable[Slave]) -> None:
    """Wait until all processes are ready, or raise the error of one of them."""
    for slave in slaves:
        if isinstance(slave, RemoteSlave):
            slave.ready()


def limits_given(step: float | str | None) -> Limits:
    """Return the limits of isolated FMUs with this one for a call [s], or raise InputError."""
    if step is None:
        return Limits()
    try:
        limit = float(step)
    except (TypeError, ValueError):
        limit = math.nan
    if not 0.0 < limit < math.inf:
        raise InputError(f"step limit {step!r} must be a number of seconds > 0, for example 60")
    return Limits(step=limit)
