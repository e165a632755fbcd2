"""The study through the FMUs: numbers as `flexsat run` gives them, lost runs, slews that do not fit."""

import csv
import json
from pathlib import Path

import pytest

from flexbench.cli.parser import main
from flexbench.engine.jobs import Finished, run_job
from flexbench.runs import histories
from flexbench.runs.metrics import root_mean_square
from flexbench.runs.metrics_file import evaluate
from flexbench.studies.layouts import study
from flexbench.studies.layouts.outcome import measure
from flexbench.studies.layouts.plan import ComparisonPlan
from flexbench.studies.layouts.result_file import read_result
from flexbench.studies.layouts.statistics import ratio
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ALL_MODES, ARCSECOND, Slew
from lockstep import InputError, read_signals
from lockstep.results.read_run_record import read_run_record

ROOT = Path(__file__).parents[4]
SEEDS = (1, 2)
SHORT = ComparisonPlan(seeds=SEEDS, duration={"fine_pointing": 0.5})
ANGLE = 5e-6  # rad: a slew of 0.8 s
FEW_MODES = {"plant.modes": 25}
SLEW = ComparisonPlan(seeds=SEEDS, duration={"slew": 6.5}, slew=Slew(rotation=(ANGLE, 0.0, 0.0), start_time=0.5),
            overrides=FEW_MODES)  # fmt: skip


def in_this_process(jobs, *_, **__):
    """Run jobs as `run_jobs`, but one after the other: processes are tested with it, and take a second each."""
    return [run_job(job) for job in jobs]


@pytest.fixture(scope="module")
def compared(delivered, tmp_path_factory):
    """Return a comparison of fine pointing, and its folder."""
    folder = tmp_path_factory.mktemp("layouts")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "run_jobs", in_this_process)
        return study.run_layouts(delivered, folder, SHORT), folder


def test_a_run_has_the_numbers_of_flexsat_run(delivered, compared, tmp_path):
    comparison, _ = compared
    errors = comparison.errors[2]
    settings = {"frequency": errors.frequency, "damping": errors.damping, "participation": errors.participation}
    words = [f"--set=plant.dispersion.{name}={value!r}" for name, value in settings.items()]
    words += [f"--set=plant.dispersion.inertia[{k + 1}]={value!r}" for k, value in enumerate(errors.inertia)]
    system = str(delivered / "distributed" / "fine_pointing.ssd")
    assert (
        main(["run", system, "--native", "--seed", "2", "--stop-time", "0.5", *words, "--out", str(tmp_path / "run")])
        == 0
    )

    (window,) = json.loads((tmp_path / "run" / "metrics.json").read_text())["windows"]
    found = comparison.of("distributed", "fine_pointing")[2]
    rms = window["rms"]
    expected = (rms["pointing_error"], rms["deformation"], rms["torque"])
    assert tuple(found.numbers.values()) == pytest.approx(expected, rel=1e-12)  # the rows are the same
    assert 0.01 * ARCSECOND < found.numbers["pointing"] < 0.5 * ARCSECOND
    assert [window["name"]] == [text.partition(",")[0] for text in found.windows]


def test_the_errors_reach_the_plants_of_both_layouts_in_every_mode(compared):
    comparison, folder = compared
    for seed in SEEDS:
        plants = []
        for name in CONFIGURATIONS:
            record, _ = read_run_record(study.run_folder(folder, name, "fine_pointing", seed))
            (plant,) = [part["parameters"] for part in record["component"] if part["name"] == "plant"]
            plants.append({key: value for key, value in plant.items() if key.startswith("dispersion.")})
        assert plants[0] == plants[1]
        assert len(plants[0]) == 3 * ALL_MODES + 3
        values = {value for key, value in plants[0].items() if key.startswith("dispersion.frequency[")}
        assert values == {comparison.errors[seed].frequency}


def test_files_hold_every_run_and_the_ratios_of_pairs(compared):
    comparison, folder = compared
    rows = list(csv.DictReader((folder / "layouts.csv").read_text().splitlines()))
    assert [(row["configuration"], row["seed"]) for row in rows] == [
        (name, str(seed)) for seed in SEEDS for name in CONFIGURATIONS
    ]
    first, second = ([float(row["deformation"]) for row in rows if row["configuration"] == name]
                     for name in CONFIGURATIONS)  # fmt: skip
    content = json.loads((folder / "layouts.json").read_text())
    (stored,) = [one for one in content["quantities"] if one["key"] == "deformation"]
    expected = ratio(first, second)
    assert stored["ratio"] == pytest.approx(
        {"value": expected.value, "low": expected.low, "high": expected.high, "count": 2}
    )
    assert read_result(folder)["shown"] == ["centralised-fine-pointing-seed1", "distributed-fine-pointing-seed1"]
    assert "None of 4 runs was lost." in (folder / "layouts.txt").read_text()
    wheels = comparison.wheels
    assert (wheels["centralised"].count, wheels["distributed"].count) == (6, 33)
    assert wheels["distributed"].inertia == pytest.approx(33 * 0.84)
    assert wheels["distributed"].weight / wheels["centralised"].weight == pytest.approx(5.5**0.4)  # 5.5 times as many


