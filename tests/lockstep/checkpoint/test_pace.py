"""Real-time pacing: deadlines on a clock that the test turns, and runs that never get ahead of the real one."""

import json
import time
import tomllib
from dataclasses import replace

import pytest

from lockstep import Component, InputError, System, simulate
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.interrupt import Interrupt
from lockstep.run.real_time_pacing import Pacer, pacer_given

MS = 1_000_000


class Clock:
    """A clock that goes on when it is slept by, and by a little when it is looked at."""

    def __init__(self):
        self.now, self.slept = 1000.0, []

    def __call__(self):
        self.now += 1e-6
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds + 1e-4  # as a sleep does, too long


def paced(pace, works, tick=0.01, first=0.0):
    """Run ticks that take so long each; return the pacer, the clock and when each tick began, from the start on."""
    clock = Clock()
    pacer = Pacer(pace, clock, clock.sleep)
    pacer.start(first, Interrupt())
    start, began = clock.now, []
    for k, work in enumerate(works):
        pacer(first + k * tick)
        began.append(clock.now - start)
        clock.now += work
    pacer(first + len(works) * tick)
    return pacer, clock, began


@pytest.mark.parametrize("pace", [0.5, 1.0, 8.0])
@pytest.mark.parametrize("first", [0.0, 100.0])
def test_each_tick_begins_at_its_time_and_not_before(pace, first):
    pacer, clock, began = paced(pace, [1e-5] * 300, first=first)
    due = [k * 0.01 / pace for k in range(300)]
    assert all(began[k] >= due[k] - 1e-9 for k in range(300))
    assert max(b - d for b, d in zip(began, due, strict=True)) < 3e-6  # no drift, though each sleep lasts too long
    assert (pacer.overruns, pacer.worst) == (0, 0.0)
    assert max(clock.slept) <= 0.05  # Ctrl-C is looked at so often


def test_a_late_tick_is_counted_and_shifts_none_after_it():
    works = [1e-3] * 20
    works[7] = 0.025  # ticks 8 and 9 are due while it goes on
    pacer, _, began = paced(1.0, works)
    assert (pacer.overruns, pacer.worst_at) == (2, pytest.approx(0.08))
    assert pacer.worst == pytest.approx(0.015, abs=1e-5)
    assert began[8] == pytest.approx(0.095, abs=1e-5)
    assert began[9] == pytest.approx(0.096, abs=1e-5)  # at once
    assert began[10] == pytest.approx(0.1, abs=1e-5)  # on time again
    assert str(pacer) == "paced at 1 x real time, 2 overruns, worst 15 ms late at 0.08 s"


def test_ticks_are_counted_by_how_late_they_began():
    works = [1e-3] * 20
    works[7] = 0.025
    pacer, _, _ = paced(1.0, works)
    counts = dict(zip(pacer.summary()["lateness_edges"], pacer.counts.tolist(), strict=False))  # by their upper edge
    assert pacer.counts.sum() == 21  # of 20 ticks, and of the end
    assert counts[0.02] == 1  # the eighth began 15 ms late
    assert counts[0.01] == 1  # the ninth 6 ms
    assert sum(count for edge, count in counts.items() if edge <= 5e-6) == 19
    assert pacer.summary()["lateness_counts"] == pacer.counts.tolist()
    lines = pacer.histogram()
    assert lines[0] == "ticks by how late they began:"
    assert lines[-1].split() == ["10", "ms", "to", "20", "ms", "1", "###"]
    assert any(line.split()[:5] == ["100", "us", "to", "200", "us"] and line.split()[5] == "0" for line in lines)
    assert max(line.count("#") for line in lines) == 40


def test_a_pacer_without_ticks_has_no_histogram():
    assert Pacer(1.0).histogram() == []


def test_the_last_tick_has_to_be_done_in_time_too():
    pacer, _, _ = paced(1.0, [1e-3, 1e-3, 0.012])
    assert (pacer.overruns, pacer.worst_at) == (1, 0.03)


def test_ctrl_c_ends_a_long_wait():
    clock, interrupt = Clock(), Interrupt()
    pacer = Pacer(
        1.0, clock, lambda seconds: (clock.sleep(seconds), setattr(interrupt, "requested", len(clock.slept) > 3))
    )
    pacer.start(0.0, interrupt)
    with pytest.raises(KeyboardInterrupt):
        pacer(3600.0)
    assert len(clock.slept) == 4


@pytest.mark.parametrize("pace", [None, 0, "0", 0.0])
def test_no_pace_is_as_fast_as_possible(pace):
    assert pacer_given(pace) is None


@pytest.mark.parametrize("pace", [-1, "fast", "nan", "inf"])
def test_a_wrong_pace_is_refused(pace):
    with pytest.raises(InputError, match=rf"pace '?{pace}'? must be a factor of real time > 0, for example 1\.0"):
        pacer_given(pace)


@pytest.fixture(scope="session")
def sleeper(fmus):
    """Return a system of one FMU that sleeps 30 ms in its fourth step of 10 ms."""
    part = Component(name="a", source=fmus["good"], period=10 * MS, kind="sampled", isolated=False)
    sleeping = {"u": 0.0, "offset": 0.0, "flag": False, "number": 0, "sleep": 0.03, "sleep_at": 4}
    return System(name="sleeper", tick=10 * MS, stop_time=120 * MS, components=(replace(part, parameters=sleeping),))


def test_a_run_is_never_ahead_of_the_clock_and_tells_of_its_overruns(sleeper, tmp_path):
    started = time.perf_counter()
    summary = simulate(sleeper, tmp_path / "out", pace="2", checkpoints=CheckpointSchedule(times=["0.02"]))
    assert time.perf_counter() - started >= 0.06
    assert summary.wall_time >= 0.06
    assert summary.pacer.overruns >= 5  # ticks of 5 ms: 30 ms take six of them, and only one is waited for
    assert summary.pacer.worst >= 0.025 - 1e-4
    run = tomllib.loads((tmp_path / "out/run.toml").read_text())
    assert run["pace"]["factor"] == 2.0
    assert run["pace"]["overruns"] == summary.pacer.overruns
    events = [json.loads(line) for line in (tmp_path / "out/events.jsonl").read_text().splitlines()]
    written = [event for event in events if event["event"] == "pace"]
    assert [(event["factor"], event["overruns"]) for event in written] == [(2.0, summary.pacer.overruns)]

    restart = Restart(checkpoint=read_checkpoint(tmp_path / "out/checkpoints/t=0.02.ckpt"))
    again = simulate(sleeper, tmp_path / "branch", pace=1, restart=restart)
    assert again.wall_time >= 0.1  # of what is left, not of all


def test_pacing_changes_no_bit(sleeper, tmp_path):
    simulate(sleeper, tmp_path / "paced", pace=1000)
    simulate(sleeper, tmp_path / "plain")
    assert "pace" not in tomllib.loads((tmp_path / "plain/run.toml").read_text())
    paths = (tmp_path / name / "signals.parquet" for name in ("paced", "plain"))
    assert len({path.read_bytes() for path in paths}) == 1
