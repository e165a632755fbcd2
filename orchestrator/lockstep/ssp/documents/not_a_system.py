"""Say what a path is that was given for a system and is none, and which systems are near it."""

from pathlib import Path

from lockstep.errors import InputError, compact
from lockstep.fmi.safe_zip import UnreadableZip, examine_zip
from lockstep.ssp.documents.xml import MAIN

_SYSTEMS = (".ssd", ".ssp")
_MODEL, _RUN = "modelDescription.xml", "run.toml"


def refuse_no_system(path: Path) -> None:
    """Raise InputError for a folder without a system, an FMU, or what else is known to be no system."""
    if path.is_dir():
        raise InputError(f"{path}: {_folder(path)}; {_systems_in(path)}")
    if path.suffix.lower() in _SYSTEMS or not path.is_file():
        return  # read as a system, or reported as missing
    what = _file(path)
    if what is not None:
        raise InputError(f"{path}: {what}; {_systems_in(path.parent)}")


def _folder(path: Path) -> str:
    if (path / _RUN).is_file():
        return "is the results folder of a run, not a system (--resume continues a run that was killed)"
    if (path / _MODEL).is_file():
        return "is an unpacked FMU, not a system; pack it, and write a system file (.ssd) that names it"
    return f"is a folder without {MAIN}, so not an unpacked system"


def _file(path: Path) -> str | None:
    if path.suffix.lower() == ".ckpt":
        return "is a checkpoint, not a system (--restart-from begins a run there)"
    try:
        with examine_zip(path) as archive:
            names = archive.namelist()
    except UnreadableZip:
        return None
    if _MODEL in names:
        return "is an FMU, not a system; write a system file (.ssd) that names it"
    return f"is a system package; name it {path.stem}.ssp" if MAIN in names else "is an archive without a system"


def _systems_in(folder: Path) -> str:
    """List the systems of a folder, or of the folders in it."""
    for pattern in ("*", "*/*"):
        found = sorted(str(path.relative_to(folder)) for path in folder.glob(pattern)
                       if path.suffix.lower() in _SYSTEMS and path.is_file())  # fmt: skip
        if found:
            return f"systems in {folder}: {compact(found)}"
    return f"no system (.ssd, .ssp) in {folder}"