def test_a_slew_is_compared_while_it_lasts_and_from_its_end_on(delivered, tmp_path):
    job = study.plan_jobs(delivered, tmp_path, SLEW)["centralised", "slew", 1]
    lines = []
    study.check_slew(job, "centralised: ", lines.append)
    assert lines[0].startswith("centralised: slew of 0.000286479 deg from 0.5 s: ends at 1.4")

    found = measure(run_job(job), "centralised", "slew", 1, None)
    evaluated = evaluate(job.folder).numbers
    moving, settled = evaluated.windows  # it settles at once: the table has the same windows
    begin, end = moving.window.spans[0]
    signals = read_signals(job.folder)
    rows = (signals.time >= end - 1e-9) & (signals.time < 6.5 - 1e-9)
    assert (begin, end) == pytest.approx((0.35, 1.44), abs=0.01)
    assert found.lost == ""
    assert found.numbers == {
        "slew_pointing": moving.rms["pointing_error"],
        "slew_deformation": moving.rms["deformation"],
        "settling": 0.0,
        "settled_pointing": root_mean_square(histories.pointing_error(signals)[rows]),
        "settled_deformation": root_mean_square(histories.deformation(signals)[rows]),
        "settled_torque": root_mean_square(histories.torque_norm(signals)[rows]),
    }
    assert found.numbers["settled_torque"] == settled.rms["torque"]
    assert found.windows == ("slew, 0.35 to 1.44 s", "after the slew, 1.44 to 6.5 s")
    assert moving.rms["deformation"] > found.numbers["settled_deformation"] > 0.0
    again = Finished(job=job, metrics={}, wall_time=0.0, simulated_time=6.5)
    never = measure(again, "centralised", "slew", 1, 1e-3 * ARCSECOND)
    assert never.numbers == found.numbers | {"settling": None}  # the band moves no window


def test_a_slew_that_leaves_no_time_after_it_is_refused_before_anything_runs(delivered, tmp_path):
    plan = ComparisonPlan(seeds=SEEDS, duration={"slew": 5.0}, slew=SLEW.slew)
    with pytest.raises(InputError, match=r"--stop-time 5: the slew ends at 1\.43. s, .*; give 6 or more"):
        study.run_layouts(delivered, tmp_path / "out", plan)
    plan = ComparisonPlan(seeds=SEEDS, overrides={"plant.external.torque[1]": 1.0})
    with pytest.raises(InputError, match=r"centralised: momentum: a wheel would have to take "):
        study.run_layouts(delivered, tmp_path / "out", plan)
    assert not (tmp_path / "out").exists()


def test_a_limit_cycle_is_lost_and_named(delivered, tmp_path):
    """The published design on 40 modes is at the torque limit within a second."""
    plan = ComparisonPlan(seeds=SEEDS, duration={"fine_pointing": 4.0},
                overrides={"controller.design": "published", "plant.modes": 40})  # fmt: skip
    job = study.plan_jobs(delivered, tmp_path, plan)["distributed", "fine_pointing", 1]
    found = measure(run_job(job), "distributed", "fine_pointing", 1, None)

    assert found.numbers == {}
    assert found.lost.startswith("torque saturation: ")
    assert "limit cycle: once at " in found.lost
    assert "no divergence" not in found.lost


def test_two_spacecraft_that_are_built_are_compared_in_the_order_given(tmp_path, monkeypatch):
    text = (ROOT / "examples" / "spacecraft" / "four_wheels.toml").read_text(encoding="utf-8")
    for name in ("small", "large"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "spacecraft.toml").write_text(text.replace('"four_wheels"', f'"{name}"'), encoding="utf-8")
        (tmp_path / name / "fine_pointing.ssd").touch()
    plans = []

    def noted(fmus, _folder, plan, *_):
        plans.append((fmus, plan.layouts))
        raise InputError("noted")

    monkeypatch.setattr(study, "run_layouts", noted)
    words = ["compare-layouts", "--fmus", str(tmp_path), "--scenario", "fine_pointing", "--out", str(tmp_path / "out")]
    assert main([*words, "--configuration", "small", "--configuration", "large"]) == 2
    assert plans == [(tmp_path, ("small", "large"))]


def test_one_spacecraft_is_refused_with_what_to_do(tmp_path, capsys):
    assert main(["compare-layouts", "--configuration", "centralised", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        "flexsat: --configuration centralised: give two spacecraft with FMUs in one folder, each with --configuration;"
        " `flexsat campaign` simulates any number of systems\n"
    )
    assert not (tmp_path / "out").exists()
