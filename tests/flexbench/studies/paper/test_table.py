"""The table: numbers as printed, the rule that judges them, and the four ways it is written."""

from __future__ import annotations

import csv
import io
import json

import pytest

from flexbench.loop.scenarios import SCENARIOS
from flexbench.studies.paper.published import ROWS, VARIANTS
from flexbench.studies.paper.table import (
    Cell,
    Results,
    as_csv,
    as_json,
    as_markdown,
    as_text,
    compare,
    comparisons,
    number,
)
from flexsat.parameters import CONFIGURATIONS


def results(variants=VARIANTS, factors=(1.0,)):
    """Return a study whose numbers are the references, times a factor a seed."""
    metrics = {
        (variant, name, scenario): [
            {row.key: factor * row.reference_for(variant, name) / row.scale for row in ROWS if row.scenario == scenario}
            for factor in factors
        ]
        for variant in variants
        for name in CONFIGURATIONS
        for scenario in SCENARIOS
    }
    return Results(metrics=metrics, seeds=range(1, len(factors) + 1), duration=300.0)


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


@pytest.mark.parametrize(
    ("mean", "reference", "scatter", "criterion", "met"),
    [
        (1.09, 1.0, 0.0, "10 %", True),
        (1.11, 1.0, 0.0, "10 %", False),
        (0.91, 1.0, 0.09, "10 %", True),
        (0.89, 1.0, 0.09, "10 %", False),  # one seed scatters less than 10 %: that is the rule
        (1.29, 1.0, 0.11, "3 standard deviations of one seed", True),
        (1.34, 1.0, 0.11, "3 standard deviations of one seed", False),
        (0.0, 0.0, 0.0, "10 %", True),
        (1e-9, 0.0, 0.0, "10 %", False),
        (2.0, 0.0, 1.0, "3 standard deviations of one seed", True),
    ],
)
def test_criterion_is_ten_percent_or_three_deviations(mean, reference, scatter, criterion, met):
    comparison = compare(Cell(mean=mean, deviation=None, count=1), reference, scatter)

    assert (comparison.criterion, comparison.met, comparison.reference) == (criterion, met, reference)
    if reference:
        assert comparison.deviation == pytest.approx(mean / reference - 1.0, rel=1e-12)  # rounding


def test_a_study_that_gives_the_references_meets_them_all():
    found = comparisons(results())

    assert len(found) == len(ROWS) * len(VARIANTS) * len(CONFIGURATIONS)
    assert all(comparison.met and abs(comparison.deviation) < 1e-12 for *_, comparison in found)


def test_a_cell_is_mean_and_standard_deviation_over_the_seeds():
    study = results(factors=(0.9, 1.0, 1.1, 1.2))
    row = ROWS[0]
    cell = study.cell(row, "corrected", "distributed")

    assert cell is not None
    reference = row.reference_for("corrected", "distributed")
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
    assert len(comparisons(study)) == len(ROWS) * len(CONFIGURATIONS)
    header = as_markdown(study).splitlines()[0]
    assert "corrected" in header
    assert "as published" not in header


def test_markdown_is_one_table_a_configuration_with_equal_columns():
    blocks = as_markdown(results(factors=(1.0, 1.01))).split("\n\n")

    for name, block in zip(CONFIGURATIONS, blocks, strict=False):
        lines = block.splitlines()
        assert len(lines) == 2 + len(ROWS)
        assert {line.count("|") for line in lines} == {6}
        assert lines[0].startswith(f"| {name} |")
    assert blocks[-1].startswith("- Runs of 300 s through the FMUs; seeds 1, 2 (mean ± ")


def test_csv_is_one_line_a_number_in_full_precision():
    rows = list(csv.DictReader(io.StringIO(as_csv(results(factors=(1.0, 1.1))))))

    assert len(rows) == len(ROWS) * 4
    first = rows[0]
    assert (first["row"], first["variant"], first["configuration"]) == (ROWS[0].label, "as_published", "centralised")
    assert float(first["mean"]) == pytest.approx(1.05 * 2.05e4, rel=1e-15 * 10)
    assert (float(first["published"]), float(first["reference"]), first["seeds"]) == (1.9e4, 2.05e4, "2")


def test_json_holds_everything_behind_the_table():
    study = results(factors=(1.0, 1.3))
    content = json.loads(as_json(study))

    assert (content["seeds"], content["duration"], len(content["rows"])) == ([1, 2], 300.0, len(ROWS) * 4)
    for key, seeds in study.metrics.items():
        assert content["metrics_si"][" ".join(key)] == list(seeds)
    assert {row["met"] for row in content["rows"] if row["reference"] != 0.0} <= {True, False}


def test_text_fits_its_width_and_shows_every_row_and_comparison():
    text = as_text(results(), width=110)
    tables = text.partition("Runs of 300 s")[0]

    assert max(map(len, tables.splitlines())) <= 110
    for row in ROWS:
        assert tables.count(row.label) >= 2  # a table each configuration; the third may break a long one
        assert row.definition in text
    assert " met" in tables
    assert "not met" not in tables
    assert "not met" in as_text(results(factors=(1.5,)))
