"""Histories of hand-made signals agree with closed forms."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.runs import histories
from flexsat.runtime.rotations import rotate_mrp
from lockstep import Signals

ROUNDING = 1e-12  # relative; a few dozen operations in double precision


def signals(time: Any, **arrays: Any) -> Signals:
    """Make signals; a name's double underscores stand for dots, and (rows, k) arrays become k columns."""
    columns = {}
    for key, values in arrays.items():
        name, values = key.replace("__", "."), np.asarray(values, dtype=float)
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {f"{name}[{i}]": values[:, i - 1] for i in range(1, values.shape[1] + 1)}
    return Signals(time=np.asarray(time, dtype=float), columns=columns, units={}, descriptions={})


def small_design(period: float = 0.005) -> Any:
    """Two wheels about x and y, one mode; the second wheel sits on a slope of 0.5 about its axis."""
    # state: 3 MRP, 1 eta, 3 rate, 1 eta', 2 wheels; the basis leaves the first wheel out
    weights = SimpleNamespace(
        basis=np.delete(np.eye(10), 8, axis=1),
        state_weight=np.diag(np.arange(1.0, 10.0)),
        torque_weight=np.array([[2.0, 1.0], [1.0, 4.0]]),
        modes=np.array([0]),
    )
    return SimpleNamespace(
        wheel_axis=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        wheel_axial_slope=np.array([[0.0], [0.5]]),
        modes=1,
        nominal_speed=np.array([10.0, 20.0]),
        period=period,
        known_modes=np.array([0]),
        weights=lambda: weights,
    )


def full_signals(**changed: Any) -> Signals:
    """Two rows of a spacecraft at rest at nominal wheel speed, except what is changed."""
    zero = {"attitude__mrp": 3, "modal__displacement": 1, "rate": 3, "modal__velocity": 1}
    arrays = {f"plant__{name}": np.zeros((2, k)) for name, k in zero.items()}
    names = ("mrp", "modal__displacement", "rate", "modal__velocity", "wheel__speed", "torque")
    arrays |= {
        f"controller__reference__{name}": np.zeros((2, k)) for name, k in zip(names, (3, 1, 3, 1, 2, 2), strict=True)
    }
    arrays["plant__wheel__speed"] = np.array([[10.0, 20.0], [10.0, 20.0]])
    arrays["controller__wheel__torque"] = np.zeros((2, 2))
    return signals([0.0, 0.005], **(arrays | changed))


def test_pointing_error_is_the_angle_between_the_attitudes():
    reference = (0.1, -0.2, 0.05)
    turned = [rotate_mrp(reference, axis) for axis in ((1e-6, 0.0, 0.0), (0.0, 3e-3, 4e-3))]

    found = histories.pointing_error(
        signals([0.0, 1.0], plant__attitude__mrp=turned, controller__reference__mrp=[reference] * 2)
    )

    assert_allclose(found, [1e-6, 5e-3], rtol=1e-9)  # 1e-16 of an attitude of order 1 is 1e-10 of a microradian


def test_rate_error_is_the_norm_of_the_difference():
    given = signals([0.0], plant__rate=[[1.0, 2.0, 3.0]], controller__reference__rate=[[1.0, -1.0, -1.0]])

    assert_allclose(histories.rate_error(given), [5.0], rtol=ROUNDING)


@pytest.mark.parametrize("angle", [0.0, 0.00873, -1.0, 2.5])
def test_rotation_about_x_is_the_angle_of_a_rotation_about_x(angle: float):
    mrp = [rotate_mrp((0.0, 0.0, 0.0), (angle, 0.0, 0.0))]

    assert_allclose(histories.rotation_about_x(signals([0.0], plant__attitude__mrp=mrp)), [angle], rtol=ROUNDING)
    given = signals([0.0], controller__reference__mrp=mrp)
    assert_allclose(histories.rotation_about_x(given, histories.ATTITUDE_REFERENCE), [angle], rtol=ROUNDING)


def test_rotation_about_x_is_insensitive_to_a_small_rotation_about_y():
    mrp = [rotate_mrp(rotate_mrp((0.0, 0.0, 0.0), (0.3, 0.0, 0.0)), (0.0, 1e-6, 0.0))]

    assert_allclose(histories.rotation_about_x(signals([0.0], plant__attitude__mrp=mrp)), [0.3], atol=1e-12)  # 1e-6^2


