"""Results folders for a page: found, read, refused; windows of time and fault events."""

import base64
import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose

from flexbench.html.document import Table
from flexbench.report.headline import headline_blocks
from flexbench.report.results import MOST_RUNS, Result, load_results
from flexbench.report.run_data import is_fault, read_run_data
from flexbench.report.text_blocks import event_blocks
from flexbench.report.write import write_report
from flexbench.runs.run_folder import Run
from lockstep import InputError


def test_folder_of_results_folders_gives_all_its_runs(tmp_path, foreign_run):
    for path in ("study/a", "study/b", "other/a"):
        foreign_run(tmp_path / path)

    assert [r.name for r in load_results([tmp_path / "study"])[0]] == ["a", "b"]
    given = [tmp_path / "study", tmp_path / "other" / "a"]
    assert [r.name for r in load_results(given)[0]] == ["study/a", "b", "other/a"]


def test_too_many_runs_are_refused(tmp_path, foreign_run):
    for k in range(MOST_RUNS + 1):
        foreign_run(tmp_path / f"r{k}")
    with pytest.raises(InputError, match=f"a page takes {MOST_RUNS} at most"):
        load_results([tmp_path])


def test_run_without_rows_is_refused(tmp_path, foreign_run):
    run = foreign_run(tmp_path / "run")
    pq.write_table(pq.read_table(run / "signals.parquet").slice(0, 0), run / "signals.parquet")
    with pytest.raises(InputError, match="no row of signals yet"):
        write_report([run])


def test_runs_that_cannot_be_read_do_not_stop_the_page_of_the_others(tmp_path, foreign_run):
    names = ["good", "without rows", "torn", "no record"]
    good, empty, torn, broken = (foreign_run(tmp_path / "study" / name) for name in names)
    pq.write_table(pq.read_table(empty / "signals.parquet").slice(0, 0), empty / "signals.parquet")
    (torn / "signals.parquet").write_bytes((torn / "signals.parquet").read_bytes()[:100])
    (broken / "run.toml").write_text("[[[")

    (page,) = write_report([tmp_path / "study"])

    text = page.read_text(encoding="utf-8")
    for name in names[1:]:
        assert f"Not on this page: {name} (" in text
    assert "Not on this page: good" not in text
    assert '"name": "good"' in text
    shutil.rmtree(good)
    with pytest.raises(InputError, match="no row of signals yet"):
        write_report([tmp_path / "study"])


def test_runs_that_did_not_complete_are_marked_where_they_are_among_others(tmp_path, foreign_run):
    names = ["whole", "failed", "killed"]
    folders = [foreign_run(tmp_path / "study" / name) for name in names]
    for folder, status in zip(folders[1:], ("failed", "running"), strict=True):
        record = folder / "run.toml"
        record.write_text(record.read_text().replace("completed", status).replace("2.0", "1.25"))

    assert [r.name for r in load_results(folders)[0]] == ["whole", "failed (failed at 1.25 s)", "killed (without end)"]
    assert [r.name for r in load_results(folders[1:2])[0]] == ["failed"]  # the page of one has its status


def test_numbers_in_events_have_units(tmp_path, foreign_run):
    events = [
        {"time": 0.0, "event": "start", "stop_time": 300.0},
        {"time": 1.5, "event": "torque-saturation", "state": "begin", "limit": 0.8, "wheels": [28, 31]},
        {"time": 1.9, "event": "torque-saturation", "state": "end", "since": 1.5},
        {"time": 2.0, "event": "divergence", "quantity": "rate", "value": 0.25},
    ]
    run = foreign_run(tmp_path / "run", "".join(f"{json.dumps(one)}\n" for one in events))
    read, _ = load_results([run])
    (table,) = (block for block in event_blocks(read) if isinstance(block, Table))
    assert [row[2] for row in table.rows] == [
        "stop_time: 300 s",
        "state: begin, limit: 0.8 N.m, wheels: [28, 31]",
        "state: end, since: 1.5 s",
        "quantity: rate, value: 0.25 rad/s",
    ]


@pytest.mark.parametrize(
    ("status", "sentence"),
    [
        ("failed", "The run failed: controller: refused at 2 s."),
        ("interrupted", "The run was interrupted: controller: refused at 2 s."),
        ("running", "The run has not ended, or was killed."),
    ],
)
def test_the_page_of_a_run_begins_with_why_it_did_not_complete(status, sentence):
    record = {"status": status} | ({} if status == "running" else {"reason": "controller: refused\nat 2 s."})
    run = Run(folder=Path("nowhere"), configuration="distributed", slew=False, seed=1)
    result = Result(folder=Path("nowhere"), name="r", record=record, text="", events=[], run=run)
    assert sentence in headline_blocks([result], [])[0].text


def test_a_page_does_not_replace_a_record(tmp_path, foreign_run):
    run = foreign_run(tmp_path / "run")
    with pytest.raises(InputError, match=r"run\.toml: is the run's own record; choose another file"):
        write_report([run], run / "run.toml")


def test_short_window_keeps_every_row(tmp_path, foreign_run):
    (result,), _ = load_results([foreign_run(tmp_path / "run")])

    (part,) = read_run_data(result, runs=1, window=(0.5, 0.75)).for_script["parts"]

    assert_allclose((part["time"]["start"], part["time"]["end"], part["time"]["count"]), (0.5, 0.75, 26))
    values = np.frombuffer(base64.b64decode(part["data"][0]), dtype="<f4").astype(float)
    assert_allclose(values, np.sin(np.arange(50, 76) * 0.01), rtol=1e-6)
    with pytest.raises(
        InputError, match=r"--time-range 5 6: holds less than two rows; the record goes from 0 to 1\.99 s"
    ):
        read_run_data(result, runs=1, window=(5.0, 6.0))


def test_damaged_run_record_is_refused(tmp_path, foreign_run):
    run = foreign_run(tmp_path / "run", extra="[[[")
    with pytest.raises(InputError, match=r"run\.toml: is no TOML"):
        write_report([run])


def test_fault_events_are_recognised():
    assert is_fault({"event": "fault", "name": "stuck"})
    assert is_fault({"event": "begin", "kind": "fault"})
    assert not is_fault({"event": "start"})
