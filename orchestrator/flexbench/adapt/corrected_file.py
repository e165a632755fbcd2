"""Write changes of an adapter into its file, and leave everything else in it as it is."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence

from flexbench.adapt.verdict import Correction
from lockstep.errors import InputError

_NEXT = re.compile(r"\s*\[")  # the header of a table
_ENTRY = re.compile(r": (input|output) (\d+) \(")


def corrected(text: str, changes: Sequence[Correction], file: str) -> str:
    """Return the text of an adapter file with changes, or raise InputError where it is written in another form."""
    lines = text.splitlines(keepends=True)
    for change in changes:
        found = _ENTRY.search(change.entry.location)
        if found is None or not _write(lines, found[1], int(found[2]), change):
            raise InputError(
                f"{file}: {change.error}: is not written as `{change.key} = ...` on a line of its own below "
                f"[[input]] or [[output]]; write {change.remedy} there"
            )
    return "".join(lines)


def _write(lines: list[str], direction: str, number: int, change: Correction) -> bool:
    """Replace or add the line of a key in the table of an entry; return whether that is possible."""
    header = re.compile(rf"\s*\[\[\s*{direction}\s*\]\]")
    begins = [k for k, line in enumerate(lines) if header.match(line)]
    if len(begins) < number:
        return False
    begin = begins[number - 1] + 1
    end = next((k for k in range(begin, len(lines)) if _NEXT.match(lines[k])), len(lines))
    written = f"{change.remedy}  # by check-adapter\n"
    for k in range(begin, end):
        if re.match(rf"\s*{change.key}\s*=", lines[k]):
            if not _is_whole(lines[k]):
                return False
            lines[k] = written
            return True
    lines.insert(begin, written)
    return True


def _is_whole(line: str) -> bool:
    """Return whether the value of a key ends on its line."""
    try:
        tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return False
    return True
