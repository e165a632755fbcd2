"""Child processes: how they ended, what they printed and left running, and the record of their last call."""

import os
import signal
import time
from functools import partial

import pytest

from lockstep import RunError
from lockstep.processes.child_call import call_in_child
from lockstep.processes.child_process import ChildProcess, absolute_paths, ending, printed_lines
from lockstep.processes.last_call import last_call_in, read_last_call


@pytest.fixture
def child(tmp_path):
    """Return a function that runs Python code in a child process, which is killed at the end."""
    started = []

    def start(source):
        started.append(ChildProcess(["-c", source], printed=tmp_path / "printed", temporary=tmp_path / "tmp"))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.parametrize(
    ("source", "code", "text"),
    [
        ("pass", 0, "ended its process with exit code 0"),
        ("raise SystemExit(3)", 3, "ended its process with exit code 3"),
        ("import os; os.abort()", -6, "crashed with SIGABRT"),
    ],
)
def test_the_end_of_a_process_is_described(child, source, code, text):
    assert child(source).wait(60.0) == code
    assert ending(code) == text


def test_a_signal_without_a_name_is_described():
    assert ending(-99, "the") == "crashed with signal 99"


def test_a_process_that_goes_on_has_no_exit_code(child):
    process = child("import time; time.sleep(600)")
    assert (process.wait(0.05), process.code) == (None, None)
    process.kill()
    assert process.wait(60.0) == -9


LEAVES = """
import os, subprocess, sys
code = "import time; time.sleep(600)"
for new_session in (False, True):
    subprocess.Popen([sys.executable, "-c", code], start_new_session=new_session)
"""


def test_processes_left_running_are_found_and_killed(child):
    process = child(LEAVES)
    assert process.wait(60.0) == 0
    assert process.left_running
    assert process.others() == []
    assert not child("pass").left_running


def test_the_last_lines_printed_are_kept(child, tmp_path):
    child("print('first'); print(); print('x' * 300)").wait(60.0)
    assert printed_lines(tmp_path / "printed", 2) == ["first", "x" * 200]
    assert printed_lines(tmp_path / "printed", 1) == ["x" * 200]
    assert printed_lines(tmp_path / "nothing", 1) == []


def test_folders_in_the_environment_hold_in_another_working_directory(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(["lib", "", "/opt/lib"]))
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)
    monkeypatch.chdir(tmp_path)
    paths = absolute_paths()
    assert paths["PYTHONPATH"].split(os.pathsep) == [str(tmp_path / "lib"), str(tmp_path), "/opt/lib"]
    assert "LD_LIBRARY_PATH" not in paths


def fail():
    raise RunError("no torque")


def test_a_call_in_a_child_returns_its_result_or_a_reason():
    assert call_in_child(partial(divmod, 7, 2)) == (3, 1)
    assert call_in_child(fail) == "no torque"
    assert call_in_child(partial(int, "seven")).startswith("ValueError: invalid literal")
    assert call_in_child(partial(os._exit, 4)) == "the FMU ended its process with exit code 4"
    assert call_in_child(partial(signal.raise_signal, signal.SIGKILL)) == "the FMU crashed with SIGKILL"
    assert call_in_child(os.getpid) != os.getpid()


def fork_and_return():
    if os.fork() == 0:
        return "copy"
    time.sleep(0.3)  # the copy returns first
    return "original"


def test_a_call_that_copies_its_process_has_one_result():
    assert call_in_child(fork_and_return) == "original"


def test_the_last_call_outlives_its_process(tmp_path):
    path = tmp_path / "last_call"
    assert read_last_call(path) == ""
    record = last_call_in(path)
    assert read_last_call(path) == ""
    record.enter("fmi2DoStep", 0.25)
    assert read_last_call(path) == "fmi2DoStep at t = 0.25 s"
    record.leave()
    assert read_last_call(path) == ""
    record.enter("fmi2Instantiate", None)
    assert read_last_call(path) == "fmi2Instantiate"
    path.write_bytes(b"cut off")
    assert read_last_call(path) == ""


def test_a_long_text_is_cut_to_the_record(tmp_path):
    record = last_call_in(tmp_path / "last_call")
    record.leave_text("y" * 5000)
    assert record.text == "y" * 960
