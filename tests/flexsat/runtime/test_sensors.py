"""Sensors and wheel jitter: statistics, rates, filter and formulas."""

from copy import deepcopy
from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import butter, lsim
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from flexsat.runtime import sensors
from flexsat.runtime.plant_parameters import PlantParameters, parameters_of_run
from flexsat.runtime.sensor_parameters import SensorParameters
from flexsat.runtime.wheel_jitter import Harmonics

WHEELS, GYROS, ACCELEROMETERS = 4, 3, 2
STEP = 0.001  # s
# Each component of the wrenches is one wheel's jitter, which shows it plainly
WRENCH_OF_JITTER = np.eye(4 * WHEELS)


def parameters(**changes: object) -> SensorParameters:
    """Return sensors without any noise or jitter, unless changed."""
    quiet = SensorParameters(
        seed=1,
        gyro_noise=0.0,
        accelerometer_noise=0.0,
        encoder_noise=0.0,
        star_tracker_noise=0.0,
        filter_frequency=80.0,
        step=STEP,
        fast_steps=5,
        star_tracker_steps=100,
        jitter=True,
        imbalance_force=0.0,
        imbalance_torque=0.0,
        broadband_force=0.0,
        broadband_torque=0.0,
        wheels=WHEELS,
        gyros=GYROS,
        accelerometers=ACCELEROMETERS,
        wrench_of_jitter=WRENCH_OF_JITTER,
        nominal_speed=np.full(WHEELS, 30.0),
    )
    return replace(quiet, **changes)


def observe(given: SensorParameters, steps: int, signal=None):
    """Step through a signal of the step's number (all truths zero without one); yield copies of the outputs."""
    prepared = sensors.prepare(given)
    state = sensors.init(prepared)
    still = {
        "quaternion": np.array([0.0, 0.0, 0.0, 1.0]),
        "rate": np.zeros(given.gyros),
        "acceleration": np.zeros(given.accelerometers),
        "speed": np.zeros(given.wheels),
        "angle": np.zeros(given.wheels),
    }
    for k in range(steps):
        out = sensors.step(prepared, state, sensors.SensorInputs(**(still | (signal(k) if signal else {}))))
        yield {name: np.copy(getattr(out, name)) for name in sensors.SensorOutputs.__slots__}


def check_deviation(values: np.ndarray, deviation: float) -> None:
    """Check mean and variance of normal samples at one false alarm in 1e6; the seed is fixed, so none comes later."""
    count = values.size
    assert abs(values.mean()) < 5.0 * deviation / np.sqrt(count)
    low, high = chi2.ppf([5e-7, 1.0 - 5e-7], count)
    assert low < np.sum((values / deviation) ** 2) < high


def test_noise_of_each_sample():
    given = parameters(
        gyro_noise=2e-7, accelerometer_noise=2e-5, encoder_noise=3e-4, fast_steps=1, star_tracker_steps=1,
        star_tracker_noise=5e-5, broadband_force=2.0, broadband_torque=0.3,
    )  # fmt: skip
    seen = list(observe(given, 4000))
    check_deviation(np.array([s["gyro_rate"] for s in seen]), 2e-7)
    check_deviation(np.array([s["accelerometer"] for s in seen]), 2e-5)
    check_deviation(np.array([s["encoder_speed"] for s in seen]), 3e-4)
    check_deviation(4.0 * np.array([s["star_tracker_mrp"] for s in seen]), 5e-5)  # small angles are four MRPs
    jitter = np.array([s["wrench"] for s in seen]).reshape(-1, 4, WHEELS)
    check_deviation(jitter[:, :2], 2.0)
    check_deviation(jitter[:, 2:], 0.3)
    # and they are independent: correlations of 4000 samples are 1/sqrt(4000) wide
    channels = np.hstack([np.array([s[n] for s in seen]) for n in ("gyro_rate", "accelerometer", "encoder_speed")])
    correlation = np.corrcoef(np.hstack([channels, jitter.reshape(len(seen), -1)]), rowvar=False)
    assert np.abs(correlation - np.eye(len(correlation))).max() < 5.5 / np.sqrt(4000)
    white = np.sum(channels[1:] * channels[:-1], axis=0) / np.sum(channels**2, axis=0)
    assert np.abs(white).max() < 5.5 / np.sqrt(4000)


def test_published_error_uses_the_noise_of_the_gyros():
    given = parameters(gyro_noise=0.5, accelerometer_noise=0.0, accelerometer_noise_is_gyros=True, fast_steps=1)
    check_deviation(np.array([s["accelerometer"] for s in observe(given, 2000)]), 0.5)


def test_star_tracker_error_is_in_body_axes():
    """The measured attitude is the true one turned further by the error, alike about each axis."""
    truth = Rotation.from_rotvec([1.0, -2.0, 0.5])
    given = parameters(star_tracker_noise=1e-3, fast_steps=1, star_tracker_steps=1)
    errors = []
    for out in observe(given, 2000, lambda _: {"quaternion": truth.as_quat()}):
        measured = Rotation.from_quat(out["star_tracker_quaternion"])
        assert_allclose((Rotation.from_mrp(out["star_tracker_mrp"]).inv() * measured).magnitude(), 0.0, atol=1e-12)
        errors.append((truth.inv() * measured).as_rotvec())
    for axis in range(3):
        check_deviation(np.array(errors)[:, axis], 1e-3)


