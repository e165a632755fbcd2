"""Lines of a table as plain aligned text."""

from __future__ import annotations

from collections.abc import Sequence

_GAP = "  "


def plain_lines(table: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table: columns of numbers aligned right, others left, two spaces between."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    numeric = [k > 0 and all(_is_number(row[k]) for row in table[1:]) for k in range(len(widths))]
    return [
        _GAP.join(cell.rjust(width) if right else cell.ljust(width)
                  for cell, width, right in zip(row, widths, numeric, strict=True)).rstrip()
        for row in table
    ]  # fmt: skip


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text in ("", "-")
    return True
