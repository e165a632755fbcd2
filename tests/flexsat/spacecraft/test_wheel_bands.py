"""Speed bands between crossings of the Campbell diagram, and a wheel that null motion keeps away from one."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from flexbench.loop.properties import properties_of, property_lines
from flexsat.closed_loop import ClosedLoop
from flexsat.description.spacecraft_file import SpacecraftFile
from flexsat.design.chain import designs_of
from flexsat.parameters import RPM, SpeedSelection
from flexsat.spacecraft.assembly import build_spacecraft
from flexsat.spacecraft.campbell_crossings import modal_frequencies
from flexsat.spacecraft.wheel_bands import choose_bands

SPEEDS = """\
[speeds]
lowest = "310 rpm"
highest = "345 rpm"
avoid_crossings = true
clearance = "1 rpm"
window = "10 rpm"
"""


@pytest.fixture(scope="module")
def banded(pyramid) -> SpacecraftFile:
    """Modes of 5.45 and 6.49 Hz, free: at 327 and 390 rpm."""
    return pyramid((5.0, 6.0), "", 'harmonics = [{ order = 2.0, force = "2e-8 N/rpm2" }]', SPEEDS)


def chosen(banded, **speeds):
    config = banded.configurations["robust"]
    config = replace(config, speeds=replace(config.speeds, **speeds))
    return choose_bands(config, build_spacecraft(config))


def test_a_band_that_no_gap_holds_is_what_the_widest_leaves(banded):
    """25 rpm either side do not fit between the ends of the range and the crossing at 327 rpm."""
    found = chosen(banded)
    (low, high), nominal = found.response.gap[0] / RPM, found.response.nominal[0]
    at = low * RPM
    assert np.abs(modal_frequencies(found.spacecraft, np.array([at]))[:, 0] - at).min() < 1e-4  # straight between
    assert high == pytest.approx(345.0)
    assert nominal / RPM == pytest.approx(0.5 * (low + 1.0 + 345.0), abs=1e-6)
    band = found.spacecraft.wheel_set.speed_band
    assert band[0] / RPM == pytest.approx(0.5 * (345.0 - low - 1.0), abs=1e-6)
    assert_array_equal([device.wheel.speed_band for device in found.config.wheels], band)


def test_a_band_of_the_file_is_kept_where_a_gap_holds_it(banded):
    """Up to 600 rpm: the quietest speeds with 25 rpm and the clearance either side free of crossings."""
    free = chosen(banded, lowest=200.0 / 60.0, highest=10.0)
    assert_allclose(free.spacecraft.wheel_set.speed_band, 25.0 * RPM)
    for k, (nominal, band) in enumerate(zip(free.response.nominal, free.spacecraft.wheel_set.speed_band, strict=True)):
        for order in (1.0, 2.0) if k == 4 else (1.0,):
            speeds = np.linspace(nominal - band - RPM, nominal + band + RPM, 7)
            beside = modal_frequencies(free.spacecraft, speeds) - order * speeds
            assert np.all(beside[:, 0] * beside[:, -1] > 0.0), f"order {order} of wheel {k + 1}"
    # without, the whole of that band is weighed, and no crossing is looked for
    plain = chosen(banded, lowest=200.0 / 60.0, highest=10.0, avoid_crossings=False, clearance=5.0 / 60.0)
    assert plain.response.gap is None
    assert plain.config.wheels == banded.configurations["robust"].wheels


def test_harmonics_of_one_wheel_have_crossings_of_their_own(banded):
    """Only the fifth wheel has a second harmonic, which meets both modes at half their speeds."""
    found = chosen(banded, lowest=150.0 / 60.0, highest=200.0 / 60.0)
    assert_allclose(found.response.gap[0] / RPM, [150.0, 200.0])
    ends = found.response.gap[4] / RPM
    assert_allclose(ends, [163.5, 194.8], atol=0.3)
    # where the first harmonic counts too, the second is a weak one
    strong = chosen(banded, lowest=150.0 / 60.0, highest=340.0 / 60.0, crossing_response=0.9)
    assert_allclose(strong.response.gap[4] / RPM, [150.0, 327.0], atol=0.1)


def test_no_gap_is_refused_with_what_there_is(banded):
    with pytest.raises(ValueError, match=r"clearance of 20 rpm leaves wheel 1 no speeds: its widest gap .* is 18.0"):
        chosen(banded, clearance=20.0 / 60.0)


def test_spacecraft_lists_bands_and_gaps(banded):
    lines = list(property_lines(properties_of(banded, "banded.toml")))
    assert any(line.startswith("wheels 1, 2, 3, 4, 5: 336.5 +-8.5 rpm, between 327.0 and 345.0 rpm") for line in lines)


def test_null_motion_keeps_a_wheel_away_from_a_crossing_that_it_meets_without(banded):
    """A torque along one wheel's axis that slows it, for 6 s: least squares give it most of the momentum."""
    configurations = banded.configurations
    designs = designs_of(configurations["robust"], configurations["published"])
    wheels = designs.corrected.spacecraft.wheel_set
    crossing = designs.corrected.response.gap[0, 0]
    torque = -0.055 * np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    speed = {}
    for rate, band in ((1.0, None), (0.0, 50.0 * RPM)):  # without, with a band that knows of no crossing
        controller = {"wheel.null_motion_rate": rate, "star_tracker.fine": True}
        parameters = {
            "plant": {"external.torque": torque},
            "sensors": {"jitter.enabled": False},
            "controller": controller if band is None else controller | {"wheel.speed_band": band},
        }
        speed[rate] = ClosedLoop(designs, parameters).run(6.0, ["plant.wheel.speed"], 20).signals["plant.wheel.speed"]
    share = (speed[1.0] - designs.corrected.response.nominal) / wheels.speed_band
    assert np.abs(share).max() < 0.999
    assert speed[1.0][:, :4].min() > crossing + RPM
    assert speed[0.0][:, 0].min() < crossing - 0.5 * RPM
    # the body's torque is taken either way: both have the same momentum
    held = {rate: ((one - one[0]) * wheels.inertia) @ designs.corrected.spacecraft.wheels.axis
            for rate, one in speed.items()}  # fmt: skip
    assert_allclose(held[1.0], held[0.0], atol=2e-2 * np.abs(held[0.0]).max())


@pytest.mark.parametrize("name", ["clearance", "crossing_response"])
def test_what_would_have_no_effect_is_refused(name):
    with pytest.raises(ValueError, match=rf"SpeedSelection\.{name} is 0\.2, without effect: set avoid_crossings"):
        SpeedSelection(**{name: 0.2})
    assert getattr(SpeedSelection(avoid_crossings=True, **{name: 0.2}), name) == 0.2
