"""The results folder of a run: made in one step, and never over files that are no run."""

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from lockstep.errors import InputError
from lockstep.results.run_record import RUN, write_manifest


def check_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that a run may not take."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file; choose another results folder")
    if any(folder.iterdir()):
        if not (folder / RUN).exists():
            raise InputError(f"{folder}: holds other files and no run; choose another results folder")
        if not overwrite:
            raise InputError(f"{folder}: holds a run already; choose another folder or overwrite it")


def make_folder(folder: Path, manifest: Mapping[str, object]) -> None:
    """Put the new run's folder in place of an old one, in one step for whoever looks."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        fresh.chmod(0o755)
        try:
            write_manifest(fresh, manifest)
            old = None
            if folder.exists():
                old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=folder.parent))
                folder.replace(old)
            fresh.rename(folder)
        except BaseException:
            shutil.rmtree(fresh, ignore_errors=True)
            raise
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror or error}); choose another folder") from None
