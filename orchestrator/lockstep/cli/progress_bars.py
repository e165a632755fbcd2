"""Lay bars of progress out within the width of a terminal, so that no text is cut."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn

from lockstep.standard_streams import printable

_BAR, _SHORTEST_BAR = 40, 6
_LEFT = len("0:00:00")  # of the time that is left
_SHORTEST_TITLE = 16


class Bars:
    """Bars of a progress, each with a title, a state and the time that is left.

    Where the width does not suffice, the bar is shortened, then what may be left out of the state, then the bar is left
    out, and then the title is wrapped.
    """

    def __init__(self, console: Console, titles: Sequence[str], state: int, more: int = 0) -> None:
        """Lay out for titles, and states of at most `state` characters, and `more` of what may be left out."""
        title = max(map(len, titles), default=0)
        room = console.width - title - state - _LEFT - 3  # for bar and `more`; a blank between two columns
        self.full = room - more >= _SHORTEST_BAR  # whether states have room for `more`
        bar = min(_BAR, room - more if self.full else room)
        columns: list[ProgressColumn] = [TextColumn("{task.description}")]
        if bar >= _SHORTEST_BAR:
            columns.append(BarColumn(bar))
        self._title = max(min(title, title + room + 1), _SHORTEST_TITLE)
        columns += [TextColumn("{task.fields[state]}"), TimeRemainingColumn()]
        self.progress = Progress(*columns, console=console, transient=True)

    def description(self, title: str) -> str:
        """Return a title as a description: wrapped at blanks and hyphens if it is too long."""
        return escape("\n".join(textwrap.wrap(printable(title), self._title) or [""]))
