"""The command line `flexsat`: help with an example for every command, exit codes, one line and no traceback."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from flexbench.cli import commands
from flexbench.cli.parser import main
from lockstep import InputError, RunError


def told(capsys, *arguments):
    """Return exit code, output and errors of a command line."""
    try:
        code = main(arguments)
    except SystemExit as end:
        code = end.code
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture
def names(capsys):
    """Return the names of all commands, as a user is told them."""
    _, _, error = told(capsys, "no such command")
    return re.findall(r"'([\w-]+)'", error.partition("choose from")[2])


def test_help_lists_every_command(capsys, names):
    code, out, error = told(capsys, "--help")

    assert (code, error) == (0, "")
    assert {"build", "run", "paper", "equivalence"} <= set(names)
    assert [name for name in names if not re.search(rf"^ +{name}\s+\S", out, re.MULTILINE)] == []


def test_help_of_every_command_has_an_example_and_tells_every_option(capsys, names):
    for name in names:
        code, out, error = told(capsys, name, "--help")

        assert (code, error) == (0, ""), name
        example = re.search(r"^example:\n  flexsat (\S+)(.*)$", out, re.MULTILINE)
        assert example is not None, name
        assert example[1] == name
        for option in re.findall(r"--[a-z-]+", example[2]):
            assert f"  {option}" in out, f"{name}: the example uses {option}, which there is not"
        for option in re.findall(r"^  (--[a-z-]+)(?: [\w.:=]+)?(?:, .*)?$\n(?! {6,}\S)", out, re.MULTILINE):
            raise AssertionError(f"{name} {option} is not explained")


def test_help_does_not_wait_for_numerics():
    code = (
        "import sys\nfrom flexbench.cli.parser import main\n"
        "try:\n    main(['run', '--help'])\nexcept SystemExit:\n    pass\n"
        "print([m for m in ('scipy', 'matplotlib', 'flexsat') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)

    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (InputError("plant.x: no such parameter"), 2, "flexsat: plant.x: no such parameter\n"),
        (ValueError("two\nlines"), 2, "flexsat: two lines\n"),
        (RunError("plant: fmi2DoStep returned fmi2Error"), 1, "flexsat: plant: fmi2DoStep returned fmi2Error\n"),
        (OSError(28, "No space left on device", "a/run.toml"), 1, "flexsat: a/run.toml: No space left on device\n"),
        (KeyboardInterrupt(), 130, "flexsat: interrupted; what was simulated is in the results folder\n"),
        (BrokenPipeError(), 1, ""),
        (ZeroDivisionError("division"), 1, "flexsat: internal error, please report it: ZeroDivisionError: division\n"),
    ],
)
def test_whatever_happens_is_one_line_and_an_exit_code(capsys, monkeypatch, error, code, line):
    def fail(*_):
        raise error

    monkeypatch.setattr(commands, "run", fail)

    assert told(capsys, "run", "some.ssd") == (code, "", line)


def test_what_a_command_returns_is_the_exit_code(capsys, monkeypatch):
    monkeypatch.setattr(commands, "run", lambda _: 0)
    assert told(capsys, "run", "some.ssd") == (0, "", "")
    monkeypatch.setattr(commands, "equivalence", lambda _: 1)  # the gate does not hold
    assert told(capsys, "equivalence") == (1, "", "")


def test_options_reach_the_command(monkeypatch):
    seen = []
    monkeypatch.setattr(commands, "run", lambda options: seen.append(options) or 0)
    main(["run", "a.ssd", "--set", "plant.seed=1", "--set", "b.c=2", "--delay", "a:b=3", "--seed", "4"])
    (options,) = seen

    assert (str(options.system), options.set, options.delay, options.seed) == (
        "a.ssd",
        ["plant.seed=1", "b.c=2"],
        ["a:b=3"],
        4,
    )
    assert (options.out, options.stop, options.record, options.overwrite, options.period) == (
        None,
        None,
        None,
        False,
        [],
    )
