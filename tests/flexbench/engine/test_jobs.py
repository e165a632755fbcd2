"""Runs in parallel processes: order, messages of failed jobs and dead processes, progress."""

from __future__ import annotations

import io
import os
import re
import subprocess
from pathlib import Path

import psutil
import pytest
import rich.console
from rich.console import Console

from flexbench.engine import jobs as jobs_module
from flexbench.engine import tasks
from flexbench.engine.dispatch import dispatch
from flexbench.engine.job_progress import show_jobs
from flexbench.engine.jobs import Job, run_jobs
from flexbench.engine.pools import LocalPool, settings_of
from flexbench.engine.tasks import NoResult, Task
from flexbench.engine.worker import BugInWorker, LostWorker
from lockstep import InputError, RunError


class Shell(str):
    """A job that is a line of shell in its worker: `run_jobs` reads only the title of a job."""

    __slots__ = ()

    @property
    def title(self):
        """Return the last word."""
        return self.split()[-1]

    def __reduce__(self):
        return str, (str(self),)


class Deadly(Shell):
    """A job that ends its process at once, as an FMU may."""

    __slots__ = ()

    def __reduce__(self):
        return os._exit, (3,)


@pytest.fixture
def shell(monkeypatch):
    """Let workers run lines of shell instead of simulations; a function of a module that they can import."""
    monkeypatch.setattr(jobs_module, "run_job", subprocess.getoutput)


@pytest.mark.usefixtures("shell")
def test_results_are_in_the_order_of_the_jobs():
    jobs = [Shell(f"sleep {wait}; echo {name}") for wait, name in ((1.0, "slow"), (0.0, "quick"), (0.0, "last"))]

    assert run_jobs(jobs, processes=2) == ["slow", "quick", "last"]


@pytest.mark.usefixtures("shell")
def test_jobs_share_processes_that_live_on():
    pids = run_jobs([Shell(f"echo $PPID {k}") for k in range(3)], processes=1)

    assert len({text.split()[0] for text in pids}) == 1
    assert not psutil.pid_exists(int(pids[0].split()[0]))


@pytest.mark.usefixtures("shell")
def test_dead_process_is_reported_by_the_name_of_its_job():
    with pytest.raises(RunError, match=r"^fatal: its process ended with exit code 3, twice; run it alone"):
        run_jobs([Deadly("echo fatal")], processes=1)


def fail(job: str) -> None:
    """Fail as a run does that the master stops: in a worker."""
    raise RunError(f"plant: refused at 1 s, in {job.split()[-1]}")


def test_a_failed_run_is_returned_with_its_reason_where_that_is_wanted(monkeypatch):
    monkeypatch.setattr(jobs_module, "run_job", fail)
    jobs = [Shell("echo first"), Shell("echo second")]
    with pytest.raises(RunError, match=r"^first: plant: refused at 1 s, in first$"):
        run_jobs(jobs[:1], processes=1)

    finished = run_jobs(jobs, processes=2, keep_failed=True)
    assert [done.failure for done in finished] == [
        "plant: refused at 1 s, in first",
        "plant: refused at 1 s, in second",
    ]
    assert [done.job.title for done in finished] == ["first", "second"]
    assert all(done.simulated_time == 0.0 for done in finished)


def test_one_run_does_not_stop_others_where_all_are_wanted(tmp_path, monkeypatch, capsys):
    nowhere = Job(system=tmp_path / "nowhere.ssd", folder=tmp_path / "slew")
    (refused,) = run_jobs([nowhere], processes=1, keep_all=True)
    assert capsys.readouterr().err == "slew: failed (1 of 1)\n"
    assert "nowhere.ssd: no such file" in refused.failure

    monkeypatch.setattr(jobs_module, "run_job", subprocess.getoutput)
    dead, alive = run_jobs([Deadly("echo fatal"), Shell("echo alive")], processes=2, keep_all=True)
    assert dead.failure == "its process ended with exit code 3, twice"
    assert alive == "alive"


def test_failed_job_is_named_in_the_message(tmp_path: Path):
    job = Job(system=tmp_path / "nowhere.ssd", folder=tmp_path / "results" / "centralised-slew-seed1")

    with pytest.raises(InputError, match=r"^centralised-slew-seed1: .*nowhere\.ssd: no such file"):
        run_jobs([job])
    assert list(tmp_path.iterdir()) == []


