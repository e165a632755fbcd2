"""The folder that a run unpacks its FMUs to: removed at its end, or by a later run if it was killed before."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lockstep.fmi.safe_zip import unpacking_place

_PREFIX, _LOCK = "lockstep-", ".lock"
_YOUNG = 60.0  # [s]: one that is being made may not be locked yet


@contextmanager
def run_folder(removed: Callable[[Path], None] = lambda _: None) -> Iterator[Path]:
    """Make a folder that is locked while this process lives; remove those that killed runs left, and tell of each."""
    place = unpacking_place()
    for path in remove_abandoned(Path(place or tempfile.gettempdir())):
        removed(path)
    with tempfile.TemporaryDirectory(prefix=_PREFIX, dir=place, ignore_cleanup_errors=True) as name:
        folder = Path(name)
        lock = os.open(folder / _LOCK, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            os.write(lock, f"{os.getpid()}\n".encode())  # says that it has been locked: free means dead from now on
            yield folder
        finally:
            os.close(lock)


def remove_abandoned(place: Path) -> list[Path]:
    """Remove the folders of runs whose processes are gone: nobody holds their locks. Return them."""
    removed = []
    for path in place.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError):  # locked, somebody else's, or gone meanwhile
            state = path.stat()
            if state.st_size == 0 and time.time() - state.st_mtime < _YOUNG:
                continue
            lock = os.open(path, os.O_RDWR)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(path.parent, ignore_errors=True)
                removed.append(path.parent)
            finally:
                os.close(lock)
    return removed
