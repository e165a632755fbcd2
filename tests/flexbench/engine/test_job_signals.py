"""A signal to a study ends its processes, with their results closed; a job holds its folder, and feeds its inputs."""

import json
import os
import signal
import threading
import time
import tomllib

import pytest

from flexbench.engine.jobs import Job, run_job, run_jobs
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, InputError, System, read_signals, write_ssd
from lockstep.interrupt import Stopped, ended_by_signals
from lockstep.results.results_folder import claim

START = {"u": 0.0, "offset": 0.0, "number": 0, "flag": False}


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a system file of one FMU, isolated."""
    folder = tmp_path_factory.mktemp("system")
    part = Component(
        name="a", source=wanderer(folder, "good"), period=1_000_000, kind="sampled", isolated=True, parameters=START
    )
    write_ssd(System(name="one", tick=1_000_000, stop_time=10**14, components=(part,), connections=()),
              folder / "one.ssd")  # fmt: skip
    return folder / "one.ssd"


def wait_for_rows(folder):
    deadline = time.monotonic() + 60.0
    while not ((folder / "signals.arrows").exists() and (folder / "signals.arrows").stat().st_size > 20_000):
        assert time.monotonic() < deadline, f"nothing was written to {folder}"
        time.sleep(0.02)


def test_a_signal_ends_the_jobs_and_closes_their_folders(system, tmp_path):
    def send():
        wait_for_rows(tmp_path / "one")
        os.kill(os.getpid(), signal.SIGTERM)

    thread = threading.Thread(target=send)
    thread.start()
    with pytest.raises(Stopped) as caught, ended_by_signals():
        run_jobs([Job(system=system, folder=tmp_path / "one", metrics=False)])
    thread.join()

    assert caught.value.name == "SIGTERM"
    run = tomllib.loads((tmp_path / "one/run.toml").read_text())
    assert run["status"] == "interrupted"
    assert run["simulated_time"] == len(read_signals(tmp_path / "one").time) / 1000  # every row is there
    assert json.loads((tmp_path / "one/events.jsonl").read_text().splitlines()[-1])["status"] == "interrupted"


def test_a_job_is_refused_while_another_run_has_its_folder(system, tmp_path):
    with claim(tmp_path / "out"), pytest.raises(InputError, match="another run is writing to it"):
        run_job(Job(system=system, folder=tmp_path / "out", metrics=False))


def test_a_job_that_is_complete_is_not_repeated_unless_what_it_depends_on_has_changed(system, tmp_path):
    def job(**changed):
        return Job(system=system, folder=tmp_path / "out", stop_time=0.01, metrics=False, **changed)

    first = run_job(job(overrides={"a.seed": 1}))
    before = (tmp_path / "out/signals.parquet").stat()
    again = run_job(job(overrides={"a.seed": 1}))
    kept = (tmp_path / "out/signals.parquet").stat()
    other = run_job(job(overrides={"a.seed": 2}))
    after = (tmp_path / "out/signals.parquet").stat()

    assert (again.wall_time, again.simulated_time) == (first.wall_time, first.simulated_time)
    assert kept.st_mtime_ns == before.st_mtime_ns
    assert after.st_mtime_ns > before.st_mtime_ns
    assert other.simulated_time == 0.01
    content = json.loads((tmp_path / "out/job.json").read_text())
    (tmp_path / "out/job.json").write_text(json.dumps({**content, "depends_on": "other code"}))
    run_job(job(overrides={"a.seed": 2}))
    assert (tmp_path / "out/signals.parquet").stat().st_mtime_ns > after.st_mtime_ns


def test_a_job_feeds_its_inputs_and_is_another_one_once_their_file_changes(system, tmp_path):
    file = tmp_path / "u.csv"
    for value in (2.5, -1.0):
        file.write_text(f"time,a.u\n0,{value}\n", encoding="utf-8")
        job = Job(system=system, folder=tmp_path / "out", metrics=False, stop_time=0.01, inputs=(file,),
                  record=("inputs:a.u",))  # fmt: skip
        run_job(job)
        assert set(read_signals(tmp_path / "out")["a.u"]) == {value}
