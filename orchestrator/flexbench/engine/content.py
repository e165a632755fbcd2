"""Files by their content: what a task needs is named by SHA-256, and reaches each machine once."""

from __future__ import annotations

import getpass
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from time import time

from lockstep.errors import InputError
from lockstep.whole_file import file_digest

_FOLDER = "flexsat-files"
MOST = 2_000_000_000  # bytes in the store of a machine, beside what was used within an hour
UNUSED = 7 * 86400.0  # s after which a file in it is removed
_IN_USE = 3600.0  # s since its last use within which a file is not removed
_MINUTE = 60.0  # s: how finely the time of the last use is kept


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class File:
    """A file by its content. The suffix is kept, as readers go by it."""

    digest: str
    suffix: str

    @property
    def name(self) -> str:
        """Name of the file in a store."""
        return self.digest + self.suffix


def put(path: Path, store: Path) -> File:
    """Copy a file into a store, unless it is there; return its name there. InputError if it cannot be read."""
    try:
        file = File(digest=file_digest(path), suffix=path.suffix)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if not (store / file.name).is_file():
        store.mkdir(parents=True, exist_ok=True)
        _whole(store / file.name, path)
    return file


def _whole(target: Path, source: Path) -> None:
    partial = target.with_name(f".{target.name}-{os.getpid()}")
    try:
        shutil.copyfile(source, partial)
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def found(files: Iterable[File], shared: Path | None) -> dict[File, Path]:
    """Return where files are on this machine: in the store of the campaign, if it can be seen, or in this one's own."""
    places = [*([] if shared is None else [shared]), _own()]
    paths = {file: place / file.name for file in files for place in reversed(places) if _holds(place / file.name, file)}
    for path in paths.values():
        if path.parent != shared:
            _note_use(path)
    return paths


def receive(contents: Mapping[File, bytes]) -> None:
    """Keep files in the store of this machine, and remove from it what was not used for long."""
    folder = _own()
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    _tidy(folder, time())
    for file, content in contents.items():
        partial = folder / f".{file.name}-{os.getpid()}"
        partial.write_bytes(content)
        partial.replace(folder / file.name)


def _own() -> Path:
    return Path(tempfile.gettempdir(), f"{_FOLDER}-{getpass.getuser()}")


def _note_use(path: Path) -> None:
    with suppress(OSError):  # removed meanwhile: it is asked for again
        state = path.stat()
        if time() - state.st_atime > _MINUTE:
            os.utime(path, ns=(int(1e9 * time()), state.st_mtime_ns))


def _tidy(folder: Path, now: float) -> None:
    """Remove files that were not used for long, and the longest unused ones beyond what the store may hold."""
    states = []
    for path in folder.iterdir():
        with suppress(OSError):
            state = path.stat()
            states.append((max(state.st_atime, state.st_mtime), state.st_size, path))
    total = sum(size for _, size, _ in states)
    for used, size, path in sorted(states):
        if now - used > (_IN_USE if total > MOST or path.name.startswith(".") else UNUSED):
            with suppress(OSError):
                path.unlink()
                total -= size


def _holds(path: Path, file: File) -> bool:
    """Return whether a file is there with its content; looked at again only where it has changed."""
    try:
        state = path.stat()
    except OSError:
        return False
    return _digest_then(path, state.st_mtime_ns, state.st_size) == file.digest


@lru_cache(256)
def _digest_then(path: Path, _changed: int, _size: int) -> str:
    try:
        return file_digest(path)
    except OSError:
        return ""
