"""Two runs in two threads of one process: each gives its results where it is asked to, and nothing else changes."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, System, load_system, read_signals, simulate, write_ssd

STEP = 10_000_000  # [ns]
VALUES = {"level": 1.0, "rate": 1.0}
GAINS = {"one": 2.0, "two": 5.0}


def system(fmu, gain, isolated):
    """Return a system of one FMU with this gain."""
    part = Component(name="b", source=fmu, period=STEP, parameters={**VALUES, "gain": gain}, isolated=isolated)
    return System(name="one", tick=STEP, stop_time=20 * STEP, components=(part,))


def process_state():
    """Return what all threads of this process share, and the cores and the personality of this thread."""
    mask = os.umask(0)
    os.umask(mask)
    personality = Path("/proc/thread-self/personality").read_text()
    return Path.cwd(), mask, dict(os.environ), os.sched_getaffinity(0), personality


@pytest.fixture
def slow(tmp_path, monkeypatch):
    """Return the relative path of an FMU whose library takes long to load."""
    bad_fmu(tmp_path, "LOADS_SLOWLY")
    monkeypatch.chdir(tmp_path)
    return Path("bad.fmu")


@pytest.mark.parametrize("isolated", [False, True])
def test_runs_in_two_threads_use_relative_paths(slow, tmp_path, isolated):
    before, seen = process_state(), set()

    def run(name):
        write_ssd(system(slow, GAINS[name], isolated), Path(f"{name}.ssd"))
        simulate(load_system(f"{name}.ssd"), name)

    with ThreadPoolExecutor() as threads:
        runs = []
        for name in GAINS:
            runs.append(threads.submit(run, name))
            for _ in range(15):  # the second one begins while the first one loads
                time.sleep(0.01)
                seen.add(Path.cwd())
        for one in runs:
            one.result()

    assert (process_state(), seen) == (before, {tmp_path})
    gains = {name: read_signals(tmp_path / name)["b.scaled"] for name in GAINS}
    np.testing.assert_array_equal(gains["two"] - gains["one"], GAINS["two"] - GAINS["one"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.fmu", "bad.so", "one", "one.ssd", "two", "two.ssd"]
