"""The folder that a run unpacks its FMUs to: removed at the end of the run, or by a later run if that was killed."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.fmi.temporary_folder import temporary_folder, unpacking_folder
from lockstep.operating_system import lock_file, names_living_process

_PREFIX, _LOCK = "lockstep-", ".lock"
_YOUNG = 60.0  # [s]: one that is being made may not be locked yet


@contextmanager
def run_folder(removed: Callable[[Path], None] = lambda _: None) -> Iterator[Path]:
    """Make a folder that is locked while this process lives; first remove those of killed runs, reporting each."""
    parent = unpacking_folder()
    for path in remove_abandoned(parent):
        removed(path)
    with temporary_folder(_PREFIX) as folder:
        try:
            release = lock_file(folder / _LOCK)
            (folder / _LOCK).write_text(f"{os.getpid()}\n")  # it has been locked: once it is free, its run has ended
        except OSError as error:
            raise TemporaryFolderError(
                f"temporary folder {folder}: {error.strerror}; set TMPDIR to another one"
            ) from None
        try:
            yield folder
        finally:
            if release is not None:
                release()


def remove_abandoned(parent: Path) -> list[Path]:
    """Remove and return the folders of runs whose processes have ended, so that their locks are free."""
    removed = []
    for path in parent.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError):  # of another user, or removed meanwhile
            state = path.stat()
            if state.st_size == 0 and time.time() - state.st_mtime < _YOUNG:
                continue
            release = None if names_living_process(path, state.st_mtime) else lock_file(path)
            if release is not None:
                shutil.rmtree(path.parent, ignore_errors=True)
                removed.append(path.parent)
                release()
    return removed
