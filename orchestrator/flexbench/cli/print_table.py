"""Print a table on a terminal or to a file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]], width: int) -> None:
    """Print a table as wide as the terminal, or of a width in characters if the output is none."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table(*map(escape, header))  # a unit in brackets is no markup
    for row in rows:
        table.add_row(*map(escape, row))
    console = Console()
    if not console.is_terminal:
        console.width = width
    console.print(table)
