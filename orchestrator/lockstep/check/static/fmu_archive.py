"""The FMU file under check: its archive, and its model description as far as it can be read."""

from __future__ import annotations

import hashlib
import zipfile
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path

from lockstep.check.report.finding import Finding, Status
from lockstep.check.static.model import Model, parse_xml, read_model
from lockstep.errors import InputError

DESCRIPTION = "modelDescription.xml"
LARGEST_DESCRIPTION = 500_000_000  # [bytes] unpacked: refuse a zip bomb, not a large model
KEPT = 500  # details a finding, at most: a broken file may have one for each of 100,000 variables


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
            with zipfile.ZipFile(self.path) as archive:
                return archive.read(name)
        except (OSError, zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
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
        with path.open("rb") as stream:
            sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
            size = stream.tell()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of an .fmu file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    members, description, model, problem = None, None, None, ""
    try:
        with zipfile.ZipFile(path) as archive:
            members = tuple(archive.infolist())
            description = _description(archive)
        model = read_model(parse_xml(description))
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
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


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckOutcome:
    """What a check found: the rest of the finding stands with the check."""

    status: Status
    message: str
    details: tuple[str, ...] = ()
    numbers: tuple[tuple[str, float], ...] = ()


class Notes:
    """Collect the notes of one check; the worst of them is its status."""

    def __init__(self) -> None:
        self._kept: dict[Status, list[str]] = {"error": [], "warning": [], "info": []}

    def error(self, text: str) -> None:
        """Note a violation of FMI, or what makes the FMU unusable."""
        self._kept["error"].append(text)

    def warning(self, text: str) -> None:
        """Note what will cause trouble for users."""
        self._kept["warning"].append(text)

    def info(self, text: str) -> None:
        """Note what is worth knowing."""
        self._kept["info"].append(text)

    def outcome(self, passed: str, numbers: Iterable[tuple[str, float]] = ()) -> CheckOutcome:
        """Return all of it, the worst first; `passed` is the message when there is nothing else."""
        noted = [(status, text) for status, texts in self._kept.items() for text in texts]
        if not noted:
            return CheckOutcome(status="pass", message=passed, numbers=tuple(numbers))
        worst: Status = noted[0][0]
        if len(noted) == 1:
            return CheckOutcome(status=worst, message=noted[0][1], numbers=tuple(numbers))
        words: dict[Status, str] = {"error": "error", "warning": "warning", "info": "note"}
        counts = [f"{len(texts)} {words[s]}{'s' * (len(texts) > 1)}" for s, texts in self._kept.items() if texts]
        lines = [text if status == worst else f"{status}: {text}" for status, text in noted]
        if len(lines) > KEPT:
            lines = [*lines[: KEPT - 1], f"and {len(lines) - KEPT + 1} more"]
        return CheckOutcome(
            status=worst,
            message=f"{', '.join(counts)}: {noted[0][1]}",
            details=tuple(lines[1:]),
            numbers=tuple(numbers),
        )


Check = Callable[[FmuArchive], Finding]


def check(name: str, title: str) -> Callable[[Callable[[FmuArchive], CheckOutcome]], Check]:
    """Make a static check of a function of the fmu."""

    def decorate(function: Callable[[FmuArchive], CheckOutcome]) -> Check:
        @wraps(function)
        def run(fmu: FmuArchive) -> Finding:
            try:
                outcome = function(fmu)
            except ValueError as error:  # a member that cannot be unpacked
                outcome = CheckOutcome(status="error", message=str(error))
            return Finding(
                check=f"static.{name}",
                group="static",
                title=title,
                status=outcome.status,
                message=outcome.message,
                details=outcome.details,
                numbers=dict(outcome.numbers),
            )

        return run

    return decorate


def model_check(name: str, title: str) -> Callable[[Callable[[Model], CheckOutcome]], Check]:
    """Make a static check of a function of the model description; skipped without a readable one of FMI 2.0."""

    def decorate(function: Callable[[Model], CheckOutcome]) -> Check:
        @check(name, title)
        @wraps(function)
        def run(fmu: FmuArchive) -> CheckOutcome:
            reason = unreadable(fmu)
            return CheckOutcome(status="skipped", message=reason) if reason else function(_model(fmu))

        return run

    return decorate


def unreadable(fmu: FmuArchive) -> str:
    """Return why there is no model description of FMI 2.0 to check; empty if there is one."""
    if fmu.model is None:
        return fmu.problem
    version = fmu.model.attributes.get("fmiVersion", "")
    return "" if version == "2.0" else f"FMI version {version or 'unknown'}, not 2.0"


def _model(fmu: FmuArchive) -> Model:
    assert fmu.model is not None  # unreadable() has excluded it
    return fmu.model
