"""The static pointing error under a constant external torque, from the linear loop of a real structure."""

import numpy as np
import pytest

from flexbench.studies.margins.designed_loop import DesignedLoop
from flexbench.studies.margins.real_plant import Plants
from flexsat.description.built_in import configuration
from flexsat.design.chain import build_design
from flexsat.parameters import ARCSECOND
from flexsat.runtime.zero_order_hold import zero_order_hold
from flexsat.spacecraft.variation import ModelErrors

ERRORS = ModelErrors(frequency=0.05, inertia=0.1)  # of the plant, which the controller does not know
MODES = 27  # of the plant: more than the controller's
TORQUE = np.array([1e-3, -2e-3, 5e-4])  # N.m, on the body
DOUBLINGS = 15  # of the star tracker's period of 0.1 s: 55 min


def _settled(layout: str, **parameters: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the pointing error at a sample of the star tracker [rad], and the body torque of the wheels [N.m].

    The external torque changes the net momentum, so that the speeds of the wheels grow all the time: the loop has all
    states of the plant, and is followed until the rest of it has settled.
    """
    plants = Plants(build_design(configuration(layout, "robust")), MODES)
    model = plants.model(MODES, ERRORS)
    given = {"star_tracker.fine": True, **{f"filter.{name}": value for name, value in parameters.items()}}
    loop = DesignedLoop(design=plants.design, plant=model, parameters=given)
    loop.__dict__["_reached_model"] = model.a, model.b_torque, model.c
    opened = loop.at()
    first, rest = opened.closed()
    entering = np.zeros(len(first))
    entering[: len(model.a)] = zero_order_hold(model.a, model.b_body, opened.period)[1] @ TORQUE
    over, offset = np.eye(len(first)), np.zeros(len(first))
    for step in range(opened.steps):
        transition = rest if step else first
        over, offset = transition @ over, transition @ offset + entering
    for _ in range(DOUBLINGS):
        over, offset = over @ over, over @ offset + offset
    pointing = 4.0 * offset[model.index.mrp]
    return pointing, loop.body_axes[1] @ (opened.first.c @ offset)


@pytest.mark.parametrize("layout", ["centralised", "distributed"])
def test_a_constant_torque_leaves_no_static_error(layout):
    without, balance = _settled(layout)
    assert np.linalg.norm(without) > 0.1 * ARCSECOND  # the error of a feedback without integration
    np.testing.assert_allclose(balance, TORQUE, rtol=1e-4)  # the wheels give it in any case
    for bias in (False, True):
        pointing, balance = _settled(layout, disturbance=True, gyro_bias=bias)
        np.testing.assert_allclose(balance, TORQUE, rtol=1e-6)
        assert np.linalg.norm(pointing) < 1e-4 * np.linalg.norm(without)
