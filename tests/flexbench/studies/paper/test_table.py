"""The table: numbers as printed, their deviation from the paper, and the four ways it is written."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from flexbench.engine.jobs import Finished
from flexbench.html.document import Paragraph, Table
from flexbench.loop.scenarios import SCENARIOS
from flexbench.report import paper_pages
from flexbench.report.headline import headline_blocks
from flexbench.report.study_table import study_table
from flexbench.studies.paper import paper
from flexbench.studies.paper.published import ROWS, VARIANTS
from flexbench.studies.paper.table import (
    Failed,
    Results,
    against_published,
    as_csv,
    as_json,
    as_markdown,
    as_text,
    number,
    numbers,
)
from flexbench.studies.paper.table import lines as table_lines
from flexsat.description.built_in import CONFIGURATIONS

RUN = ("as_published", "corrected")  # the variants that have numbers


def results(variants=RUN, factors=(1.0,), duration=300.0, lost=None):
    """Return a study whose numbers are the published ones, times a factor a seed."""
    metrics = {
        (variant, name, scenario): [
            {row.key: factor * row.published_for(name) / row.scale for row in ROWS if row.scenario == scenario}
            for factor in factors
        ]
        for variant in variants
        for name in CONFIGURATIONS
        for scenario in SCENARIOS
    }
    return Results(metrics=metrics, seeds=range(1, len(factors) + 1), duration=duration, lost=lost or {})


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.0, "1"),
        (0.12345, "0.123"),
        (0.01, "0.01"),
        (0.00999, "9.99e-3"),
        (3.4e-5, "3.40e-5"),
        (-2.5, "-2.5"),
        (461.0, "461"),
        (999.4, "999"),
        (999.6, "1000"),
        (1234.5, "1234"),
        (9999.4, "9999"),
        (2.05e4, "2.05e4"),
        (-1e-10, "-1.00e-10"),
    ],
)
def test_number_has_three_digits_and_an_exponent_only_where_shorter(value, text):
    assert number(value) == text


def test_the_deviation_is_that_from_the_paper_with_the_scatter_of_one_seed_beside_it():
    row = next(row for row in ROWS if row.label == "slew: pointing error")
    study = results(factors=(0.9, 1.0, 1.1, 1.2))  # their standard deviation is .129

    assert against_published(row, study, "distributed") == "+5 ± 13 %"
    assert against_published(row, results(variants=("corrected",)), "distributed") == "-"
    text = against_published(row, results(factors=(1.5,)), "distributed")  # one seed: the scatter of the stored study
    assert text.startswith("+50 ± ")
    assert text != against_published(row, results(factors=(1.5,)), "centralised")


def test_rows_of_whole_runs_are_left_out_of_shorter_studies():
    study = results(duration=200.0)
    shown = {row.label for row, *_ in numbers(study)}

    assert {row.label for row in ROWS} - shown == {"slew: total cost", "slew: control cost", "slew: settling"}
    assert "refer to runs of 300 s and are not shown" in as_text(study)


@pytest.mark.parametrize(
    ("times", "text"),
    [
        ([0.03], "lost at 0.03 s"),
        ([0.5, 0.03], "lost at 0.03 to 0.5 s"),
        ([0.5, None], "lost in 1 of 2"),
        ([None], "lost in 0 of 1"),
    ],
)
def test_when_the_published_design_is_lost_stands_in_its_column(times, text):
    study = results(lost=dict.fromkeys(CONFIGURATIONS, times))
    header, _, *lines = as_markdown(study).split("\n\n")[0].splitlines()

    assert header.endswith("| corrected, published design |")
    column = {line.split("|")[1].strip(): line.split("|")[-2].strip() for line in lines}
    assert column["fine pointing: error"] == text
    assert column["slew: pointing error"] == "-"


def test_a_cell_is_mean_and_standard_deviation_over_the_seeds():
    study = results(factors=(0.9, 1.0, 1.1, 1.2))
    row = ROWS[0]
    cell = study.cell(row, "corrected", "distributed")

    assert cell is not None
    reference = row.published_for("distributed")
    assert cell.mean == pytest.approx(1.05 * reference, rel=1e-12)
    assert cell.deviation == pytest.approx(reference * (0.05 / 3.0) ** 0.5, rel=1e-12)  # variance 0.05 / (4 - 1)
    assert cell.text == f"{number(cell.mean)} ± {number(cell.deviation)}"
    single = results().cell(row, "corrected", "distributed")
    assert single is not None
    assert (single.deviation, single.text) == (None, number(reference))


def test_a_variant_that_was_not_run_has_no_column():
    study = results(variants=("corrected",))

    assert study.variants == ["corrected"]
    assert study.cell(ROWS[0], "as_published", "distributed") is None
    assert len(numbers(study)) == len(ROWS) * len(CONFIGURATIONS)
    header = as_markdown(study).splitlines()[0]
    assert "corrected" in header
    assert "as published" not in header


def test_markdown_is_one_table_a_configuration_with_equal_columns():
    blocks = as_markdown(results(factors=(1.0, 1.01))).split("\n\n")

    for name, block in zip(CONFIGURATIONS, blocks, strict=False):
        lines = block.splitlines()
        assert len(lines) == 2 + len(ROWS)
        assert {line.count("|") for line in lines} == {7}
        assert lines[0].startswith(f"| {name} |")
    assert blocks[-1].startswith("- Runs of 300 s through the FMUs; seeds 1, 2 (mean ± ")


def test_csv_is_one_line_a_number_in_full_precision():
    rows = list(csv.DictReader(io.StringIO(as_csv(results(factors=(1.0, 1.1))))))

    assert len(rows) == len(ROWS) * 4
    first = rows[0]
    assert (first["row"], first["variant"], first["configuration"]) == (ROWS[0].label, "as_published", "centralised")
    assert float(first["mean"]) == pytest.approx(1.05 * 1.9e4, rel=1e-15 * 10)
    assert (float(first["published"]), first["seeds"]) == (1.9e4, "2")


def test_json_holds_everything_behind_the_table():
    study = results(factors=(1.0, 1.3))
    content = json.loads(as_json(study))

    assert (content["seeds"], content["duration"], len(content["rows"])) == ([1, 2], 300.0, len(ROWS) * 4)
    for key, seeds in study.metrics.items():
        assert content["metrics_si"][" ".join(key)] == list(seeds)
    assert {row["deviation"] is None for row in content["rows"] if row["variant"] == "corrected"} == {True}


def test_text_shows_every_row():
    text = as_text(results(lost={name: [0.03] for name in CONFIGURATIONS}))
    tables = text.partition("Runs of 300 s")[0]

    for row in ROWS:
        assert tables.count(row.label) == 2  # a table each configuration
        assert row.definition in text


@pytest.fixture
def lame(monkeypatch, tmp_path):
    """Return a study of which two runs failed, one of them for each seed, as `run_paper` leaves it; and its folder."""

    def finished(jobs, processes, *, keep_all):
        assert (processes, keep_all) == (2, True)
        found = []
        for job in jobs:
            name = job.folder.name
            failure = "plant: crashed\nwith SIGSEGV." if name.startswith("distributed-slew-as") else ""
            failure = "sensors: refused" if name == "centralised-slew-seed2" else failure
            metrics = {} if failure else {row.key: 2.0 for row in ROWS}
            found.append(Finished(job=job, metrics=metrics, wall_time=1.0, simulated_time=300.0, failure=failure))
        return found

    monkeypatch.setattr(paper, "run_jobs", finished)
    monkeypatch.setattr(paper, "saturated_from", lambda _: 0.02)
    return paper.run_paper(tmp_path / "fmus", tmp_path, VARIANTS, [1, 2], 300.0, 2), tmp_path


def test_runs_that_failed_are_marked_and_the_others_counted(lame):
    study, folder = lame
    assert [one.folder.name for one in study.failed] == [
        "distributed-slew-as-published-seed1", "distributed-slew-as-published-seed2", "centralised-slew-seed2",
    ]  # fmt: skip
    lines = {line[0]: line for line in table_lines(study, "distributed")}
    assert lines["slew: settling"][3:6] == ["failed", "-", "2 ± 0"]
    assert "failed" not in lines["fine pointing: error"]
    cell = study.cell(ROWS[0], "corrected", "centralised")
    assert cell is not None
    assert (cell.count, cell.deviation) == (1, None)
    text = (folder / "table.txt").read_text()
    assert f"Failed, and excluded from the numbers: {study.failed[0].text}." in text
    assert study.failed[0].text.endswith(f"plant: crashed with SIGSEGV ({study.failed[0].folder})")
    assert paper.failures_text(study)[0].startswith("3 of 28 runs failed, table and page have the others: distributed")
    kept = paper.one_seed_folders(folder, VARIANTS, 2, [one.folder for one in study.failed])
    assert len(kept) == 10
    assert paper.failures_text(results()) == []


def test_the_page_marks_runs_that_failed_with_cause_and_folder(lame):
    _, folder = lame
    blocks = study_table(folder)
    centralised, distributed = (block for block in blocks if isinstance(block, Table))
    rows = {row[0]: row for row in distributed.rows}
    width = len(distributed.header)
    assert rows["slew: settling"][:6] == ["slew: settling", "s", "30", "failed", "-", "2 ± 0"]
    assert all(len(row) == width for row in [*centralised.rows, *distributed.rows])
    assert "failed" not in str(centralised.rows)  # of one of two seeds
    assert sum(text_of(block).startswith("Failed, and excluded from the numbers") for block in blocks) == 3
    (answer, _) = [text_of(block) for block in headline_blocks([], [folder])] + [""]
    assert "Failed, and excluded from the paper's table: distributed-slew-as-published-seed1, " in answer
    assert "What they recorded" not in answer
    begun = SimpleNamespace(
        folder=folder / "centralised-slew-seed2", name="centralised-slew-seed2 (failed at 9 s)", run=None
    )
    answer = text_of(headline_blocks([begun], [folder])[0])
    assert ", centralised-slew-seed2 (failed at 9 s); the cause is below" in answer
    assert "What they recorded before they failed is on this page." in answer


def test_what_a_failed_run_left_is_distinguished_from_a_run_of_an_earlier_study(tmp_path):
    cause = "plant: crashed with SIGSEGV at 9 s"
    assert not paper.has_begun(tmp_path, cause)
    for content, begun in (
        ('status = "failed"\nreason = "plant: crashed with SIGSEGV at 9 s"', True),
        ('status = "failed"\nreason = "sensors: refused"', False),
        ('status = "running"', True),  # its process was killed
        ('status = "completed"', False),
    ):
        (tmp_path / "run.toml").write_text(f"{content}\ncomponent = []\n")
        assert paper.has_begun(tmp_path, cause) == begun


def test_the_page_has_the_runs_that_failed_as_far_as_they_came(lame, monkeypatch):
    study, folder = lame
    shown = []
    monkeypatch.setattr(paper_pages, "write_report", lambda runs, page, **_: shown.append(runs) or [page])
    begun = replace(study.failed[0], begun=True)
    paper_pages.report_paper(folder, VARIANTS, 1, [begun, study.failed[1]])
    paper_pages.report_paper(folder, VARIANTS, 1, study.failed)
    assert set(shown[0]) - set(shown[1]) == {begun.folder}
    alone = [Failed(key=one.key, seed=1, folder=path, cause="", begun=True)
             for one in study.failed[:1] for path in shown[0]]  # fmt: skip
    assert paper_pages.report_paper(folder, VARIANTS, 1, alone) is None


def text_of(block):
    """Return the text of a paragraph."""
    return block.text if isinstance(block, Paragraph) else ""
