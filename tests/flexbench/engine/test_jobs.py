"""Runs in parallel processes: order, messages of failed jobs and dead processes, progress."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import psutil
import pytest

from flexbench.engine import jobs as jobs_module
from flexbench.engine.dispatch import dispatch
from flexbench.engine.job_progress import show_jobs
from flexbench.engine.jobs import Job, run_jobs
from flexbench.engine.pools import LocalPool, settings_of
from flexbench.engine.tasks import Task
from flexbench.engine.worker import BugInWorker
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


def test_one_run_does_not_stop_others_where_all_are_wanted(tmp_path, monkeypatch):
    nowhere = Job(system=tmp_path / "nowhere.ssd", folder=tmp_path / "slew")
    (refused,) = run_jobs([nowhere], processes=1, keep_all=True)
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
