"""The paper's study, run as a user runs it: as published against an earlier independent simulation, and the targets.

That reference (PHYSICS section 7, "of record") is itself a mean of four to six seeds. How much one seed scatters comes
from a stored study of six seeds, flexbench's `scatter.json`, with which the table judges too.
`python tests/system/test_paper.py RESULTS COMMIT` writes it anew from the results of `flexsat paper --seeds 6`.
The corrected variant flies the robust design on 198 modes: its numbers are compared with the targets of that design.
"""

import json
import sys
import tomllib
from math import sqrt
from pathlib import Path

import pytest

from flexbench.loop.equivalence import relative_difference
from lockstep import read_signals
from lockstep.array_names import array_of

SCATTER = Path(__file__).parents[2] / "orchestrator" / "flexbench" / "studies" / "paper" / "scatter.json"
VARIANTS, CONFIGURATIONS = ("as_published", "corrected"), ("centralised", "distributed")
SCENARIOS = ("slew", "fine-pointing", "fine-pointing-open-loop")
REFERENCE_SEEDS = 5  # four to six

# row: as published; centralised, distributed. In the printed unit of the table.
REFERENCE = {
    "slew: total cost": (2.05e4, 422.0),
    "slew: control cost": (213.0, 41.0),
    "slew: settling": (95.0, 33.0),
    "slew: pointing error": (52.4, 1.14),
    "slew: rate error": (1.13e-3, 1.4e-4),
    "slew: deformation": (2.44, 0.36),
    "fine pointing: torque": (0.100, 0.241),
    "fine pointing: error": (0.126, 0.068),
    "fine pointing: rate": (1.9e-5, 1.4e-5),
    "deformation, closed loop": (0.278, 0.112),
    "deformation, open loop": (0.316, 0.328),
}
CELLS = {
    f"{row} | as_published | {name}": values[n]
    for row, values in REFERENCE.items()
    for n, name in enumerate(CONFIGURATIONS)
}

# What does not agree, with the mean of six seeds. Not to be made larger for convenience: a cell that is listed here
# and agrees, or the other way round, fails a test.
KNOWN_MISSES: dict[str, float] = {}
# What is more than 10 % and more than two standard deviations of these means away, but not three.
KNOWN_DOUBTS: dict[str, float] = {
    "fine pointing: error | as_published | distributed": 0.0571,  # against .068
}
# At most, of one seed; centralised, distributed. Linear analysis gives what the loop does without the targets' margin:
# centralised fine pointing errs by .0191 arcsec, and .1227 um is what its wheels can do (PHYSICS asks for .10).
TARGETS = {
    "fine pointing: error": (0.022, 0.03),  # asked for: .02, .03
    "fine pointing: torque": (0.02, 0.06),
    "deformation, closed loop": (0.14, 0.14),  # asked for: .10, .14
    "slew: pointing error": (1.0, 1.0),
    "slew: settling": (30.0, 30.0),
}
LOST_BY = 1.0  # s: the published design on the plant of 198 modes


def cells(table):
    """Return the rows of table.json by row, variant and configuration."""
    return {f"{row['row']} | {row['variant']} | {row['configuration']}": row for row in table["rows"]}


def allowed(reference, deviation, seeds, deviations=3.0):
    """Return how far a mean over `seeds` may lie from the reference: 10 %, or three standard deviations if more."""
    return max(0.10 * abs(reference), deviations * deviation * sqrt(1.0 / seeds + 1.0 / REFERENCE_SEEDS))


@pytest.fixture(scope="module")
def scatter():
    """Return mean and standard deviation of one seed by cell."""
    return json.loads(SCATTER.read_text())["cells"]


@pytest.fixture(scope="module")
def table(study):
    """Return table.json."""
    return json.loads((study[0] / "table.json").read_text())


