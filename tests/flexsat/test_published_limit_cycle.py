"""The published design on a structure with more modes than it knows: a limit cycle (PHYSICS section 9)."""

import numpy as np
import pytest

from flexsat.closed_loop import ClosedLoop
from flexsat.description.built_in import configuration
from flexsat.design.chain import Designs, build_design
from flexsat.spacecraft.variation import with_modes
from flexsat.variants import VARIANTS

FINE_POINTING = {
    "plant": {"seed": 1},
    "sensors": {"seed": 1, "star_tracker.fine": True, "jitter.enabled": True},
    "controller": {"design": "published", "star_tracker.fine": True, "jitter.feed_forward": True},
}
STOP, LAST = 20.0, 5.0  # s


def torque(name, modes):
    """Return the RMS over the last seconds of the sum of |torque| over the wheels [N.m]."""
    design = build_design(with_modes(configuration(name, "published"), modes))
    designs = Designs(dict.fromkeys(VARIANTS, design))
    run = ClosedLoop(designs, FINE_POINTING).run(STOP, ["controller.wheel.torque"])
    total = np.abs(run.signals["controller.wheel.torque"][run.time > STOP - LAST]).sum(axis=1)
    return float(np.sqrt(np.mean(total**2)))


# with 28 modes the centralised layout is quiet for longer than this run, at the wheel speeds that are quiet on them
@pytest.mark.parametrize(("name", "modes"), [("distributed", 28), ("centralised", 40)])
def test_modes_that_it_does_not_know_drive_the_published_design_to_the_limits_of_its_wheels(name, modes):
    assert torque(name, modes) > 5.0


def test_on_the_modes_that_it_knows_it_is_quiet():
    assert torque("centralised", 25) < 0.2  # PHYSICS section 9: .091
