"""The public entry: options by name or as one object, and the summary of a run."""

import dataclasses
import subprocess
import sys
import tomllib
from typing import get_type_hints

import numpy as np
import pytest

from lockstep import InputError, RunOptions, read_signals, simulate
from lockstep.simulation import NamedOptions


@pytest.mark.parametrize(
    ("stop", "period", "rows"), [(0.01, 0.003, 4), (0.01, 0.005, 3), (0.011, 0.005, 3), (0.01, 0.02, 1)]
)
def test_the_summary_counts_the_recorded_rows(loop, tmp_path, stop, period, rows):
    summary = simulate(loop, tmp_path / "out", stop_time=stop, record_period=period)

    assert summary.rows == len(read_signals(tmp_path / "out").time) == rows
    assert (summary.simulated_time, summary.ticks, summary.start_time) == (stop, round(stop / 0.001), 0.0)


def test_options_by_name_replace_those_of_the_object(loop, tmp_path):
    options = RunOptions(stop_time=0.005, record=["plant.*"])

    one = simulate(loop, tmp_path / "one", options)
    two = simulate(loop, tmp_path / "two", options, stop_time="0.003")

    assert (one.simulated_time, two.simulated_time) == (0.005, 0.003)
    assert list(read_signals(tmp_path / "two").columns) == ["plant.x", "plant.clock"]


def test_numbers_of_numpy_are_the_same_run_as_plain_ones(loop, tmp_path):
    """The record is TOML, which knows no np.float64(0.003)."""
    plain = {"plant.x0": 4.0, "echo.u[2]": 1.5}
    simulate(loop, tmp_path / "plain", stop_time=0.003, overrides=plain, record_period=0.001)
    given = {"plant.x0": np.float32(4.0), "echo.u[2]": np.array(1.5)}
    simulate(
        loop, tmp_path / "numpy", stop_time=np.float64(0.003), overrides=given, record_period=np.array(0.001),
        pace=np.float64(0.0), faults=None, checkpoints=None,
    )  # fmt: skip

    records = [tomllib.loads((tmp_path / name / "run.toml").read_text()) for name in ("plain", "numpy")]
    assert records[1]["overrides"] == plain
    assert records[1]["component"] == records[0]["component"]
    assert (tmp_path / "numpy/signals.parquet").read_bytes() == (tmp_path / "plain/signals.parquet").read_bytes()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"overrides": {"plant.x0": None}}, r"plant\.x0: None cannot be kept; give a number"),
        ({"overrides": {"plant.x0": [np.float64(0.0)]}}, r"plant\.x0: got 1 values for one parameter"),
        ({"overrides": {"plant.x0": 1j}}, r"plant\.x0: 1j of type complex cannot be kept"),
        ({"overrides": {"plant.x0": {"a": 1.0}}}, r"plant\.x0: \{'a': 1\.0\} is not of its type Real"),
        ({"overrides": {"plant.x0": 10**400}}, r"plant\.x0: 1000.* is not of its type Real"),
        ({"record": [None]}, r"record: None cannot be kept"),
        ({"record": 1}, r"record = 1 must be a list of texts"),
        ({"stop_time": [0.1]}, r"stop time: \[0\.1\] is not a number of seconds"),
        ({"step_limit": [1]}, r"step limit \[1\] must be a number of seconds"),
        (
            {"step_limit": np.int64(60)},
            r"step limit 60 s: no FMU of this run is isolated; .* --isolate counter, or leave it out",
        ),
        ({"pace": [1]}, r"pace \[1\] must be a factor of real time"),
    ],
)
def test_values_of_another_kind_are_refused_before_anything_is_written(loop, tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        simulate(loop, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_a_single_pattern_to_record_is_a_text(loop, tmp_path):
    simulate(loop, tmp_path / "out", stop_time=0.002, record="plant.x")
    assert list(read_signals(tmp_path / "out").columns) == ["plant.x"]


def test_an_unknown_option_is_refused_before_anything_is_written(loop, tmp_path):
    with pytest.raises(TypeError, match="unexpected keyword argument 'stop'"):
        simulate(loop, tmp_path / "out", stop=0.005)
    assert not (tmp_path / "out").exists()


def test_every_option_has_its_keyword_argument():
    fields = {field.name for field in dataclasses.fields(RunOptions)}

    assert fields == set(get_type_hints(NamedOptions))


def test_importing_the_package_loads_nothing_that_takes_long():
    """Tens of processes are started in a check, and each imports the package."""
    source = "import sys, lockstep; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True).stdout.split()
    tops = {name.partition(".")[0] for name in loaded}

    assert "lockstep" in tops
    assert tops & {"numpy", "pyarrow", "lxml", "scipy", "fmpy", "matplotlib", "psutil", "filelock", "click"} == set()
