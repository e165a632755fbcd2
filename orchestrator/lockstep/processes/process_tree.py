"""Processes of others: which are left of a session, and what ended one."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path


def running(session: int, environment: Mapping[str, str]) -> list[int]:
    """Return the processes of a session, and those that left it but still carry its environment; zombies aside."""
    marks = {f"{name}={value}".encode() for name, value in environment.items()}
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, its_session = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            if state != "Z" and (
                int(its_session) == session or marks <= set((folder / "environ").read_bytes().split(b"\0"))
            ):
                found.append(int(folder.name))
        except (OSError, ValueError):  # it has ended, or belongs to another user
            continue
    return found


def signal_name(code: int) -> str:
    """Return the name of the signal that an exit code < 0 tells."""
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"signal {-code}"
