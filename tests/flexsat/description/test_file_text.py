"""A spacecraft in Python becomes a file that describes the same spacecraft, to the last bit of each number."""

from dataclasses import replace

import pytest

from flexsat.controller_weights import Weights
from flexsat.description.built_in import CONFIGURATIONS, configuration
from flexsat.description.configuration import Configuration
from flexsat.description.file_text import file_of
from flexsat.description.placement import ALONG, Bus, Device, Site, direction
from flexsat.parameters import Harmonic, Modes, SensorErrors, Wheel


def pyramid(**changes):
    """Return a spacecraft with two kinds of wheels."""
    small = Wheel(inertia=0.1 + 0.2, speed_limit=100.0, full_torque_speed=1.0 / 3.0, torque_step=1e-3,
                  harmonics=(Harmonic(order=2.0, force=1e-7, phase=0.1), Harmonic(order=3.9, torque=1e-7)))  # fmt: skip
    vectors = ((1.0, 0.0, 1.0), (0.0, -1.0, -1.0), (-1.0, 0.0, 1.0), (0.3, 1.0, -1.0))
    given = Configuration(
        name="mine",
        layout='four "wheels"',
        wheel=Wheel().scaled(3.0),
        weights=Weights(mrp=2e6, torque=0.7),
        sites=(Site(name="tip", radius=14.176, angle=60.0), Site(name="top", on_bus=(0.0, 0.1, -0.2))),
        wheels=tuple(Device(site="bus", axis=direction(v), wheel=small if v[0] else None) for v in vectors),
        gyros=tuple(Device(site="tip", axis=ALONG[name]) for name in ("+x", "-y")),
        accelerometers=(Device(site="top", axis=ALONG["+z"]),),
        bus=Bus(mass=800.0, inertia=(500.0, 500.0, 600.0, 1.0, 0.0, 0.0)),
        modes=Modes(plant=12, design=7),
        sensor_errors=SensorErrors(gyro_bias=1e-7, boresight=(0.0, 0.6, 0.8)),
    )
    return replace(given, **changes)


def test_a_spacecraft_and_its_file_are_the_same():
    robust, published = pyramid(), pyramid(weights=Weights(mrp=1e6))
    found = file_of(robust, published)
    assert found.configurations["robust"].weights == robust.weights
    assert found.configurations["published"].weights == published.weights
    one = found.configurations["robust"]
    assert one == robust
    kinds = tuple(replace(device, wheel=device.wheel or Wheel()) for device in robust.wheels)
    assert file_of(pyramid(wheels=kinds)).configurations["robust"] == pyramid(wheels=kinds, wheel=Wheel())


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_the_built_in_spacecraft_survive(name):
    given = configuration(name, "robust"), configuration(name, "published")
    assert tuple(file_of(*given).configurations[key] for key in ("robust", "published")) == given


def test_what_is_no_spacecraft_is_refused():
    with pytest.raises(ValueError, match="may differ in their weights alone; they, or a file, have another bus"):
        file_of(pyramid(), pyramid(bus=Bus()))
    with pytest.raises(ValueError, match=r"sites.tip: 13 m at 0 deg: no mesh node"):
        file_of(pyramid(sites=(Site(name="tip", radius=13.0), pyramid().sites[1])))
