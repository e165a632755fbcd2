"""Two runs in two threads of one process: each gives its results where it is asked to, and nothing else changes."""

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, System, load_system, read_signals, simulate, write_ssd
from lockstep.processes import cpu_affinity

STEP = 10_000_000  # [ns]
VALUES = {"level": 1.0, "rate": 1.0}
GAINS = {"one": 2.0, "two": 5.0}


def system(fmu, gain, isolated):
    """Return a system of one FMU with this gain."""
    part = Component(
        name="b", source=fmu, period=STEP, kind="sampled", parameters={**VALUES, "gain": gain}, isolated=isolated
    )
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


@pytest.fixture
def good(tmp_path):
    """Return an FMU without a defect."""
    return bad_fmu(tmp_path / "good", "KEEPS_A_DIARY")


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


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core: there is nothing to choose")
def test_a_thread_that_calls_simulate_keeps_its_cores_during_the_run(good, tmp_path, monkeypatch):
    """Looked at from another thread, all the time; only workers are pinned."""
    chosen, pin = [], cpu_affinity.pin
    monkeypatch.setattr(cpu_affinity, "pin", lambda thread, to: (chosen.append((thread, len(to))), pin(thread, to)))
    thread, cores, seen, ended = threading.get_native_id(), os.sched_getaffinity(0), [], threading.Event()

    def look():
        while not ended.wait(0.001):
            seen.append(os.sched_getaffinity(thread))

    looking = threading.Thread(target=look)
    looking.start()
    try:
        simulate(system(good, 2.0, isolated=True), tmp_path / "out", stop_time=200.0)
    finally:
        ended.set()
        looking.join()
    assert any(count == 1 for _, count in chosen), "the run was too short for workers to be pinned"
    assert thread not in [one for one, _ in chosen]
    assert len(seen) > 20
    assert set(map(frozenset, seen)) == {frozenset(cores)}
