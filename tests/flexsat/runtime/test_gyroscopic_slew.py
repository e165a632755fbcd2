"""Slews of a spacecraft whose wheels have a net momentum: the feed-forward holds it in inertial space."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexsat.closed_loop import ClosedLoop, port_values
from flexsat.description.built_in import configuration
from flexsat.description.placement import ALONG, Bus, Device, direction
from flexsat.design.chain import build_design, designs_of
from flexsat.parameters import ARCSECOND, Modes, SensorNoise, Wheel
from flexsat.ports.controller import parameters, ports
from flexsat.runtime import controller
from flexsat.runtime.rotations import matrix_from_mrp

QUIET = SensorNoise(gyro=1e-12, accelerometer=1e-9, encoder=1e-9, star_tracker_coarse=1e-10, star_tracker_fine=1e-10)


@pytest.fixture(scope="module")
def config():
    """Return four unequal wheels that all turn the same way about z, and a stiff structure of twelve modes."""
    large, small = Wheel().scaled(5.5), Wheel(speed_band=4.0).scaled(3.0)
    vectors = {(1.0, 0.0, 1.0): large, (-1.0, 0.0, 1.0): large, (0.0, 1.0, 1.0): small, (0.0, -1.0, 1.0): small}
    given = configuration("centralised")
    return replace(
        given,
        name="biased",
        release=None,
        modes=Modes(plant=8, design=8),
        bus=Bus(mass=800.0, inertia=(500.0, 500.0, 600.0, 0.0, 0.0, 0.0)),
        wheels=tuple(Device(site="bus", axis=direction(v), wheel=wheel) for v, wheel in vectors.items()),
        gyros=tuple(Device(site="bus", axis=ALONG[name]) for name in ("+x", "+y", "+z")),
        noise=QUIET,
        weights=replace(given.weights, jitter_cancellation=0.0, gyro_noise=1.0),
    )


def test_the_wheels_keep_the_momentum_where_it_was(config):
    """The reference alone: momentum of body and wheels, turned to inertial axes by the reference attitude, stays."""
    design = build_design(config)
    matrices = design.controller
    net = matrices.wheel_axis.T @ (matrices.wheel_inertia * matrices.nominal_speed)
    assert np.linalg.norm(net) > 200.0  # N.m.s
    values = port_values("controller", ports(matrices), {"slew.gyroscopic": True})
    prepared = controller.prepare(matrices, parameters(matrices, values.__getitem__))
    state = controller.init(prepared, np.array([8e-4, -4e-4, 2e-4]), 2.0)
    still = controller.Measurements(
        np.zeros(3), np.zeros(matrices.accelerometers), matrices.nominal_speed, np.zeros(4), np.zeros(3), False
    )
    rows = []
    for k in range(5000):
        out = controller.step(prepared, state, 5e-3 * k, still)
        rows.append(np.concatenate([out.reference, out.reference_torque]))
    seen, m = np.array(rows[::20]), matrices.modes
    speed = matrices.nominal_speed + seen[:, 6 + 2 * m : 10 + 2 * m]
    coupling = seen[:, 6 + m : 6 + 2 * m] @ design.spacecraft.rotation.T
    body = seen[:, 3 + m : 6 + m] @ matrices.inertia.T + coupling
    body += (matrices.wheel_inertia * speed) @ matrices.wheel_axis
    attitudes = [matrix_from_mrp(mrp) for mrp in seen[:, :3].tolist()]
    momentum = np.array([attitude.T @ one for attitude, one in zip(attitudes, body, strict=True)])
    turned = np.linalg.norm(body - body[0], axis=1).max()
    assert turned > 0.05  # N.m.s: in the body it turns by angle times momentum
    # the torque is held over 5 ms and counts the momentum at their beginnings
    assert_allclose(momentum, np.broadcast_to(net, momentum.shape), atol=0.02 * turned)
    assert not seen[-1, 10 + 2 * m :].any()  # it ends with the slew


def test_the_body_follows_closer_by_an_order(config):
    """Pointing error in a slew without noise and jitter, with and without the torque counted."""
    errors = {}
    for counted in (False, True):
        values = {"command.rotation": np.array([1e-3, 0.0, 0.0]), "command.start_time": 2.0, "slew.gyroscopic": counted}
        loop = ClosedLoop(designs_of(config, config), {"controller": values, "sensors": {"jitter.enabled": False},
                                                       "plant": {"initial.random_wheel_phases": False}})  # fmt: skip
        seen = loop.run(15.0, ["plant.attitude.mrp", "controller.reference.mrp"], 25).signals
        off = 4.0 * np.linalg.norm(seen["plant.attitude.mrp"] - seen["controller.reference.mrp"], axis=1)
        errors[counted] = off.max() / ARCSECOND
    assert errors[False] > 0.5
    assert errors[True] < 0.1 * errors[False]


def test_a_smoothed_reference_refuses_it(centralised, flight):
    with pytest.raises(ValueError, match=r"slew.gyroscopic: the smoothed reference has no wheel speeds that follow it"):
        controller.prepare(centralised.controller, flight(centralised, gyroscopic=True, smoothed=True))
