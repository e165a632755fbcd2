"""Print a table: with rules on a terminal, as plain aligned text elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

from lockstep.plain_table import plain_lines

_RULE = 3  # characters that a column of a table with rules takes beside its text


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table.

    On a terminal, texts are wrapped between words to its width; columns for which there is no room follow in a table
    of their own, which repeats the first column. In a file or a pipe, each row is one line, however long.
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
        for k in columns:  # a unit in brackets is no markup
            shown.add_column(escape(table[0][k]), min_width=_longest_word(table, k))
        for row in table[1:]:
            shown.add_row(*(escape(row[k]) for k in columns))
        console.print(shown)


def parts(table: Sequence[Sequence[str]], width: int) -> list[list[int]]:
    """Return the columns of each table that fits a width without breaking a word; the first column is in all."""
    least = [_longest_word(table, k) + _RULE for k in range(len(table[0]))]
    found = [[0]]
    for k in range(1, len(least)):
        if len(found[-1]) > 1 and sum(least[i] for i in found[-1]) + least[k] + 1 > width:
            found.append([0])
        found[-1].append(k)
    return found


def _longest_word(table: Sequence[Sequence[str]], column: int) -> int:
    return max((len(word) for row in table for word in row[column].split()), default=0)
