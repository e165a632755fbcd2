"""Metrics of hand-made signals agree with closed forms."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.runs.metrics import Windows, compute_metrics, root_mean_square, settling_time
from flexsat.variants import AS_PUBLISHED
from lockstep import InputError, Signals

ROUNDING = 1e-9  # relative; a sum over some thousand rows, and mrp to angle and back
INTERVAL = 0.1  # s, of the controller too
TIME = np.round(np.arange(3000) * INTERVAL, 9)  # 0 to 299.9 s
STEADY = 1499  # rows after 150 s
FINE, SLEW = Windows(slew_end=None), Windows(slew_end=100.0)
SLEW_AS_PUBLISHED = Windows(slew_end=100.0, variant=AS_PUBLISHED)
SINE = np.sin(2.0 * np.pi * TIME / 10.0)  # zero at 75 s and at 150 s


def spacecraft() -> Any:
    """Return a design of two wheels and one mode, with a regulator that weighs each state once and torque twice."""
    weights = SimpleNamespace(
        basis=np.eye(10), state_weight=np.eye(10), torque_weight=2.0 * np.eye(2), modes=np.array([0])
    )
    return SimpleNamespace(
        wheel_axis=np.eye(3)[:2],
        wheel_axial_slope=np.zeros((2, 1)),
        modes=1,
        nominal_speed=np.array([10.0, 20.0]),
        period=INTERVAL,
        cost=weights,
        known_modes=np.array([0]),
        weights=lambda: weights,
    )


def recorded(time: Any = TIME, **changed: Any) -> Signals:
    """Return a run at rest on its reference, but for what is changed."""
    rows = len(time)
    columns = {
        "plant.attitude.mrp": np.zeros((rows, 3)),
        "plant.modal.displacement": np.zeros((rows, 1)),
        "plant.rate": np.zeros((rows, 3)),
        "plant.modal.velocity": np.zeros((rows, 1)),
        "plant.wheel.speed": np.tile([10.0, 20.0], (rows, 1)),
        "plant.rms_deformation": np.zeros(rows),
        "controller.wheel.torque": np.zeros((rows, 2)),
    }
    names = {"mrp": 3, "modal.displacement": 1, "rate": 3, "modal.velocity": 1, "wheel.speed": 2, "torque": 2}
    columns |= {f"controller.reference.{name}": np.zeros((rows, size)) for name, size in names.items()}
    columns |= changed
    flat = {}
    for name, values in columns.items():
        if values.ndim == 1:
            flat[name] = values
        else:
            flat |= {f"{name}[{i + 1}]": values[:, i] for i in range(values.shape[1])}
    return Signals(time=np.asarray(time), columns=flat, units={}, descriptions={})


def along(axis: int, history: Any, size: int = 3) -> Any:
    """Return an array that is a history along one axis and zero along the others."""
    return np.outer(history, np.eye(size)[axis])


def test_root_mean_square_of_a_sine():
    assert_allclose(root_mean_square(7.0 * SINE), 7.0 / np.sqrt(2.0), rtol=ROUNDING)  # whole periods


def test_a_run_on_its_reference_has_no_errors():
    assert set(compute_metrics(recorded(), spacecraft(), SLEW).values()) == {0.0}


def test_pointing_rate_and_deformation_are_rms_over_the_steady_part():
    # angle 4 x MRP; large before 150 s, which is not counted
    factor = np.where(TIME > 150.0, 1.0, 100.0)
    signals = recorded(
        **{
            "plant.attitude.mrp": along(0, 0.25 * 3e-6 * SINE * factor),
            "plant.rate": along(1, 5e-7 * SINE * factor),
            "controller.reference.rate": along(2, 0.0 * SINE),
            "plant.rms_deformation": 2e-7 * np.abs(SINE) * factor,
        }
    )

    metrics = compute_metrics(signals, spacecraft(), FINE)

    rms = np.sqrt(750.0 / STEADY)  # 15 periods of 100 rows; the first of these rows, a zero, is not counted
    assert_allclose(metrics["pointing_error"], 3e-6 * rms, rtol=ROUNDING)
    assert_allclose(metrics["rate_error"], 5e-7 * rms, rtol=ROUNDING)
    assert_allclose(metrics["deformation"], 2e-7 * rms, rtol=ROUNDING)
    assert "settling_time" not in metrics


def test_published_definitions_of_a_slew_use_75_to_150_s_and_divide_by_root_two():
    inside = (TIME > 75.0) & (TIME < 150.0)
    signals = recorded(
        **{
            "plant.rate": along(0, 5e-7 * SINE * inside),
            "plant.rms_deformation": 2e-7 * np.abs(SINE) * inside,
            "plant.attitude.mrp": along(0, 0.25e-6 * SINE * inside),
        }
    )

    published = compute_metrics(signals, spacecraft(), SLEW_AS_PUBLISHED)
    corrected = compute_metrics(signals, spacecraft(), SLEW)

    rms = np.sqrt(375.0 / 749.0) / np.sqrt(2.0)  # 7.5 periods, without the zeros at both ends
    assert_allclose(published["rate_error"], 5e-7 * rms, rtol=ROUNDING)
    assert_allclose(published["deformation"], 2e-7 * rms, rtol=ROUNDING)
    assert (published["pointing_error"], corrected["rate_error"], corrected["deformation"]) == (0.0, 0.0, 0.0)


def test_published_definitions_of_fine_pointing_use_the_same_windows():
    signals = recorded(**{"plant.rms_deformation": 1e-7 * np.abs(SINE)})
    published = compute_metrics(signals, spacecraft(), Windows(slew_end=None, variant=AS_PUBLISHED))

    assert published == compute_metrics(signals, spacecraft(), FINE)


def test_torque_is_the_rms_of_the_sum_over_the_wheels():
    signals = recorded(**{"controller.wheel.torque": np.outer(np.where(TIME > 150.0, 0.5, 9.0), [1.0, -3.0])})

    assert_allclose(compute_metrics(signals, spacecraft(), FINE)["torque"], 2.0, rtol=ROUNDING)


def test_cost_is_the_sum_over_the_whole_run():
    signals = recorded(
        **{
            "plant.modal.displacement": np.full((3000, 1), 0.5),
            "controller.wheel.torque": np.full((3000, 2), 0.1),
            "controller.reference.torque": np.tile([0.1, 0.0], (3000, 1)),
        }
    )

    metrics = compute_metrics(signals, spacecraft(), FINE)

    assert_allclose(metrics["control_cost"], 3000 * 0.5 * 2.0 * 0.1**2, rtol=ROUNDING)
    assert_allclose(metrics["total_cost"], 3000 * 0.5 * (0.5**2 + 2.0 * 0.1**2), rtol=ROUNDING)


def test_cost_counts_only_the_samples_of_the_controller():
    signals = recorded(**{"controller.wheel.torque": np.full((3000, 2), 0.1)})
    slower = spacecraft()
    slower.period = 5.0 * INTERVAL
    ratio = [compute_metrics(signals, design, FINE)["control_cost"] for design in (spacecraft(), slower)]

    assert_allclose(ratio[0] / ratio[1], 5.0, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("last_above", "since", "expected"),
    [(120.0, 100.0, 20.0), (90.0, 100.0, 0.0), (0.0, 100.0, 0.0), (240.0, 5.0, 235)],
)
def test_settling_time_is_from_the_end_of_the_slew_to_the_last_large_error(last_above, since, expected):
    error = np.where(last_above >= TIME, 1.0, 0.1)  # 3 RMS of the last 50 s: 0.3

    assert_allclose(settling_time(TIME, error, since), expected, atol=1e-9)


@pytest.mark.parametrize(("size", "expected"), [(0.299, 0.0), (0.301, 60.0)])
def test_settling_limit_is_three_rms_of_the_last_50_s(size, expected):
    error = np.full(len(TIME), 0.1)
    error[TIME == 160.0] = size

    assert_allclose(settling_time(TIME, error, 100.0), expected, atol=1e-9)


def test_settling_time_of_a_zero_error_is_zero():
    assert settling_time(TIME, np.zeros(len(TIME)), 100.0) == 0.0


@pytest.mark.parametrize("rows", [2, 1501])
def test_a_run_without_a_steady_part_is_refused(rows):
    with pytest.raises(InputError, match=r"the run ends at .* s, and they refer to t > 150 s; simulate longer"):
        compute_metrics(recorded(TIME[:rows]), spacecraft(), FINE)


def test_a_missing_signal_is_named():
    signals = recorded()
    columns = {name: values for name, values in signals.columns.items() if name != "plant.rms_deformation"}

    with pytest.raises(InputError, match=r"plant\.rms_deformation: not recorded"):
        compute_metrics(Signals(time=TIME, columns=columns, units={}, descriptions={}), spacecraft(), FINE)


def test_a_run_whose_slew_ends_in_the_steady_part_is_none_of_the_papers():
    """It printed a settling time of 0."""
    with pytest.raises(InputError, match=r"refer to t > 150 s, and the slew ends at 350\.9 s"):
        compute_metrics(recorded(), spacecraft(), Windows(slew_end=350.9))


def test_a_controller_of_others_has_no_cost():
    design = spacecraft()
    design.cost = None
    assert set(compute_metrics(recorded(), design, FINE)) == {"pointing_error", "torque", "rate_error", "deformation"}
