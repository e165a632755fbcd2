"""Print a table: with rules on a terminal, as plain aligned text elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

from lockstep.plain_table import plain_lines

_RULE = 3  # characters that a column of a table with rules takes beside its text


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table.

    On a terminal, texts are wrapped between words to its width; columns for which there is no room follow in a table
    of their own, which repeats what distinguishes the rows. In a file or a pipe, each row is one line, however long.
    """
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from lockstep.standard_streams import printable, unfiltered

    def cells(texts: Iterable[str]) -> list[str]:
        return [printable(text, keep="\n") for text in texts]

    table = [cells(header), *map(cells, rows)]
    console = Console(file=unfiltered(sys.stdout))
    if not console.is_terminal:
        print("\n".join(plain_lines([[cell.replace("\n", " ") for cell in row] for row in table])))
        return
    for columns in parts(table, console.width):
        shown = Table()
        for k, width in zip(columns, widths(table, columns, console.width), strict=True):
            shown.add_column(escape(table[0][k]), width=width)  # a unit in brackets is no markup
        for row in table[1:]:
            shown.add_row(*(escape(row[k]) for k in columns))
        console.print(shown)


def parts(table: Sequence[Sequence[str]], width: int) -> list[list[int]]:
    """Return the columns of each table that fits a width without breaking a word.

    In all of them are the first columns, as many as distinguish the rows; the first alone if so many have no room.
    """
    least = [_longest_word(table, k) + _RULE for k in range(len(table[0]))]
    count = _distinguishing(table)
    if sum(least[:count]) + max(least[count:], default=0) + 1 > width:
        count = 1
    found = [list(range(count))]
    for k in range(count, len(least)):
        if len(found[-1]) > count and sum(least[i] for i in found[-1]) + least[k] + 1 > width:
            found.append(list(range(count)))
        found[-1].append(k)
    return found


def widths(table: Sequence[Sequence[str]], columns: Sequence[int], width: int) -> list[int]:
    """Return the widths of the texts of columns within a width, the widest wrapped first, none narrower than a word.

    rich makes columns narrower than their longest word, and cuts what is then beyond the width.
    """
    least = [_longest_word(table, k) for k in columns]
    found = [max(len(line) for row in table for line in (row[k].splitlines() or [""])) for k in columns]
    while sum(found) + _RULE * len(columns) + 1 > width and found != least:
        widest = max((k for k in range(len(found)) if found[k] > least[k]), key=lambda k: found[k])
        found[widest] -= 1
    return found


def _distinguishing(table: Sequence[Sequence[str]]) -> int:
    rows = table[1:]
    different = (k for k in range(1, len(table[0])) if len({tuple(row[:k]) for row in rows}) == len(rows))
    return next(different, 1)


def _longest_word(table: Sequence[Sequence[str]], column: int) -> int:
    return max((len(word) for row in table for word in row[column].split()), default=0)
