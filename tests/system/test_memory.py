"""Memory does not grow with the length of a run."""

import pytest

pytestmark = pytest.mark.slow

PEAK = """
import resource
from flexbench.loop.native_fmus import with_native_fmus
from lockstep import load_system, simulate
fmus, folder, stop, native, record = given
system = load_system(Path(fmus, "distributed", "fine_pointing.ssd"))
simulate(with_native_fmus(system) if native else system, Path(folder), stop_time=stop, record=record)
result = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MiB
"""
# The final conversion works on row groups of 16 MB, which 30 s do not fill: it holds a group as batches, as one table
# and compressed. All that 300 s record are 115 MB: without streaming the difference would be larger than that.
ALLOWED = 64.0  # MiB


# Python FMUs take six times as long, so that their runs are shorter and record one signal: what they may lose in a
# simulated second is the same.
SHORTER, ONE_SIGNAL = 40.0, ["plant.rms_deformation"]  # s between both lengths


def test_ten_times_the_length_takes_no_more_memory(fmus, python, tmp_path):
    short = python(PEAK, fmus, tmp_path / "short", 30.0, True, None, fresh=True)
    long = python(PEAK, fmus, tmp_path / "long", 300.0, True, None, fresh=True)

    assert long - short < ALLOWED


def test_python_fmus_keep_nothing_of_a_step(fmus, python, tmp_path):
    short = python(PEAK, fmus, tmp_path / "short", 5.0, False, ONE_SIGNAL, fresh=True)
    long = python(PEAK, fmus, tmp_path / "long", 5.0 + SHORTER, False, ONE_SIGNAL, fresh=True)

    assert long - short < ALLOWED * SHORTER / 270.0
