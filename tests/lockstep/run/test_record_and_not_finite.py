"""Recording of variables other than outputs, and of values that are not finite where nothing uses them."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fmus.echo_fmu import echo_fmu
from lockstep import Component, Connection, RunError, System, read_signals, simulate
from lockstep.__main__ import main

pytestmark = pytest.mark.usefixtures("each_tick")

MS = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def echo(tmp_path_factory) -> Path:
    return echo_fmu(tmp_path_factory.mktemp("echo"))


@pytest.fixture
def chain(echo) -> System:
    """Two components of 1 and 2 ms, `second.x` connected to `first.out.x`."""
    components = [
        Component(name=name, source=echo, period=period * MS, kind="continuous", isolated=False)
        for name, period in (("first", 1), ("second", 2))
    ]
    link = Connection(from_component="first", output="out.x", to_component="second", input="x", delay=1)
    return System(name="chain", tick=MS, components=tuple(components), connections=(link,), path=echo)


@pytest.fixture
def ramp(tmp_path) -> Path:
    file = tmp_path / "in.csv"
    file.write_text("time,first.x,first.n\n0,0,0\n0.003,3,9\n0.005,5,0\n0.009,9,0\n")
    return file


def test_inputs_locals_and_parameters_are_recorded_when_they_are_true(chain, ramp, tmp_path):
    record = ["first.out.x", "inputs:*.x", "second.inner", "parameters:first.*"]
    simulate(chain, tmp_path / "run", stop_time=0.008, inputs=ramp, record=record)
    run = read_signals(tmp_path / "run")
    assert list(run.columns) == ["first.out.x", "second.inner", "first.x", "first.gain", "second.x"]
    ticks = np.arange(8.0)
    assert np.allclose(run["first.x"][:8], ticks, atol=1e-15)  # taken at the start of the step
    assert np.allclose(run["first.out.x"][:8], [0, *ticks[:-1]], atol=1e-15)  # the FMU gives it at the end
    # taken by the step of 2 ms at its start, and held by it; inner is three times it at the step's end
    taken = np.array([0, 0, 1, 1, 3, 3, 5, 5])
    assert np.allclose(run["second.x"][:8], taken, atol=1e-15)
    assert np.allclose(run["second.inner"][:8], [0, 0, 0, 0, 3, 3, 9, 9], atol=1e-15)
    assert set(run["first.gain"]) == {3.0}


def test_inputs_of_isolated_components_are_the_same(chain, ramp, tmp_path):
    record = ["all", "inputs:*", "locals:*"]
    apart = replace(chain, components=tuple(replace(c, isolated=True) for c in chain.components))
    simulate(chain, tmp_path / "one", stop_time=0.008, inputs=ramp, record=record)
    simulate(apart, tmp_path / "two", stop_time=0.008, inputs=ramp, record=record)
    one, two = read_signals(tmp_path / "one"), read_signals(tmp_path / "two")
    assert len(one.columns) == 22
    for name in one.columns:
        np.testing.assert_array_equal(one[name], two[name])


def test_pattern_means_outputs_and_where_none_matches_other_variables(chain, tmp_path):
    simulate(chain, tmp_path / "run", stop_time=0.002, record=["first.*", "second.i*"])
    names = list(read_signals(tmp_path / "run").columns)
    assert names == ["first.out.x", "first.out.h", "first.out.n", "first.out.b", "first.out.s", "second.inner"]


def test_system_without_outputs_records_its_locals(tmp_path):
    fmu = echo_fmu(tmp_path, outputs=False)
    arguments = ["--share-process", "e*", "--stop-time", "0.003", "--step-size", "0.001", "--set", "echo.x=2"]
    assert main(["run", str(fmu), *arguments, "--out", str(tmp_path / "run")]) == 0
    run = read_signals(tmp_path / "run")
    assert list(run.columns) == ["echo.inner"]
    assert set(run["echo.inner"]) == {6.0}


def test_value_that_nothing_uses_is_recorded_and_reported_once(chain, ramp, tmp_path):
    summary = simulate(chain, tmp_path / "run", stop_time=0.008, inputs=ramp)
    h = read_signals(tmp_path / "run")["first.out.h"]
    assert list(np.flatnonzero(np.isnan(h))) == [4, 5]  # of the steps from 3 and 4 ms, at their ends
    events = [json.loads(line) for line in (tmp_path / "run" / "events.jsonl").read_text().splitlines()]
    assert (events[0]["event"], events[0]["stop_time"]) == ("start", 0.008)
    found = [event for event in events if event["event"] == "not-finite"]
    assert [(e["time"], e["component"], e["variables"], e["value"]) for e in found] == [
        (0.003, "first", "out.h", "nan")
    ]
    text = "recorded though not finite, as no connection uses it: first.out.h (nan at 0.004 s)"
    assert [line for line in summary.warnings if "finite" in line] == [text]
    assert text in tomllib.loads((tmp_path / "run" / "run.toml").read_text())["warnings"]


def test_value_of_an_isolated_component_is_recorded_from_the_start(echo, tmp_path, capfd):
    arguments = ["--stop-time", "0.003", "--step-size", "0.001", "--set", "echo.n=9", "--isolate", "ec?o"]
    assert main(["run", str(echo), *arguments, "--out", str(tmp_path / "run")]) == 0
    assert np.isnan(read_signals(tmp_path / "run")["echo.out.h"]).all()
    lines = capfd.readouterr().err.splitlines()
    text = "warning: recorded though not finite, as no connection uses it: echo.out.h (nan at 0 s)"
    assert [line for line in lines if "finite" in line] == [text]


def test_ctrl_c_while_the_components_are_initialized_ends_the_run_before_its_first_tick(chain, tmp_path):
    with pytest.raises(KeyboardInterrupt):  # the FMU sends it, in the midst of a call that must not be disturbed
        simulate(chain, tmp_path / "run", stop_time=0.002, overrides={"first.n": 7})
    assert not (tmp_path / "run").exists()


def test_value_that_a_connection_uses_ends_the_run(chain, ramp, tmp_path):
    link = Connection(from_component="first", output="out.h", to_component="second", input="h", delay=1)
    used = replace(chain, connections=(*chain.connections, link))
    with pytest.raises(RunError, match=r"^first\.out\.h: is nan at 0\.004 s; every exchanged value must be finite"):
        simulate(used, tmp_path / "run", stop_time=0.008, inputs=ramp)
