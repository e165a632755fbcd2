"""Make the results folder of a run in one step, never over files that are no run."""

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from lockstep.errors import InputError
from lockstep.results.run_record import RUN, write_run_record


def check_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that a run may not use."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file; choose another results folder")
    if any(folder.iterdir()):
        if not (folder / RUN).exists():
            raise InputError(f"{folder}: holds other files and no run; choose another results folder")
        if not overwrite:
            raise InputError(f"{folder}: holds a run already; choose another folder or overwrite it")


def make_folder(folder: Path, record: Mapping[str, object]) -> None:
    """Replace the folder of an old run by that of a new one, in one step."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        new = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        new.chmod(0o755)
        try:
            write_run_record(new, record)
            old = None
            if folder.exists():
                old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=folder.parent))
                folder.replace(old)
            new.rename(folder)
        except BaseException:
            shutil.rmtree(new, ignore_errors=True)
            raise
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror or error}); choose another folder") from None