def test_title_of_a_job_is_the_name_of_its_folder(tmp_path: Path):
    assert Job(system=tmp_path / "a.ssd", folder=tmp_path / "some-run").title == "some-run"


def test_progress_without_terminal_is_one_line_for_each_finished_run(capsys):
    with show_jobs(["a", "b"]) as show:
        for title, simulated in (("a", 1.0), ("b", 2.0), ("a", 3.0), ("a", 3.0), ("b", 3.0)):
            show(title, simulated, 3.0)

    assert capsys.readouterr().err == "a: 3 s simulated (1 of 2)\nb: 3 s simulated (2 of 2)\n"


def test_progress_on_a_terminal_has_a_bar_for_each_run_under_way_and_a_line_for_each_that_ended(monkeypatch):
    shown = io.StringIO()
    monkeypatch.setattr(
        rich.console, "Console", lambda **_: Console(file=shown, width=80, force_terminal=True, color_system=None)
    )
    names = [f"centralised-fine-pointing-open-loop-as-published-seed{k}" for k in range(1, 4)]
    with show_jobs(names) as show:
        show(names[0], 30.0, 300.0)
        show(names[1], 60.0, 300.0)
        show(names[0], 300.0, 300.0)
        show.end(names[1], "failed")
        show(names[1], 60.0, 300.0)  # a report that comes late
        show.end(names[0], "ended")  # as its last report said
        bars = [task.description for task in show._bars.progress.tasks]
    lines = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.getvalue()).splitlines()
    assert bars == ["2 of 3 runs"]
    assert [line for line in lines if line.endswith(" of 3)")] == [
        f"{names[0]}: 300 s simulated (1 of 3)",
        f"{names[1]}: failed (2 of 3)",
    ]
    assert "…" not in shown.getvalue()


def test_a_bug_in_a_task_comes_with_the_traceback_of_its_process():
    pool = LocalPool(settings_of(), 1)
    task = Task(number=1, title="bug", function=int, arguments=("none",))
    try:
        with pytest.raises(BugInWorker, match="ValueError: invalid literal") as caught:
            list(dispatch([task], pool))
    finally:
        pool.close()
    (note,) = caught.value.__notes__
    assert "worker_process.py" in note


def carried_out(code):
    """Return the outcome of a task that is lines of Python."""
    pool = LocalPool(settings_of(), 1)
    try:
        (outcome,) = dispatch([Task(number=1, title="run 1", function=exec, arguments=(code,))], pool)
    finally:
        pool.close()
    return outcome


def test_what_a_machine_refuses_once_is_tried_again_in_another_process(tmp_path):
    mark = tmp_path / "mark"
    outcome = carried_out(f"""
import os, pathlib
mark = pathlib.Path({str(mark)!r})
first = not mark.exists()
with mark.open("a") as stream:
    stream.write(f"{{os.getpid()}} ")
if first:
    raise OSError(24, "Too many open files", "signals")
""")

    assert (outcome.failure, outcome.error, outcome.attempts) == ("", None, 2)
    assert len(set(mark.read_text().split())) == 2


@pytest.mark.parametrize(
    ("error", "cause"),
    [
        ("OSError(24, 'Too many open files', 'signals')", "signals: Too many open files"),
        ("MemoryError", "out of memory"),
        ('RuntimeError("can\'t start new thread")', "no more threads"),
    ],
)
def test_what_a_machine_refuses_twice_is_no_result_and_no_bug(error, cause):
    with pytest.raises(NoResult, match=f"^run 1: {cause}, twice, on .*; mend that and give the same command again$"):
        carried_out(f"raise {error}")


def test_a_task_whose_worker_is_lost_while_the_pool_ends_is_not_begun_again(monkeypatch):
    begun = []

    class Lost(tasks.WorkerProcess):
        def run(self, *_):
            begun.append(self)
            pool.end()
            raise LostWorker("vanished", "its process was killed (SIGKILL)")

    monkeypatch.setattr(tasks, "WorkerProcess", Lost)
    pool = LocalPool(settings_of(), 1)
    try:
        with pytest.raises(KeyboardInterrupt):
            pool.submit(Task(number=1, title="run 1", function=int, arguments=("1",))).result(timeout=60.0)
    finally:
        pool.close()
    assert len(begun) == 1
