"""Static checks of the archive: that it opens, what it holds, its documentation and its licence."""

from __future__ import annotations

import re
import stat
import zipfile
from collections import Counter
from pathlib import PurePosixPath

from lockstep.check.static.fmu_archive import FmuArchive
from lockstep.check.static.static_check import CheckOutcome, Notes, check
from lockstep.fmi.safe_zip import UnreadableZip, examine_zip, is_inside

_LEFT_BEHIND = (
    re.compile(r"(^|/)(__pycache__|\.git|\.svn|\.hg|\.idea|\.vscode|__MACOSX)/"),
    re.compile(
        r"(^|/)(\.DS_Store|Thumbs\.db|desktop\.ini|\.gitignore|[^/]*\.(pyc|pyo|orig|rej|bak|tmp|swp|swo)|[^/]*~)$", re.I
    ),
    re.compile(r"(^|/)#[^/]*#$"),
)
_METHODS = {zipfile.ZIP_STORED: "stored", zipfile.ZIP_DEFLATED: "deflate"}
_ENCRYPTED, _UNIX = 0x1, 3  # general purpose bit 0; `version made by` of a file system with modes
_SHORT = 60  # characters of a licence's name that are printed
_LICENCE = re.compile(r"^documentation/licenses/.+|^documentation/license\.(txt|html|md)$", re.I)


@check("archive", "the file is a readable zip archive")
def archive(fmu: FmuArchive) -> CheckOutcome:
    """Unpack every member and compare its checksum."""
    if fmu.members is None:
        return CheckOutcome(status="error", message=fmu.problem)
    try:
        with examine_zip(fmu.path) as opened:
            broken = opened.testzip()
    except UnreadableZip as error:  # damaged, or encrypted members, which hygiene lists
        return CheckOutcome(status="error", message=f"cannot be unpacked: {error}")
    if broken is not None:
        return CheckOutcome(status="error", message=f"checksum of {broken} is wrong: the file is damaged")
    unpacked = sum(member.file_size for member in fmu.members)
    return CheckOutcome(
        status="pass",
        message=f"{len(fmu.names)} files, {fmu.size / 1e6:.2f} MB, {unpacked / 1e6:.2f} MB unpacked",
        numbers=(("files", len(fmu.names)), ("packed_bytes", fmu.size), ("unpacked_bytes", unpacked)),
    )


@check("hygiene", "members have safe paths and no leftovers")
def hygiene(fmu: FmuArchive) -> CheckOutcome:
    """Look for unsafe paths, colliding names, unusual packing, links and leftovers."""
    if fmu.members is None:
        return CheckOutcome(status="skipped", message=fmu.problem)
    notes = Notes()
    for member in fmu.members:
        name = member.orig_filename
        if "\\" in name:
            notes.error(f"{name!r}: a backslash in a path; zip demands forward slashes")
        elif not is_inside(name):
            notes.error(f"{name!r}: a path that leaves the folder it is unpacked to")
        if member.flag_bits & _ENCRYPTED:
            notes.error(f"{name}: encrypted")
        if member.compress_type not in _METHODS:
            notes.error(f"{name}: packed by method {member.compress_type}; FMI tools read stored and deflate only")
        if member.create_system == _UNIX and stat.S_ISLNK(member.external_attr >> 16):
            notes.warning(f"{name}: a symbolic link, which unpacks as a text file or not at all")
        if any(pattern.search(name) for pattern in _LEFT_BEHIND):
            notes.warning(f"{name}: left behind by a tool and not part of the model")
    files = [member.filename for member in fmu.members]
    for name, count in Counter(files).items():
        if count > 1 and not name.endswith("/"):
            alike = len({(m.CRC, m.file_size) for m in fmu.members if m.filename == name}) == 1
            note, and_what = (notes.warning, ", all alike") if alike else (notes.error, ", which differ")
            note(f"{name}: {count} members of this name{and_what}")
    for names in _grouped(sorted(set(files))):
        notes.warning(f"{' and '.join(names)}: one file where upper and lower case are the same")
    return notes.outcome("paths, names and packing are in order")


def _grouped(names: list[str]) -> list[list[str]]:
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(name.casefold(), []).append(name)
    return [group for group in groups.values() if len(group) > 1]


@check("documentation", "documentation/index.html is there")
def documentation(fmu: FmuArchive) -> CheckOutcome:
    """Look for the entry page of the documentation."""
    if fmu.members is None:
        return CheckOutcome(status="skipped", message=fmu.problem)
    count = sum(name.startswith("documentation/") for name in fmu.names)
    if "documentation/index.html" in fmu.names:
        return CheckOutcome(status="pass", message=f"{count} files in documentation/")
    other = sorted(name for name in fmu.names if PurePosixPath(name).name.lower() in ("index.html", "index.htm"))
    there = f"; there is {other[0]}" if other else ""
    return CheckOutcome(
        status="warning", message=f"no documentation/index.html: users have only the names of ports{there}"
    )


@check("licence", "the FMU contains its licence")
def licence(fmu: FmuArchive) -> CheckOutcome:
    """Look for licence texts and the licence in the model description."""
    if fmu.members is None:
        return CheckOutcome(status="skipped", message=fmu.problem)
    files = sorted(name for name in fmu.names if _LICENCE.match(name))
    licence_name = "" if fmu.model is None else fmu.model.attributes.get("license", "")
    if len(licence_name) > _SHORT:  # some files contain the whole text
        licence_name = f"{licence_name[:_SHORT]}..."
    declared = (
        f"license={licence_name!r} in the model description" if licence_name else "the model description names none"
    )
    if files:
        return CheckOutcome(status="pass", message=f"{', '.join(files[:4])}; {declared}")
    return CheckOutcome(status="warning", message=f"no text in documentation/licenses/; {declared}")
