"""Memory does not grow with the length of a run."""

import pytest

pytestmark = pytest.mark.slow

PEAK = """
import resource
from lockstep import load_system, simulate
fmus, folder, stop = given
simulate(load_system(Path(fmus, "distributed", "fine_pointing.ssd")), Path(folder), stop_time=stop)
result = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MiB
"""
# The final conversion works on row groups of 16 MB, which 30 s do not fill: it holds a group as batches, as one table
# and compressed. All that 300 s record are 115 MB: without streaming the difference would be larger than that.
ALLOWED = 64.0  # MiB


def test_ten_times_the_length_takes_no_more_memory(fmus, python, tmp_path):
    short = python(PEAK, fmus, tmp_path / "short", 30.0)
    long = python(PEAK, fmus, tmp_path / "long", 300.0)

    assert long - short < ALLOWED
