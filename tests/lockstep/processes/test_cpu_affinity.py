"""Workers that the master only waits for are pinned to its core while no other program needs it."""

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
from lockstep.processes.cpu_affinity import SAMPLE, CoreAssignment, core_assignment, own_thread
from lockstep.processes.last_call import BUSY
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.shared_memory import SharedMemory, shared_file
from lockstep.processes.worker_link import WorkerLink

ALL = os.sched_getaffinity(0)
pytestmark = pytest.mark.skipif(len(ALL) < 2, reason="one core: all share it")


@pytest.fixture
def foreign_worker():
    """Return a function that starts a process that sleeps and adds it to an assignment."""
    processes, files = [], []

    def start(assignment):
        process = subprocess.Popen(["sleep", "600"])
        processes.append(process)
        files.append(shared_file())
        return assignment.add(process.pid, SharedMemory(files[-1]).last_call, WorkerLink())

    yield start
    for process in processes:
        process.kill()
        process.wait()
    for file in files:
        os.close(file)
    os.sched_setaffinity(0, ALL)


@pytest.fixture
def worker(foreign_worker):
    """Return the function, in a thread that may be pinned."""
    with own_thread():
        yield foreign_worker


class Machine:
    """A clock, and how long threads ran and waited for a core."""

    def __init__(self, monkeypatch):
        self.now, self.ran, self.waited = 1000.0, 0.0, 0.0
        monkeypatch.setattr(module, "monotonic", lambda: self.now)
        monkeypatch.setattr(module, "thread_times", lambda _thread: (self.ran, self.waited))

    def interval(self, assignment, steps, *, work=20e-6, lead=0.0, ran=0.0, waited=0.0):
        """Let an interval pass in which each of these steps works for so long, while the master does for `lead`."""
        self.ran, self.waited = self.ran + ran, self.waited + waited
        for k in range(10 * SAMPLE):
            self.now += 0.051 if k == 9 * SAMPLE else 0.0
            for one in steps:
                one.link.messages += 1
                assignment.message_sent(one, self.now)
                one.last_call.reals[BUSY] += work
                if one in assignment.timed:
                    one.link.since -= lead  # as if the clock had gone on
            for one in steps:
                if one in assignment.timed:
                    assignment.waits(one)


@pytest.fixture
def machine(monkeypatch):
    """Return a machine under control."""
    return Machine(monkeypatch)


def pinned(*workers):
    """Return for each worker whether it and this thread are pinned to one core."""
    core = os.sched_getaffinity(0)
    return [len(core) == 1 and os.sched_getaffinity(one.pid) == core for one in workers]


