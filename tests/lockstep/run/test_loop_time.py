"""The wall time of the loop is charged to components, exchange, recording, waiting and the rest: all of it."""

import tomllib
from dataclasses import replace

import pytest

import lockstep
from fmus.wanderer.wanderer import wanderer
from lockstep import Component, Connection, System, read_signals, simulate
from lockstep.checkpoint.schedule import CheckpointSchedule
from lockstep.cli.progress import print_summary

MS = 1_000_000  # [ns]
OTHERS = {"exchange", "recording", "waiting", "rest"}
SLEEP = 0.002  # [s] of one component in each step


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """Return a system of two FMUs, of which one is stepped every third tick and sleeps."""
    fmu = wanderer(tmp_path_factory.mktemp("fmu"), "good")
    quick = Component(name="quick", source=fmu, period=MS, kind="sampled", isolated=False, parameters={"seed": 5})
    sleeping = {"sleep": SLEEP, "sleep_at": -1}
    slow = Component(name="slow", source=fmu, period=3 * MS, kind="sampled", isolated=False, parameters=sleeping)
    link = Connection(from_component="quick", output="y", to_component="slow", input="u", delay=1)
    return System(name="demo", tick=MS, components=(quick, slow), connections=(link,), stop_time=60 * MS,
                  record=("quick.*", "slow.steps"))  # fmt: skip


def check(found, wall):
    """Check that the parts of a loop are all of it."""
    parts = dict(found.parts)
    assert set(parts) == {"quick", "slow"} | OTHERS
    assert min(parts.values()) >= 0.0
    assert sum(parts.values()) == pytest.approx(found.wall, rel=1e-9)  # rounding of sums
    assert found.wall <= wall
    assert max(parts, key=parts.get) == "slow"  # 20 steps that sleep 2 ms, beside some microseconds of the others
    quick, slow = found.components
    assert (quick.calls, slow.calls) == (60, 20)
    assert slow.time >= 20 * SLEEP * 0.99  # no sleep ends early; 1 % for the rate of the stamps
    assert slow.mean == slow.time / 20
    assert quick.time < slow.time


@pytest.mark.parametrize("tick", ["c", "python"])
def test_a_component_that_sleeps_has_the_largest_part(system, tmp_path, tick, capsys):
    summary = simulate(system, tmp_path / "out", tick=tick, profile=True, record_period="0.001")
    found = summary.loop_time
    check(found, summary.wall_time)
    assert found.simulated == pytest.approx(0.06)
    assert found.factor == pytest.approx(0.06 / found.wall)
    assert read_signals(tmp_path / "out")["slow.steps"][-1] == 21  # as the FMU counts, with the sample at the end

    record = tomllib.loads((tmp_path / "out/run.toml").read_text(encoding="utf-8"))["time"]
    assert record["loop"] == pytest.approx(found.wall, abs=1e-9)
    assert {name: record[name] for name in OTHERS} == pytest.approx(found.others, abs=1e-9)
    assert [(part["name"], part["calls"]) for part in record["component"]] == [("quick", 60), ("slow", 20)]
    assert record["component"][1]["step"] == pytest.approx(found.components[1].mean, rel=1e-5)

    print_summary(summary)
    assert "\nwall time of the loop: slow " in capsys.readouterr().out
    print_summary(summary, profile=True)
    lines = capsys.readouterr().out.splitlines()
    row = next(line for line in lines if line.startswith("slow "))
    assert row.split()[:2] == ["slow", "20"]
    assert "##" in row


def test_python_measures_nothing_unasked(system, tmp_path):
    summary = simulate(system, tmp_path / "out", tick="python")
    found = summary.loop_time
    assert (found.parts, found.line()) == ([], "")
    assert [(part.name, part.calls, part.time) for part in found.components] == [
        ("quick", 60, None),
        ("slow", 20, None),
    ]
    record = tomllib.loads((tmp_path / "out/run.toml").read_text(encoding="utf-8"))["time"]
    assert set(record) == {"loop", "real_time_factor", "component"}


def test_an_isolated_component_is_charged_for_what_the_loop_waits(system):
    quick, slow = system.components
    summary = simulate(replace(system, components=(quick, replace(slow, isolated=True))), profile=True)
    check(summary.loop_time, summary.wall_time)


def test_steps_in_threads_are_charged_for_what_the_loop_waits(system):
    summary = simulate(system, tick="c", threads=2)
    found = summary.loop_time
    parts = dict(found.parts)
    assert sum(parts.values()) == pytest.approx(found.wall, rel=1e-9)
    assert [part.calls for part in found.components] == [60, 20]
    assert parts["quick"] + parts["slow"] > 0.5 * 20 * SLEEP  # either finds that the other has begun


def test_waiting_and_checkpoints_have_their_parts(system, tmp_path):
    paced = simulate(system, tick="c", pace=0.2)
    parts = dict(paced.loop_time.parts)
    assert parts["waiting"] > 0.0  # 300 ms, of which the steps take 40
    assert sum(parts.values()) == pytest.approx(paced.loop_time.wall, rel=1e-9)
    saved = simulate(system, tmp_path / "out", tick="c", checkpoints=CheckpointSchedule(every="0.02")).loop_time
    assert sum(time for _, time in saved.parts) == pytest.approx(saved.wall, rel=1e-9)
    assert dict(saved.parts)["rest"] > 0.0


def test_a_stepped_run_counts_what_it_executed(system):
    with lockstep.open(system, profile=True) as run:
        run.run_until(0.02)
        start = run.snapshot()
        run.run_until(0.03)
        run.restore(start)
        run.run_until(0.05)
    found = run.summary.loop_time
    assert [part.calls for part in found.components] == [60, 7 + 3 + 10]
    assert sum(time for _, time in found.parts) == pytest.approx(found.wall, rel=1e-9)
