"""Tables: plain aligned lines where there is no terminal; on one, no broken word and no line wider than it."""

import io
import re
import sys

from lockstep.cli.print_table import parts, print_table, widths
from lockstep.plain_table import plain_lines

HEADER = ("loop", "gain", "phase", "delay", "what is left out of it")
ROWS = [("design: body axes", "-9.31 dB at 0.0821 Hz, +11.02 dB at 1.31 Hz", "38.2 deg at 0.5 Hz", "210.7 ms", "3"),
        ("measured: x [rad]", "none found", "31.7 ± 0.4 deg at 0.5 Hz", "198.02 ± 2.1 ms", "12")]  # fmt: skip


class Terminal(io.StringIO):
    """A terminal that keeps what is written to it."""

    def isatty(self):
        return True


def test_without_a_terminal_each_row_is_one_aligned_line(capsys):
    print_table(HEADER, ROWS)
    lines = capsys.readouterr().out.splitlines()

    assert len(lines) == 3
    assert [line.split("  ")[0] for line in lines[1:]] == ["design: body axes", "measured: x [rad]"]
    for text in ("38.2 deg", "31.7 ±"):
        assert next(line for line in lines if text in line).index(text) == lines[0].index("phase")
    assert plain_lines([("name", "number"), ("a", "1"), ("b", "12.5")]) == [
        "name  number",
        "a          1",
        "b       12.5",
    ]
    assert plain_lines([("only", "header")]) == ["only  header"]


def test_on_a_terminal_of_80_columns_no_line_is_wider_and_no_word_is_broken(monkeypatch):
    # beside a long text, a column with one long word would be narrowed as far
    single = (("name", "what it says"), [("w" * 30, "a few words again " * 12)])
    for width, header, rows in ((80, HEADER, ROWS), (60, HEADER, ROWS), (40, HEADER, ROWS), (50, *single)):
        screen = Terminal()
        monkeypatch.setattr(sys, "stdout", screen)
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setenv("TERM", "xterm")
        print_table(header, rows)
        monkeypatch.undo()
        shown = re.sub(r"\x1b\[[0-9;]*m", "", screen.getvalue())  # without colours
        assert max(len(line) for line in shown.splitlines()) <= width
        words = {word for row in (header, *rows) for text in row for word in text.split()}
        assert words <= set(shown.replace("│", " ").replace("┃", " ").split())


def test_columns_without_room_follow_in_another_table_with_the_first_column():
    table = [("name", "a" * 30, "b" * 30, "c" * 10), ("x", "", "", "")]
    assert parts(table, 80) == [[0, 1, 2], [0, 3]]
    assert parts(table, 200) == [[0, 1, 2, 3]]
    assert parts(table, 10) == [[0, 1], [0, 2], [0, 3]]


def test_as_many_columns_are_repeated_as_distinguish_the_rows():
    table = [("layout", "error", "a" * 30, "b" * 30, "c" * 20), ("one", "x", *"pqr"), ("one", "y", *"pqr")]
    assert parts(table, 80) == [[0, 1, 2], [0, 1, 3, 4]]
    assert parts([*table, table[1]], 80) == [[0, 1, 2], [0, 3, 4]]  # no columns do
    assert parts(table, 40) == [[0, 1], [0, 2], [0, 3], [0, 4]]  # no room for both


def test_columns_have_the_width_of_a_word_at_least_and_fit_together():
    """Texts of a table of `flexsat robustness`, which rich alone made 81 wide."""
    header = ("configuration", "error", "runs", "unstable", "torque [N.m]", "pointing error [arcsec]")
    table = [header, ("centralised", "frequency random, 1 %", "1", "0", "0.0185", "0.146")]
    found = widths(table, range(6), 80)
    assert sum(found) + 3 * 6 + 1 == 80
    assert all(width >= max(map(len, name.split())) for width, name in zip(found, header, strict=True))
    assert widths(table, range(6), 200) == [13, 21, 4, 8, 12, 23]
    assert widths(table, [0], 5) == [13]
