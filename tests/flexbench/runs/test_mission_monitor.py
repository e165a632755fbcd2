"""How a mission went, in lines for the end of a run: from the rows of the manager, through the events."""

import json
from pathlib import Path

import numpy as np
import pytest

from flexbench.runs.mission_monitor import MODE, MOMENTUM, OUTAGE, STATUS, MissionMonitor, mission_lines, print_mission
from flexsat.runtime.missions.mode_logic import MODES

COLUMNS = (MODE, OUTAGE, f"{STATUS}[1]", f"{STATUS}[2]")
AXES = tuple(f"{MOMENTUM}[{axis}]" for axis in (1, 2, 3))


def lines_of(modes, *, one=(), two=(), outage=(), momentum=(0.0, 0.0, 0.0), tolerance=0.02, duration=1.0, blocks=1):
    """Return the lines for modes of a row a second, and what holds from given rows on."""
    count = len(modes)
    columns = {MODE: np.array([MODES.index(mode) for mode in modes], np.float64)}
    for name, begins in ((OUTAGE, outage), (COLUMNS[2], one), (COLUMNS[3], two)):
        columns[name] = np.zeros(count)
        for value, row in enumerate(begins, 1):
            columns[name][row:] = value % 2 if name == OUTAGE else value
    columns |= {name: np.full(count, value) for name, value in zip(AXES, momentum, strict=True)}
    monitor = MissionMonitor(COLUMNS, AXES, tolerance, duration)
    found = []
    for rows in np.array_split(np.arange(count), blocks):
        found += monitor.rows(rows.astype(np.float64), {name: values[rows] for name, values in columns.items()})
    return mission_lines([{"event": one.event, "time": one.time, **one.details} for one in found])


@pytest.mark.parametrize("blocks", [1, 3])
def test_a_mission_without_failures_says_its_last_mode(blocks):
    assert lines_of(["settle"] * 3 + ["fine"] * 3, blocks=blocks) == ["mission: in mode fine from 3 s to the end"]


def test_safe_names_what_led_to_it():
    fine, safe = ["fine"] * 3, ["safe"] * 3
    (first, *wheels) = lines_of(fine + safe, one=(1,), two=(3, 5))
    assert first.startswith("mission: in mode safe from 3 s to the end: the remaining wheels give no torque")
    assert wheels == ["wheel 1: off from 1 s on", "wheel 2: off from 3 s on, seized from 5 s on"]
    first, second = lines_of(fine + safe, outage=(2,))
    assert first == "mission: in mode safe from 3 s to the end: no sample of the star tracker from 2 s on"
    assert second == "star tracker: no samples, known from 2 s to the end"
    assert lines_of(fine + safe) == ["mission: in mode safe from 3 s to the end, by command"]


def test_outages_that_end_are_listed_with_their_end():
    modes = ["fine", "fine", "acquisition", "acquisition", "settle", "fine"]
    assert lines_of(modes, outage=(2, 4))[1:] == ["star tracker: no samples, known from 2 s to 4 s"]


def test_an_off_loading_that_leaves_momentum_is_named_and_one_within_its_tolerance_is_not():
    modes = ["fine", "off-load", "off-load", "settle", "fine"]
    _, left = lines_of(modes, momentum=(0.01, -177.72, 0.0))
    assert left == (
        "off-loading from 1 to 3 s left 178 N.m.s about an axis, more than mission.off_loading.tolerance, 0.02"
    )
    assert len(lines_of(modes, momentum=(0.01, -0.019, 0.0))) == 1
    assert len(lines_of(modes, momentum=(0.0, 0.1, 0.0), tolerance=0.2)) == 1


def test_an_off_loading_that_ended_by_itself_is_not_blamed_for_what_came_after():
    """It lasted 2 s of the 4 after which it is given up: it was within its tolerance, and the environment went on."""
    modes, since = ["fine", "off-load", "off-load", "settle", "fine"], (0.0, 0.021, 0.0)
    assert len(lines_of(modes, momentum=since, duration=2.0)) == 1
    assert len(lines_of([*modes[:3], "safe", "safe"], momentum=since, duration=2.0)) == 2  # ended by a failure


def test_other_runs_print_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    print_mission(tmp_path)
    (tmp_path / "events.jsonl").write_text(json.dumps({"event": "started", "time": 0.0}) + "\n", encoding="utf-8")
    print_mission(tmp_path)
    assert capsys.readouterr().out == ""
