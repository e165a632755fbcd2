"""FMUs that crash, hang, exit and worse while they run: one line, readable results, nothing left behind."""

import json
import tomllib

import numpy as np
import pytest

from fmus.bad.bad_fmus import bad_fmu
from lockstep import read_signals

IN_STEP = "in fmi2DoStep at 0.05 s"
# defect: the line that the user sees, after the component's name
ENDED = {
    "CRASHES": f"crashed with SIGSEGV {IN_STEP}",
    "HANGS": f"no answer within 5 s {IN_STEP}",
    "EXITS": f"ended its process with exit code 3 {IN_STEP}",
    "EXITS_QUIETLY": f"ended its process with exit code 0 {IN_STEP}",
    "EATS_MEMORY": "GB of memory " + IN_STEP,
    "RETURNS_FATAL": "fmi2DoStep returned fmi2Fatal at 0.05 s: beyond repair",
}
SURVIVED = ("LEAVES_A_PROCESS", "LEAVES_A_THREAD", "FLOODS_THE_LOG", "CRASHES_AT_UNLOAD", "NOT_A_NUMBER")
WARNED = {"NOT_A_NUMBER": ["recorded though not finite, as no connection uses it: b.scaled (nan at 0.07 s)"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of all defects."""
    return tmp_path_factory.mktemp("hostile")


@pytest.fixture(scope="module")
def found(folder, good, pair, runs):
    """Return how each run ended, beside a good FMU that comes first in each tick."""
    cases = {}
    for defect in (*ENDED, *SURVIVED):
        system = pair(folder / defect, good, bad_fmu(folder / defect / "fmu", defect))
        arguments = ("run", system, "--out", folder / defect / "out", "--step-limit", "5")
        cases[defect] = (folder / defect, arguments)
    return runs(cases)


@pytest.mark.parametrize("defect", ENDED)
def test_a_run_ends_with_one_line_and_keeps_earlier_rows(found, folder, defect):
    ended, out = found[defect], folder / defect / "out"
    assert ended["code"] == 1
    (line,) = ended["lines"]
    assert line.startswith("lockstep: b: ")
    assert ENDED[defect] in line, line
    steps = 5
    record = tomllib.loads((out / "run.toml").read_text())
    assert (record["status"], record["simulated_time"]) == ("failed", steps / 100)
    assert f"lockstep: {record['reason']}" == line
    np.testing.assert_array_equal(read_signals(out)["b.count"], np.arange(steps) + 1)


@pytest.mark.parametrize("defect", [*ENDED, *SURVIVED])
def test_no_process_or_file_is_left_and_the_other_fmu_is_freed(found, folder, defect):
    ended = found[defect]
    assert (ended["processes"], ended["left"]) == ([], [])
    assert (folder / defect / "diary").read_text() == "a terminated\na freed\n"
    assert ended["descriptors"] == found["CRASHES"]["descriptors"]


@pytest.mark.parametrize("defect", SURVIVED)
def test_a_defect_that_does_not_affect_the_run_does_not_end_it(found, folder, defect):
    assert (found[defect]["code"], found[defect]["lines"]) == (0, [])
    record = tomllib.loads((folder / defect / "out" / "run.toml").read_text())
    assert record.get("warnings", []) == WARNED.get(defect, [])
    assert read_signals(folder / defect / "out")["b.count"][-1] == 21  # the sample at the stop time too


def test_a_limited_number_of_messages_is_kept(found, folder):
    assert found["FLOODS_THE_LOG"]["code"] == 0
    events = [json.loads(line) for line in (folder / "FLOODS_THE_LOG/out/events.jsonl").read_text().splitlines()]
    logged = [event for event in events if event["event"] == "log"]
    assert len(logged) == 1001
    assert (logged[0]["time"], logged[0]["message"]) == (0.05, "x" * 1024)
    assert logged[-1]["message"] == "further messages are not listed"
