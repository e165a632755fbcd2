"""FMUs that write to descriptors or the working directory, or copy their process: values and folders stay right."""

import json
from pathlib import Path

import numpy as np
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import Component, RunError, System, read_signals, simulate
from lockstep.fmi.model_description import read_description
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.shared_memory import REQUEST

STEP = 10_000_000  # [ns]


def component(fmu, **options):
    """Return a component `b` of an FMU."""
    return Component(name="b", source=fmu, period=STEP, parameters={"level": 1.0, "rate": 1.0}, **options)


def run(fmu, out, **options):
    """Run 20 steps of an FMU; return its signals and what it logged."""
    simulate(System(name="one", tick=STEP, stop_time=20 * STEP, components=(component(fmu, **options),)), out)
    events = [json.loads(line) for line in (out / "events.jsonl").read_text().splitlines()]
    return read_signals(out), [event for event in events if event["event"] == "log"]


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """Return the signals of an FMU without a defect in the master's process."""
    folder = tmp_path_factory.mktemp("usual")
    return run(bad_fmu(folder), folder / "out", isolated=False)[0]


@pytest.mark.parametrize("defect", ["WRITES_TO_DESCRIPTORS", "RETURNS_TWICE"])
def test_values_are_those_of_the_fmu_alone(usual, tmp_path, defect):
    signals, logged = run(bad_fmu(tmp_path, defect), tmp_path / "out")

    for name in usual.columns:
        np.testing.assert_array_equal(signals[name], usual[name], name)
    texts = [event["message"] for event in logged]
    assert [text[:54] for text in texts] == (
        ["it, or a process that it started, writes to the pipe of"[:54]] if defect == "WRITES_TO_DESCRIPTORS" else []
    )


def test_files_written_to_the_working_directory_do_not_reach_the_users_folder(usual, tmp_path, monkeypatch):
    fmu = bad_fmu(tmp_path, "LEAVES_A_FILE")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")

    signals, _ = run(Path("..", fmu.name), Path("out"))

    np.testing.assert_array_equal(signals["b.scaled"], usual["b.scaled"])
    assert [path.name for path in Path().iterdir()] == ["out"]


def test_a_request_that_is_missing_ends_the_run(good, tmp_path):
    slave = RemoteSlave(component(good), read_description(component(good)), tmp_path, lambda *_: None)
    try:
        slave.ready()
        connection = slave.connection
        connection.link.number += 1
        connection.numbers[REQUEST] = connection.link.number
        with pytest.raises(RunError, match="request 3 came where 2 was expected"):
            slave.setup_experiment(0.0, 1.0)
    finally:
        slave.close()
