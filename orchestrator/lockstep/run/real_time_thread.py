"""Give the thread that steps the FMUs a real-time priority and a core of its own, where the system permits."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field

from lockstep.errors import InputError
from lockstep.operating_system import Release, use_core, use_priority
from lockstep.processes.cpu_affinity import core_assignment

_PERMISSION = "; root may set it, and users whom `ulimit -r` permits it"


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTimeThread:
    """What was asked for, and what became of it."""

    record: dict[str, object] = field(default_factory=dict)  # for run.toml
    warnings: list[str] = field(default_factory=list)  # a line for each thing that is not there or not permitted


def thread_given(priority: int | str | None, core: int | str | None) -> tuple[int | None, int | None]:
    """Return a priority and the number of a core as whole numbers. Raises InputError."""
    return _whole(priority, 1, "realtime_priority"), _whole(core, 0, "core")


def _whole(value: int | str | None, least: int, name: str) -> int | None:
    if value is None:
        return None
    try:
        number = int(value)
    except (TypeError, ValueError):
        number = least - 1
    if isinstance(value, float) or number < least:
        raise InputError(f"{name} {value!r} must be a whole number from {least} on")
    return number


@contextmanager
def real_time_thread(priority: int | None, core: int | None) -> Iterator[RealTimeThread]:
    """Raise the calling thread in this block; what the system refuses is a warning, and the run goes on without."""
    thread = RealTimeThread()
    wanted: list[tuple[str, str, int | None, Callable[[int], Release]]] = [
        ("core", "core", core, use_core),
        ("priority", "real-time priority", priority, use_priority),
    ]
    with ExitStack() as stack:
        if core is not None:
            core_assignment().leave_thread()
        for name, what, value, use in wanted:
            if value is None:
                continue
            reason = ""
            try:
                stack.callback(use(value))
            except OSError as error:
                reason = _reason(error)
                thread.warnings.append(f"{what} {value}: the run goes on without it ({reason})")
            thread.record.update({name: value, f"{name}_used": not reason})
        yield thread


def _reason(error: OSError) -> str:
    text = error.strerror or os.strerror(error.errno or 0)
    return f"{text[0].lower()}{text[1:]}{_PERMISSION if isinstance(error, PermissionError) else ''}"
