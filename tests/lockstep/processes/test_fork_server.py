"""Copies of a process that has imported modules: each is a process of its own, with its own end, folder and output."""

import json
import os
import signal

import psutil
import pytest

from lockstep.operating_system import can_serve_copies
from lockstep.processes.child_process import ChildProcess, environment_of, printed_lines
from lockstep.processes.fork_server import ForkServer

pytestmark = pytest.mark.skipif(not can_serve_copies(), reason="this system cannot copy processes at any time")
ACTS = """
import json, os, subprocess, sys, time
imported = os.getpid()
state = []

def main(arguments):
    state.append(1)
    what = arguments[0]
    if what == "show":
        print(json.dumps([os.getpid() != imported, state, os.getcwd(), os.environ["TMPDIR"], arguments]))
        return 3
    if what == "crash":
        os.abort()
    if what == "leave":
        left = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], start_new_session=True)
        print(left.pid)
        return 0
    if what == "end the server":
        os.kill(imported, 9)
    time.sleep(600)
"""


@pytest.fixture
def start(tmp_path, monkeypatch):
    """Return a function that starts a copy which acts as it is named, in a folder."""
    (tmp_path / "acts.py").write_text(ACTS)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    server = ForkServer(["acts"], environment_of(tmp_path / "tmp"), tmp_path)
    started = []

    def act(*words, folder=tmp_path):
        child = ChildProcess(["acts:main", *words], printed=tmp_path / "printed", temporary=tmp_path / "tmp",
                             directory=folder, server=server)  # fmt: skip
        started.append(child)
        return child

    yield act
    for child in started:
        child.kill()
        child.wait()
    server.close()


def test_a_copy_is_what_a_new_process_would_be(start, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    for folder in (tmp_path / "elsewhere", tmp_path):
        child = start("show", "ä b", folder=folder)
        assert child.wait(60.0) == 3
        (line,) = printed_lines(tmp_path / "printed", 2)
        assert json.loads(line) == [True, [1], str(folder), str(tmp_path / "tmp"), ["show", "ä b"]]
        assert not child.left_running


def test_a_crash_a_kill_and_a_time_limit_end_one_copy_alone(start):
    assert start("crash").wait(60.0) == -signal.SIGABRT
    child = start("wait")
    assert child.wait(0.05) is None
    assert os.getsid(child.pid) == child.guard
    child.kill()
    assert child.wait(60.0) == -signal.SIGKILL
    assert start("show").wait(60.0) == 3


def test_what_a_copy_leaves_running_is_reported_and_ended(start, tmp_path):
    child = start("leave")
    assert child.wait(60.0) == 0
    assert child.left_running
    (left,) = printed_lines(tmp_path / "printed", 2)
    assert not psutil.pid_exists(int(left))


def test_a_copy_ends_with_its_server_and_the_next_is_refused(start):
    child = start("end the server")
    pid = child.pid
    assert child.wait(60.0) == -signal.SIGKILL
    psutil.wait_procs([psutil.Process(pid)] if psutil.pid_exists(pid) else [], timeout=60.0)
    assert not psutil.pid_exists(pid)
    with pytest.raises(OSError):  # noqa: PT011 (of which kind depends on how far the end has got)
        start("show")
