"""Save the states of slaves as bytes, by component and file, and put slaves into them."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Protocol, TypeGuard

from lockstep.errors import InputError
from lockstep.fmi.saved_state import FILE
from lockstep.fmi.slave import ERROR, Slave, Stateful
from lockstep.run.exchange import Exchange

State = Mapping[str, bytes]  # by file
_FOLDER = "state"


def saved_states(
    names: Iterable[str], slaves: Mapping[str, Slave], exchange: Exchange, time: float, temporary: Path
) -> dict[str, State]:
    """Return the states of components at a time [s]; RunError if one fails to save its state."""
    return {name: _saved(name, slaves[name], exchange, time, temporary / _FOLDER) for name in names}


class OneFile(Protocol):
    """A slave whose saved state is one file, which it returns and takes as bytes too."""

    def state_bytes(self) -> tuple[int, bytes]:
        """Return a status of FMI and the content of the file."""
        ...

    def restore_bytes(self, content: bytes) -> int:
        """Restore it."""
        ...


def _has_one_file(slave: object) -> TypeGuard[OneFile]:
    return hasattr(slave, "state_bytes")  # ten times quicker than a protocol that is checked


def _saved(name: str, slave: Slave, exchange: Exchange, time: float, folder: Path) -> State:
    if _has_one_file(slave):
        status, content = slave.state_bytes()
        exchange.check(name, "GetFMUstate", time, status)
        return {FILE: content}
    folder.mkdir()
    try:
        status = slave.save_state(str(folder)) if isinstance(slave, Stateful) else ERROR
        exchange.check(name, "GetFMUstate", time, status)
        return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def restore_state(name: str, slave: Slave, state: State, exchange: Exchange, time: float, temporary: Path) -> None:
    """Put a component into a state at a time [s]; RunError if it fails, InputError if it cannot restore states."""
    if not isinstance(slave, Stateful):
        raise InputError(f"{name}: cannot restore a state; give --reinitialise {name}")
    if _has_one_file(slave):
        if FILE not in state:
            raise FileNotFoundError(f"{FILE} is not among {', '.join(state) or 'its files'}")
        exchange.check(name, "SetFMUstate", time, slave.restore_bytes(state[FILE]))
        return
    folder = temporary / _FOLDER
    folder.mkdir()
    try:
        for file, content in state.items():
            (folder / file).write_bytes(content)
        status = slave.restore_state(str(folder))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    exchange.check(name, "SetFMUstate", time, status)
