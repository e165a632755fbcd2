"""Tables and verdicts of the comparison: from intervals, without lost runs, which are named."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from flexbench.engine.jobs import Finished, Job
from flexbench.runs.windows import Window
from flexbench.studies.layouts.outcome import QUANTITIES, growing, lost_by, measure
from flexbench.studies.layouts.result_file import as_csv, as_json, as_text
from flexbench.studies.layouts.tables import (
    answer,
    cells,
    compare,
    cost_text,
    header,
    lost_text,
    notes,
    verdict,
    wheels_header,
)
from flexbench.studies.layouts.wheels import Wheels
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ARCSECOND
from lockstep import Signals

VALUES = tuple(ARCSECOND * np.array([1.0, 2.0, 4.0, 3.0]))


def row_of(comparison, key):
    """Return the row of a quantity."""
    return next(row for row in compare(comparison) if row.quantity.key == key)


def test_a_verdict_says_which_layout_is_better_and_by_how_much(compare_made):
    lower = verdict(row_of(compare_made(VALUES, 0.5), "pointing"))
    assert lower == "pointing error in fine pointing: lower with distributed wheels, by a factor of 2 (95 %: 2 to 2)."
    higher = verdict(row_of(compare_made(VALUES, 4.0), "pointing"))
    assert higher == "pointing error in fine pointing: higher with distributed wheels, by a factor of 4 (95 %: 4 to 4)."
    scattered = compare_made(VALUES, distributed=dict(enumerate(VALUES[::-1], start=1)))
    row = row_of(scattered, "pointing")
    low, high = row.contrast.low, row.contrast.high
    assert low * high == pytest.approx(1.0)  # the same values in another order
    assert verdict(row) == (
        f"pointing error in fine pointing: no difference shown (distributed / centralised 1, 95 %: {low:.3g} to"
        f" {high:.3g})."
    )


def test_a_factor_has_the_bounds_of_its_interval_in_rising_order(compare_made):
    row = row_of(compare_made(VALUES, distributed={k: v * (0.3 + 0.05 * k) for k, v in enumerate(VALUES, 1)}), "torque")
    found = row.contrast
    assert found.high < 1.0
    expected = f"by a factor of {1 / found.value:.3g} (95 %: {1 / found.high:.3g} to {1 / found.low:.3g})."
    assert verdict(row).endswith(expected)


def test_settling_is_compared_by_its_difference_as_it_may_be_zero(compare_made):
    zero = row_of(compare_made((0.0, 0.0, 0.0)), "settling")
    assert verdict(zero) == "settling time after the slew: no difference shown (equal in every pair)."
    longer = row_of(compare_made((1.0, 0.0, 2.0), distributed={1: 3.0, 2: 2.5, 3: 4.0}), "settling")
    reach = 4.302652729911275 * np.std([2.0, 2.5, 2.0], ddof=1) / math.sqrt(3.0)  # t, 2 degrees of freedom
    low, high = 6.5 / 3.0 - reach, 6.5 / 3.0 + reach
    assert verdict(longer) == (
        f"settling time after the slew: higher with distributed wheels, by 2.17 s (95 %: {low:.3g} to {high:.3g})."
    )
    assert not longer.is_ratio
    assert row_of(compare_made(VALUES), "pointing").is_ratio


def test_lost_runs_are_in_no_number_and_named(compare_made):
    """The lost run has no part in the mean of its layout, nor has its pair in the ratio."""
    lost = {("distributed", 2): "limit cycle: once at 3 s"}
    comparison = compare_made((1.0, 1000.0, 3.0, 4.0), 0.5, lost=lost)
    row = row_of(comparison, "deformation")

    assert (row.means["centralised"].count, row.means["distributed"].count) == (4, 3)
    assert row.means["distributed"].value == pytest.approx(0.5 * 8.0 / 3.0)
    assert (row.contrast.count, row.contrast.value) == (3, pytest.approx(0.5))
    text = lost_text(comparison)
    assert text.startswith("2 of 16 runs were lost, and are excluded from means and ratios")
    assert "distributed, fine pointing, seed 2: limit cycle: once at 3 s; distributed, slew, seed 2: limit" in text
    assert text in as_text(comparison, compare(comparison))
    lines = list(csv.DictReader(as_csv(comparison).splitlines()))
    (line,) = [one for one in lines if one["lost"] and one["scenario"] == "slew"]
    assert (line["configuration"], line["seed"], line["settled_torque"]) == ("distributed", "2", "")
    assert as_json(comparison, compare(comparison))["shown"][0].endswith("seed1")
    assert lost_text(compare_made(VALUES)) == "None of 16 runs was lost."


def test_a_layout_whose_runs_are_all_lost_is_not_compared(compare_made):
    comparison = compare_made(VALUES, lost={("centralised", seed): "diverged" for seed in (1, 2, 3, 4)})
    rows = compare(comparison)

    assert {verdict(row).partition(": ")[2] for row in rows} == {"no pair of runs to compare."}
    assert answer(comparison, rows)[0].endswith("These runs cannot show it: there are no pairs to compare.")
    assert cost_text(comparison) == "Every run of a layout was lost: its wheels are not compared."
    stored = as_json(comparison, rows)
    assert {one["means"]["centralised"] for one in stored["quantities"]} == {None}
    json.dumps(stored, allow_nan=False)


def test_one_pair_left_shows_nothing(compare_made):
    lost = {("centralised", seed): "diverged" for seed in (2, 3, 4)}
    comparison = compare_made(VALUES, lost=lost)
    rows = compare(comparison)
    assert verdict(rows[0]).endswith("one pair of runs shows no scatter, so nothing about others.")
    assert answer(comparison, rows)[0].endswith("there are no pairs to compare.")
    json.dumps(as_json(comparison, rows), allow_nan=False)


def test_runs_that_do_not_settle_have_no_value_and_are_counted(compare_made):
    comparison = compare_made(VALUES, distributed={3: None})
    row = row_of(comparison, "settling")
    assert (row.means["distributed"].count, row.contrast.count) == (3, 3)
    assert verdict(row).startswith(
        "settling time after the slew (not settled at the end: 0 of centralised and 1 of distributed; without these): "
    )


def test_the_answer_sorts_the_quantities(compare_made):
    comparison = compare_made(VALUES, 0.5, durations={"fine_pointing": 100.0})
    first, second, *_ = answer(comparison, compare(comparison))
    assert first == "Does distributing the wheels pay? In 3 of 3 quantities; in none is it shown to be worse."
    assert second == (
        "Distributing lowers the pointing error in fine pointing by a factor of 2 (95 %: 2 to 2), the deformation in"
        " fine pointing by a factor of 2 (95 %: 2 to 2) and the torque in fine pointing by a factor of 2"
        " (95 %: 2 to 2)."
    )
    worse = compare_made(VALUES, 2.0)
    assert answer(worse, compare(worse))[0].endswith("Not in any of the 9 quantities compared.")


def test_two_spacecraft_of_ones_own_are_compared_by_their_names(compare_made):
    """The same numbers as of the paper's layouts, under other names."""
    made = compare_made(VALUES, 0.5)
    names = dict(zip(CONFIGURATIONS, ("small", "large"), strict=True))
    outcomes = [replace(one, configuration=names[one.configuration]) for one in made.outcomes]
    other = replace(made, plan=replace(made.plan, layouts=("small", "large")), outcomes=outcomes, modes=(7, 9))
    rows = compare(other)
    assert header(other) == ("quantity", "unit", "small", "large", "large / small", "pairs")
    assert wheels_header(other) == ("wheels", "unit", "small", "large")
    assert [cells(row) for row in rows] == [cells(row) for row in compare(made)]
    assert verdict(rows[0]) == "pointing error in fine pointing: lower with large, by a factor of 2 (95 %: 2 to 2)."
    first, second, *_ = answer(other, rows)
    assert first == "Is large better than small? In 9 of 9 quantities; in none is it shown to be worse."
    assert second.startswith("With large these are lower: the pointing error in fine pointing by a factor of 2 (")
    assert "on a plant of 7 and 9 modes" in notes(other)[0]
    assert as_json(other, rows)["shown"][0].startswith("small-")


