"""Print a table on a terminal or to a file."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]], width: int) -> None:
    """Print a table as wide as the terminal, or of a width in characters if the output is none."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from lockstep.standard_streams import printable, unfiltered

    def cells(texts: Iterable[str]) -> list[str]:  # a unit in brackets is no markup
        return [escape(printable(text, keep="\n")) for text in texts]

    table = Table(*cells(header))
    for row in rows:
        table.add_row(*cells(row))
    console = Console(file=unfiltered(sys.stdout))
    if not console.is_terminal:
        console.width = width
    console.print(table)
