"""Repeating a command is no error: default folders carry the seed, and a number if they are taken."""

import tomllib
from pathlib import Path

import click
import pytest

from flexbench.cli.parser import PROGRAM, main
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, write_ssd
from lockstep.__main__ import main as lockstep


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a system whose plant has a seed."""
    folder = tmp_path_factory.mktemp("system")
    plant = Component(name="plant", source=wanderer(folder, "plant"), period=1_000_000, kind="sampled", isolated=False,
                      parameters={"u": 0.0, "offset": 0.0, "number": 0, "flag": False})  # fmt: skip
    write_ssd(System(name="loop", tick=1_000_000, stop_time=5_000_000, components=(plant,), connections=()),
              folder / "loop.ssd")  # fmt: skip
    return folder / "loop.ssd"


def stop_times():
    """Return the stop time of each run by the name of its folder."""
    return {
        path.parent.name: tomllib.loads(path.read_text())["stop_time"] for path in Path("results").glob("*/run.toml")
    }


def test_repeated_runs_have_folders_of_their_own(system, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for arguments in ([], [], ["--seed", "3"], ["--seed", "3", "--stop-time", "0.002"]):
        assert main(["run", str(system), *arguments]) == 0, capsys.readouterr().err
    expected = {"loop": 0.005, "loop-2": 0.005, "loop-seed3": 0.005, "loop-seed3-2": 0.002}
    assert stop_times() == expected
    assert f"{tmp_path}/results/loop-seed3-2" in capsys.readouterr().out

    assert lockstep(["run", str(system)]) == 0
    assert lockstep(["run", str(system), "--overwrite", "--stop-time", "0.003"]) == 0  # the one without a number
    assert stop_times() == expected | {"loop": 0.003, "loop-3": 0.005}
    assert lockstep(["run", str(system), "--set", "plant.gian=1"]) == 2
    assert len(list(Path("results").iterdir())) == 5


def test_no_command_has_a_fixed_default_folder():
    """Those of `build` and `export-c` aside, into which the same input writes the same bytes."""
    defaults = {}
    for name in PROGRAM.list_commands(None):
        command = PROGRAM.get_command(None, name)
        assert isinstance(command, click.Command)
        defaults[name] = next((option.default for option in command.params if option.name == "out"), None)
    assert {name: default for name, default in defaults.items() if isinstance(default, str | Path)} == {
        "build": "fmus",
        "export-c": "flight",
    }
