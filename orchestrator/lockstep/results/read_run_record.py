"""Read the record of a run, run.toml in its results folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lockstep.data_text import check_shape, parse_toml
from lockstep.errors import InputError
from lockstep.results.run_record import RUN

_REMEDY = "run again, or restore the file"
_SHADOW = {
    "name": "text", "source": "text", "period": "time", "isolated": "flag", "blend": "time",
    "?switchover": "time", "?adapter": "text", "?grouped": "flag",
}  # fmt: skip
_WHOLE = {  # what a run needs to be resumed
    "status": "text",
    "started": "text",
    "stop_time": "time",
    "tick": "time",
    "record": ["text"],
    "record_period": "time",
    "system": {"name": "text", "path": "text", "sha256": "text"},
    "overrides": "table",
    "latency": [{"from": "text", "to": "text", "delay": "whole number"}],
    "component": [
        {
            "name": "text", "source": "text", "sha256": "text", "period": "time", "kind": "text", "isolated": "flag",
            "parameters": "table", "?model": "text", "?guid": "text", "?offset": "time", "?adapter": "text",
            "?stands_for": "text", "?grouped": "flag", "?shadow": _SHADOW,
        }
    ],
}  # fmt: skip
_MORE = {
    "?start_time": "time",
    "?simulated_time": "number",
    "?wall_time": "number",
    "?versions": {"*": "text"},
    "?faults": [{"path": "text", "sha256": "text"}],
    "?branch": "table",
    "?resumed": ["table"],
    "?reason": "text",
    "?pace": "table",
    "?time": "table",
    "?real_time": "table",
    "?recorded": {"?signals": "whole number", "?rows": "whole number", "?size": "whole number"},
}


def _optional(shape: Any) -> Any:
    """Return a shape in which every key may be missing, but the name of a component."""
    if isinstance(shape, dict):
        return {key if key[0] in "?*" or key == "name" else f"?{key}": _optional(each) for key, each in shape.items()}
    return [_optional(shape[0])] if isinstance(shape, list) else shape


_SHAPE = {**_optional(_WHOLE), **_MORE, "component": _optional(_WHOLE["component"])}


def read_run_record(folder: Path) -> tuple[dict[str, Any], str]:
    """Return the record of a run as tables and as text.

    Raises
    ------
    InputError
        If there is none, it is no TOML, or it has not the shape of a record.
    """
    path = folder / RUN
    if not path.is_file():
        raise InputError(f"{folder}: holds no {RUN}; give the folder of a run")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    record = parse_toml(content, str(path), _REMEDY)
    check_shape(record, _SHAPE, str(path), _REMEDY)
    return record, f"{content.decode('utf-8').rstrip()}\n"  # there is room at the end while a run goes on


def check_whole_record(record: object, where: str, remedy: str) -> None:
    """Raise InputError if this is no record of a run, or lacks something that a run needs to be resumed."""
    check_shape(record, {**_WHOLE, **_MORE}, where, remedy, "run")
