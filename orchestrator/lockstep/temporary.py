"""The folder that a run unpacks its FMUs to: removed at its end, or by a later run if it was killed before."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lockstep.archive import unpacking_place

_PREFIX, _LOCK = "lockstep-", ".lock"
_YOUNG = 60.0  # [s]: one that is being made may not be locked yet


@contextmanager
def run_folder() -> Iterator[Path]:
    """Make a folder that is locked while this process lives, and remove those that killed runs left."""
    place = unpacking_place()
    remove_abandoned(Path(place or tempfile.gettempdir()))
    with tempfile.TemporaryDirectory(prefix=_PREFIX, dir=place, ignore_cleanup_errors=True) as name:
        folder = Path(name)
        lock = os.open(folder / _LOCK, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield folder
        finally:
            os.close(lock)


def remove_abandoned(place: Path) -> None:
    """Remove the folders of runs whose processes are gone: nobody holds their locks."""
    for path in place.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError):  # locked, somebody else's, or gone meanwhile
            if time.time() - path.stat().st_mtime < _YOUNG:
                continue
            lock = os.open(path, os.O_RDWR)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(path.parent, ignore_errors=True)
            finally:
                os.close(lock)
