"""Hold a results folder from the first moment of a run to its last: no other run can use it meanwhile.

A folder is filled in place and never exchanged for another one: it may be a mount point, a link, or the working
directory of the user.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Self

from lockstep.errors import InputError, refuse_undecodable
from lockstep.operating_system import LOCK, Release, lock_folder
from lockstep.results.run_record import PARTIAL, RUN, write_run_record

_REPLACED = ".replaced"  # in a results folder: what an earlier run left, until the record of the new one is written
_LOCKS = {LOCK, f"{LOCK}.lock"}
_ATTEMPTS = 100  # to make a folder that others remove meanwhile


class ResultsFolder:
    """A results folder that no other run can use until it is unlocked. Made by `claim` and the like."""

    def __init__(self, path: Path, made: list[Path], unlock: Release) -> None:
        self.path = path
        self._made = made  # folders that were made for it, the outermost first
        self._unlock: Release | None = unlock

    def fill(self, record: Mapping[str, object]) -> None:
        """Write the record of a new run, in place of everything that an earlier run left; or raise InputError.

        When that fails half-way, the folder holds what it held before. After a kill the next claim sees to that.
        """
        try:
            partial = write_run_record(self.path, record, rename=False)
            self._replace_by(partial)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be made ({_reason(error)}); choose another folder") from None

    def _replace_by(self, partial: Path) -> None:
        replaced = self.path / _REPLACED
        old = [entry.name for entry in _content(self.path) if entry != partial]
        try:
            if old:
                replaced.mkdir()
            for name in sorted(old, key=lambda name: name != RUN):  # first of all: see `_recover`
                (self.path / name).rename(replaced / name)
            partial.rename(self.path / RUN)
        except BaseException:
            partial.unlink(missing_ok=True)
            _restore(self.path)
            raise
        shutil.rmtree(replaced, ignore_errors=True)

    def unlock(self) -> None:
        """Let others use the folder; remove it if it was made for this run and nothing was written to it."""
        if self._unlock is None:
            return
        if self._made and self.path.is_dir() and not _content(self.path):
            with suppress(OSError):
                for name in _LOCKS:
                    (self.path / name).unlink(missing_ok=True)
                for folder in reversed(self._made):
                    folder.rmdir()
        self._unlock()
        self._unlock = None

    def __enter__(self) -> Self:
        """Hold the folder inside the block."""
        return self

    def __exit__(self, *_: object) -> None:
        """Unlock it."""
        self.unlock()


def claim(folder: Path | str, *, overwrite: bool = False, numbered: bool = False) -> ResultsFolder:
    """Hold a folder for a new run; make it if there is none.

    Parameters
    ----------
    folder : must be empty, or not be there
    overwrite : it may also hold an earlier run, which is replaced when the new one is initialised
    numbered : if the folder is in use or holds anything, the first of FOLDER-2, FOLDER-3, ... that is free

    Raises
    ------
    InputError
        If the folder is in use, holds something else, or cannot be made.
    """
    path = Path(folder).absolute()
    refuse_undecodable(path, "results folder ")
    for number in count(2):
        try:
            return _claim_new(path, overwrite)
        except _Taken:
            if not numbered:
                raise
        path = path.with_name(f"{Path(folder).name}-{number}")
    raise AssertionError  # the numbers do not end


def claim_earlier(folder: Path | str) -> ResultsFolder:
    """Hold the folder of an earlier run, to continue it; raise InputError if it still goes on, or is no folder."""
    path = Path(folder).absolute()
    if not path.is_dir():
        raise InputError(f"{folder}: holds no {RUN}; give the folder of a run")
    held = _hold(path, [])
    if held is None:
        raise InputError(f"{folder}: its run is still going on; end it before it is resumed")
    return held


def claim_shared(folder: Path | str, *, numbered: bool = False) -> ResultsFolder:
    """Hold the folder of several runs and of what is computed from them; it may hold anything already.

    `numbered` as in `claim`. Raises InputError if the folder is in use, or cannot be made.
    """
    if numbered:
        return claim(folder, numbered=True)
    path = Path(folder).absolute()
    return _held(path)


@contextmanager
def held(folder: Path | str | ResultsFolder, *, overwrite: bool = False) -> Iterator[ResultsFolder]:
    """Claim a folder for a new run inside the block, unless the caller holds it already."""
    if isinstance(folder, ResultsFolder):
        yield folder
        return
    with claim(folder, overwrite=overwrite) as claimed:
        yield claimed


class _Taken(InputError):
    """Refuse a folder that another run has, or had."""


def _claim_new(path: Path, overwrite: bool) -> ResultsFolder:
    folder = _held(path)
    try:
        if _content(path):
            if not (path / RUN).exists():
                raise _Taken(f"{path}: holds other files and no run; choose another results folder")
            if not overwrite:
                raise _Taken(f"{path}: holds a run already; choose another folder, or replace it (--overwrite)")
    except BaseException:
        folder.unlock()
        raise
    return folder


def _held(path: Path) -> ResultsFolder:
    """Make a folder if there is none, and hold it; _Taken if it is in use or a file."""
    for _ in range(_ATTEMPTS):
        try:
            made = _make(path)
        except FileNotFoundError:  # a parent was removed meanwhile, as it was empty
            continue
        except OSError as error:
            raise InputError(f"{path}: cannot be made ({_reason(error)}); choose another folder") from None
        if not path.is_dir():
            raise _Taken(f"{path}: is no folder; choose another results folder")
        try:
            folder = _hold(path, made)
        except FileNotFoundError:
            continue
        except OSError as error:
            raise InputError(f"{path}: cannot be used ({_reason(error)}); choose another folder") from None
        if folder is None:
            raise _Taken(f"{path}: another run is writing to it; choose another folder, or wait until that has ended")
        return folder
    raise InputError(f"{path}: cannot be made, as another process keeps removing it; choose another folder")


def _make(path: Path) -> list[Path]:
    """Make a folder and its parents, and return those that were not there, the outermost first."""
    missing = [folder for folder in (path, *path.parents) if not os.path.lexists(folder)]
    made = []
    for folder in reversed(missing):
        with suppress(FileExistsError):
            folder.mkdir()
            made.append(folder)
    return made


def _hold(path: Path, made: list[Path]) -> ResultsFolder | None:
    """Lock a folder that exists; None if it is in use, FileNotFoundError if it was removed meanwhile."""
    try:
        before = path.stat()
        unlock = lock_folder(path)
    except FileNotFoundError:
        raise
    except OSError:
        if not os.access(path, os.R_OK | os.X_OK):
            raise
        unlock = _unlocked  # a file system without locks
    if unlock is None:
        return None
    try:
        if not os.path.samestat(before, path.stat()):
            raise FileNotFoundError(path)
        _recover(path)
    except BaseException:
        unlock()
        raise
    return ResultsFolder(path, made, unlock)


def _unlocked() -> None:
    """Unlock nothing."""


def _recover(path: Path) -> None:
    """Complete what a process that was killed while it replaced an earlier run left undone.

    The record of the earlier run is the first file that is moved away, and the last that is moved back.
    """
    with suppress(OSError):
        (path / PARTIAL).unlink(missing_ok=True)
    replaced = path / _REPLACED
    if not replaced.is_dir():
        return
    if (path / RUN).exists():
        shutil.rmtree(replaced, ignore_errors=True)
    else:
        _restore(path)


def _restore(path: Path) -> None:
    """Move back what was moved away."""
    replaced = path / _REPLACED
    if not replaced.is_dir():
        return
    for entry in sorted(replaced.iterdir(), key=lambda entry: entry.name == RUN):
        with suppress(OSError):
            entry.rename(path / entry.name)
    with suppress(OSError):
        replaced.rmdir()


def _content(path: Path) -> list[Path]:
    return [entry for entry in path.iterdir() if entry.name not in _LOCKS]


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
