"""The public entry: options by name or as one object, and the summary of a run."""

import dataclasses
import subprocess
import sys
from typing import get_type_hints

import pytest

from lockstep import RunOptions, read_signals, simulate
from lockstep.simulation import _Named


@pytest.mark.parametrize(
    ("stop", "period", "rows"), [(0.01, 0.003, 4), (0.01, 0.005, 2), (0.011, 0.005, 3), (0.01, 0.02, 1)]
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


def test_an_unknown_option_is_refused_before_anything_is_written(loop, tmp_path):
    with pytest.raises(TypeError, match="unexpected keyword argument 'stop'"):
        simulate(loop, tmp_path / "out", stop=0.005)
    assert not (tmp_path / "out").exists()


def test_every_option_has_its_keyword_argument():
    fields = {field.name for field in dataclasses.fields(RunOptions)}

    assert fields == set(get_type_hints(_Named))


def test_importing_the_package_loads_nothing_that_takes_long():
    """Tens of processes are started in a check, and each imports the package."""
    source = "import sys, lockstep; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True).stdout.split()
    tops = {name.partition(".")[0] for name in loaded}

    assert "lockstep" in tops
    assert tops & {"numpy", "pyarrow", "lxml", "scipy", "fmpy", "matplotlib", "psutil", "filelock", "click"} == set()
