"""Open zip files that came from elsewhere with one-line errors, and extract only below their folder."""

import hashlib
import io
import os
import shutil
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from time import time
from typing import IO, BinaryIO, cast

from lockstep.errors import InputError, refuse_undecodable

_SIZES = ("compress_size", "file_size")
_LARGEST = 4 * 2**30  # bytes that one archive may unpack to
_SUSPICIOUS, _DENSEST = 200_000_000, 100  # above so many bytes, at most so many times the packed size

UNIX = 3  # made on a file system with links
_LOADED = ("binaries/", "resources/")  # what an FMU reads when it runs
_SETTLED = 2.0  # [s] after which a file that changes has another time of change
_MOST_KNOWN = 100  # digests that are kept
_digests: dict[tuple[int, ...], str] = {}  # by device, number, size and times of change of the file
_READ_BY_PEOPLE, _LICENSES = ("sources/", "documentation/"), "documentation/licenses/"

_BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError)


_REMEDY = "free space there, or set TMPDIR to another folder"


class TemporaryFolderError(InputError):
    """The folder for temporary files is full, read-only or gone: the FMU is not the culprit."""


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
        raise InputError(f"{name}: not a readable zip file ({error}); give an undamaged file") from None
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


def extract(archive: zipfile.ZipFile, folder: Path, name: str) -> None:
    """Unpack what an FMU needs to run, and its licences, to a folder.

    Raises InputError for links, and TemporaryFolderError if the folder is the culprit.
    """
    for member in archive.infolist():
        linked = member.create_system == UNIX and stat.S_ISLNK(member.external_attr >> 16)
        if linked and member.filename.startswith(_LOADED):
            raise InputError(
                f"{name}: {member.filename} is a symbolic link, which cannot be unpacked; pack the file itself"
            )
    with _unpacking(folder, name):
        archive.extractall(folder, [name for name in archive.namelist() if _is_needed(name)])


def copy_extracted(extracted: Path, folder: Path, name: str) -> None:
    """Copy what was extracted to a new folder, a tenth of the work of extracting it; raise TemporaryFolderError."""
    with _unpacking(folder, name):
        folder.mkdir(parents=True)
        for path in extracted.rglob("*"):  # copytree would go on after an error, and name each file
            target = folder / path.relative_to(extracted)
            if path.is_dir():
                target.mkdir()
            else:
                shutil.copyfile(path, target)


@contextmanager
def _unpacking(folder: Path, name: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise TemporaryFolderError(f"{name}: cannot be unpacked to {folder} ({reason}); {_REMEDY}") from None


def _is_needed(member: str) -> bool:
    return member.startswith(_LICENSES) or not member.startswith(_READ_BY_PEOPLE)


@contextmanager
def open_file(path: Path, archive: Path | None, name: str) -> Iterator[BinaryIO]:
    """Open a file on disk, or a member of a zip archive, for reading with seek.

    An archive in an archive is named as if the outer one were a folder: `outer.ssp/resources/inner.ssp`.
    """
    refuse_undecodable(path if archive is None else archive / path, f"{name}: ")
    if archive is None:
        if path.exists() and not path.is_file() and not path.is_dir():
            raise InputError(f"{name}: {path} is a pipe or a device; give a regular file")
        try:
            with path.open("rb") as stream:
                yield stream
        except FileNotFoundError:
            what = "no such file" if name == str(path) else f"no such file {path}"
            raise InputError(f"{name}: {what}; correct the path, or make the file") from None
        except IsADirectoryError:
            raise InputError(
                f"{name}: {path} is a folder; give a file (an FMU is a zip archive of its folder)"
            ) from None
        except PermissionError as error:
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
            raise InputError(f"{name}: no such file {path} in {archive}; pack it again with the file") from None
        with member:
            yield cast(BinaryIO, member)


def sha256_of(stream: BinaryIO, *, on_disk: bool) -> str:
    """Return the SHA-256 of a stream; that of a file on disk is computed again only when it may have changed."""
    if not on_disk:
        return hashlib.sha256(stream.read()).hexdigest()
    known = os.fstat(stream.fileno())
    key = known.st_dev, known.st_ino, known.st_size, known.st_mtime_ns, known.st_ctime_ns
    if key not in _digests:
        digest = hashlib.sha256(stream.read()).hexdigest()
        if time() - max(known.st_mtime, known.st_ctime) <= _SETTLED:
            return digest
        if len(_digests) >= _MOST_KNOWN:
            del _digests[next(iter(_digests))]
        _digests[key] = digest
    return _digests[key]
