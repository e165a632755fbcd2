"""Bars of progress at the widths of terminals: no text is cut."""

import io

import pytest
from rich.console import Console

from lockstep.cli.progress_bars import Bars

STATE, MORE = "123 of 300 s", ", 12.3 x real time"
LONG = "centralised-fine-pointing-open-loop-as-published-seed12"


@pytest.mark.parametrize(
    ("title", "width", "lines", "bar", "full"),
    [
        ("slew", 80, ["slew"], True, True),
        (LONG, 120, [LONG], True, True),
        (LONG, 80, [LONG], False, False),
        (LONG, 84, [LONG], True, False),
        (LONG, 60, ["centralised-fine-pointing-open-loop-as-", "published-seed12"], False, False),
    ],
)
def test_a_bar_fits_the_width_and_no_text_is_cut(title, width, lines, bar, full):
    shown = io.StringIO()
    console = Console(file=shown, width=width, force_terminal=True, color_system=None, legacy_windows=False)
    bars = Bars(console, [title, "slew"], len(STATE), len(MORE))
    assert bars.full == full
    state = STATE + (MORE if full else "")
    bars.progress.add_task(bars.description(title), total=300.0, completed=123.0, state=state)

    console.print(bars.progress.get_renderable())

    written = shown.getvalue().splitlines()
    assert "…" not in shown.getvalue()
    assert max(map(len, written)) <= width
    assert state in written[0]
    assert [line[: len(text)] for line, text in zip(written, lines, strict=True)] == lines
    assert ("━" in written[0]) == bar
