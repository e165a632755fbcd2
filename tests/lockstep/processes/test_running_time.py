"""Time in which the master or a worker is stopped, or the machine sleeps, does not count against an FMU."""

import time

import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, RunError
from lockstep.fmi.model_description import read_description
from lockstep.processes import running_time as module
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.running_time import RunningTime

LIMIT = 0.6  # [s]


class Clock:
    """The clock of a machine that may sleep."""

    def __init__(self):
        self.slept = 0.0  # [s]

    def monotonic(self):
        return time.monotonic() + self.slept


@pytest.fixture
def clock(monkeypatch):
    """Return the clock of running times."""
    found = Clock()
    monkeypatch.setattr(module, "monotonic", found.monotonic)
    return found


@pytest.mark.parametrize("limit", [0.01, 1.0, 60.0])
def test_time_between_two_looks_counts_up_to_a_bound(clock, limit):
    running = RunningTime(limit)
    for _ in range(3):
        clock.slept += 1e5
        running.look()
        assert not running.is_over
    clock.slept += limit / 8
    running.look(counts=False)
    for _ in range(1200):
        clock.slept += limit / 1000
        running.look()
    assert running.is_over


@pytest.fixture(scope="module")
def waiting(tmp_path_factory):
    """Return an FMU whose step lasts until there are two files."""
    return bad_fmu(tmp_path_factory.mktemp("waiting"), "WAITS_FOR_THE_OTHER")


@pytest.fixture
def slave(waiting, tmp_path, monkeypatch):
    """Return the isolated FMU `a`, with a limit for a step."""
    monkeypatch.setenv("MEETING", str(tmp_path))
    part = Component(name="a", source=waiting, period=1)
    found = RemoteSlave(part, read_description(part), tmp_path, lambda *_: None)
    found.setup_experiment(0.0, 1.0)
    found.enter_initialization()
    found.exit_initialization()
    (tmp_path / "b.0").touch()
    found.do_step(0.0, 0.01, 1)
    found.complete()
    found.connection.process.limit = LIMIT  # from here on
    yield found
    found.close()


def test_a_step_ends_within_the_limit_though_its_worker_is_stopped_for_longer(slave, tmp_path):
    slave.connection.process._child.process.suspend()
    slave.do_step(0.01, 0.01, 1)
    time.sleep(LIMIT + 0.3)
    slave.connection.process._child.process.resume()
    (tmp_path / "b.1").touch()
    slave.complete()


def test_a_step_ends_within_the_limit_though_the_master_is_stopped_for_longer(slave, clock, tmp_path):
    slave.do_step(0.01, 0.01, 1)
    time.sleep(0.15)
    clock.slept = 3600.0
    time.sleep(0.15)
    (tmp_path / "b.1").touch()
    slave.complete()


def test_a_step_that_lasts_for_longer_than_the_limit_is_ended(slave):
    slave.do_step(0.01, 0.01, 1)
    with pytest.raises(RunError, match=f"a: no answer within {LIMIT} s in fmi2DoStep at 0.01 s"):
        slave.complete()
