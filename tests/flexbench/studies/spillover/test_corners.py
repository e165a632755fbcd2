"""Stability of both controller designs on a structure with more modes than the controller knows."""

import numpy as np
import pytest

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.real_plant import MODE_COUNTS, Corner, stability, table_rows
from flexbench.studies.spillover.corners import DELAY, GAINS, PHASE, required_corners
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ALL_MODES
from flexsat.spacecraft.variation import ModelErrors
from lockstep import InputError

WORST = ModelErrors(frequency=-0.05, damping=-0.5, inertia=0.1)  # the corner with the least damping of all


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_published_design_is_unstable_on_40_modes(published, name):
    """PHYSICS section 9: stable on the 25 modes that it was designed on, unstable on 40."""
    assert stability(published[name], Corner(modes=25)).stable
    found = stability(published[name], Corner(modes=40))
    assert not found.stable
    assert found.growth > 0.1  # 1/s: seconds to the limits of the wheels
    assert table_rows([found])[0][-1] == "UNSTABLE"


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_robust_design_holds_at_its_corners(robust, name):
    """A cheap subset; all corners with 198 modes by tests/bench/robust_design.py."""
    corners = [
        Corner(modes=25, errors=WORST),
        Corner(modes=28),
        Corner(modes=60, gain=GAINS[0]),
        Corner(modes=60, gain=GAINS[1]),
        Corner(modes=60, phase=PHASE),
        Corner(modes=60, delay=DELAY[name]),
        Corner(modes=60, errors=WORST),
    ]
    unstable = [
        found.corner.title for found in (stability(robust[name], corner) for corner in corners) if not found.stable
    ]
    assert unstable == []


def test_corners_do_not_bound_what_lies_between_them(robust):
    """A campaign found it: it lost 83 of 500 centralised loops within these errors, and no distributed one."""
    between = Corner(modes=40, errors=ModelErrors(damping=-0.5, inertia=0.02))
    assert stability(robust["distributed"], between).stable
    found = stability(robust["centralised"], between)
    assert found.growth == pytest.approx(0.0912, rel=0.01)  # 1/s
    assert stability(robust["centralised"], Corner(modes=40, errors=WORST)).stable


def test_growth_is_that_of_the_loop_itself(published):
    """On the model that the controller was designed on: the spectral radius of the designed loop."""
    plants = published["centralised"]
    loop = DesignedLoop(design=plants.design).at()
    # the same structure, once built with 25 modes and once with 60: modes agree to 1e-9, poles are near the circle
    expected = np.log(loop.radius()) / loop.period
    assert stability(plants, Corner(modes=25)).growth == pytest.approx(expected, rel=1e-4)


def test_the_frequency_of_a_pole_is_no_alias_at_the_star_trackers_rate(robust):
    """With 2.4 times the gain the bus drives a mode of 10.3 Hz, as in FMUs (tests/bench/measured_margins.py)."""
    found = stability(robust["centralised"], Corner(modes=60, gain=2.4))
    assert not found.stable
    assert found.frequency == pytest.approx(10.3, abs=0.05)  # folded at 10 Hz: 0.3


def test_required_corners_cover_the_grid():
    corners = list(required_corners("distributed"))
    assert {corner.modes for corner in corners} == set(MODE_COUNTS)
    assert {corner.gain for corner in corners} == {1.0, *GAINS}
    assert {corner.phase for corner in corners} == {0.0, -PHASE, PHASE}
    assert max(corner.delay for corner in corners) == DELAY["distributed"]
    full = {corner.errors for corner in corners if corner.modes == ALL_MODES}
    assert len(full) == 9  # none, and both signs of all three together


def test_more_modes_than_the_structure_has_are_refused(robust):
    with pytest.raises(InputError, match="61 modes: the structure has 60"):
        stability(robust["centralised"], Corner(modes=61))
