"""The closed loop of each layout as one FMU: all outputs of its native FMUs are those of the master, bit by bit."""

import numpy as np
import pytest

from fmus.bundle_host import alone, bits, bundled, recorded
from lockstep import load_system
from lockstep.bundle.ports import Choice


@pytest.mark.parametrize("layout", ["centralised", "distributed"])
def test_every_output_of_the_closed_loop_is_that_of_the_master(fmus, tmp_path, layout):
    system = load_system(fmus / layout / "native" / "fine_pointing.ssd")
    choice = Choice(inputs=("plant.external.*",), outputs=("all",), parameters=("controller.*",))
    found = alone(bundled(system, tmp_path / "loop.fmu", choice), 0.2)
    expected = recorded(system, 0.2, record_period=0.001)

    assert len(expected) > 600
    assert np.ptp(expected["plant.rate[1]"]) > 0.0
    for name, values in expected.items():
        assert bits(found[name]) == bits(values), name
