"""Hold the folder of a study while it runs: its runs, tables and figures belong together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lockstep.results.results_folder import claim_shared


@contextmanager
def study_folder(out: Path | None, default: str) -> Iterator[Path]:
    """Yield the folder of a study, which no other study can use inside the block.

    Parameters
    ----------
    out : folder that the user asked for, which may hold an earlier study; None for a new one
    default : name of the new one in `results`, with the next free number if that is taken

    Raises
    ------
    InputError
        If another study is writing to the folder, or it cannot be made.
    """
    with claim_shared(out or Path("results", default), numbered=out is None) as held:
        yield out or Path("results", held.path.name)
