"""A loop in which a component would miss samples of the star tracker is refused."""

from dataclasses import replace
from fractions import Fraction
from math import lcm

import pytest

from flexbench.loop.missed_samples import missed_share, refuse_missed_samples
from lockstep import InputError, load_system
from lockstep.system.component import Shadow

MILLISECOND = 1_000_000  # [ns]


@pytest.fixture(scope="module")
def system(delivered):
    return load_system(delivered / "centralised" / "fine_pointing.ssd")


def counted(sampling: int, duration: int, period: int, shift: int) -> Fraction:
    """Return the share of samples without a read while they are flagged, by counting over many periods."""
    cycle = lcm(sampling, period)
    times = range(0, cycle, sampling)
    missed = [t for t in times if not any((at - shift) % period == 0 for at in range(t, t + duration))]
    return Fraction(len(missed), len(times))


def test_the_share_of_missed_samples_is_that_of_counting():
    for sampling in (4, 6, 7):
        for duration in (1, 2, 3):
            for period in (1, 2, 3, 5, 6):
                for shift in range(-3, 4):
                    given = sampling, duration, period, shift
                    assert missed_share(*given) == counted(*given), given


@pytest.mark.parametrize(
    ("overrides", "period", "delay"),
    [
        ({}, 5, 0),
        ({}, 10, 0),  # every second sample of the gyros, and each of the star tracker
        ({}, 5, 7),  # the flag is true for as long as the controller's period: read once, whatever the delay
        ({"sensors.fast_period": 0.001}, 5, 0),
        ({"sensors.fast_period": "0.01", "sensors.star_tracker.period": "0.2"}, 8, 0),
        ({"sensors.star_tracker.period": "soon"}, 30, 0),  # refused later, in other words
    ],
)
def test_a_loop_that_uses_every_sample_is_accepted(system, overrides, period, delay):
    changed = system.with_period("controller", period * MILLISECOND).with_delay("sensors", "controller", delay)
    refuse_missed_samples(changed, overrides)


@pytest.mark.parametrize(
    ("overrides", "period", "delay", "message"),
    [
        (
            {},
            30,
            0,
            "controller: would miss 2 of 3 star tracker samples: sensors.star_tracker.valid stays true for"
            " 0.005 s after each, every 0.1 s, and controller reads every 0.03 s; set sensors.star_tracker.period to a"
            " whole multiple of 0.03 s, or sensors.fast_period to at least 0.03 s",
        ),
        (
            {"sensors.star_tracker.period": "0.101", "sensors.fast_period": 0.001},
            5,
            0,
            "would miss 4 of 5 star tracker samples",
        ),
        ({"sensors.fast_period": 0.002}, 5, 1, "reads every 0.005 s; set sensors.fast_period to at least 0.005 s"),
    ],
)
def test_a_loop_that_would_miss_samples_is_refused(system, overrides, period, delay, message):
    changed = system.with_period("controller", period * MILLISECOND).with_delay("sensors", "controller", delay)
    with pytest.raises(InputError) as refused:
        refuse_missed_samples(changed, overrides)
    assert message in str(refused.value)


def test_a_shadow_reads_at_its_own_period(system):
    original = system.component("controller")
    slow = replace(original, name="controller_shadow", period=30 * MILLISECOND)
    shadowed = replace(original, shadow=Shadow(component=slow, period=original.period, outputs=()))
    changed = replace(system, components=(*(c for c in system.components if c != original), shadowed))

    with pytest.raises(InputError, match=r"controller_shadow: would miss 2 of 3"):
        refuse_missed_samples(changed, {})


def test_flat_names_are_judged_too(delivered):
    flat = load_system(delivered / "centralised" / "fine_pointing.ssd")
    components = tuple(replace(c, source=delivered / "centralised" / "flat" / c.source.name) for c in flat.components)
    connections = tuple(
        replace(c, output="star_tracker_valid") for c in flat.connections if c.output == "star_tracker.valid"
    )
    changed = replace(flat, components=components, connections=connections)

    with pytest.raises(InputError, match=r"sensors\.star_tracker_valid .* set sensors\.star_tracker_period to a whole"):
        refuse_missed_samples(changed.with_period("controller", 30 * MILLISECOND), {})
