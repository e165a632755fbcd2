"""FMUs that stay loaded from one run to the next, and are reset between them."""

from __future__ import annotations

from pathlib import Path

from lockstep.fmi.fmi1 import Fmi1Slave
from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.instantiate import instantiate
from lockstep.fmi.log_callbacks import Log
from lockstep.fmi.model_description import Description
from lockstep.fmi.slave import WARNING, Slave
from lockstep.system.component import Component

_Own = Fmi1Slave | Fmi2Slave
_Key = tuple[str, str, float | None]  # digest of the description, name of the instance, tolerance


class _Log:
    """Passes the messages of an instance to the run that it is in."""

    def __init__(self, to: Log) -> None:
        self.to = to

    def __call__(self, component: str, status: int, category: str, message: str) -> None:
        self.to(component, status, category, message)


class KeptFmus:
    """Instances of native FMUs between runs, in this process; those of FMI 3.0 and those with Python are started
    for each run.

    An instance that failed, or cannot be reset, is freed, and the next run gets a new one.
    """

    def __init__(self, folder: Path) -> None:
        """Unpack FMUs into a folder, which is there until `close` has been called."""
        self._folder = folder
        self._count = 0
        self._idle: dict[_Key, list[tuple[_Own, _Log]]] = {}
        self._lent: dict[int, tuple[_Key, _Own, _Log]] = {}

    def start(self, component: Component, description: Description, log: Log) -> Slave:
        """Return an instance of the FMU of a component as if it were new."""
        key = (description.sha256, component.name, description.tolerance_of(component))
        idle = self._idle.get(key)
        if idle:
            slave, passed = idle.pop()
            passed.to = log
        else:
            self._count += 1
            folder, passed = self._folder / str(self._count), _Log(log)
            started = instantiate(component, description, folder, passed)
            if (
                not isinstance(started, _Own)
                or description.once_per_process
                or description.needs_tool
                or any(folder.glob("resources/*.py"))
            ):
                return started
            slave = started
        self._lent[id(slave)] = key, slave, passed
        return slave

    def end(self, slave: Slave) -> None:
        """Take an instance back after a run and reset it; close it if it cannot be kept. Never raises."""
        key, own, passed = self._lent.pop(id(slave), (None, None, None))
        if key is None or own is None or passed is None:
            slave.close()
            return
        usable = own.instance.alive and own.instance.worst <= WARNING
        passed.to = _ignore
        own.forget_calls()
        if usable and own.reset() <= WARNING:
            self._idle.setdefault(key, []).append((own, passed))
        else:
            own.close()

    def close(self) -> None:
        """Free all instances."""
        for idle in self._idle.values():
            for slave, _ in idle:
                slave.close()
        self._idle.clear()


def _ignore(component: str, status: int, category: str, message: str) -> None:
    """Ignore a message between two runs."""
