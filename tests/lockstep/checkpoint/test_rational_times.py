"""Step sizes that are no whole nanoseconds: 60 Hz beside 100 Hz, with exact times in every file."""

import tomllib
from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np
import pytest

from lockstep import Component, Connection, System, load_system, read_signals, resume, simulate, write_ssd
from lockstep.__main__ import main
from lockstep.checkpoint.file import read_checkpoint
from lockstep.checkpoint.restart import Restart
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.shadow.component import with_shadow
from lockstep.system.clock import nanoseconds

SIXTIETH, TICK = Fraction(10**9, 60), Fraction(10**9, 300)  # [ns]


@pytest.fixture(scope="module")
def rates(fmus):
    """Return `a` at 60 Hz, sampled, and `p` at 100 Hz, continuous, in a loop: 300 ticks a second."""
    part = partial(Component, source=fmus["good"], isolated=False)
    return System(
        name="rates",
        tick=TICK,
        stop_time=2 * 10**9,
        components=(
            part(name="a", period=SIXTIETH, kind="sampled",
                 parameters={"seed": 5, "offset": 0.25, "number": 0, "flag": False}),
            part(name="p", period=10**7, kind="continuous",
                 parameters={"seed": 7, "offset": 0.125, "number": 0, "flag": False}),
        ),
        connections=(
            Connection(from_component="a", output="y", to_component="p", input="u"),
            Connection(from_component="p", output="y", to_component="a", input="u", delay=1),
        ),
    )  # fmt: skip


@pytest.fixture(scope="module")
def run(rates, tmp_path_factory):
    folder = tmp_path_factory.mktemp("rates") / "out"
    simulate(rates, folder, checkpoints=CheckpointSchedule(times=["1/3", "1.1"]))
    return folder


def test_every_time_is_the_double_nearest_to_the_exact_one(run):
    signals, ticks = read_signals(run), range(601)
    assert signals.time.tolist() == [k / 300 for k in ticks]  # of whole numbers: rounded once
    assert signals["a.began"].tolist() == [k // 5 / 60 for k in ticks]
    assert signals["p.began"].tolist() == [max(0, (k - 3) // 3) / 100 for k in ticks]
    assert (signals["a.steps"][-1], signals["p.steps"][-1]) == (121, 200)


def test_files_keep_the_times_exactly(rates, run, tmp_path):
    record = tomllib.loads((run / "run.toml").read_text())
    assert [nanoseconds(record[key], key) for key in ("tick", "record_period", "stop_time")] == [TICK, TICK, 2 * 10**9]
    assert [nanoseconds(c["period"], "period") for c in record["component"]] == [SIXTIETH, 10**7]
    saved = read_checkpoint(run / "checkpoints/t=1_3.ckpt")
    assert (saved.tick, saved.time) == (100, Fraction(10**9, 3))
    write_ssd(rates, tmp_path / "rates.ssd")
    again = load_system(tmp_path / "rates.ssd")
    assert [c.period for c in again.components] == [SIXTIETH, 10**7]
    assert (again.tick, again.stop_time) == (TICK, 2 * 10**9)


def test_runs_branch_and_resume_bit_by_bit(rates, run, tmp_path):
    full = read_signals(run)
    restart = Restart(checkpoint=read_checkpoint(run / "checkpoints/t=1_3.ckpt"))
    branch = tmp_path / "branch"
    simulate(rates, branch, restart=restart, checkpoints=CheckpointSchedule(times=["5/3"]))
    before, record = (branch / "signals.parquet").read_bytes(), branch / "run.toml"
    mine = read_signals(branch)
    assert mine.time.tolist() == full.time[100:].tolist()
    for name, values in mine.columns.items():
        np.testing.assert_array_equal(values.view(np.int64), full[name][100:].view(np.int64), name)
    record.write_text(record.read_text().replace('status = "completed"', 'status = "running"'))
    resume(branch, rates)
    assert (branch / "signals.parquet").read_bytes() == before


def test_step_sizes_of_the_command_line_may_be_fractions_or_rounded_ones(rates, run, tmp_path):
    write_ssd(replace(rates, components=tuple(replace(c, period=10**7) for c in rates.components), tick=10**7),
              tmp_path / "rates.ssd")  # fmt: skip
    text = (tmp_path / "rates.ssd").read_text()
    assert text.count('tick="0.01"') == 1
    (tmp_path / "rates.ssd").write_text(text.replace('tick="0.01"', 'tick="1/300"'))
    for size in ("1/60", "0.016666666666666666", "0.0166666666667"):
        out = tmp_path / size.replace("/", "_")
        words = ["--step-size", f"a={size}", "--share-process", "a", "--share-process", "p", "--out", str(out)]
        assert main(["run", str(tmp_path / "rates.ssd"), *words]) == 0
        assert (out / "signals.parquet").read_bytes() == (run / "signals.parquet").read_bytes()


def test_a_shadow_at_60_hz_acts_from_the_step_of_its_switchover_on(rates, fmus, tmp_path):
    over, given = Fraction(10**9, 3), {"stop_time": 1.0, "overrides": {"a.shadow.gain": 3.0}}
    for times in ((), ("0.5",)):  # the second one is continued in the middle of the blend
        system = with_shadow(rates, "a", fmus["good"], switchover=over, blend=Fraction(10**9, 2))
        simulate(system, tmp_path / f"{len(times)}", checkpoints=CheckpointSchedule(times=times), **given)
    restart = Restart(checkpoint=read_checkpoint(tmp_path / "1/checkpoints/t=0.5.ckpt"))
    simulate(system, tmp_path / "branch", restart=restart)
    full, mine = read_signals(tmp_path / "0"), read_signals(tmp_path / "branch")
    acted = np.flatnonzero(full["a.y"] != full["a.original.y"])
    assert acted[0] == 105  # one step after the switchover at tick 100, where the difference is blended in full
    for name, values in mine.columns.items():
        np.testing.assert_array_equal(values.view(np.int64), full[name][150:].view(np.int64), name)