def test_a_worker_the_master_waits_for_is_pinned_to_its_core(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    machine.interval(assignment, [one])
    assert pinned(one) == [True]
    assert os.sched_getaffinity(0) == {current_core()}
    assignment.remove(one)
    assert os.sched_getaffinity(0) == ALL


def test_in_a_thread_of_another_program_only_the_workers_are_pinned(foreign_worker, machine, monkeypatch):
    assignment = CoreAssignment()
    one, two = foreign_worker(assignment), foreign_worker(assignment)
    for core in sorted(ALL)[:2]:  # where the thread is, and where it has moved to
        monkeypatch.setattr(module, "current_core", lambda core=core: core)
        machine.interval(assignment, [one, two])
        assert [os.sched_getaffinity(pid) for pid in (0, one.pid, two.pid)] == [ALL, {core}, {core}]
    machine.interval(assignment, [one, two], ran=0.01, waited=0.02)
    assert [os.sched_getaffinity(pid) for pid in (0, one.pid, two.pid)] == [ALL, ALL, ALL]
    assignment.remove(one)
    os.sched_setaffinity(0, {min(ALL)})  # by its program
    assignment.remove(two)
    assert os.sched_getaffinity(0) == {min(ALL)}


def test_nothing_is_pinned_in_the_first_interval(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    machine.now -= 0.002
    machine.interval(assignment, [one])
    assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL


@pytest.mark.parametrize(
    ("work", "lead", "stays"),
    [
        (2e-4, 0.0, True),  # nothing else is done meanwhile
        (2e-4, 5e-5, True),  # less than waking another core costs
        (5e-5, 2e-4, True),  # the step is shorter than that
        (2e-4, 2e-4, False),
        (2e-3, 0.0, False),  # so long that waking does not count
        (math.nan, 0.0, False),  # the worker has written nonsense to its memory
        (math.inf, math.inf, False),
    ],
)
def test_a_worker_that_works_at_the_same_time_as_the_master_is_released(worker, machine, work, lead, stays):
    assignment = CoreAssignment()
    one = worker(assignment)
    for _ in range(3):
        machine.interval(assignment, [one], work=work, lead=lead)
    assert pinned(one) == [stays]
    assert os.sched_getaffinity(one.pid) == (os.sched_getaffinity(0) if stays else ALL)
    assignment.remove(one)


@pytest.mark.parametrize(("work", "apart"), [(5e-5, False), (3e-4, True)])
def test_of_two_overlapping_workers_the_first_is_released_if_that_is_faster(worker, machine, work, apart):
    assignment = CoreAssignment()
    first, second = worker(assignment), worker(assignment)
    for _ in range(4):
        machine.interval(assignment, [first, second], work=work)
    assert pinned(first, second) == [not apart, True]


def test_a_worker_is_judged_again_when_its_overlap_changes(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    places = []
    for lead in (0.0, 3e-4, 0.0):
        for _ in range(2):
            machine.interval(assignment, [one], work=3e-4, lead=lead)
        places += pinned(one)
    assert places == [True, False, True]


def test_a_worker_with_few_messages_is_not_judged(worker, machine):
    assignment = CoreAssignment()
    one, rare = worker(assignment), worker(assignment)
    machine.interval(assignment, [one])
    rare.link.messages, rare.last_call.reals[BUSY], rare.pinned = 3, 1.0, True
    machine.interval(assignment, [one])
    assert (rare.pinned, rare.link.messages) == (True, 3)


def test_a_crowded_core_is_released_for_increasing_pauses(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    pauses = []
    machine.interval(assignment, [one])
    for _ in range(8):
        machine.interval(assignment, [one], ran=0.01, waited=0.02)
        assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL
        pauses.append(assignment._next - machine.now)
        machine.now = assignment._next
        machine.interval(assignment, [one])
        assert pinned(one) == [True]
    assert pauses == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 1.6, 1.6, 1.6])
    for _ in range(100):  # calm
        machine.interval(assignment, [one], ran=0.025)
    machine.interval(assignment, [one], ran=0.01, waited=0.02)
    assert assignment._next - machine.now == pytest.approx(0.05)


def test_waiting_of_master_and_worker_for_each_other_does_not_count_as_crowded(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    machine.interval(assignment, [one])
    for _ in range(5):
        machine.interval(assignment, [one], ran=0.024, waited=0.02)  # of each of both: one of them runs nearly always
        assert pinned(one) == [True]


def test_a_released_worker_that_waits_for_another_core_does_not_count_as_crowded(worker, machine, monkeypatch):
    """Nor does a crowd on another core."""
    assignment = CoreAssignment()
    one, away = worker(assignment), worker(assignment)
    for _ in range(3):
        machine.interval(assignment, [one])
        machine.interval(assignment, [away], work=2e-3)
    assert pinned(one, away) == [True, False]
    monkeypatch.setattr(module, "thread_times", lambda thread: (0.0, machine.now if thread == away.pid else 0.0))
    for _ in range(3):
        machine.interval(assignment, [one])
        assert pinned(one) == [True]


def test_all_are_released_where_the_kernel_reports_no_waiting_times(worker, machine, monkeypatch):
    def unknown(thread):
        raise FileNotFoundError(thread)

    assignment = CoreAssignment()
    one = worker(assignment)
    machine.interval(assignment, [one])
    assert pinned(one) == [True]
    monkeypatch.setattr(module, "thread_times", unknown)
    for _ in range(3):
        machine.interval(assignment, [one])
        assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == ALL


def test_thread_times_are_those_of_the_kernel():
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


def test_a_worker_started_later_may_run_on_all_cores(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    machine.interval(assignment, [one])
    assert pinned(one) == [True]
    assignment.give_back()
    other = worker(assignment)
    assert os.sched_getaffinity(0) == os.sched_getaffinity(one.pid) == os.sched_getaffinity(other.pid) == ALL
    machine.interval(assignment, [one, other])
    assert pinned(one, other) == [True, True]


def test_a_run_uses_the_cores_that_are_available_at_its_start(worker, machine):
    assignment = CoreAssignment()
    one = worker(assignment)
    assignment.remove(one)
    os.sched_setaffinity(0, {min(ALL)})
    two = worker(assignment)
    machine.interval(assignment, [two])
    assert pinned(two) == [True]  # as it was started: nothing to choose
    assignment.remove(two)
    assert os.sched_getaffinity(0) == {min(ALL)}


def test_each_thread_has_its_own_assignment(worker, machine):
    """Two runs in two threads of one program do not affect each other."""
    found = []
    thread = threading.Thread(target=lambda: found.extend([core_assignment(), core_assignment()]))
    thread.start()
    thread.join()
    assert found[0] is found[1] is not core_assignment()
    mine = worker(core_assignment())
    machine.interval(core_assignment(), [mine])
    assert pinned(mine) == [True]
    assert found[0]._core is None
    core_assignment().remove(mine)


def test_an_isolated_slave_is_stepped_on_the_core_of_the_master(good, tmp_path):
    component = Component(
        name="a", source=good, period=10_000_000, kind="sampled", parameters={"level": 1.0, "rate": 1.0}
    )
    description = read_description(component)
    with own_thread():
        slave = RemoteSlave(component, description, tmp_path / "a", lambda *_: None)
    try:
        slave.setup_experiment(0.0, 1e6)
        slave.enter_initialization()
        slave.exit_initialization()
        values = np.zeros(1)
        reference = np.array([description.variables["scaled"].reference], np.uint32)
        get, step = slave.getter("Real", reference, values), slave.do_step
        deadline, k = time.monotonic() + 60.0, 0
        while len(os.sched_getaffinity(slave.connection.process.pid)) > 1:  # on a crowded machine only now and then
            assert time.monotonic() < deadline
            assert step(k * 0.01, 0.01, 1) == 0
            get()
            k += 1
        assert os.sched_getaffinity(slave.connection.process.pid) == os.sched_getaffinity(0) == {current_core()}
    finally:
        slave.close()
    assert os.sched_getaffinity(0) == ALL


PLACE = "import ctypes; print(ctypes.cast(ctypes.CDLL(None).getpid, ctypes.c_void_p).value)"


def test_workers_have_the_same_memory_layout_and_the_master_keeps_its_own():
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
