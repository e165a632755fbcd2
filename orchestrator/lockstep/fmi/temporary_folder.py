"""Temporary folders that FMUs are unpacked to and run from."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lockstep.fmi.safe_zip import TemporaryFolderError
from lockstep.operating_system import refuses_programs

_REMEDY = "set TMPDIR to another folder"


def unpacking_folder() -> Path:
    """Return the folder in which to create temporary folders for FMUs, or raise TemporaryFolderError.

    FMUs made by pythonfmu 0.7 undo no percent-encoding in the URI of their resources but that of the blank, and crash
    for letters outside ASCII: then /tmp is used instead, where there is one.
    """
    try:
        folder = Path(tempfile.gettempdir()).absolute()
    except OSError as error:  # it tries to write to each that it knows
        raise TemporaryFolderError(f"no temporary folder can be written ({error.strerror}); {_REMEDY}") from None
    if "%" in folder.as_uri().replace("%20", "") and os.access("/tmp", os.W_OK | os.X_OK):
        folder = Path("/tmp")
    if refuses_programs(folder):
        raise TemporaryFolderError(f"temporary folder {folder}: mounted noexec, so no FMU can run from it; {_REMEDY}")
    return folder


@contextmanager
def temporary_folder(prefix: str) -> Iterator[Path]:
    """Make a folder to unpack FMUs to, and remove it at the end; raise TemporaryFolderError if it cannot be made."""
    parent = unpacking_folder()
    try:
        made = tempfile.TemporaryDirectory(prefix=prefix, dir=parent, ignore_cleanup_errors=True)
    except OSError as error:
        raise TemporaryFolderError(f"temporary folder {parent}: {error.strerror}; {_REMEDY}") from None
    with made as name:
        yield Path(name)
