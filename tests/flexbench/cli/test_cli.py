"""The program `flexsat`: its help, exit codes, and one line for whatever goes wrong."""

import importlib
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from flexbench.cli import options as shared
from flexbench.cli.parser import PROGRAM, main
from flexbench.loop.scenarios import SCENARIOS
from flexsat.description.built_in import CONFIGURATIONS
from lockstep import InputError, RunError

HEAVY = {"numpy", "scipy", "matplotlib", "pyarrow", "xarray", "pandas", "fmpy", "lxml", "rich", "flexsat"}


def run(capsys, *arguments):
    """Return exit code, output and errors of a command line."""
    code = main(arguments)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture
def callback(monkeypatch):
    """Return a function that replaces what a command does."""

    def replace(name, function):
        command = PROGRAM.get_command(None, name)
        monkeypatch.setattr(command, "callback", function)

    return replace


def loaded_by(*arguments):
    """Return the top-level modules that a command line has imported at its end."""
    code = f"import sys\nfrom flexbench.cli.parser import main\nmain({list(arguments)})\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return {name.partition(".")[0] for name in done.stdout.splitlines()[-1].split()}


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["margins", "--help"], ["runn"]])
def test_help_and_usage_errors_import_no_numerics(arguments):
    loaded = loaded_by(*arguments)

    assert "flexbench" in loaded
    assert loaded & HEAVY == set()


def test_the_help_imports_no_command():
    code = "import sys\nfrom flexbench.cli.parser import main\nmain(['--help'])\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    loaded = done.stdout.splitlines()[-1].split()

    assert [name for name in loaded if name.startswith("flexbench.cli.")] == ["flexbench.cli.parser"]


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (InputError("plant.x: no such parameter"), 2, "flexsat: plant.x: no such parameter\n"),
        (InputError("two\nlines"), 2, "flexsat: two lines\n"),
        (RunError("plant: fmi2DoStep returned fmi2Error"), 1, "flexsat: plant: fmi2DoStep returned fmi2Error\n"),
        (OSError(28, "No space left on device", "a/run.toml"), 1, "flexsat: a/run.toml: No space left on device\n"),
        (KeyboardInterrupt(), 130, "flexsat: interrupted; what was simulated is in the results folder\n"),
        (BrokenPipeError(32, "Broken pipe"), 1, "flexsat: system: Broken pipe\n"),  # not of the output
        (
            ZeroDivisionError("division"),
            70,
            "flexsat: ZeroDivisionError: division: this is a bug of flexsat, not of the input; please report it with "
            "the command line, the input files and what the same command prints with --traceback\n",
        ),
    ],
)
def test_every_exception_is_one_line_and_an_exit_code(capsys, callback, error, code, line):
    def fail(**_):
        raise error

    callback("run", fail)

    assert run(capsys, "run", "some.ssd") == (code, "", line)


@pytest.mark.parametrize("arguments", [["--traceback", "run", "some.ssd"], ["run", "some.ssd", "--traceback"]])
def test_a_traceback_is_printed_on_request(capsys, callback, arguments):
    def fail(**_):
        raise InputError("plant.x: no such parameter")

    callback("run", fail)
    code, out, error = run(capsys, *arguments)

    assert (code, out) == (2, "")
    assert error.startswith("Traceback (most recent call last):\n")
    assert "in fail\n" in error
    assert error.endswith("\nflexsat: plant.x: no such parameter\n")


def test_the_value_of_a_command_is_the_exit_code(capsys, callback):
    callback("run", lambda **_: 0)
    assert run(capsys, "run", "some.ssd") == (0, "", "")
    callback("equivalence", lambda **_: 1)  # signals differ
    assert run(capsys, "equivalence") == (1, "", "")


def test_options_reach_the_command(callback):
    seen = {}
    callback("run", lambda **given: seen.update(given))
    main(["run", "a.ssd", "--set", "plant.seed=-1", "--set", "b.c=2", "--delay", "a:b=3", "--seed", "4"])

    assert str(seen["system"]) == "a.ssd"
    assert seen["settings"] == ("plant.seed=-1", "b.c=2")
    assert seen["delay"] == ("a:b=3",)
    assert seen["seed"] == 4
    absent = ("out", "stop_time", "record_period", "shadow", "resume", "restart_from", "pace")
    assert {name: seen[name] for name in absent} == dict.fromkeys(absent)
    assert (seen["record"], seen["step_size"], seen["tick"], seen["overwrite"]) == ((), (), (), False)


def test_options_with_any_number_of_values_end_at_the_next_option(callback):
    seen = {}
    callback("branch", lambda **given: seen.update(given))
    callback("robustness", lambda **given: seen.update(given))
    main(["branch", "a.ckpt", "--vary", "a.x", "-1", "2e-3", "-.5", "--vary", "b.y[2]", "0,1", "--stop-time", "7"])
    assert seen["vary"] == (("a.x", "-1", "2e-3", "-.5"), ("b.y[2]", "0,1"))
    assert seen["stop_time"] == 7.0
    main(["robustness", "--levels", "1", "2", "5", "--seeds", "6"])
    assert (seen["levels"], seen["seed_count"]) == ((1.0, 2.0, 5.0), 6)


def test_the_choices_are_the_configurations_and_scenarios():
    """They are written twice, as the help does not wait for numpy."""
    assert tuple(CONFIGURATIONS) == shared.CONFIGURATIONS
    assert set(shared.SCENARIOS) == set(SCENARIOS)


def test_every_module_of_a_command_exists():
    for name in PROGRAM.list_commands(None):
        command = PROGRAM.get_command(None, name)
        assert command.name == name
        assert importlib.import_module(command.callback.__module__).__doc__


def test_the_version_of_both_programs_is_that_of_the_distribution(capsys):
    from lockstep.__main__ import PROGRAM as lockstep_program

    for program, name in ((PROGRAM, "flexsat"), (lockstep_program, "python -m lockstep")):
        assert program.run(["--version"]) == 0
        assert capsys.readouterr().out == f"{name} {metadata.version('flexsat')}\n"

    cited = (Path(__file__).parents[3] / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {metadata.version('flexsat')}\n" in cited
