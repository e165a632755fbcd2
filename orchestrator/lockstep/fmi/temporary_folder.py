"""Temporary folders that FMUs run from: removed at the end, or later where their process was killed."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.operating_system import lock_file, names_living_process, process_lives, refuses_programs

_REMEDY = "set TMPDIR to another folder"
_NAME, _LOCK = re.compile(r"lockstep-[a-z]+-(\d+)-"), ".lock"  # the number is the process's that made it
_YOUNG = 60.0  # [s]: one that is being made may not be locked yet
_YOUNGEST = 1.0  # [s]: the same, of a process that does not live here; others may share the disk


def unpacking_folder() -> Path:
    """Return the folder in which to create temporary folders for FMUs, or raise TemporaryFolderError.

    FMUs made by pythonfmu 0.7 undo no percent-encoding in the URI of their resources but that of the blank, and crash
    for letters outside ASCII: then /tmp is used instead, where there is one.
    """
    try:
        folder = Path(tempfile.gettempdir()).absolute()
    except OSError as error:  # it tries to write to each that it knows
        raise TemporaryFolderError(f"no temporary folder can be written ({error.strerror}); {_REMEDY}") from None
    if "%" in folder.as_uri().replace("%20", "") and os.access("/tmp", os.W_OK | os.X_OK):
        folder = Path("/tmp")
    if refuses_programs(folder):
        raise TemporaryFolderError(f"temporary folder {folder}: mounted noexec, so no FMU can run from it; {_REMEDY}")
    return folder


@contextmanager
def temporary_folder(purpose: str) -> Iterator[Path]:
    """Make a folder that is locked while this process lives, and remove it at the end.

    First remove those of processes that were killed. Raises TemporaryFolderError if none can be made.
    """
    parent = unpacking_folder()
    remove_abandoned(parent)
    try:
        made = tempfile.TemporaryDirectory(
            prefix=f"lockstep-{purpose}-{os.getpid()}-", dir=parent, ignore_cleanup_errors=True
        )
    except OSError as error:
        raise TemporaryFolderError(f"temporary folder {parent}: {error.strerror}; {_REMEDY}") from None
    with made as name:
        folder = Path(name)
        try:
            unlock = lock_file(folder / _LOCK)
            (folder / _LOCK).write_text(f"{os.getpid()}\n")  # it has been locked: once it is free, its use has ended
        except OSError as error:
            raise TemporaryFolderError(f"temporary folder {folder}: {error.strerror}; {_REMEDY}") from None
        try:
            yield folder
        finally:
            if unlock is not None:
                unlock()


def remove_abandoned(parent: Path) -> list[Path]:
    """Remove and return the folders of processes that have ended, so that their locks are free or never came to be."""
    removed = []
    for folder in parent.glob("lockstep-*"):
        named = _NAME.match(folder.name)
        if named is not None:
            with suppress(OSError):  # of another user, or removed meanwhile
                unlock = _abandoned(folder, int(named[1]))
                if unlock is not None:
                    shutil.rmtree(folder, ignore_errors=True)
                    removed.append(folder)
                    unlock()
    return removed


def _abandoned(folder: Path, process: int) -> Callable[[], None] | None:
    """Return what releases the lock of a folder that nobody uses; None if one may use it."""
    lock = folder / _LOCK
    if not lock.exists():  # its process was killed before it locked it, or while it removed it
        changed = folder.stat().st_mtime
        in_use = process_lives(process, changed) or time.time() - changed < _YOUNGEST
        return None if in_use else lambda: None
    state = lock.stat()
    if state.st_size == 0 and time.time() - state.st_mtime < _YOUNG:
        return None
    return None if names_living_process(lock, state.st_mtime) else lock_file(lock)
