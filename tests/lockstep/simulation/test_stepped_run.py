"""A run that is stepped: its rows are those of one call, however it is stepped; its end, and what is refused."""

import gc
import json
import pickle
import signal
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import lockstep
from lockstep import InputError, RunError, read_signals, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule

STOP = 0.06  # [s]


def assert_equal(one, other):
    assert list(one) == list(other)
    np.testing.assert_array_equal(one.time, other.time)
    for name in one:
        np.testing.assert_array_equal(one[name].view(np.int64), other[name].view(np.int64), name)


@pytest.fixture(scope="module")
def whole(triple):
    return simulate(triple).signals


def test_steps_give_the_rows_of_one_call(triple, whole):
    with lockstep.open(triple) as run:
        assert run.time == 0.0
        run.step()
        run.step(4)
        assert run.time == 0.005
        run.run_until("0.02")
        times = list(run)
        assert times == [k / 1000 for k in range(21, 61)]
        assert_equal(run.signals, whole)  # with the row at the stop time
    assert_equal(run.signals, whole)
    assert (run.summary.rows, run.summary.ticks, run.summary.simulated_time) == (61, 60, STOP)


def test_a_folder_of_a_stepped_run_is_that_of_one_call(triple, tmp_path):
    options = {"checkpoints": CheckpointSchedule(times=["0.02"]), "record_period": 0.003, "overrides": {"a.gain": 2.0}}
    simulate(triple, tmp_path / "whole", **options)
    with lockstep.open(triple, tmp_path / "stepped", **options) as run:
        with pytest.raises(InputError, match=r"signals: are in .*stepped when the run is closed"):
            _ = run.signals
        for _ in run:
            pass

    assert (tmp_path / "stepped/signals.parquet").read_bytes() == (tmp_path / "whole/signals.parquet").read_bytes()
    events = [(tmp_path / name / "events.jsonl").read_text() for name in ("whole", "stepped")]
    assert events[0] == events[1]
    assert tomllib.loads((tmp_path / "stepped/run.toml").read_text())["status"] == "completed"
    assert (tmp_path / "stepped/checkpoints/t=0.02.ckpt").exists()
    assert_equal(run.signals, read_signals(tmp_path / "whole"))


def test_a_run_that_is_closed_early_is_one_that_ends_there(triple, tmp_path):
    with lockstep.open(triple, tmp_path / "early") as run:
        run.run_until(0.03)
    record = tomllib.loads((tmp_path / "early/run.toml").read_text())

    assert_equal(read_signals(tmp_path / "early"), simulate(triple, stop_time=0.03).signals)
    assert (record["status"], record["stop_time"], record["simulated_time"]) == ("completed", 0.03, 0.03)


def test_a_sum_of_floats_is_the_tick_beside_it(triple):
    time = 0.0
    with lockstep.open(triple) as run:
        for _ in range(30):
            time += 0.001
            run.run_until(time)
        assert run.time == 0.03 != time
        run.run_until(run.time)  # nothing to do


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run: run.step(0), r"step: 0 must be a whole number of ticks, 1 or more; run_until goes to a time"),
        (lambda run: run.step(0.5), r"step: 0\.5 must be a whole number of ticks"),
        (lambda run: run.step(60), r"a step to 0\.061 s would pass the stop time, 0\.06 s; open the run with a later"),
        (lambda run: run.run_until(0.0105), r"run_until: 0\.0105 s lies between two ticks; choose 0\.01 s or 0\.011 s"),
        (lambda run: run.run_until(0.0), r"run_until: 0\.0 s is before the present time, 0\.001 s; restore a snapshot"),
        (lambda run: run.run_until(1), r"a step to 1 s would pass the stop time, 0\.06 s"),
        (lambda run: run.run_until(float("nan")), r"run_until: nan is not a number of seconds"),
        (lambda run: run.run_until("soon"), r"run_until: 'soon' is not a number of seconds"),
        (lambda run: run.summary, r"summary: is there when the run is closed"),
        (lambda run: run.restore(3), r"restore: 3 is no snapshot"),
    ],
)
def test_what_is_refused_leaves_the_run_as_it_was(triple, call, message):
    with lockstep.open(triple, stop_time=STOP) as run:
        run.step()
        with pytest.raises(InputError, match=message):
            call(run)
        assert run.time == 0.001
        run.step(59)


def test_numbers_of_numpy_are_counts(triple):
    with lockstep.open(triple) as run:
        run.step(np.int64(3))
        assert run.time == 0.003


