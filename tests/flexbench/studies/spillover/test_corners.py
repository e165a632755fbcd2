"""Stability of both controller designs on a structure with more modes than the controller knows."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.real_plant import MODE_COUNTS, Corner, Plants, stability, table_rows
from flexbench.studies.spillover.corners import (
    DELAY,
    ERRORS,
    GAINS,
    PHASE,
    drawn_points,
    points_between,
    required_corners,
)
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.design.chain import build_design
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


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_robust_design_holds_between_the_corners(robust, name):
    """Corners do not bound what lies between them: a campaign lost 83 of 500 loops of an earlier centralised design."""
    points = [*islice(points_between(40), 2, None, 3), *drawn_points(40, 8)]
    assert len(points) == 11
    assert [found.corner.title for found in (stability(robust[name], one) for one in points) if not found.stable] == []


def test_between_the_corners_a_design_can_be_lost():
    """Weights of an earlier design: stable at the worst corner, and not with 2 % more inertia (flown: .088 1/s)."""
    now = configuration("centralised", "robust")
    before = {"mrp": 2e6, "deformation": 2e6, "null_wheel_speed": 3e-3, "torque": 10.0}
    weights = replace(now.weights, gyro_noise=15.0, encoder_noise=4.0, **before)
    plants = Plants(build_design(replace(now, weights=weights)), 40)
    found = stability(plants, Corner(modes=40, errors=ModelErrors(damping=-0.5, inertia=0.02)))
    assert found.growth == pytest.approx(0.0912, rel=0.01)  # 1/s
    assert stability(plants, Corner(modes=40, errors=WORST)).stable


def test_drawn_points_fill_the_box_of_the_errors():
    drawn = [point.errors for point in drawn_points(40, 64)]
    for name in ("frequency", "damping", "inertia"):
        largest, values = getattr(ERRORS, name), [getattr(errors, name) for errors in drawn]
        assert max(map(abs, values)) <= largest
        assert np.histogram(values, 4, (-largest, largest))[0].tolist() == [16] * 4  # Sobol points


def test_growth_is_that_of_the_loop_itself(published):
    """On the model that the controller was designed on: the spectral radius of the designed loop."""
    plants = published["centralised"]
    loop = DesignedLoop(design=plants.design).at()
    # the same structure, once built with 25 modes and once with 60: modes agree to 1e-9, poles are near the circle
    expected = np.log(loop.radius()) / loop.period
    assert stability(plants, Corner(modes=25)).growth == pytest.approx(expected, rel=1e-4)


def test_the_frequency_of_a_pole_is_no_alias_at_the_star_trackers_rate(robust):
    """With 7 times the gain the bus drives a mode of 5.9 Hz, as in FMUs (tests/bench/measured_margins.py)."""
    found = stability(robust["centralised"], Corner(modes=60, gain=7.0))
    assert not found.stable
    assert found.frequency == pytest.approx(5.92, abs=0.05)  # folded at 10 Hz: 4.08


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