@pytest.mark.parametrize(("listed", "deviations"), [(KNOWN_MISSES, 3.0), (KNOWN_MISSES | KNOWN_DOUBTS, 2.0)])
def test_the_misses_and_doubts_listed_are_those_that_six_seeds_show(scatter, listed, deviations):
    assert set(scatter) == set(CELLS)
    found = {
        cell: values["mean"]
        for cell, values in scatter.items()
        if abs(values["mean"] - CELLS[cell]) > allowed(CELLS[cell], values["standard_deviation"], 6, deviations)
    }

    assert found == pytest.approx(listed, rel=0.005)  # the lists give three digits


@pytest.mark.slow
def test_the_study_ends_with_a_page_of_all_its_runs(study):
    folder, printed = study
    page = folder / "report.html"

    assert str(page) in printed
    assert page.stat().st_size < 15_000_000
    text = page.read_text(encoding="utf-8")
    runs = {run.parent.name for run in folder.glob("*/run.toml")}
    compared = {run for run in runs if "published-design" not in run}  # a limit cycle has nothing to compare
    assert len(runs) == len(compared) + 2
    assert compared == {run for run in runs if run in text}
    assert "slew: settling" in text
    assert "lost at" in text  # when the published design is


# `flexsat report` without the design's delay margin, which every run has: pages of short runs show it
ONE_PAGE = """
from flexbench.report import study_sections, write_report
folder, out = map(Path, given)
study_sections.SECTIONS = [one for one in study_sections.SECTIONS if one[0] != "Margins"]
result = len(write_report([folder], out))
"""


@pytest.mark.slow
def test_one_run_of_the_study_has_a_page_too(study, python, tmp_path):
    out = tmp_path / "slew.html"
    python(ONE_PAGE, study[0] / "distributed-slew-seed1", out)

    assert out.stat().st_size < 15_000_000
    assert "slew: settling" in out.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("row", TARGETS)
def test_the_robust_design_meets_its_targets(table, row):
    for name, most in zip(CONFIGURATIONS, TARGETS[row], strict=True):
        assert cells(table)[f"{row} | corrected | {name}"]["mean"] <= most


@pytest.mark.slow
def test_the_published_design_is_lost_on_the_full_plant(table):
    assert set(table["published_design_lost_at"]) == set(CONFIGURATIONS)
    for times in table["published_design_lost_at"].values():
        assert all(time is not None and time < LOST_BY for time in times)


@pytest.mark.slow
@pytest.mark.parametrize("cell", CELLS)
def test_a_number_agrees_with_the_reference(table, scatter, cell):
    found, reference = cells(table)[cell]["mean"], CELLS[cell]
    deviation = scatter[cell]["standard_deviation"]
    if cell in KNOWN_MISSES:  # one seed may come within 10 %; its scatter does not explain how far it stays off
        limit = 3.0 * deviation * sqrt(1.0 + 1.0 / REFERENCE_SEEDS)
        assert abs(found - reference) > limit
        assert abs(found - KNOWN_MISSES[cell]) <= limit
    else:
        assert abs(found - reference) <= allowed(reference, deviation, 1)


@pytest.mark.slow
@pytest.mark.parametrize("cell", CELLS)
def test_a_number_is_one_of_those_that_six_seeds_gave(table, scatter, cell):
    mean, deviation = scatter[cell]["mean"], scatter[cell]["standard_deviation"]

    # 1 %: what does not depend on the seed may follow small changes of the product
    assert abs(cells(table)[cell]["mean"] - mean) <= max(0.01 * mean, 3.0 * deviation * sqrt(1.0 + 1.0 / 6.0))


