"""Workers that the master only waits for run on its core, as long as nobody else wants it."""

import ctypes
import math
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from lockstep import Component
from lockstep.fmi.model_description import read_description
from lockstep.operating_system import current_core, same_memory_layout, thread_times
from lockstep.processes import cpu_affinity as module
from lockstep.processes.cpu_affinity import SAMPLE, CoreAssignment, core_assignment
from lockstep.processes.last_call import BUSY
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.shared_memory import SharedMemory, shared_file

ALL = os.sched_getaffinity(0)
pytestmark = pytest.mark.skipif(len(ALL) < 2, reason="one core: everybody shares it anyhow")


@pytest.fixture
def worker():
    """Return a function that starts a process that sleeps and has cores take it in."""
    processes, files = [], []

    def start(cores):
        process = subprocess.Popen(["sleep", "600"])
        processes.append(process)
        files.append(shared_file())
        return cores.add(process.pid, SharedMemory(files[-1]).last_call)

    yield start
    for process in processes:
        process.kill()
        process.wait()
    for file in files:
        os.close(file)
    os.sched_setaffinity(0, ALL)


class Machine:
    """A clock, and how long threads ran and waited for a core."""

    def __init__(self, monkeypatch):
        self.now, self.ran, self.waited = 1000.0, 0.0, 0.0
        monkeypatch.setattr(module, "monotonic", lambda: self.now)
        monkeypatch.setattr(module, "thread_times", lambda _thread: (self.ran, self.waited))

    def interval(self, cores, steps, *, work=20e-6, lead=0.0, ran=0.0, waited=0.0):
        """Let an interval pass in which each of these steps works for so long, while the master does for `lead`."""
        self.ran, self.waited = self.ran + ran, self.waited + waited
        for k in range(10 * SAMPLE):
            self.now += 0.051 if k == 9 * SAMPLE else 0.0
            for one in steps:
                one.messages += 1
                cores.message_sent(one, self.now)
                one.last_call.reals[BUSY] += work
                if one in cores.timed:
                    one.since -= lead  # as if the clock had gone on
            for one in steps:
                if one in cores.timed:
                    cores.waits(one)


@pytest.fixture
def machine(monkeypatch):
    """Return a machine under control."""
    return Machine(monkeypatch)


def near(*workers):
    """Tell for each worker whether it is kept to the core of this thread, which keeps to it too."""
    home = os.sched_getaffinity(0)
    return [len(home) == 1 and os.sched_getaffinity(one.pid) == home for one in workers]