def test_the_cost_is_in_wheels_momentum_and_weight(compare_made):
    comparison = compare_made(VALUES)
    one = Wheels(count=6, inertia=27.72, torque=4.4, turning=8.8, momentum=1000.0, energy=1.0, slowest=1.0, fastest=2.0,
                 weight=6 * 4.62**0.6, imbalance=0.1)  # fmt: skip
    many = Wheels(count=33, inertia=27.72, torque=0.8, turning=8.8, momentum=900.0, energy=1.0, slowest=1.0,
                  fastest=2.0, weight=33 * 0.84**0.6, imbalance=0.1)  # fmt: skip
    comparison.wheels.update(centralised=one, distributed=many)
    assert cost_text(comparison) == (
        "What it costs: 33 wheels in place of 6, with 27.7 kg.m2 in all against 27.7 and 900 N.m.s stored at nominal"
        " speed against 1e+03. The paper takes both sets as equally heavy; rotors of one shape and material would"
        " weigh 2 times as much."
    )


def made_run(last):
    """Return a second of torque of one wheel, of 0.1 N.m, then `last`."""
    torque = np.repeat([0.1, last], 100) * np.tile([1.0, -1.0], 100)
    columns = {"controller.wheel.torque[1]": torque}
    return Signals(time=0.005 * np.arange(200), columns=columns, units={}, descriptions={})


@pytest.mark.parametrize(("last", "lost"), [(0.19, ""), (0.21, "the torque grows 2.1 times from one half of")])
def test_torque_that_doubles_in_the_steady_part_is_lost(last, lost):
    window = Window(name="steady part", spans=((0.0, 1.0),))
    assert growing(made_run(last), window)[:38] == lost[:38]


def test_saturation_that_ends_is_no_loss():
    short = {"event": "torque-saturation", "count": 1, "first": 2.0, "seconds": 0.5}
    assert lost_by([short]) == ""
    assert lost_by([short | {"until_the_end": True}]) == "torque saturation: once at 2 s, for 0.5 s, to the end"
    assert "divergence (rate): once" in lost_by([short, short | {"event": "divergence", "quantity": "rate"}])
    assert lost_by([]) == ""


def test_a_run_that_the_master_stopped_is_lost_for_its_reason(tmp_path):
    job = Job(system=None, folder=tmp_path)
    failed = Finished(job=job, metrics={}, wall_time=0.0, simulated_time=0.0, failure="plant: refused at 3 s")
    found = measure(failed, "centralised", "slew", 1, None)
    assert (found.lost, found.numbers) == ("plant: refused at 3 s", {})


def test_every_quantity_has_a_key_of_its_own():
    assert len({one.key for one in QUANTITIES}) == len(QUANTITIES) == 9