def test_torque_norm_sums_over_the_wheels_and_impulse_over_time():
    given = signals([0.0, 2.0, 3.0], controller__wheel__torque=[[1.0, -2.0], [0.0, -1.0], [5.0, 5.0]])

    assert_allclose(histories.torque_norm(given), [3.0, 1.0, 10.0], rtol=ROUNDING)
    assert_allclose(histories.torque_impulse(given), [0.0, 6.0, 7.0], rtol=ROUNDING)  # the last torque has not acted


def test_wheel_speed_deviation_adds_the_rate_of_the_mount():
    given = full_signals(
        plant__rate=[[0.1, 0.2, 0.3], [0.0, 0.0, 0.0]],
        plant__modal__velocity=[[0.0], [2.0]],
        plant__wheel__speed=[[10.0, 20.0], [11.0, 20.0]],
    )

    assert_allclose(
        histories.wheel_speed_deviation(given, small_design()), [[0.1, 0.2], [1.0, 0.5 * 2.0]], rtol=ROUNDING
    )


def test_cost_is_zero_on_the_reference():
    given = full_signals(
        plant__modal__displacement=[[3.0], [4.0]],
        controller__reference__modal__displacement=[[3.0], [4.0]],
        controller__wheel__torque=[[1.0, 1.0], [2.0, 2.0]],
        controller__reference__torque=[[1.0, 1.0], [2.0, 2.0]],
    )

    total, control = histories.lqr_cost(given, small_design())

    assert_allclose(total, 0.0, atol=0.0)
    assert_allclose(control, 0.0, atol=0.0)


def test_cost_of_a_hand_made_state():
    given = full_signals(
        plant__attitude__mrp=[[0.0, 0.5, 0.0], [0.0, 0.0, 0.0]],  # weight 2, of a quarter of the angle: atan of it
        plant__rate=[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]],  # weight 5; turns the first wheel, which is left out
        plant__wheel__speed=[[10.0, 20.0], [10.0, 22.0]],  # weight 9
        controller__reference__wheel__speed=[[0.0, 0.0], [0.0, 1.0]],
        controller__wheel__torque=[[0.0, 0.0], [1.0, 3.0]],
        controller__reference__torque=[[0.0, 0.0], [0.0, 1.0]],
    )

    total, control = histories.lqr_cost(given, small_design())

    du = 0.5 * (2.0 * 1.0 + 2.0 * 1.0 * 1.0 * 2.0 + 4.0 * 2.0**2)
    assert_allclose(control, [0.0, du], rtol=ROUNDING)
    assert_allclose(total, [0.5 * 2.0 * np.arctan(0.5) ** 2, 0.5 * (5.0 * 3.0**2 + 9.0 * 1.0**2) + du], rtol=ROUNDING)


def test_controller_rows_are_the_samples_of_the_controller():
    time = np.arange(11) * 0.001
    assert list(time[histories.controller_rows(signals(time), small_design())]) == [0.0, 0.005, 0.01]
    assert histories.controller_rows(signals([0.0, 0.005, 0.01]), small_design()) == slice(None, None, 1)


@pytest.mark.parametrize("interval", [0.01, 0.002])
def test_record_period_that_does_not_divide_the_controller_period_is_refused(interval: float):
    with pytest.raises(ValueError, match=r"record period .* must divide the controller's period of 0\.005 s"):
        histories.controller_rows(signals([0.0, interval, 2.0 * interval]), small_design())


def test_modes_that_the_controller_does_not_know_are_no_part_of_its_cost():
    """Three modes in the plant, of which the controller knows the last; a fourth port of the plant has no mode."""
    design = small_design()
    design.modes, design.wheel_axial_slope = 3, np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    design.known_modes = np.array([2])
    more = full_signals(
        plant__modal__displacement=np.tile([7.0, 8.0, 0.5, 9.0], (2, 1)),
        plant__modal__velocity=np.tile([2.0, 0.0, 0.0, 9.0], (2, 1)),
    )
    known = histories.regulated_error(more, design)

    # MRP, eta, rate, eta', and of the wheels the second, whose mount turns by 0.5 x 2
    assert_allclose(known, np.tile([0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0], (2, 1)), rtol=ROUNDING)
