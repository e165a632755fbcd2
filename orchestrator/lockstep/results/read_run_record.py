"""Read the record of a run, run.toml in its results folder."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from lockstep.errors import InputError
from lockstep.results.run_record import RUN


def read_run_record(folder: Path) -> tuple[dict[str, Any], str]:
    """Return the record of a run as tables and as text; raise InputError if there is none, or it is no TOML."""
    path = folder / RUN
    if not path.is_file():
        raise InputError(f"{folder}: holds no {RUN}; give the folder of a run")
    try:
        text = path.read_text(encoding="utf-8")
        return tomllib.loads(text), f"{text.rstrip()}\n"  # there is room at the end while a run goes on
    except ValueError as error:  # no UTF-8, or no TOML
        raise InputError(f"{path}: is no TOML ({error}); run again, or restore the file") from None
