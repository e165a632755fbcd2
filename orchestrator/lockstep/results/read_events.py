"""Read the events of a run: events.jsonl in its results folder."""

from __future__ import annotations

from contextlib import suppress
from operator import itemgetter
from pathlib import Path
from typing import Any

from lockstep.data_text import parse_json
from lockstep.errors import InputError
from lockstep.results.run_record import EVENTS


def read_events(folder: Path) -> list[dict[str, Any]]:
    """Return the events of a run in the order of their times; none for a folder without the file.

    What a monitor found was written when it was noticed, after events of later times.
    A killed run may leave half a line at the end, which is left out. Any other line that is no event is an InputError.
    """
    path = folder / EVENTS
    if not path.is_file():
        return []
    try:
        lines = path.read_bytes().split(b"\n")  # a text may hold other ends of lines
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    last = lines.pop()
    events = [_event(line, f"{path}: line {number}") for number, line in enumerate(lines, start=1)]
    if last:
        with suppress(InputError):  # cut off
            events.append(_event(last, str(path)))
    return sorted(events, key=itemgetter("time"))


def _event(line: bytes, where: str) -> dict[str, Any]:
    remedy = "restore the file, or remove that line"
    event = parse_json(line, where, remedy)
    if not (isinstance(event, dict) and isinstance(event.get("event"), str)):
        raise InputError(f'{where}: is no event, a table with "event"; {remedy}')
    if isinstance(event.get("time"), bool) or not isinstance(event.get("time"), int | float):
        raise InputError(f"{where}: time = {event.get('time')!r} must be a number of seconds; {remedy}")
    return event
