"""A monitor sees each recorded row once, in order; what it finds is among the events, also of a run that went on."""

import json
import shutil
import tomllib

import numpy as np
import pytest

from fmus.wanderer.wanderer import wanderer
from lockstep import Component, RunError, System, read_signals, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.results.monitor import Found
from lockstep.results.read_events import read_events
from lockstep.simulation import resume

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMU is compiled with gcc")
STEP = 100_000_000  # [ns]: ten rows a second


class Crossings:
    """Finds where a signal becomes positive; how rows are divided does not matter."""

    def __init__(self, name):
        self.name, self.time, self.values, self.count, self.before = name, [], [], 0, True

    def rows(self, time, columns):
        values = columns[self.name]
        self.time += time.tolist()
        self.values += values.tolist()
        for t, positive in zip(time.tolist(), (values > 0.0).tolist(), strict=True):
            if positive and not self.before:
                self.count += 1
                yield Found(time=t, event="crossing", details={"value": 1})
            self.before = positive

    def end(self):
        return [Found(time=self.time[-1], event="crossings", details={"count": self.count})]

    def summary(self):
        return [{"event": "crossing", "count": self.count}]


class Watcher:
    """Makes the monitor of a run, and keeps it."""

    def __call__(self, system, parameters, recorded):
        self.given = [c.name for c in system.components], parameters["a"]["seed"], list(recorded)
        self.monitor = Crossings("a.y")
        return self.monitor


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    fmu = wanderer(tmp_path_factory.mktemp("fmu"), "good")
    part = Component(name="a", source=fmu, period=STEP, kind="sampled", isolated=False, parameters={"seed": 5})
    return System(name="demo", tick=STEP, components=(part,), stop_time=45 * STEP, record=("a.y", "a.steps"))


def lines(folder):
    return [json.loads(line) for line in (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()]


def test_a_monitor_sees_all_rows_and_its_findings_are_events(system, tmp_path):
    watch = Watcher()
    simulate(system, tmp_path / "run", watch=watch)
    signals = read_signals(tmp_path / "run")
    y = signals["a.y"]
    crossings = signals.time[1:][(y[1:] > 0.0) & (y[:-1] <= 0.0)]

    assert watch.given == (["a"], 5, ["a.y", "a.steps"])
    np.testing.assert_array_equal(watch.monitor.time, signals.time)
    np.testing.assert_array_equal(watch.monitor.values, y)
    found = lines(tmp_path / "run")
    assert len(crossings) > 3
    assert [e["time"] for e in found if e["event"] == "crossing"] == crossings.tolist()
    assert [e["event"] for e in found[-2:]] == ["crossings", "end"]
    times = [e["time"] for e in read_events(tmp_path / "run")]
    assert times == sorted(e["time"] for e in found)
    record = tomllib.loads((tmp_path / "run/run.toml").read_text(encoding="utf-8"))
    assert record["found"] == [{"event": "crossing", "count": len(crossings)}]


def test_a_run_without_a_monitor_has_no_findings(system, tmp_path):
    simulate(system, tmp_path / "run", watch=lambda *_: None)
    assert "found" not in (tmp_path / "run/run.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("time", ["1.5", "3.0"])
def test_a_run_that_goes_on_has_the_same_findings(system, tmp_path, time):
    simulate(system, tmp_path / "run", watch=Watcher(), checkpoints=CheckpointSchedule(times=[time]))
    before = [e for e in lines(tmp_path / "run") if e["event"].startswith("crossing")]
    record = tmp_path / "run/run.toml"
    record.write_text(record.read_text().replace('"completed"', '"running"', 1))
    watch = Watcher()
    resume(tmp_path / "run", system, watch=watch)

    assert [e for e in lines(tmp_path / "run") if e["event"].startswith("crossing")] == before
    np.testing.assert_array_equal(watch.monitor.time, read_signals(tmp_path / "run").time)
    assert tomllib.loads(record.read_text())["found"] == [{"event": "crossing", "count": before[-1]["count"]}]


def test_findings_of_a_run_that_fails_stay(tmp_path):
    fmu = wanderer(tmp_path, "complains", "COMPLAINS")  # its state cannot be saved
    part = Component(name="a", source=fmu, period=STEP, kind="sampled", isolated=False, parameters={"seed": 5})
    failing = System(name="demo", tick=STEP, components=(part,), stop_time=45 * STEP, record=("a.y", "a.steps"))
    watch = Watcher()
    with pytest.raises(RunError):
        simulate(failing, tmp_path / "run", watch=watch, checkpoints=CheckpointSchedule(times=["3.5"]))
    record = tomllib.loads((tmp_path / "run/run.toml").read_text(encoding="utf-8"))
    assert record["status"] == "failed"
    assert record["found"] == [{"event": "crossing", "count": watch.monitor.count}]
    assert watch.monitor.time == read_signals(tmp_path / "run").time.tolist()
