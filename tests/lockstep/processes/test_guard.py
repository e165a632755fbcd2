"""Daemons of FMUs and of other child processes are ended, however the process that started them ended."""

import signal
import subprocess
import sys
import tempfile
import time

import psutil
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, System, read_signals, simulate
from lockstep.processes.child_process import ChildProcess

STEP = 10_000_000  # [ns]
# a process without a parent, in a session of its own, with an empty environment
DAEMON = """
import os, signal, sys, time
path = {path!r}
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        with open(path + "-", "w") as file:
            file.write(str(os.getpid()))
        os.rename(path + "-", path)
        os.execve("/bin/sleep", ["sleep", "600"], {{}})
    os._exit(0)
while not os.path.exists(path):
    time.sleep(0.002)
"""
ENDS = {
    "returns": ("", 0),
    "crashes": ("os.abort()", -signal.SIGABRT),
    "is killed": ("os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL),
    "hangs": ("time.sleep(600)", -signal.SIGKILL),
}
MASTER = """
import sys, time
from pathlib import Path
from lockstep.processes.child_process import ChildProcess
folder = Path(sys.argv[1])
child = ChildProcess(["-c", sys.argv[2]], printed=folder / "printed", temporary=folder / "tmp")
time.sleep(600)
"""


def daemon(path):
    """Return the daemon that has written its number to a file."""
    deadline = time.monotonic() + 60.0
    while not path.exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return int(path.read_text())


def assert_gone(process):
    deadline = time.monotonic() + 30.0
    while psutil.pid_exists(process):
        assert time.monotonic() < deadline, "the daemon goes on"
        time.sleep(0.01)


@pytest.mark.parametrize("end", ENDS)
def test_a_daemon_ends_with_the_process_that_started_it(tmp_path, end):
    source, code = ENDS[end]
    path = tmp_path / "daemon"
    source = DAEMON.format(path=str(path)) + source
    child = ChildProcess(["-c", source], printed=tmp_path / "printed", temporary=tmp_path / "tmp")
    process = daemon(path)
    if end == "hangs":
        child.kill()
    assert (child.wait(60.0), child.left_running) == (code, True)
    assert not psutil.pid_exists(process)


def test_a_daemon_ends_where_the_master_is_killed(tmp_path):
    source = DAEMON.format(path=str(tmp_path / "daemon")) + "time.sleep(600)"
    with subprocess.Popen([sys.executable, "-c", MASTER, str(tmp_path), source]) as master:
        process = daemon(tmp_path / "daemon")
        assert psutil.pid_exists(process)
        master.kill()
    assert_gone(process)


def test_a_daemon_of_an_fmu_ends_with_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # it runs in a folder there
    part = Component(
        name="b",
        source=bad_fmu(tmp_path, "LEAVES_A_DAEMON"),
        period=STEP,
        kind="sampled",
        parameters={"level": 1.0, "rate": 1.0},
    )

    simulate(System(name="one", tick=STEP, stop_time=10 * STEP, components=(part,)), tmp_path / "out")

    left = []
    for process in psutil.process_iter():
        try:
            if process.cwd().startswith(str(tmp_path)):
                left.append(process.name())
        except (psutil.Error, OSError):  # it has ended
            continue
    assert left == []
    assert read_signals(tmp_path / "out")["b.count"][-1] == 11  # the sample at the stop time too
