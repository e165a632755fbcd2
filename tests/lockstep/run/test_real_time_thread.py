"""A real-time priority and a core for the thread that steps: used, or refused in one line, and given back."""

import ctypes
import os
import threading
import tomllib

import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, InputError, System, simulate
from lockstep.run.real_time_thread import real_time_thread

pytestmark = pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="a system without priorities")
STEP = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    fmu = wanderer(tmp_path_factory.mktemp("fmu"), "good")
    part = Component(name="a", source=fmu, period=STEP, kind="sampled", isolated=False, parameters={"seed": 5})
    return System(name="demo", tick=STEP, components=(part,), stop_time=1200 * STEP, record=("a.y", "a.steps"))


def in_thread(function, *, permitted=True):
    """Return what a function returns in a thread of its own, which has no rights of root if it is not permitted."""
    found = []

    def work():
        if not permitted:
            header, none = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
            assert ctypes.CDLL(None).capset(header, none) == 0  # gives up all capabilities, of this thread alone
        found.append(function())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    return found[0]


def state():
    return (
        os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK,
        os.sched_getparam(0).sched_priority,
        os.sched_getaffinity(0),
    )


def test_the_thread_has_its_core_inside_the_block_alone():
    core = max(os.sched_getaffinity(0))

    def use():
        before = state()
        with real_time_thread(None, core) as thread:
            inside = state()
        return before, inside, state(), thread

    before, inside, after, thread = in_thread(use)
    assert inside == (*before[:2], {core})
    assert after == before
    assert (thread.record, thread.warnings) == ({"core": core, "core_used": True}, [])


def test_the_thread_has_its_priority_where_that_is_permitted_and_its_threads_have_not():
    def use():
        before = state()
        with real_time_thread(7, None) as thread:
            inside, below = state(), in_thread(state)
        return before, inside, below, state(), thread

    before, inside, below, after, thread = in_thread(use)
    if thread.warnings:
        pytest.skip("not permitted here")
    assert inside[:2] == (os.SCHED_FIFO, 7)
    assert below[:2] == after[:2] == before[:2]
    assert thread.record == {"priority": 7, "priority_used": True}


def test_what_is_refused_is_one_line_each_and_the_run_goes_on(system, tmp_path):
    def run():
        return simulate(system, tmp_path / "out", realtime_priority=7, core=4095, stop_time="0.01")

    summary = in_thread(run, permitted=False)
    assert summary.warnings[-2].startswith("core 4095: the run goes on without it (this program may use ")
    expected = (
        "real-time priority 7: the run goes on without it (operation not permitted; root may set it, and users whom "
    )
    assert summary.warnings[-1].startswith(expected)
    record = tomllib.loads((tmp_path / "out/run.toml").read_text(encoding="utf-8"))
    assert record["status"] == "completed"
    assert record["real_time"] == {"core": 4095, "core_used": False, "priority": 7, "priority_used": False}
    assert record["warnings"][-2:] == list(summary.warnings[-2:])


def test_a_priority_that_the_system_has_not_is_said():
    with real_time_thread(1000, None) as thread:
        assert thread.warnings == ["real-time priority 1000: the run goes on without it (this system has 1 to 99)"]


@pytest.mark.parametrize(
    ("name", "value", "least"), [("realtime_priority", 0, 1), ("core", -1, 0), ("core", "one", 0), ("core", 1.5, 0)]
)
def test_wrong_values_are_refused(system, name, value, least):
    with pytest.raises(InputError, match=rf"{name} '?{value}'? must be a whole number from {least} on"):
        simulate(system, **{name: value})
