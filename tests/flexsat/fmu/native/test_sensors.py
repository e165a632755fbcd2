"""The native sensors against the Python stepper: outputs, noise, messages, saved states."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from flexsat.ports import sensors as interface
from flexsat.runtime import sensors
from flexsat.runtime.sensor_parameters import SensorMatrices
from flexsat.variants import chosen_by
from fmus.native.twin import Twin

STEP = 1e-3  # s
OUTPUTS = {
    "gyro.rate": "gyro_rate",
    "accelerometer.acceleration": "accelerometer",
    "encoder.speed": "encoder_speed",
    "encoder.angle": "encoder_angle",
    "star_tracker.quaternion": "star_tracker_quaternion",
    "star_tracker.mrp": "star_tracker_mrp",
    "star_tracker.valid": "star_tracker_valid",
}
WRENCH = [f"jitter.{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz"]


@pytest.fixture(scope="module", params=["centralised", "distributed"])
def variants(request: pytest.FixtureRequest) -> dict[str, SensorMatrices]:
    """Return matrices of the size of a layout: six wheels on one mount, or three on each of eleven."""
    mounts, on_each = (1, 6) if request.param == "centralised" else (11, 3)
    random = np.random.default_rng(1)
    wheels, further = mounts * on_each, mounts // 4  # harmonics: none, or two
    axes = np.random.default_rng(2).normal(size=(2 * mounts + 1, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    wrench = random.normal(size=(6, mounts, 4, mounts, on_each)) * np.eye(mounts)[:, None, :, None]
    corrected = SensorMatrices(
        nominal_speed=random.uniform(20.0, 80.0, wheels),
        wrench_of_jitter=wrench.reshape(6 * mounts, 4 * wheels),
        gyros=2 * mounts + 1,
        accelerometers=mounts + 2,
        gyro_axis=axes,
        rate_of_gyros=np.linalg.pinv(axes),
        gyro_bias=0.0,
        gyro_bias_walk=0.0,
        gyro_scale_error=0.0,
        gyro_misalignment=0.0,
        accelerometer_bias=0.0,
        star_tracker_misalignment=np.zeros(3),
        low_frequency_error=0.0,
        low_frequency_time=1e3,
        boresight=np.array([0.0, 0.0, 1.0]),
        roll_factor=1.0,
        gyro_noise=2e-7,
        gyro_noise_factor=random.uniform(0.3, 1.0, 2 * mounts + 1),
        gyro_mounting_error=np.zeros((3, 2 * mounts + 1)),
        accelerometer_noise=2e-5,
        encoder_noise=3e-4,
        star_tracker_coarse=5e-5,
        star_tracker_fine=5e-7,
        filter_frequency=80.0,
        imbalance_force=8.6e-6,
        imbalance_torque=3.5e-6,
        broadband_force=1.6e-3,
        broadband_torque=6.4e-4,
        **{f"{name}_factor": random.uniform(0.0, 1.0, wheels) for name in interface.JITTER_NUMBERS},
        harmonic_order=random.uniform(0.5, 6.0, (further, wheels)),
        harmonic_force=random.uniform(0.0, 1e-5, (further, wheels)),
        harmonic_torque=random.uniform(0.0, 1e-5, (further, wheels)),
        harmonic_phase=random.uniform(-3.0, 3.0, (further, wheels)),
        step_size=STEP,
        fast_period=5e-3,
        star_tracker_period=0.1,
    )
    return {
        "corrected": corrected,
        "as_published": replace(corrected, nominal_speed=1.1 * corrected.nominal_speed),
    }


@pytest.fixture(scope="module")
def made(compiled: Callable[..., Path], variants: dict[str, SensorMatrices]) -> Iterator[Callable[..., Twin]]:
    """Return a maker of instances."""
    matrices = variants["corrected"]
    ports = interface.ports(matrices)
    library = compiled(f"{len(matrices.nominal_speed)}-wheels", "sensors", ports, variants)
    instances: list[Twin] = []

    def make(**values: Any) -> Twin:
        instances.append(Twin(library, ports, **values))
        return instances[-1]

    yield make
    for instance in instances:
        instance.close()


def truth(twin: Twin, k: int) -> None:
    """Set the inputs of step k: everything moves, with other phases."""
    for place, name in enumerate(interface.TRUTH):
        view = twin.view(name)
        view[:] = np.sin(0.01 * k * (1.0 + place) + np.arange(view.size))
    twin.view("wheel.speed")[:] *= 60.0
    twin.view("wheel.angle")[:] *= 1e3
    twin.view("attitude.quaternion")[:] /= np.linalg.norm(twin.view("attitude.quaternion"))


def value_of(twin: Twin) -> Callable[[str], Any]:
    """Return what gives the value of a port of an instance."""
    sizes = {port.name: port.size for port in twin.table}
    return lambda name: twin.view(name)[0].item() if sizes[name] is None else twin.view(name).copy()


@pytest.mark.parametrize(
    "values",
    [
        {"seed": 7},
        {"seed": 2**31 - 1, "as_published": True, "star_tracker__fine": True, "step_size": STEP},
        {"jitter__enabled": False, "fast_period": 2e-3, "star_tracker__period": 6e-3},
        {
            "gyro__bias": 1e-5,
            "gyro__bias_deviation": 2e-5,
            "gyro__bias_walk": 1e-4,
            "gyro__scale_error": 0.01,
            "gyro__scale_error_deviation": 0.02,
            "gyro__misalignment_deviation": 0.01,
            "gyro__mounting_error_x": 1e-3,
            "gyro__mounting_error_y": -2e-3,
            "gyro__mounting_error_z": 5e-4,
            "accelerometer__bias": 0.1,
            "accelerometer__bias_deviation": 0.05,
            "star_tracker__misalignment": (1e-3, -2e-3, 5e-3),
            "star_tracker__low_frequency_error": 1e-3,
            "star_tracker__low_frequency_time": 0.05,
            "star_tracker__boresight": (0.3, -0.4, 0.6),
            "star_tracker__roll_factor": 8.0,
            "seed": 11,
            "star_tracker__sun__direction": (0.5, 0.5, -0.5),
            "star_tracker__sun__half_angle": 1.4,
            "star_tracker__period": 5e-3,
        },
    ],
    ids=["nominal", "as-published", "quiet-wheels", "errors"],
)
def test_outputs_are_those_of_the_python_stepper(
    made: Callable[..., Twin], variants: dict[str, SensorMatrices], values: dict[str, Any]
):
    twin = made(**values)
    twin.start()
    matrices = variants[chosen_by(values.get).name]
    assert_array_equal(twin.view("encoder.speed"), matrices.nominal_speed)
    assert_array_equal(twin.view("star_tracker.quaternion"), [0.0, 0.0, 0.0, 1.0])
    assert twin.component.step_length == values.get("step_size", 0.0)
    if "step_size" not in values:
        twin.first_step(STEP)
    prepared = sensors.prepare(interface.parameters(matrices, value_of(twin), STEP))
    state = sensors.init(prepared)
    inputs = sensors.SensorInputs(*(twin.view(name) for name in ("attitude.quaternion", "gyro_site.rate",
        "accelerometer_site.acceleration", "wheel.speed", "wheel.angle")))  # fmt: skip
    expected: list[np.ndarray] = []
    seen: list[np.ndarray] = []
    for k in range(250):
        truth(twin, k)
        outputs = sensors.step(prepared, state, inputs)
        twin.advance(k * STEP, STEP)
        expected.append(np.concatenate([np.ravel(getattr(outputs, name)) for name in (*OUTPUTS.values(), "wrench")]))
        seen.append(np.concatenate([twin.view(name) for name in (*OUTPUTS, *WRENCH)]))
    # rounding of the filter's sums, the sines and the wrenches' sums, relative to the largest of a kind
    largest = np.abs(expected).max(axis=0)
    largest[-len(outputs.wrench) :] = largest[-len(outputs.wrench) :].max()
    assert np.all(np.abs(np.array(seen) - expected) <= 1e-12 * largest)
    valid = np.array(expected)[:, sum(twin.view(name).size for name in list(OUTPUTS)[:-1])]
    assert 0 < np.count_nonzero(valid) < len(valid)
    assert outputs.wrench.any() == values.get("jitter__enabled", True)


def test_noise_is_bit_for_bit_that_of_the_python_stepper(
    made: Callable[..., Twin], variants: dict[str, SensorMatrices]
):
    twin = made(seed=12345)
    twin.start()
    twin.first_step(STEP)
    prepared = sensors.prepare(interface.parameters(variants["corrected"], value_of(twin), STEP))
    state = sensors.init(prepared)
    for name in interface.TRUTH:
        twin.view(name)[:] = 0.0  # outputs are the noise alone
    twin.view("attitude.quaternion")[3] = 1.0
    inputs = sensors.SensorInputs(*(twin.view(name) for name in ("attitude.quaternion", "gyro_site.rate",
        "accelerometer_site.acceleration", "wheel.speed", "wheel.angle")))  # fmt: skip
    for k in range(200):
        expected = sensors.step(prepared, state, inputs)
        twin.advance(k * STEP, STEP)
        for name in ("gyro.rate", "accelerometer.acceleration", "encoder.speed"):
            assert_array_equal(twin.view(name), getattr(expected, OUTPUTS[name]))
    assert twin.view("gyro.rate").all()


def test_restored_state_goes_on_bit_for_bit(made: Callable[..., Twin]):
    twin, other = made(seed=3), made(seed=3)
    twin.start()
    twin.first_step(STEP)
    for k in range(7):
        truth(twin, k)
        twin.advance(k * STEP, STEP)
    saved = twin.save()
    other.start()  # it has not made a step: its length comes with the state
    other.restore(saved)
    for k in range(7, 300):
        for instance in (twin, other):
            truth(instance, k)
            instance.advance(k * STEP, STEP)
        assert_array_equal(twin.arrays["real"], other.arrays["real"])
        assert_array_equal(twin.arrays["boolean"], other.arrays["boolean"])


def test_a_seed_set_in_a_run_begins_all_noise_anew_and_nothing_else(
    made: Callable[..., Twin], variants: dict[str, SensorMatrices]
):
    errors = {"gyro__bias_deviation": 1.0, "gyro__bias_walk": 1e-4, "star_tracker__low_frequency_error": 1e-3}
    twin, fresh = made(seed=3, **errors), made(seed=8, **errors)
    inputs = sensors.SensorInputs(*(twin.view(name) for name in ("attitude.quaternion", "gyro_site.rate",
        "accelerometer_site.acceleration", "wheel.speed", "wheel.angle")))  # fmt: skip
    for instance in (twin, fresh):
        instance.start()
        instance.first_step(STEP)
    prepared = sensors.prepare(interface.parameters(variants["corrected"], value_of(twin), STEP))
    state = sensors.init(prepared)

    def step(k: int) -> None:
        truth(twin, k)
        sensors.step(prepared, state, inputs)
        twin.advance(k * STEP, STEP)

    for k in range(10):
        step(k)
    assert state.errors is not None
    bias = state.errors.gyro_bias.copy()
    saved = twin.save()
    after: list[np.ndarray] = []
    for seed in (8, 9, 8):
        twin.restore(saved)
        twin.view("seed")[:] = seed
        twin.tuned()
        if len(after) == 0:
            sensors.begin_noise(state, seed)
        for k in range(10, 130):
            truth(twin, k)
            twin.advance(k * STEP, STEP)
            if len(after) == 0:
                sensors.step(prepared, state, inputs)
                assert_array_equal(twin.view("encoder.speed"), state.outputs.encoder_speed)
                assert np.max(np.abs(twin.view("gyro.rate") - state.outputs.gyro_rate)) < 1e-12
                wrench = np.concatenate([twin.view(name) for name in WRENCH])  # rounding of sums, and no more
                assert np.max(np.abs(wrench - state.outputs.wrench)) < 1e-12 * np.max(np.abs(wrench))
        assert 0.0 < np.max(np.abs(state.errors.gyro_bias - bias)) < 0.001  # it walks on: it is not drawn again
        after.append(twin.arrays["real"].copy())
    assert_array_equal(after[0], after[2])
    assert np.count_nonzero(after[0] != after[1]) > 20

    truth(fresh, 10)
    fresh.advance(0.0, STEP)
    twin.restore(saved)
    twin.view("seed")[:] = 8
    twin.tuned()
    truth(twin, 10)
    twin.advance(10 * STEP, STEP)
    assert_array_equal(twin.view("encoder.speed"), fresh.view("encoder.speed"))  # the noise of a run with that seed
    twin.view("seed")[:] = -1
    with pytest.raises(ValueError, match="seed must be >= 0, got -1"):
        twin.tuned()
    with pytest.raises(ValueError, match="seed must be >= 0, got -1"):
        sensors.begin_noise(state, -1)


@pytest.mark.parametrize(
    ("values", "step"),
    [
        ({"fast_period": 3e-3, "star_tracker__period": 0.1}, 0.0),
        ({"fast_period": 5e-3}, 3e-3),
        ({"fast_period": 4e-3, "star_tracker__period": 6e-3, "step_size": 1e-3}, 0.0),
        ({"star_tracker__period": 0.1, "step_size": 3e-3, "fast_period": 3e-3}, 0.0),
        ({"step_size": 3e-7}, 0.0),
        ({"gyro__noise": -1e-7}, 0.0),
        ({"encoder__noise": -30.0}, 0.0),
        ({"star_tracker__noise_coarse": -2.0e20}, 0.0),
        ({"accelerometer__filter_frequency": 0.0}, 0.0),
        ({"seed": -1}, 0.0),
        ({"gyro__bias_walk": -1e-9}, 0.0),
        ({"star_tracker__low_frequency_time": 0.0}, 0.0),
        ({"star_tracker__boresight": (0.0, 0.0, 0.0)}, 0.0),
        ({"star_tracker__earth__half_angle": 0.5}, 0.0),
    ],
)
def test_bad_parameters_are_refused_in_the_same_words(
    made: Callable[..., Twin], variants: dict[str, SensorMatrices], values: dict[str, Any], step: float
):
    twin = made(**values)
    with pytest.raises(ValueError, match=r".") as expected:
        sensors.prepare(interface.parameters(variants["corrected"], value_of(twin), step or None))
    if step:
        twin.start()
    with pytest.raises(ValueError, match=r".") as refused:
        twin.first_step(step) if step else twin.start()
    assert str(refused.value) == str(expected.value)
