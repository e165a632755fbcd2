"""The ripple of wheels' harmonics on estimated torque and biases: against stepped filters and recorded gyros."""

import numpy as np
from numpy.testing import assert_allclose

from flexbench.runs.run_folder import read_run
from flexbench.studies.health.vibration import FilterStep, jitter_phasor, measured_vibration, ripple
from flexsat.runtime.wheel_jitter import harmonic

PERIOD, PHASES = 5e-3, 20


def test_ripple_is_the_covariance_of_a_filter_that_is_stepped():
    """A bias filter of one gyro and a slow star tracker, under two sines: the mean square over 2,000 of its periods."""
    steps = []
    for phase in range(PHASES):
        gain = np.array([[0.01, 0.2], [0.004, -0.05]]) * ([1.0, 1.0] if phase == 0 else [1.0, 0.0])
        model = np.array([[1.0, -PERIOD], [0.0, 1.0]])
        steps.append(FilterStep(a=model - gain @ np.array([[0.0, 1.0], [1.0, 0.0]]) @ model, gain=gain))
    frequency = 2.0 * np.pi * np.array([6.72005, 3.72039])  # Hz: beside the star tracker's 10 Hz in no small ratio
    measured = np.array([[1.0 - 0.5j, 0.3j], [0.02 + 0.01j, -0.05 + 0.0j]])
    time = PERIOD * np.arange(2300 * PHASES)
    signal = np.real(np.exp(1j * np.outer(time, frequency)) @ measured.T)

    state, seen = np.zeros(2), []
    for number, y in enumerate(signal):
        one = steps[number % PHASES]
        state = one.a @ state + one.gain @ y
        if number >= 300 * PHASES:  # ten time constants
            seen.append(state)
    found = np.transpose(seen) @ np.array(seen) / len(seen)

    # what a mean over 200 s leaves of the products of sines
    assert_allclose(ripple(steps, PERIOD, frequency, measured), found, atol=0.01 * np.trace(found))


def test_phasors_are_those_of_the_wheels_jitter():
    speed, force, torque = 23.0, 7e-6, 3e-6
    for angle in (0.0, 0.4, 2.0):
        wrench = harmonic(np.array([speed]), np.array([angle]), 0.0, np.array([force]), np.array([torque]),
                          np.zeros((4, 1)))  # fmt: skip
        assert_allclose(np.real(np.exp(1j * angle) * jitter_phasor(force, torque, speed)), wrench[:, 0], rtol=1e-14)


def test_gyros_vibrate_as_the_linear_structure_says(recorded_runs, built):
    """Simulated gyros against the sines of the wheels' measured angles; their noise is a tenth of it."""
    signals = read_run(recorded_runs / "1").samples()
    _, phasors = measured_vibration(built["centralised"].published)
    late = signals.time >= 5.0  # s: what the start left of the structure's own vibration is small then
    angle, gyros = signals["sensors.encoder.angle"][late], signals["sensors.gyro.rate"][late]
    expected = np.real(np.exp(1j * angle) @ phasors[: gyros.shape[1]].T)
    slow = np.column_stack([np.ones(late.sum()), signals.time[late], signals.time[late] ** 2])  # motion of the body

    def vibration(signal):
        return signal - slow @ np.linalg.lstsq(slow, signal, rcond=None)[0]

    sensed, expected = vibration(gyros), vibration(expected)
    assert 0.9 < np.std(expected) / np.std(sensed) < 1.1
    assert np.std(sensed - expected) < 0.5 * np.std(sensed)  # what is held in steps, and modes that still decay
