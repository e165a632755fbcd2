"""Open zip files that came from elsewhere with one-line errors, and extract only below their folder."""

import io
import os
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO, BinaryIO, cast

from lockstep.errors import InputError

_SIZES = ("compress_size", "file_size")
_LARGEST = 4 * 2**30  # bytes that one archive may unpack to
_SUSPICIOUS, _DENSEST = 200_000_000, 100  # above so many bytes, at most so many times the packed size

_BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError)


class UnreadableZip(ValueError):
    """A zip file, or a member of it, that cannot be read; one line."""


@contextmanager
def open_zip(file: Path | IO[bytes], name: str) -> Iterator[zipfile.ZipFile]:
    """Open a zip file and refuse members that would leave the folder it is extracted to."""
    try:
        with zipfile.ZipFile(file) as archive:
            for member in archive.namelist():
                if not is_inside(member):
                    raise InputError(f"{name}: holds the unsafe path {member!r}; refusing to extract it")
            packed, unpacked = (sum(getattr(m, size) for m in archive.infolist()) for size in _SIZES)
            if unpacked > _LARGEST or (unpacked > _SUSPICIOUS and unpacked > _DENSEST * packed):
                sizes = f"{packed / 1e6:.3g} MB unpack to {unpacked / 1e6:.3g} MB"
                raise InputError(f"{name}: {sizes}; refusing to extract what looks like a zip bomb")
            yield archive
    except _BROKEN as error:
        raise InputError(f"{name}: not a readable zip file ({error})") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror or error})") from None


@contextmanager
def examine_zip(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open a zip file to examine it, unsafe members included; raise UnreadableZip for whatever cannot be read."""
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except (*_BROKEN, OSError, RuntimeError) as error:  # RuntimeError: encrypted
        raise UnreadableZip(str(error)) from None


def is_inside(member: str) -> bool:
    """Return whether a path stays below the folder that it is relative to."""
    path = PurePosixPath(member)
    return not (path.is_absolute() or ".." in path.parts or "\\" in member or ":" in member)


def unpacking_folder() -> str | None:
    """Return the folder in which to create temporary folders for FMUs; None is the usual one.

    FMUs made by pythonfmu 0.7 undo no percent-encoding in the URI of their resources but that of the blank, and crash
    for letters outside ASCII: then /tmp is used instead, where there is one.
    """
    uri = Path(tempfile.gettempdir()).absolute().as_uri()
    return "/tmp" if "%" in uri.replace("%20", "") and os.access("/tmp", os.W_OK | os.X_OK) else None


@contextmanager
def open_file(path: Path, archive: Path | None, name: str) -> Iterator[BinaryIO]:
    """Open a file on disk, or a member of a zip archive, for reading with seek.

    An archive in an archive is named as if the outer one were a folder: `outer.ssp/resources/inner.ssp`.
    """
    if archive is None:
        try:
            with path.open("rb") as stream:
                yield stream
        except FileNotFoundError:
            raise InputError(f"{name}: no such file {path}") from None
        except (IsADirectoryError, PermissionError) as error:
            raise InputError(f"{name}: cannot read {path} ({error.strerror})") from None
        return
    outermost = next((parent for parent in archive.parents if parent.is_file()), None)
    if outermost is not None:
        with open_file(archive.relative_to(outermost), outermost, name) as stream:
            packed = io.BytesIO(stream.read())  # going back in a packed stream unpacks it again from its start
        with _open_member(packed, path, archive, name) as inner:
            yield inner
        return
    with _open_member(archive, path, archive, name) as member:
        yield member


@contextmanager
def _open_member(file: Path | IO[bytes], path: Path, archive: Path, name: str) -> Iterator[BinaryIO]:
    with open_zip(file, str(archive)) as outer:
        try:
            member = outer.open(path.as_posix())
        except KeyError:
            raise InputError(f"{name}: no such file {path} in {archive}") from None
        with member:
            yield cast(BinaryIO, member)
