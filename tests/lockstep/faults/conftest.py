"""A counter that feeds an echo of every type and a gain, each millisecond, and the angles with units."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lockstep import Component, Connection, System, write_ssd

MS = 1_000_000  # [ns]


@pytest.fixture(scope="session")
def bench(toys: Path) -> System:
    """Return the system; the echo's u[2] is the time at which the counter's step began, the gain's input its count."""
    fed = (("echo", "u[1]", "count"), ("echo", "u[2]", "began"), ("echo", "flag", "even"), ("echo", "number", "steps"),
           ("gain", "u", "count"))  # fmt: skip
    return System(
        name="bench",
        tick=MS,
        stop_time=100 * MS,
        components=(
            Component(name="counter", source=toys / "toy_counter.fmu", period=MS, kind="sampled", isolated=False),
            Component(name="echo", source=toys / "toy_echo.fmu", period=MS, kind="sampled", isolated=False),
            Component(
                name="gain",
                source=toys / "toy_gain.fmu",
                period=MS,
                kind="sampled",
                isolated=False,
                parameters={"gain": 2.0},
            ),
        ),
        connections=tuple(
            Connection(from_component="counter", output=output, to_component=component, input=name)
            for component, name, output in fed
        ),
    )


@pytest.fixture(scope="session")
def bench_ssd(bench: System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bench as a system file."""
    path = tmp_path_factory.mktemp("bench") / "bench.ssd"
    write_ssd(bench, path)
    return path


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[[str], Path]:
    """Return a function that writes a scenario file."""

    def write(text: str) -> Path:
        path = tmp_path / "faults.toml"
        path.write_text(text)
        return path

    return write
