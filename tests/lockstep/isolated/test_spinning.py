"""Who waits spins while that pays, and sleeps when nothing comes, or others want the core."""

import os

import pytest

from lockstep.isolated import spinning
from lockstep.isolated.memory import ASKED, MAY_SPIN, Shared, shared_file
from lockstep.isolated.spinning import Spinner, share_cores


@pytest.fixture
def shared():
    """Return memory as a master and a worker share it."""
    file = shared_file()
    yield Shared(file)
    os.close(file)


@pytest.fixture
def pressure(monkeypatch, tmp_path):
    """Return a function that says for what share of time processes wait for cores [%]."""
    monkeypatch.setattr(spinning, "_PRESSURE", tmp_path / "cpu")

    def say(share):
        (tmp_path / "cpu").write_text(f"some avg10={share} avg60=0.00 avg300=0.00 total=1\nfull avg10=0.00\n")

    say("0.00")
    return say


@pytest.fixture
def machine(monkeypatch, pressure):  # noqa: ARG001
    """Return a clock that goes on by `look` with each look at it, and notes how often the core was offered."""

    class Machine:
        now, look, yields = 100.0, 1e-6, 0
        after = None  # what happens at a yield

        def clock(self):
            self.now += self.look
            return self.now

        def offer(self):
            self.yields += 1
            if self.after is not None:
                self.after()

    machine = Machine()
    monkeypatch.setattr(spinning, "perf_counter", machine.clock)
    monkeypatch.setattr(spinning.os, "sched_yield", machine.offer)
    return machine


def test_a_message_that_is_there_is_not_waited_for(shared, machine):
    shared.integers[ASKED] = 3
    Spinner(shared, ASKED).spin(3)
    assert machine.yields == 0


def test_a_message_that_comes_soon_ends_the_spin(shared, machine):
    def send():
        if machine.yields == 50:
            shared.integers[ASKED] = 1

    machine.after = send
    spinner = Spinner(shared, ASKED)
    spinner.spin(1)
    assert machine.yields == 50
    machine.after = lambda: shared.integers.__setitem__(ASKED, 2)
    spinner.spin(2)
    assert machine.yields == 51  # it paid, so it is done again


def spins(spinner, machine):
    """Return how often a wait for what never comes offers the core."""
    before = machine.yields
    spinner.spin(1000)
    return machine.yields - before


def test_a_spin_that_is_of_no_use_ends_and_is_not_repeated_at_once(shared, machine):
    spinner = Spinner(shared, ASKED)
    assert 2900 < spins(spinner, machine) < 3100  # 3 ms, each look a microsecond
    assert spins(spinner, machine) == 0
    machine.now += 0.011
    assert spins(spinner, machine) > 1000


def test_who_was_away_from_the_core_sleeps_for_longer_and_longer(shared, machine):
    def away():
        machine.now += 4e-3  # the turn of somebody else
        shared.integers[ASKED] += 1

    machine.after = away
    spinner, pauses = Spinner(shared, ASKED), []
    for count in range(1, 10):
        spinner.spin(count)
        assert machine.yields == count
        pauses.append(spinner._until - machine.now)
        machine.now = spinner._until
    assert pauses == pytest.approx([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 1.28])
    machine.now += 10.0  # calm
    spinner.spin(10)
    assert spinner._until - machine.now == pytest.approx(0.01)


def test_nobody_spins_where_processes_wait_for_cores(shared, machine, pressure):
    spinner = Spinner(shared, ASKED)
    pressure("85.31")
    for _ in range(20):
        assert spins(spinner, machine) == 0
        machine.now += 0.1
    pressure("1.50")
    machine.now += 2.0
    assert spins(spinner, machine) > 1000


@pytest.mark.parametrize("text", [None, "", "some avg10=", "some avg10=x"])
def test_a_kernel_that_does_not_say_is_not_asked(shared, machine, tmp_path, text):
    (tmp_path / "cpu").unlink() if text is None else (tmp_path / "cpu").write_text(text)
    assert spins(Spinner(shared, ASKED), machine) > 1000


@pytest.mark.parametrize(("cores", "may"), [(1, 0), (2, 0), (3, 1)])
def test_idle_workers_spin_where_each_has_a_core(shared, monkeypatch, cores, may):
    monkeypatch.setattr(spinning, "CORES", cores)
    workers = [shared, shared]
    share_cores(workers)
    assert shared.integers[MAY_SPIN] == may
