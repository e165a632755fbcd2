"""Start FMUs in the master's process, or in processes of their own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.kept_fmus import KeptFmus
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.slave import Slave
from lockstep.fmi.sums_slave import SumsSlave
from lockstep.processes.connection import Connection
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.watched_process import Limits
from lockstep.system.component import Component


class SharedProcess:
    """The process that FMUs share which need none of their own. It is started for the first of them."""

    def __init__(self) -> None:
        self.connection: Connection | None = None

    def close(self) -> None:
        """End the process, if one of its FMUs could not be closed."""
        if self.connection is not None:
            self.connection.end()


def start_slave(
    component: Component,
    description: Description,
    folder: Path,
    log: Log,
    limits: Limits,
    shared: SharedProcess,
    kept: KeptFmus | None = None,
) -> Slave:
    """Instantiate the FMU of a component; if it is isolated, only start that, in its own or the shared process.

    One that is not isolated is taken from those that are kept, if there are such; `KeptFmus.end` takes it back.
    """
    if component.sums is not None:
        return SumsSlave(component.name, component.sums)
    if component.adapter is not None or component.shadow is not None:
        description = read_description(component)  # the given one has interface ports, or those of the shadow too
    if not component.isolated:
        if kept is not None:
            return kept.start(component, description, log)
        return instantiate(component, description, folder, log)
    if not component.grouped:
        return RemoteSlave(component, description, folder, log, limits)
    if shared.connection is None:
        shared.connection = Connection(component.name, folder, log, limits)
    return RemoteSlave(component, description, folder, log, connection=shared.connection)


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