def test_a_worker_that_is_waited_for_is_kept_to_the_core_of_the_master(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    machine.interval(cores, [one])
    assert near(one) == [True]
    assert os.sched_getaffinity(0) == {current_core()}
    cores.remove(one)
    assert os.sched_getaffinity(0) == ALL


def test_before_the_first_interval_is_over_nobody_is_kept_anywhere(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    machine.now -= 0.002
    machine.interval(cores, [one])
    assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL


@pytest.mark.parametrize(
    ("work", "lead", "stays"),
    [
        (2e-4, 0.0, True),  # nothing is done beside it
        (2e-4, 5e-5, True),  # less than waking another core costs
        (5e-5, 2e-4, True),  # the step is shorter than that
        (2e-4, 2e-4, False),
        (2e-3, 0.0, False),  # so long that waking does not count
        (math.nan, 0.0, False),  # the worker has written nonsense to its memory
        (math.inf, math.inf, False),
    ],
)
def test_who_works_while_the_master_does_gets_the_other_cores(worker, machine, work, lead, stays):
    cores = CoreAssignment()
    one = worker(cores)
    for _ in range(3):
        machine.interval(cores, [one], work=work, lead=lead)
    assert near(one) == [stays]
    assert os.sched_getaffinity(one.pid) == (os.sched_getaffinity(0) if stays else ALL)
    cores.remove(one)


@pytest.mark.parametrize(("work", "apart"), [(5e-5, False), (3e-4, True)])
def test_of_two_side_by_side_the_one_begun_first_goes_if_that_pays(worker, machine, work, apart):
    cores = CoreAssignment()
    first, second = worker(cores), worker(cores)
    for _ in range(4):
        machine.interval(cores, [first, second], work=work)
    assert near(first, second) == [not apart, True]


def test_a_change_of_what_is_done_beside_a_worker_changes_its_place(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    places = []
    for lead in (0.0, 3e-4, 0.0):
        for _ in range(2):
            machine.interval(cores, [one], work=3e-4, lead=lead)
        places += near(one)
    assert places == [True, False, True]


def test_a_few_messages_are_not_judged_by(worker, machine):
    cores = CoreAssignment()
    one, rare = worker(cores), worker(cores)
    machine.interval(cores, [one])
    rare.messages, rare.last_call.reals[BUSY], rare.pinned = 3, 1.0, True
    machine.interval(cores, [one])
    assert (rare.pinned, rare.messages) == (True, 3)


def test_where_others_want_the_core_it_is_given_up_for_longer_and_longer(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    pauses = []
    machine.interval(cores, [one])
    for _ in range(8):
        machine.interval(cores, [one], ran=0.01, waited=0.02)
        assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL
        pauses.append(cores._next - machine.now)
        machine.now = cores._next
        machine.interval(cores, [one])
        assert near(one) == [True]
    assert pauses == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 1.6, 1.6, 1.6])
    for _ in range(100):  # calm
        machine.interval(cores, [one], ran=0.025)
    machine.interval(cores, [one], ran=0.01, waited=0.02)
    assert cores._next - machine.now == pytest.approx(0.05)


def test_waiting_for_each_other_is_no_reason_to_go(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    machine.interval(cores, [one])
    for _ in range(5):
        machine.interval(cores, [one], ran=0.024, waited=0.02)  # of each of both: one of them runs nearly always
        assert near(one) == [True]


def test_who_is_away_may_wait_there(worker, machine, monkeypatch):
    """Nor do we make room for those who crowd another core."""
    cores = CoreAssignment()
    one, away = worker(cores), worker(cores)
    for _ in range(3):
        machine.interval(cores, [one])
        machine.interval(cores, [away], work=2e-3)
    assert near(one, away) == [True, False]
    monkeypatch.setattr(module, "thread_times", lambda thread: (0.0, machine.now if thread == away.pid else 0.0))
    for _ in range(3):
        machine.interval(cores, [one])
        assert near(one) == [True]


def test_a_kernel_that_does_not_tell_who_waits_is_not_interfered_with(worker, machine, monkeypatch):
    def unknown(thread):
        raise FileNotFoundError(thread)

    cores = CoreAssignment()
    one = worker(cores)
    machine.interval(cores, [one])
    assert near(one) == [True]
    monkeypatch.setattr(module, "thread_times", unknown)
    for _ in range(3):
        machine.interval(cores, [one])
        assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL


def test_the_kernel_is_asked_how_long_a_thread_ran_and_waited():
    def burn():
        end = time.thread_time() + 0.05
        while time.thread_time() < end:
            pass

    before, at = thread_times(threading.get_native_id()), time.thread_time()
    burn()
    after, used = thread_times(threading.get_native_id()), time.thread_time() - at
    assert after[0] - before[0] == pytest.approx(used, abs=0.02)  # the kernel counts by its own ticks
    hog = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        os.sched_setaffinity(hog.pid, {current_core()})
        os.sched_setaffinity(0, os.sched_getaffinity(hog.pid))
        deadline = time.monotonic() + 5.0
        while thread_times(threading.get_native_id())[1] - after[1] < 0.01:
            assert time.monotonic() < deadline, "a thread beside a busy one never waits"
    finally:
        os.sched_setaffinity(0, ALL)
        hog.kill()
        hog.wait()


def test_what_starts_later_may_run_anywhere(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    machine.interval(cores, [one])
    assert near(one) == [True]
    cores.release()
    other = worker(cores)
    assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == os.sched_getaffinity(other.pid) == ALL
    machine.interval(cores, [one, other])
    assert near(one, other) == [True, True]


def test_a_run_under_other_limits_than_the_one_before_keeps_to_them(worker, machine):
    cores = CoreAssignment()
    one = worker(cores)
    cores.remove(one)
    os.sched_setaffinity(0, {min(ALL)})
    two = worker(cores)
    machine.interval(cores, [two])
    assert near(two) == [True]  # as it was started: nothing to choose
    cores.remove(two)
    assert os.sched_getaffinity(0) == {min(ALL)}


def test_a_cores_of_its_own_for_each_thread(worker, machine):
    """Two runs in two threads of one program do not move each other."""
    found = []
    thread = threading.Thread(target=lambda: found.extend([core_assignment(), core_assignment()]))
    thread.start()
    thread.join()
    assert found[0] is found[1] is not core_assignment()
    mine = worker(core_assignment())
    machine.interval(core_assignment(), [mine])
    assert near(mine) == [True]
    assert found[0]._core is None
    core_assignment().remove(mine)


def test_a_slave_in_a_process_of_its_own_is_stepped_on_the_core_of_the_master(good, tmp_path):
    component = Component(name="a", source=good, period=10_000_000, parameters={"level": 1.0, "rate": 1.0})
    description = read_description(component)
    slave = RemoteSlave(component, description, tmp_path / "a", lambda *_: None)
    try:
        slave.setup_experiment(0.0, 1e6)
        slave.enter_initialization()
        slave.exit_initialization()
        values = np.zeros(1)
        reference = np.array([description.variables["scaled"].reference], np.uint32)
        get, step = slave.getter("Real", reference, values), slave.do_step
        deadline, k = time.monotonic() + 60.0, 0
        while len(os.sched_getaffinity(slave._process.pid)) > 1:  # on a crowded machine only now and then
            assert time.monotonic() < deadline
            assert step(k * 0.01, 0.01, 1) == 0
            get()
            k += 1
        assert os.sched_getaffinity(slave._process.pid) == os.sched_getaffinity(0) == {current_core()}
    finally:
        slave.close()
    assert os.sched_getaffinity(0) == ALL


PLACE = "import ctypes; print(ctypes.cast(ctypes.CDLL(None).getpid, ctypes.c_void_p).value)"


def test_workers_are_laid_out_alike_and_the_master_stays_as_it_was():
    def place():
        return subprocess.run([sys.executable, "-c", PLACE], capture_output=True, text=True, check=True).stdout

    libc = ctypes.CDLL(None)
    before = libc.personality(0xFFFFFFFF)
    if libc.personality(before | 0x0040000) == -1:
        pytest.skip("this system does not let a process choose its layout")
    libc.personality(before)
    with same_memory_layout():
        assert place() == place()
    assert libc.personality(0xFFFFFFFF) == before
