"""Toy FMUs, systems made of them, and the command line in a fresh process."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from copied_process import Copies
from lockstep import Component, Connection, System, write_ssd
from lockstep.run.choose_tick import TickChoice, choose_tick

MS = 1_000_000  # [ns]
HERE = Path(__file__).parent

RunCli = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def toys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with every toy FMU, built in a process of its own."""
    folder = tmp_path_factory.mktemp("toys")
    subprocess.run([sys.executable, str(HERE / "slaves" / "build.py"), str(folder)], check=True, capture_output=True)
    return folder


@pytest.fixture(scope="session")
def loop(toys: Path) -> System:
    """Return a counter that feeds an echo in the same tick and an integrator two ticks later, in one process."""
    return System(
        name="loop",
        tick=MS,
        stop_time=10 * MS,
        components=(
            Component(name="counter", source=toys / "toy_counter.fmu", period=MS, kind="sampled", isolated=False),
            Component(
                name="echo",
                source=toys / "toy_echo.fmu",
                period=5 * MS,
                kind="sampled",
                parameters={"u[2]": 7.0},
                isolated=False,
            ),
            Component(
                name="plant",
                source=toys / "toy_integrator.fmu",
                period=MS,
                kind="continuous",
                parameters={"x0": 3.0},
                isolated=False,
            ),
        ),
        connections=(
            Connection(from_component="counter", output="count", to_component="echo", input="u[1]"),
            Connection(from_component="counter", output="even", to_component="echo", input="flag"),
            Connection(from_component="counter", output="steps", to_component="echo", input="number"),
            Connection(from_component="counter", output="count", to_component="plant", input="u", delay=2),
        ),
    )


@pytest.fixture
def loop_ssd(loop: System, tmp_path: Path) -> Path:
    """Return the loop as a system file."""
    write_ssd(loop, tmp_path / "loop.ssd")
    return tmp_path / "loop.ssd"


@pytest.fixture
def write(tmp_path: Path, loop: System) -> Callable[..., Path]:
    """Return a function that writes the loop with some fields replaced."""

    def write_changed(**changes: object) -> Path:
        path = tmp_path / "changed.ssd"
        write_ssd(replace(loop, **changes), path)  # type: ignore[arg-type]
        return path

    return write_changed


@pytest.fixture(params=["c", "python"])
def each_tick(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Repeat a test whose runs are in this process with both implementations of the tick; return which it is."""
    chosen: str = request.param

    def choose(wanted: str, *times: int) -> TickChoice:
        return choose_tick(chosen if wanted == "auto" else wanted, *times)

    monkeypatch.setattr("lockstep.simulation.open_run.choose_tick", choose)
    return chosen


@pytest.fixture(scope="session")
def copies() -> Iterator[Copies]:
    """Return a process that has imported the master, whose copies run programs."""
    started = Copies(("lockstep.cli.program", "lockstep.cli.run", "lockstep.simulation"), os.environ, "-W", "error")
    yield started
    started.close()


@pytest.fixture(scope="session")
def cli(copies: Copies) -> RunCli:
    """Return a function that runs `python -m lockstep` in a process of its own: an FMU may take it down.

    The process is a copy of one that is there; a new one where it gets an environment or limits.
    """

    def run(*arguments: object, **options: object) -> "subprocess.CompletedProcess[str]":
        program = ["-m", "lockstep", *map(str, arguments)]
        if not options:
            return copies.run(program, timeout=120.0)
        command = [sys.executable, "-W", "error", *program]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120, **options)  # type: ignore[call-overload,no-any-return]

    return run