def test_a_closed_run_refuses_everything_but_its_signals(triple):
    run = lockstep.open(triple)
    run.step(5)
    run.close()
    run.close()
    for call in (run.step, lambda: run.run_until(0.05), lambda: run["a.y"], lambda: run.set("a.gain", 2.0),
                 run.snapshot, lambda: list(run)):  # fmt: skip
        with pytest.raises(InputError, match=r"the run is closed; open another one with lockstep\.open"):
            call()
    assert len(run.signals.time) == 6


def test_an_exception_in_the_block_closes_the_folder(triple, tmp_path):
    with pytest.raises(ZeroDivisionError), lockstep.open(triple, tmp_path / "out") as run:  # noqa: PT012
        run.step(10)
        _ = 1 / 0
    record = tomllib.loads((tmp_path / "out/run.toml").read_text())

    assert (record["status"], record["reason"]) == ("failed", "ZeroDivisionError: division by zero")
    assert len(read_signals(tmp_path / "out").time) == 10
    with pytest.raises(
        InputError, match=r"cannot be stepped: the run was ended by ZeroDivisionError: division by zero"
    ):
        run.step()


def test_a_failed_step_ends_the_run_by_name(echo_alone, tmp_path):
    parts = {name: replace(echo_alone.components[0], name=name) for name in ("one", "two")}
    run = lockstep.open(parts, tmp_path / "out", connections=[("one.out.h", "two.x")])
    run.step(3)
    run.set("one.n", 9)  # from which on an output is not a number
    with pytest.raises(RunError, match=r"one\.out\.h: is nan at 0\.004 s; every exchanged value must be finite"):
        run.step(3)
    with pytest.raises(InputError, match=r"the run failed: one\.out\.h: is nan at 0\.004 s"):
        run.step()
    assert tomllib.loads((tmp_path / "out/run.toml").read_text())["status"] == "failed"
    assert len(read_signals(tmp_path / "out").time) >= 3
    del run
    gc.collect()


def test_ctrl_c_in_a_block_leaves_a_readable_folder(triple, tmp_path):
    with pytest.raises(KeyboardInterrupt), lockstep.open(triple, tmp_path / "out") as run:  # noqa: PT012
        for time in run:
            if time > 0.03:
                signal.raise_signal(signal.SIGINT)
    assert tomllib.loads((tmp_path / "out/run.toml").read_text())["status"] == "interrupted"
    assert len(read_signals(tmp_path / "out").time) == 31


def test_two_runs_are_open_at_once_and_a_third_in_between(triple, whole):
    with lockstep.open(triple) as one, lockstep.open(triple, overrides={"a.seed": 9}) as other:
        for _ in range(60):
            one.step()
            other.step()
        third = simulate(triple)
    assert_equal(one.signals, whole)
    assert_equal(third.signals, whole)
    assert not np.array_equal(other.signals["a.y"], whole["a.y"])


def test_fmus_in_processes_of_their_own_are_stepped_and_read(triple, whole):
    parts = tuple(replace(c, isolated=c.name != "b") for c in triple.components)
    with lockstep.open(replace(triple, components=parts)) as run:
        for time in run:
            assert run["a.y"] == pytest.approx(run["a.y"], abs=0.0)
            if time == 0.03:
                assert run["p.gain"] == 1.0
    assert_equal(run.signals, whole)


def test_a_run_that_is_not_closed_is_freed_with_its_folder_readable(triple, tmp_path):
    run = lockstep.open(triple, tmp_path / "out")
    run.step(7)
    del run
    gc.collect()

    record = tomllib.loads((tmp_path / "out/run.toml").read_text())
    assert (record["status"], record["reason"]) == ("failed", "was not closed")
    assert len(read_signals(tmp_path / "out").time) == 7


def test_a_running_run_is_not_pickled(triple):
    with (
        lockstep.open(triple) as run,
        pytest.raises(TypeError, match="a run cannot be pickled, as its FMUs are running"),
    ):
        pickle.dumps(run)


def test_events_are_there_while_the_run_goes_on(triple, tmp_path):
    for folder in (None, tmp_path / "out"):
        with lockstep.open(triple, folder) as run:
            run.step(3)
            run.set("a.gain", "2")
            assert [(e["time"], e["event"]) for e in run.events] == [(0.0, "start"), (0.003, "set")]
    lines = (tmp_path / "out/events.jsonl").read_text().splitlines()
    assert json.loads(lines[1]) == {"time": 0.003, "event": "set", "name": "a.gain", "value": "2"}
