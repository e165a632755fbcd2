"""Gain, phase and delay margins of the robust design: whole co-simulations with the plant's inputs changed.

With native FMUs, and all 198 modes. The required delays are in test_robust_design.py; more changes, and longer runs
that resolve each line of the spectrum, in tests/bench/measured_margins.py.
"""

import pytest

from flexbench.loop.native_fmus import with_native_fmus
from flexbench.studies.margins.changed_loop import Change, changed_system, fly
from flexbench.studies.margins.system_loop import read_loop
from flexbench.studies.spillover.corners import GAINS, PHASE
from lockstep import InputError, load_system

SHORT = {"settle": 2.0, "window": 3.0}  # s: what is unstable here grows by a third a second or more


def loop_of(fmus, name):
    return read_loop(with_native_fmus(load_system(fmus / name / "fine_pointing.ssd")), {})


@pytest.mark.slow
@pytest.mark.parametrize("name", ["centralised", "distributed"])
@pytest.mark.parametrize("change", [Change(gain=GAINS[1]), Change(phase=PHASE)], ids=["gain", "phase"])
def test_motion_decays_within_the_required_margins(fmus, tmp_path, name, change):
    assert fly(loop_of(fmus, name), change, tmp_path / "run", **SHORT).total < -0.02  # modes decay by 0.02 /s at least


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "change"), [("centralised", Change(gain=10.0)), ("distributed", Change(delay=0.1))], ids=["gain", "delay"]
)
def test_motion_grows_beyond_the_margins(fmus, tmp_path, name, change):
    """Linear analysis: unstable from a gain of 6.5 (growth 0.42 /s at 10), and from 25 ms (0.22 /s at 100 ms)."""
    assert fly(loop_of(fmus, name), change, tmp_path / "run", **SHORT).total > 0.1


def test_a_phase_is_a_rotation_between_two_copies_of_the_loop(fmus):
    system = changed_system(loop_of(fmus, "centralised"), Change(gain=2.0, phase=30.0))
    shares = {(c.from_component, c.input): c.factor for c in system.connections if c.to_component == "phase_shift"}
    assert len(shares) == 6 * 4  # six wheels
    first = "wheel.torque[1]"
    assert shares["controller", f"{first}.real"] == pytest.approx(3.0**0.5)
    assert shares["controller_imaginary", f"{first}.imaginary"] == pytest.approx(-1.0)
    assert shares["controller", f"{first}_imaginary.real"] == pytest.approx(1.0)
    assert shares["controller_imaginary", f"{first}_imaginary.imaginary"] == pytest.approx(3.0**0.5)


def test_a_delay_between_ticks_is_refused(fmus):
    with pytest.raises(InputError, match=r"delay 0\.5 ms: the delay must be a whole multiple of the tick, 0\.001 s"):
        changed_system(loop_of(fmus, "centralised"), Change(delay=0.0005))
