"""The FMU file under check: its archive, and its model description as far as it can be read."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

from lockstep.check.static.model import Model, parse_xml
from lockstep.check.static.other_models import read_model_of
from lockstep.errors import InputError
from lockstep.fmi.safe_zip import UnreadableZip, examine_zip
from lockstep.whole_file import file_digest

DESCRIPTION = "modelDescription.xml"
LARGEST_DESCRIPTION = 500_000_000  # [bytes] unpacked: refuse a zip bomb, not a large model


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuArchive:
    """One FMU file; `problem` says why there is no archive or no model."""

    path: Path
    sha256: str
    size: int  # bytes
    members: tuple[zipfile.ZipInfo, ...] | None
    description: bytes | None
    model: Model | None
    problem: str = ""

    @property
    def names(self) -> frozenset[str]:
        """Return the paths of the files in the archive."""
        return frozenset(member.filename for member in self.members or () if not member.is_dir())

    def read(self, name: str) -> bytes:
        """Return a member's content; raise ValueError if it cannot be unpacked."""
        try:
            with examine_zip(self.path) as archive:
                return archive.read(name)
        except UnreadableZip as error:
            raise ValueError(f"{name} cannot be unpacked: {error}") from None


def read_archive(path: Path) -> FmuArchive:
    """Read a file.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read. A file that is not an FMU is a finding of the checks.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; pack it into one .fmu file (zip) to check it")
    try:
        sha256 = file_digest(path)
        size = path.stat().st_size
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of an .fmu file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    members, description, model, problem = None, None, None, ""
    try:
        with examine_zip(path) as archive:
            members = tuple(archive.infolist())
            description = _description(archive)
        model = read_model_of(parse_xml(description))
    except UnreadableZip as error:
        problem = f"not a readable zip file: {error}"
    except ValueError as error:
        problem = f"{DESCRIPTION}: {error}"
    return FmuArchive(
        path=path,
        sha256=sha256,
        size=size,
        members=members,
        description=description,
        model=model,
        problem=problem,
    )


def _description(archive: zipfile.ZipFile) -> bytes:
    try:
        member = archive.getinfo(DESCRIPTION)
    except KeyError:
        raise ValueError("not at the top of the archive") from None
    if member.file_size > LARGEST_DESCRIPTION:
        raise ValueError(f"{member.file_size} bytes unpacked, more than {LARGEST_DESCRIPTION}")
    return archive.read(member)


def unreadable(fmu: FmuArchive) -> str:
    """Return why there is no model description to check; empty if there is one."""
    if fmu.model is None:
        return fmu.problem
    version = fmu.model.attributes.get("fmiVersion", "")
    known = version == "2.0" or version[:3] in ("1.0", "3.0")
    return "" if known else f"FMI version {version or 'unknown'}, not 1.0, 2.0 or 3.0"
