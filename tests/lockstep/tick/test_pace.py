"""Ticks that wait for real time in C: never early, counted as in Python, ended by Ctrl-C in the middle of a wait."""

from time import perf_counter

import numpy as np
import pytest

from fmus.busy_fmu import busy_fmu
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, System, simulate
from lockstep.run.real_time_pacing import PACE, Pacer
from lockstep.tick.accounts import Accounts
from lockstep.tick.operations import Pace, Program
from lockstep.tick.program_table import table_of
from lockstep.tick.structures import Kind
from lockstep.tick.thread_choice import ThreadChoice

MS = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return wanderer(tmp_path_factory.mktemp("fmu"), "good")


def system(fmu, stop, **parameters):
    part = Component(name="a", source=fmu, period=MS, kind="sampled", isolated=False, parameters=parameters)
    return System(name="demo", tick=MS, components=(part,), stop_time=stop * MS, record=("a.y", "a.steps"))


@pytest.mark.parametrize("tick", ["c", "python"])
def test_no_tick_begins_early_and_each_is_counted(fmu, tick):
    started = perf_counter()
    summary = simulate(system(fmu, 30), pace=0.5, tick=tick)
    assert perf_counter() - started >= 0.06
    assert summary.wall_time >= 0.06
    assert summary.pacer.counts.sum() == 31  # and the end
    if summary.pacer.overruns == 0:  # on a machine with nothing else to do
        assert summary.pacer.worst == 0.0


@pytest.mark.parametrize("tick", ["c", "python"])
def test_late_ticks_are_counted_and_shift_none_after_them(fmu, tick):
    summary = simulate(system(fmu, 40, sleep=0.02, sleep_at=5), pace=1, tick=tick)
    pacer = summary.pacer
    assert pacer.overruns >= 18  # the 19 ticks that are due while it sleeps, but for one at its very end
    assert pacer.worst >= 0.018
    late = pacer.counts[np.searchsorted(pacer.summary()["lateness_edges"], 0.005) :].sum()
    assert late >= 13  # 5 to 19 ms late
    assert pacer.counts.sum() == 41


def test_a_wait_is_an_operation_of_c_on_the_real_clock_alone():
    def kind(pacer):
        program = Program(ticks=[((pacer.operation(),),)])
        return table_of(program, Accounts(program)).entries[0].kind

    assert isinstance(Pacer(1.0).operation(), Pace)
    assert kind(Pacer(1.0)) == Kind.PACE
    assert kind(Pacer(1.0, clock=lambda: 0.0)) == Kind.CALLER


@pytest.mark.parametrize("tick", ["c", "python"])
def test_a_long_wait_ends_with_ctrl_c(fmu, tick, interrupt_after):
    """A tick of 1000 s of wall time: what ends the run is the look at the clock in the middle of it."""
    started = perf_counter()
    with interrupt_after(0.2), pytest.raises(KeyboardInterrupt):
        simulate(system(fmu, 30), pace=1e-6, tick=tick)
    assert perf_counter() - started < 60.0  # generously: 0.1 s after the signal, and the end of the run


def test_numbers_are_those_that_c_reads():
    assert Pacer(2.5).numbers[PACE] == 2.5


def test_waits_do_not_count_when_threads_are_chosen(tmp_path, monkeypatch):
    """A paced run has as many ticks a second with threads as without; what it works for a tick is what differs."""
    worked = []
    monkeypatch.setattr(ThreadChoice, "look", lambda self, now, *_: worked.append(now) or self.chosen)
    fmu, period = busy_fmu(tmp_path), 20 * MS
    parts = tuple(
        Component(name=name, source=fmu, period=period, kind="sampled", isolated=False, parameters={"work": 50.0})
        for name in ("one", "two")
    )
    paced = System(name="two", tick=period, components=parts, stop_time=25 * period, record=("one.y",))
    summary = simulate(paced, pace=1, tick="c", threads="auto")
    assert summary.wall_time >= 0.48
    assert 0.0 < worked[-1] < 0.25  # some 3 ms on a machine with nothing else to do
