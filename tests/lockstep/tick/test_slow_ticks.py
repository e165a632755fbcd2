"""A tick of many slow steps: progress and Ctrl-C each 0.1 s, not after the tick alone, and no half of a row."""

import signal
import tomllib
from itertools import pairwise

import pytest

from fmus.busy_fmu import busy_fmu
from lockstep import Component, Connection, System, read_signals, simulate

MS = 1_000_000  # [ns]
COUNT, WORK = 10, 40_000.0  # steps in a tick, and what each takes [us]


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    """Return a chain of components whose ticks take 0.4 s each."""
    fmu = busy_fmu(tmp_path_factory.mktemp("slow"))
    names = [f"c{k}" for k in range(COUNT)]
    parts = [
        Component(name=name, source=fmu, period=MS, kind="sampled", isolated=False, parameters={"work": WORK})
        for name in names
    ]
    links = [Connection(from_component=a, output="y", to_component=b, input="u") for a, b in pairwise(names)]
    return System(name="slow", tick=MS, components=tuple(parts), connections=tuple(links), record=("*.y",))


@pytest.mark.usefixtures("each_tick")
def test_progress_is_reported_within_a_tick(slow, tmp_path):
    reported = []
    simulate(slow, tmp_path / "out", stop_time=0.001, threads=1, progress=lambda time, _: reported.append(time))
    assert reported.count(0.0) >= 2  # of 0.4 s, at most every 0.1 s and a step of 0.04 s


@pytest.mark.usefixtures("each_tick")
def test_ctrl_c_ends_a_run_within_a_tick(slow, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        simulate(
            slow, tmp_path / "out", stop_time=1.0, threads=1, progress=lambda *_: signal.raise_signal(signal.SIGINT)
        )
    record = tomllib.loads((tmp_path / "out/run.toml").read_text())
    assert (record["status"], record["simulated_time"]) == ("interrupted", 0.0)
    assert len(read_signals(tmp_path / "out").time) == 0