@pytest.fixture(scope="module")
def short(fmus, flexsat, tmp_path_factory):
    """Return the results of the whole command with runs of seconds, and what it printed."""
    folder = tmp_path_factory.mktemp("short")
    words = (
        fmus,
        "paper",
        "--as-published",
        "--stop-time",
        "2.5",
        "--fmus",
        folder / "fmus",
        "--out",
        folder / "results",
    )
    done = flexsat(*words, script=Path(__file__).with_name("short_study.py"), timeout=900.0, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["fmus", "results"]
    return folder / "results", done.stdout


@pytest.mark.slow
def test_the_command_builds_and_simulates_both_kinds_of_fmus(short):
    folder, printed = short
    runs = {f"{name}-{scenario}-as-published" for name in CONFIGURATIONS for scenario in SCENARIOS}
    expected = {f"{run}{kind}-seed1": kind for run in runs for kind in ("", "-native")}
    assert {path.parent.name for path in folder.glob("*/run.toml")} == set(expected)
    for name, kind in expected.items():
        record = tomllib.loads((folder / name / "run.toml").read_text())
        assert (record["status"], record["simulated_time"]) == ("completed", 2.5)
        fmus = [Path(component["source"]) for component in record["component"]]
        assert {fmu.parent.name for fmu in fmus} == {"native" if kind else name.partition("-")[0]}
    content = json.loads((folder / "table.json").read_text())["metrics_si"]
    for key, seeds in content.items():
        _, name, scenario = key.split()
        run = folder / f"{name}-{scenario.replace('_', '-')}-as-published-seed1"
        assert json.loads((run / "metrics.json").read_text())["metrics"] == seeds[0]
    assert len(content) == len(runs)
    differences = json.loads((folder / "native.json").read_text())["runs"]
    assert {run["run"] for run in differences} == {f"{run}-seed1" for run in runs}
    assert all(0.0 < max(one["relative"] for one in run["differences"]) < 1e-10 for run in differences)
    assert str(folder / "report.html") in printed
    assert (folder / "table.txt").read_text().strip() in printed


# The first seconds of a run of the study, with the FMUs in Python
PYTHON_RUN = """
from flexbench.studies.paper.paper import plan_jobs
from flexbench.engine.jobs import run_job
from dataclasses import replace
fmus, folder, name, duration = given
jobs = plan_jobs(Path(fmus), Path(folder), ["as_published", "corrected"], [1], duration)
(job,) = [job for job in jobs.values() if job.folder.name == name]
run_job(replace(job, metrics=False))
result = str(job.folder)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration"),
    [("distributed-slew-as-published-seed1", 6.5), ("centralised-fine-pointing-seed1", 3.0)],  # the slew begins at 5 s
)
def test_runs_of_the_study_are_those_of_python_fmus(study, fmus, python, tmp_path, name, duration):
    """Compared over the first seconds; `test_equivalence.py` compares a whole slew."""
    expected = read_signals(Path(python(PYTHON_RUN, fmus, tmp_path, name, duration)))
    found = read_signals(study[0] / name)
    rows = len(expected.time)
    assert expected.time.tolist() == found.time[:rows].tolist()
    assert expected.columns.keys() == found.columns.keys()
    for port in dict.fromkeys(map(array_of, expected.columns)):
        assert relative_difference(found[port][:rows], expected[port]) <= 1e-9, port  # rounding makes less than 1e-10


@pytest.mark.slow
def test_every_file_is_there(study):
    folder, printed = study
    names = {
        f"{name}-{scenario}{suffix}-seed1"
        for name in CONFIGURATIONS
        for scenario in SCENARIOS
        for suffix in ("", "-as-published")
    } | {f"{name}-fine-pointing-published-design-seed1" for name in CONFIGURATIONS}
    tables = {"table.txt", "table.md", "table.csv", "table.json"}
    assert {path.name for path in folder.iterdir()} - {"figures"} == names | tables | {"report.html"}
    for name in names:
        files = {"run.toml", "signals.parquet", "events.jsonl"}
        files |= set() if "published-design" in name else {"metrics.json"}
        assert files <= {path.name for path in (folder / name).iterdir()}
    figures = [Path(line) for line in printed.splitlines() if line.startswith(str(folder / "figures"))]
    assert [path for path in figures if not path.stat().st_size > 1000] == []
    assert len(figures) >= 5
    assert (folder / "table.txt").read_text().strip() in printed


@pytest.mark.slow
def test_every_run_says_what_it_was_and_has_all_rows(study):
    for path in study[0].glob("*-seed1"):
        if "published-design" in path.name:
            continue
        run = tomllib.loads((path / "run.toml").read_text())
        assert (run["status"], run["simulated_time"], run["stop_time"]) == ("completed", 300.0, 300.0)
        assert run["overrides"]["plant.seed"] == 1
        assert run["overrides"]["controller.as_published"] == ("as-published" in path.name)
        assert all(len(component["sha256"]) == 64 for component in run["component"])
        time = read_signals(path, ["plant.rms_deformation"]).time
        assert (len(time), time[0], time[-1]) == (60_001, 0.0, 300.0)
        events = [json.loads(line) for line in (path / "events.jsonl").read_text().splitlines()]
        kinds = {event["event"] for event in events} - {"start", "end"}  # no FMU had to complain
        # the smoothed slew as published asks more than the wheels have, as C's does
        assert kinds == ({"torque-saturation"} if path.name == "distributed-slew-as-published-seed1" else set())


@pytest.mark.slow
def test_the_table_and_the_runs_agree(study, table):
    for key, seeds in table["metrics_si"].items():
        variant, name, scenario = key.split()
        suffix = "-as-published" if variant == "as_published" else ""
        run = study[0] / f"{name}-{scenario.replace('_', '-')}{suffix}-seed1"
        assert json.loads((run / "metrics.json").read_text())["metrics"] == seeds[0]
    assert len(table["metrics_si"]) == 12


@pytest.mark.slow
def test_facts_that_need_no_reference(study, table):
    metrics = {key: seeds[0] for key, seeds in table["metrics_si"].items()}
    for variant in VARIANTS:
        for name in CONFIGURATIONS:
            open_loop, closed = (metrics[f"{variant} {name} fine_pointing{x}"] for x in ("_open_loop", ""))
            assert open_loop["torque"] == 0.0
            assert open_loop["control_cost"] == 0.0
            assert closed["deformation"] < open_loop["deformation"] * 1.2  # it does not stir the structure up
            assert closed["pointing_error"] < open_loop["pointing_error"]
            slew = metrics[f"{variant} {name} slew"]
            assert 0.0 < slew["control_cost"] < slew["total_cost"]
    # as published, distributing the wheels pays in pointing; of the robust designs both point alike
    errors = [metrics[f"as_published {name} fine_pointing"]["pointing_error"] for name in CONFIGURATIONS]
    assert errors[1] < errors[0]
    torque = read_signals(study[0] / "distributed-fine-pointing-open-loop-seed1", ["controller.wheel.torque"])
    assert not torque["controller.wheel.torque"].any()
    slew = read_signals(study[0] / "centralised-slew-seed1", ["plant.attitude.mrp"])
    turned = 4.0 * slew["plant.attitude.mrp"][-1]  # rad, of a small rotation
    half_degree = 8.726646e-3
    assert turned[0] == pytest.approx(half_degree, abs=1e-5)  # two arcsec, the size of the pointing error
    assert abs(turned[1:]).max() < 1e-5


def write_scatter(results, commit):
    """Store what a six-seed study says of its cells, with its provenance."""
    table = json.loads((results / "table.json").read_text())
    content = {
        "provenance": f"flexsat paper --seeds {len(table['seeds'])}, at commit {commit}",
        "seeds": table["seeds"],
        "duration": table["duration"],
        "cells": {
            cell: {"mean": row["mean"], "standard_deviation": row["standard_deviation"], "unit": row["unit"]}
            for cell, row in cells(table).items()
        },
    }
    SCATTER.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write_scatter(Path(sys.argv[1]), sys.argv[2])
