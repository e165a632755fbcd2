"""Find the native FMU of a component: the same model from the same data, in machine code, in the folder `native`."""

from __future__ import annotations

from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.safe_zip import open_file, open_zip
from lockstep.processes.isolation_policy import BUILD_RECORD
from lockstep.ssp.documents.location import Location

NATIVE = "native"  # folder beside an FMU; the one in it has the same file name
_DATA = "resources/"


def native_location(system_file: Location, source: str, name: str) -> Location:
    """Return the native FMU beside the one that a component of a system file names as its source.

    Raises
    ------
    InputError
        If there is none, or its data are not those of the FMU beside it, where that is there too.
    """
    native, _ = system_file.resolve(source, name, NATIVE)
    try:
        with open_file(native.document, native.archive, name):
            pass
    except InputError as error:
        what = str(error).partition(";")[0]
        raise InputError(f'{what}, which native="true" asks for; build it, or leave native out') from None
    beside = native.document.parent.parent / native.document.name
    found = differing_data((beside, native.archive), (native.document, native.archive), name)
    if found:
        raise InputError(f"{name}: {native}{of_other_data(found, beside)}; build both anew, or leave native out")
    return native


def shown_file(fmu: Path) -> str:
    """Return the name of an FMU's file, and before it the folders if they say that it is native.

    Native FMUs of another version of FMI stand in a folder of the folder: `native/fmi3/plant.fmu`.
    """
    for depth in (2, 3):
        if len(fmu.parts) >= depth and fmu.parts[-depth] == NATIVE:
            return "/".join(fmu.parts[-depth:])
    return fmu.name


def of_other_data(member: str, other: Path) -> str:
    """Return the middle of a message on a native FMU whose data are not those of another one."""
    return f" has another {member} than {other}, as it is older or newer"


def differing_data(one: tuple[Path, Path | None], other: tuple[Path, Path | None], name: str) -> str:
    """Return the first data file that two FMUs both hold and in which they differ; "" if there is none.

    Parameters
    ----------
    one, other : the FMU, and the archive that holds it if there is one. One that is no readable FMU has no data here:
        it is refused where it is loaded
    name : of the component, for messages
    """
    first, second = _data(*one, name), _data(*other, name)
    return next((member for member in sorted(first.keys() & second.keys()) if first[member] != second[member]), "")


def _data(fmu: Path, archive: Path | None, name: str) -> dict[str, tuple[int, int]]:
    """Return checksum and size of each file below resources/, but for the build record."""
    try:
        with open_file(fmu, archive, name) as stream, open_zip(stream, name) as content:
            return {
                entry.filename: (entry.CRC, entry.file_size)
                for entry in content.infolist()
                if entry.filename.startswith(_DATA) and entry.filename != BUILD_RECORD
            }
    except InputError:
        return {}
