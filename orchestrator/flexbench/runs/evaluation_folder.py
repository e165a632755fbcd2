"""Where the evaluation of a run is written: its own folder, or another one if that may only be read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from lockstep import InputError


def evaluation_folders(results: Sequence[Path], out: Path | None) -> list[Path]:
    """Return the folder for the evaluation of each run: its own, `out`, or one in `out` for each of several runs.

    Raises
    ------
    InputError
        If two runs would be written to one folder.
    """
    if out is None:
        return list(results)
    if len(results) == 1:
        return [out]
    names = [path.resolve().name for path in results]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise InputError(f"--out {out}: two runs are named {name}; evaluate them one by one")
    return [out / name for name in names]


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Raise InputError for what cannot be written inside the block, with the remedy."""
    try:
        yield
    except OSError as error:
        reason = f"{error.filename or folder}: cannot be written ({error.strerror or error})"
        raise InputError(f"{reason}; give another folder with --out") from None
