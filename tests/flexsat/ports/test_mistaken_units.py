"""A number in another unit than that of its port is out of the port's range, where the two are far apart."""

import pytest

from flexsat.closed_loop import PORTS


@pytest.mark.parametrize(
    ("component", "name", "mistaken"),
    [
        ("sensors", "star_tracker.noise_fine", 0.1),  # arcsec
        ("sensors", "star_tracker.noise_coarse", 10.0),  # arcsec
        ("sensors", "gyro.noise", 0.1),  # deg/s
        ("plant", "initial.attitude_deviation", 0.1),  # arcsec
        ("plant", "initial.rate", 1.0),  # deg/s
        ("plant", "dispersion.frequency", 2.0),  # %
        ("plant", "dispersion.inertia", 10.0),  # %
        ("plant", "dispersion.damping", 50.0),  # %
        ("controller", "delay.measurement", 5.0),  # ms
    ],
)
def test_a_number_in_another_unit_than_that_of_the_port_is_refused(centralised, component, name, mistaken):
    port = next(p for p in PORTS[component](getattr(centralised, component)) if p.name == name)

    assert port.objection(mistaken) == f"must be <= {port.maximum!r}, got {mistaken}"
    assert port.objection(port.starts[0]) is None
    assert port.maximum <= mistaken / 2.0
