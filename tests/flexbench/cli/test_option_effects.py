"""Every option of every command has an effect on the result, or is refused: the table `option_effects` names the test.

A new option fails without one, in any file; where `test_option_values.py` follows it to a study, one of the study."""

import ast
from functools import cache
from pathlib import Path

import click
import pytest

from flexbench.cli.parser import PROGRAM as FLEXSAT
from lockstep.__main__ import PROGRAM as LOCKSTEP
from option_effects import EFFECTS

ROOT = Path(__file__).parents[2]
PROGRAMS = {"flexsat": FLEXSAT, "lockstep": LOCKSTEP}
COMMANDS = [(label, name) for label, program in PROGRAMS.items() for name in program.list_commands(None)]


def command(label, name):
    """Return a command of a program."""
    return PROGRAMS[label].get_command(None, name)


def options_of(label, name):
    """Return the long names of a command's options."""
    options = [one for one in command(label, name).params if isinstance(one, click.Option)]
    return {max(one.opts, key=len) for one in options} - {"--traceback"}


@cache
def names_in(file):
    """Return the names of the tests in a file."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")}


@pytest.mark.parametrize(("label", "name"), COMMANDS)
def test_every_option_has_a_test_of_its_effect(label, name):
    listed = EFFECTS.get(f"{label} {name}", {})
    missing = {test for test in listed.values() if test.partition("::")[2] not in names_in(test.partition("::")[0])}

    assert set(listed) == options_of(label, name)
    assert missing == set()


def test_no_command_is_listed_that_does_not_exist():
    assert set(EFFECTS) == {f"{label} {name}" for label, name in COMMANDS}


class Bug(Exception):
    """An error that no command expects."""


@pytest.mark.parametrize(("label", "name"), COMMANDS)
def test_a_traceback_is_shown_on_request_and_never_else(monkeypatch, capsys, label, name):
    """Also that of a bug, which says that it is one."""
    found = command(label, name)

    def fail(**_):
        raise Bug("beyond\nrepair")

    monkeypatch.setattr(found, "callback", fail)
    monkeypatch.setattr(found, "params", [one for one in found.params if one.name in ("traceback", "help")])
    line = (f"{label}: Bug: beyond repair: this is a bug of {label}, not of the input; please report it with the "
            "command line, the input files and what the same command prints with --traceback\n")  # fmt: skip

    assert PROGRAMS[label].run([name]) == 70
    assert capsys.readouterr() == ("", line)
    for words in ([name, "--traceback"], ["--traceback", name]):
        assert PROGRAMS[label].run(words) == 70
        error = capsys.readouterr().err
        assert error.startswith("Traceback (most recent call last):\n")
        assert error.endswith(line)
