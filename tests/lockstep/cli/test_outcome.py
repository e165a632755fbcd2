"""What a command came to: collected tables, files and remarks as JSON, and the line of what to do next."""

import io
import json
import re
import sys
from pathlib import Path

import click
import numpy as np
import pytest

from lockstep.cli.command import command
from lockstep.cli.outcome import keep_table, note, print_lines, remark, show_table, suggest, wrote
from lockstep.errors import RunError


@pytest.fixture(autouse=True)
def terminal(monkeypatch):
    """Let standard error be a terminal."""
    monkeypatch.setattr("lockstep.cli.outcome.on_terminal", lambda: True)


def made(then="{program} show {system} {path}", suggestion=None, code=0, error=None):
    """Return a program with one command that prints a table and writes a file."""

    @command("study", "example:\n  {program} study a.ssd", then=then, tables=True)
    @click.argument("system")
    def study(system):  # noqa: ARG001
        """Study a system."""
        show_table(("mode", "share", "note"), [("1", "0.25", "-"), ("2", "nan", "lost")], "modes")
        remark("One sentence.")
        if error:
            raise error
        wrote("results/a b/table.json")
        if suggestion:
            suggest(suggestion)
        return code

    group = click.Group("flexsat")
    group.add_command(study)

    def call(*words):
        with group.make_context("flexsat", ["study", "a.ssd", *words]) as context:
            return group.invoke(context)

    return call


def test_tables_files_and_the_next_command_are_written_as_json(tmp_path, capsys):
    assert made()("--json", str(tmp_path / "out.json")) == 0
    found = json.loads((tmp_path / "out.json").read_text())

    assert found == {
        "format": 1,
        "command": "flexsat study",
        "exit_code": 0,
        "tables": [
            {"title": "modes", "columns": ["mode", "share", "note"], "rows": [[1, 0.25, None], [2, "nan", "lost"]]}
        ],
        "remarks": ["One sentence."],
        "files": ["results/a b/table.json"],
        "next": "flexsat show a.ssd 'results/a b/table.json'",
    }
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == "modes"
    assert out.splitlines()[-1] == "results/a b/table.json"
    assert err == "next: flexsat show a.ssd 'results/a b/table.json'\n"


def test_a_table_that_other_text_has_printed_is_kept_with_all_digits(capsys):
    @command("study", "", tables=True)
    def study():
        print("a third")
        keep_table(("value", "judged", "path"), [(np.float64(1) / 3, True, Path("a")), (np.inf, None, 7)], "shares")

    group = click.Group("flexsat", commands=[study])
    with group.make_context("flexsat", ["study", "--json", "-"]) as context:
        group.invoke(context)

    out, err = capsys.readouterr()
    assert json.loads(out)["tables"] == [
        {"title": "shares", "columns": ["value", "judged", "path"], "rows": [[1 / 3, True, "a"], ["inf", None, 7]]}
    ]
    assert err == "a third\n"


def test_a_dash_prints_the_json_alone(capsys):
    assert made(code=1)("--json", "-") == 1
    out, err = capsys.readouterr()

    assert json.loads(out)["exit_code"] == 1
    assert json.loads(out)["next"] is None  # after a failure there is another thing to do first
    assert "One sentence." in err
    assert "next:" not in err


def test_nothing_is_written_or_suggested_after_an_error(tmp_path, capsys):
    with pytest.raises(RunError):
        made(error=RunError("lost"))("--json", str(tmp_path / "out.json"))
    assert list(tmp_path.iterdir()) == []
    assert "next:" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("then", "suggestion", "line"),
    [
        ("open {path}", None, "next: open 'results/a b/table.json'\n"),
        ("open {path}", "{program} report {system}", "next: flexsat report a.ssd\n"),
        ("{program} run a    # fits", None, "next: flexsat run a    # fits\n"),
        (
            "{program} run a    # longer than the terminal",
            None,
            "next: flexsat run a\n      # longer than the terminal\n",
        ),
        (
            "{program} run a-command-longer-than-the-terminal",
            None,
            "next: flexsat run a-command-longer-than-the-terminal\n",
        ),
        ("{program} run {absent}", None, ""),
        (None, None, ""),
    ],
)
def test_a_suggestion_needs_all_that_it_names(monkeypatch, capsys, then, suggestion, line):
    monkeypatch.setenv("COLUMNS", "42")
    assert made(then, suggestion)() == 0
    assert capsys.readouterr().err == line


def test_a_log_has_no_suggestions(monkeypatch, capsys):
    monkeypatch.setattr("lockstep.cli.outcome.on_terminal", lambda: False)
    assert made()("--json", "-") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["next"].startswith("flexsat show")
    assert "next:" not in err


@pytest.mark.parametrize("where", ["folder", "absent/out.json"])
def test_a_file_that_cannot_be_written_is_refused_first(tmp_path, where, monkeypatch):
    from lockstep.errors import InputError

    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=f"--json {where}: .*; "):
        made(error=AssertionError("must not begin"))("--json", where)


def test_sentences_are_wrapped_between_words_on_a_terminal(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    screen = Terminal()
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    text = "results/a/long/path/of/a/run.json: 12.5 % [of all] " * 6
    remark(text)
    monkeypatch.undo()
    lines = re.sub(r"\x1b\[[0-9;]*m", "", screen.getvalue()).splitlines()

    assert max(map(len, lines)) <= 80
    assert " ".join(lines).split() == text.split()


def test_a_note_stands_on_standard_error_and_is_no_result(capsys):
    note("undecided: step: the FMU recommends none")
    assert capsys.readouterr() == ("", "undecided: step: the FMU recommends none\n")


def test_a_long_line_of_a_result_continues_indented_on_a_terminal_and_is_one_elsewhere(monkeypatch, capsys):
    lines = ["title", "  plant       reads 6 from sensors; outputs hold-from 0 s"]
    monkeypatch.setenv("COLUMNS", "40")
    print_lines(lines)
    assert capsys.readouterr().out.splitlines() == lines
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    print_lines(lines)
    assert capsys.readouterr().out.splitlines() == [
        "title", "  plant       reads 6 from sensors;", "      outputs hold-from 0 s",
    ]  # fmt: skip