def test_each_sensor_at_its_own_rate():
    def ramp(k):
        return {
            "quaternion": Rotation.from_rotvec([1e-3 * k, 0.0, 0.0]).as_quat(),
            "rate": np.full(GYROS, float(k)),
            "speed": np.full(WHEELS, 2.0 * k),
            "angle": np.full(WHEELS, 3.0 * k),
        }

    for k, out in enumerate(observe(parameters(fast_steps=5, star_tracker_steps=20), 60, ramp)):
        fast, slow = k - k % 5, k - k % 20
        assert_allclose(out["gyro_rate"], fast, rtol=0.0)
        assert_allclose(out["encoder_speed"], 2.0 * fast, rtol=0.0)
        assert_allclose(out["encoder_angle"], 3.0 * fast, rtol=0.0)
        assert out["star_tracker_valid"] == (k % 20 < 5)  # until the next sample of the others
        turned = Rotation.from_quat(out["star_tracker_quaternion"]).as_rotvec()
        assert_allclose(turned, [1e-3 * slow, 0.0, 0.0], atol=1e-15)  # rounding


def test_before_the_first_sample():
    state = sensors.init(sensors.prepare(parameters()))
    assert not state.outputs.star_tracker_valid
    assert_allclose(state.outputs.encoder_speed, 30.0, rtol=0.0)
    assert not state.outputs.gyro_rate.any()


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_filter_is_the_analogue_butterworth(step):
    """An input that is linear between steps: SciPy's first-order hold is exact too."""
    rng = np.random.default_rng(3)
    accelerations = rng.standard_normal((400, ACCELEROMETERS))
    accelerations[0] = 0.0  # both start at rest
    given = parameters(step=step, fast_steps=1)
    seen = [o["accelerometer"] for o in observe(given, 400, lambda k: {"acceleration": accelerations[k]})]
    analogue = butter(2, 2.0 * np.pi * 80.0, analog=True)
    for k in range(ACCELEROMETERS):
        _, exact, _ = lsim(analogue, accelerations[:, k], step * np.arange(400), interp=True)
        assert_allclose(np.array(seen)[:, k], exact, atol=1e-10)  # rounding; the companion form spans 2.5e5


def test_filter_has_unit_gain_at_rest():
    given = parameters(fast_steps=1)
    *_, last = observe(given, 100, lambda _: {"acceleration": np.array([1.0, -2.0])})
    assert_allclose(last["accelerometer"], [1.0, -2.0], rtol=1e-12)  # exp(-355 x .1 s) of the start is left: 4e-16


def test_filter_starts_at_rest_with_its_first_input():
    """From the first sample on: the step response, 1 - exp(-a t) (cos a t + sin a t) with a = corner / sqrt 2."""
    given = parameters(fast_steps=1)
    seen = [out["accelerometer"] for out in observe(given, 8, lambda _: {"acceleration": np.array([1.0, -2.0])})]
    t = np.sqrt(0.5) * 2.0 * np.pi * 80.0 * STEP * np.arange(8)
    exact = 1.0 - np.exp(-t) * (np.cos(t) + np.sin(t))
    assert_allclose(seen, np.outer(exact, [1.0, -2.0]), atol=1e-14)  # rounding of eight small products


def test_random_streams_are_those_of_no_other_component(centralised, quiet_run):
    """Plant and sensors of one seed draw different numbers; each of the sensors' two streams its own."""
    matrices = centralised.plant
    n = matrices.wheels
    quiet = {item.name: getattr(quiet_run(matrices), item.name) for item in fields(PlantParameters)}
    unused = ("wheel_speed", "wheel_angle")
    rest = {name: value for name, value in quiet.items() if name not in unused}
    drawn = parameters_of_run(
        matrices, seed=5, random_wheel_phases=True, attitude_deviation=1.0, wheel_speed_offset=np.zeros(n),
        wheel_angle=np.zeros(n), **rest,
    )  # fmt: skip
    state = sensors.init(sensors.prepare(parameters(seed=5)))
    generators = [state.noise, state.disturbance]
    uniform = [deepcopy(generator).uniform(0.0, 2.0 * np.pi, n) for generator in generators]
    normal = [deepcopy(generator).standard_normal(3) for generator in generators]
    for phases in uniform:
        assert not np.isclose(phases, drawn.wheel_angle).any()
    for errors in normal:
        assert not np.isclose(0.25 * errors, drawn.mrp).any()
    assert not np.isclose(*uniform).any()


