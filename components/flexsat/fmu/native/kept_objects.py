"""Keep compiled units between processes, in the folder that FLEXSAT_OBJECTS names; without it nothing is kept.

A unit's name there is a digest of all that its object follows from: compiler, options, the unit with the headers that
it includes, and what the compiler's own headers come to. Files stand there whole or not at all, and are verified.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

from ...errors import BuildError

VARIABLE = "FLEXSAT_OBJECTS"
MOST_BYTES = 500_000_000  # that are kept: two dozen controllers; beyond, the oldest half is removed
_DIGEST_BYTES = 32


def kept_object(inputs: Iterable[bytes], compiled: Callable[[], bytes]) -> bytes:
    """Return the object that is kept for some inputs, or what `compiled` returns, which is kept then.

    Raises
    ------
    BuildError
        If the folder cannot be written to, or `compiled` raises it.
    """
    digest = hashlib.sha256()
    for part in inputs:
        digest.update(len(part).to_bytes(8, "little") + part)
    folder = Path(os.environ[VARIABLE])
    path = folder / f"{digest.hexdigest()}.o"
    try:
        known = path.read_bytes()
    except FileNotFoundError:
        known = b""
    except OSError as error:
        raise _refused(folder, error) from None
    content = known[_DIGEST_BYTES:]
    if known[:_DIGEST_BYTES] == hashlib.sha256(content).digest():
        return content
    content = compiled()
    try:
        _keep(path, hashlib.sha256(content).digest() + content)
    except OSError as error:
        raise _refused(folder, error) from None
    return content


def check_folder() -> None:
    """Make the folder, if one is named: a build that could not write to it is refused before it writes anything.

    Raises
    ------
    BuildError
        If the folder cannot be written to.
    """
    if not os.environ.get(VARIABLE):
        return
    folder = Path(os.environ[VARIABLE])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _refused(folder, error) from None


def _keep(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
    _remove_oldest(path.parent)


def _remove_oldest(folder: Path) -> None:
    found = []
    for path in folder.glob("*.o"):
        try:
            status = path.stat()
        except FileNotFoundError:  # another process removes them too
            continue
        found.append((status.st_mtime_ns, status.st_size, path))
    total = sum(size for _, size, _ in found)
    if total <= MOST_BYTES:
        return
    for _, size, path in sorted(found):
        path.unlink(missing_ok=True)
        total -= size
        if total <= MOST_BYTES // 2:
            return


def _refused(folder: Path, error: OSError) -> BuildError:
    return BuildError(
        f"{VARIABLE}={folder}: {error.strerror}; name a folder that can be written to, or unset the variable"
    )
