"""The row at the stop time: a shorter run holds the first rows of a longer one, also when it is resumed."""

import numpy as np
import pytest

from lockstep import Component, System, read_signals, resume, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.faults.read import read_scenario

MS = 1_000_000
ALWAYS = '[[fault]]\nconnection = "b.u"\nkind = "bias"\nvalue = 0.5\nfrom = 0.03\n'
TO_THE_END = '[[fault]]\nparameter = "a.gain"\nkind = "stuck"\nvalue = 3.0\nfrom = 0.03\n'


def assert_begins_alike(shorter, longer, rows):
    mine, full = read_signals(shorter), read_signals(longer)
    assert len(mine.time) == rows
    np.testing.assert_array_equal(mine.time, full.time[:rows])
    for name, values in mine.columns.items():
        np.testing.assert_array_equal(values.view(np.int64), full[name][:rows].view(np.int64), name)


def test_a_run_of_3_s_at_10_ms_has_301_rows(reference_fmu, tmp_path):
    part = Component(
        name="x", source=reference_fmu("integrator", "2.0"), period=10 * MS, kind="continuous", isolated=False,
        parameters={"u": 2.0, "rate": 0.5, "x0": 1.0},
    )  # fmt: skip
    summary = simulate(System(name="s", tick=10 * MS, stop_time=3000 * MS, components=(part,)), tmp_path / "out")
    signals = read_signals(tmp_path / "out")

    assert summary.rows == len(signals.time) == 301
    assert (signals.time[0], signals.time[-1]) == (0.0, 3.0)
    assert signals["x.x"][-1] == pytest.approx(4.0 - 3.0 * np.exp(-1.5), rel=300 * 2.0**-52)  # a rounding a step


@pytest.mark.parametrize("stop", range(42, 48))  # whoever is due there: a every 2 ms, b every 3, p every 2
def test_a_shorter_run_holds_the_first_rows_of_a_longer_one(triple, whole, tmp_path, stop):
    simulate(triple, tmp_path / "short", stop_time=stop / 1000)
    assert_begins_alike(tmp_path / "short", whole, stop + 1)


def test_faults_without_an_end_act_in_the_row_at_the_stop_time(triple, tmp_path):
    (tmp_path / "faults.toml").write_text(ALWAYS + TO_THE_END)
    faults = [read_scenario(tmp_path / "faults.toml")]
    simulate(triple, tmp_path / "long", stop_time=0.05, faults=faults)
    for stop in (40, 43, 46):
        simulate(triple, tmp_path / "short", stop_time=stop / 1000, faults=faults, overwrite=True)
        assert_begins_alike(tmp_path / "short", tmp_path / "long", stop + 1)


def test_a_run_that_was_killed_at_its_stop_time_gets_its_last_row(isolated, whole, tmp_path):
    out = tmp_path / "out"
    simulate(isolated, out, stop_time=0.046, checkpoints=CheckpointSchedule(times=["0.046"]))
    before = (out / "signals.parquet").read_bytes()
    record = out / "run.toml"
    record.write_text(record.read_text().replace('status = "completed"', 'status = "running"'))

    summary = resume(out, isolated)
    assert (summary.ticks, summary.rows) == (46, 1)
    assert (out / "signals.parquet").read_bytes() == before
    assert_begins_alike(out, whole, 47)