def test_harmonic_jitter_at_mid_step():
    """PHYSICS section 4: force C_f W^2 (sin th, cos th), torque C_t W^2 (-cos th, sin th), th = angle + W h/2."""
    speed, angle = np.array([30.0, -40.0, 50.0, 0.0]), np.array([0.1, 2.0, -3.0, 1.0])
    given = parameters(imbalance_force=0.7, imbalance_torque=0.2, step=0.005, fast_steps=1)
    (out,) = observe(given, 1, lambda _: {"speed": speed, "angle": angle})
    middle = angle + 0.0025 * speed
    s, c, square = np.sin(middle), np.cos(middle), speed**2
    expected = [0.7 * square * s, 0.7 * square * c, -0.2 * square * c, 0.2 * square * s]
    assert_allclose(out["wrench"], np.ravel(expected), rtol=1e-13, atol=1e-13)


def test_further_harmonics_have_multiples_of_the_angle_and_a_phase():
    """Two of the first wheel, one that is not whole of the second; they add to the first harmonic."""
    speed, angle = np.array([30.0, -40.0, 50.0, 0.0]), np.array([0.1, 2.0, -3.0, 1.0])
    order, phase = np.array([[2.0, 3.7, 1.0, 1.0], [4.0, 1.0, 1.0, 1.0]]), np.array([[0.4, -1.0, 0, 0], [0.0] * 4])
    force, torque = np.array([[0.5, 0.3, 0, 0], [0.2, 0, 0, 0]]), np.array([[0.1, 0.0, 0, 0], [0.7, 0, 0, 0]])
    table = Harmonics(order=order, force=force, torque=torque, phase=phase)
    first = np.array([1.0, 0.0, 0.5, 2.0])
    given = parameters(imbalance_force=first, step=0.005, fast_steps=1, harmonics=table)
    (out,) = observe(given, 1, lambda _: {"speed": speed, "angle": angle})
    middle, square = angle + 0.0025 * speed, speed**2
    expected = np.array([first * square * np.sin(middle), first * square * np.cos(middle), 0.0 * speed, 0.0 * speed])
    for p in range(2):
        turned = order[p] * middle + phase[p]
        s, c = np.sin(turned) * square, np.cos(turned) * square
        expected += [force[p] * s, force[p] * c, -torque[p] * c, torque[p] * s]
    assert_allclose(out["wrench"], np.ravel(expected), rtol=1e-13, atol=1e-13)


def test_jitter_follows_the_wheel_at_every_step_and_broadband_is_held():
    given = parameters(broadband_force=1.0, broadband_torque=1.0, fast_steps=5)
    seen = np.array([o["wrench"] for o in observe(given, 20)]).reshape(4, 5, -1)
    assert_allclose(seen, np.repeat(seen[:, :1], 5, axis=1), rtol=0.0)
    assert np.all(seen[1:, 0] != seen[:-1, 0])
    turning = parameters(imbalance_force=1.0, fast_steps=5)
    seen = np.array(
        [
            o["wrench"][:WHEELS]
            for o in observe(turning, 5, lambda k: {"speed": np.full(4, 30.0), "angle": np.full(4, 0.03 * k)})
        ]
    )
    assert np.all(np.diff(seen, axis=0) > 0.0)  # sin rises, at each step and not at samples alone


def test_no_jitter_when_off():
    given = parameters(imbalance_force=1.0, broadband_force=1.0, jitter=False)
    for out in observe(given, 10, lambda _: {"speed": np.full(4, 30.0)}):
        assert not out["wrench"].any()


NOISY = {"gyro_noise": 1.0, "accelerometer_noise": 1.0, "encoder_noise": 1.0, "star_tracker_noise": 1e-3}


def test_a_seed_repeats_and_another_differs():
    first, again, other = (list(observe(parameters(seed=seed, broadband_force=1.0, **NOISY), 20)) for seed in (7, 7, 8))
    for a, b, c in zip(first, again, other, strict=True):
        for name in a:
            assert np.array_equal(a[name], b[name])
        for name in ("gyro_rate", "accelerometer", "encoder_speed", "star_tracker_mrp"):
            assert np.all(a[name] != c[name])
        assert np.all(a["wrench"][: 2 * WHEELS] != c["wrench"][: 2 * WHEELS])


def test_measurement_noise_does_not_depend_on_the_disturbance():
    """Jitter on or off, the noise is the same: runs can be compared."""
    for a, b in zip(observe(parameters(**NOISY), 20), observe(parameters(jitter=False, **NOISY), 20), strict=True):
        assert np.array_equal(a["gyro_rate"], b["gyro_rate"])


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("seed", -1, "seed must be >= 0, got -1"),
        ("gyro_noise", -1.0, "gyro_noise must be >= 0"),
        ("encoder_noise", np.nan, "encoder_noise must be >= 0"),
        ("filter_frequency", 0.0, "filter_frequency must be > 0 Hz"),
        ("fast_steps", 0, "fast_steps must be >= 1"),
        ("star_tracker_steps", 0, "star_tracker_steps must be >= 1"),
        (
            "star_tracker_steps",
            101,
            r"star_tracker\.period = 0\.101 s must be a whole multiple of fast_period = 0\.005",
        ),
    ],
)
def test_invalid_parameters_are_refused(name, value, message):
    with pytest.raises(ValueError, match=message):
        parameters(**{name: value})
