"""A bundle gives the outputs of the master bit by bit, whatever the periods, offsets, kinds, delays and conversions."""

import numpy as np
import pytest

from lockstep import simulate
from lockstep.bundle.contents import contents
from lockstep.bundle.ports import Choice
from lockstep.bundle.write import bundle_bytes

MS = 1_000_000  # [ns]
CLOSED = Choice(inputs=("none",), outputs=("all",))


def bundled(system, path, choice=CLOSED, overrides=None, step=None):
    """Write the bundle of a system; return its path."""
    path.write_bytes(bundle_bytes(contents(system, overrides or {}, choice, step)))
    return path


def rows(system, stop=0.04, **more):
    """Return all recorded outputs as bits, by name without that of a lone FMU."""
    signals = simulate(system, stop_time=stop, record=("all",), record_period=0.001, **more)
    return {name: np.asarray(signals[name]) for name in signals}


def bits(values):
    """Return values as they are compared."""
    return values.tolist() if values.dtype == object else values.tobytes()


def inner(found):
    """Return the signals of a lone FMU by the names that they have in it."""
    return {name.partition(".")[2] if "." in name else name: values for name, values in found.items()}


@pytest.mark.parametrize("ticks", [1, 3], ids=["tick by tick", "three ticks a step"])
def test_every_output_is_that_of_the_master(cells, tmp_path, ticks):
    path = bundled(cells, tmp_path / "four.fmu")
    expected = rows(cells, 0.042)
    signals = simulate(path, stop_time=0.042, record=("all",), record_period=0.001 * ticks, periods=0.001 * ticks)
    found = inner({name: np.asarray(signals[name]) for name in signals})

    future = {"arm.text"}  # of a step that is longer than the tick
    assert {name for name in found if "." in name} == {name for name in expected if "." in name} - future
    assert len(expected) == 24
    for name in expected.keys() - future:
        values = expected[name]
        assert bits(found[name]) == bits(values[::ticks]), name
    assert np.ptp(expected["body.y[1]"]) > 0.1
    assert len(set(expected["slow.n"].tolist())) > 3
