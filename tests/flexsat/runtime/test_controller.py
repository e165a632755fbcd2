"""The flight controller against a step-by-step simulation of its linear model on a grid of 1 ms."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from flexsat.runtime import controller as stepper
from flexsat.runtime.controller import Measurements
from flexsat.runtime.prepared_controller import plan_slew

DEGREE = np.pi / 180.0
ABOUT_X = np.array([0.5 * DEGREE, 0.0, 0.0])
# Two ways of multiplying the same matrices, 5 ms at once or five times 1 ms: rounding, amplified by states of very
# different size
SAME = 1e-9


def measurements(design, y, valid, angle=0.0):
    """Return what sensors would give for outputs y of the linear model."""
    n = design.plant.wheels
    return Measurements(
        gyro_rate=y[:23],
        accelerometer=y[23:36],
        encoder_speed=y[36 : 36 + n] + design.model.nominal_speed,
        encoder_angle=np.full(n, angle),
        star_tracker_mrp=0.25 * y[36 + n :],
        star_tracker_valid=valid,
    )


class Simulation:
    """The linear model, 1 ms at a time, under torques that act `actuation` ms after their command."""

    def __init__(self, design, actuation):
        n, m = design.model.b_torque.shape
        block = np.zeros((n + m, n + m))
        block[:n, :n], block[:n, n:] = design.model.a, design.model.b_torque
        self.step = expm(1e-3 * block)[:n]
        self.actuation, self.commands = actuation, []

    def command(self, now, torque):
        self.commands.append((now + self.actuation, torque))

    def at_work(self, now):
        torque = np.zeros(self.step.shape[1] - len(self.step))
        for start, commanded in self.commands:
            if start <= now:
                torque = commanded
        return torque

    def propagate(self, x, start, end):
        for now in range(start, end):
            x = self.step @ np.concatenate([x, self.at_work(now)])
        return x


def simulate(design, given, steps, valid=lambda k: k % 20 == 0, start=0.05):
    """Run controller and simulation on the same noisy measurements; return estimates and torques of each."""
    rng = np.random.default_rng(9)
    model = design.model
    noise = design.config.noise
    deviation = np.repeat(
        [noise.gyro, noise.accelerometer, noise.encoder, noise.star_tracker_coarse], [23, 13, design.plant.wheels, 3]
    )
    # the linear simulation adds small rotations; test_controller_attitude.py covers those that do not add
    controller = stepper.prepare(design.controller, replace(given, linear_attitude=True))
    # the shaped torque begins one spacing before the rigid profile
    state = stepper.init(controller, ABOUT_X, controller.shaper.shifts[0] + start)
    sampled, actuation = round(1e3 * given.measurement_delay), round(1e3 * given.actuation_delay)
    simulation = Simulation(design, actuation)
    x, known, waiting, found, simulated = np.zeros(model.index.size), 0, 19, [], []
    r, n = controller.controlled, design.plant.wheels
    for k in range(steps):
        now = 5 * k
        y = 10.0 * deviation * rng.standard_normal(len(deviation))
        out = stepper.step(controller, state, now * 1e-3, measurements(design, y, valid(k)))
        measured = now - sampled
        if measured >= 0:
            x, known = simulation.propagate(x, known, measured), measured
            waiting = 0 if valid(k) else waiting + 1
            x = x + design.coarse.gain[min(waiting, 19)] @ (y - model.c @ x)
        expected = simulation.propagate(x, known, now + actuation)[:r]  # at rest before the first measurement
        torque = out.reference_torque - design.regulator.gain @ (expected - out.reference)
        torque = np.clip(torque, -given.torque_limit, given.torque_limit)
        room = design.controller.wheel_inertia[0] / given.period
        speed = expected[-n:]
        torque = np.clip(torque, room * (-given.speed_band - speed), room * (given.speed_band - speed))
        if given.open_loop:
            torque = np.zeros(n)
        simulation.command(now, torque)
        found.append(np.concatenate([out.estimate, out.torque]))
        simulated.append(np.concatenate([x, torque]))
    return np.array(found), np.array(simulated)


DELAYS = [(0, 0), (5, 5), (3, 4), (20, 20), (0, 7), (13, 0), (5, 0), (0, 5), (1, 1)]


@pytest.mark.parametrize(("measurement", "actuation"), DELAYS)
def test_delayed_torques_are_predicted(centralised, flight, measurement, actuation):
    given = flight(centralised, measurement_delay=1e-3 * measurement, actuation_delay=1e-3 * actuation)
    found, expected = simulate(centralised, given, 60)
    scale = np.abs(expected).max(axis=0)
    assert np.all(scale[-6:] > 0.1 * given.torque_limit)  # hard torques: a slew, and noise ten times the real one
    # uncoupled states, zero but for rounding, are judged by the largest of all
    assert np.all(np.abs(found - expected) < SAME * scale + 1e-15 * scale.max())


def test_a_slew_that_would_begin_before_the_run_is_refused(centralised, flight):
    """The shaped torque leads the slew, and before the first measurement nothing counts it."""
    given = flight(centralised, measurement_delay=0.001, actuation_delay=0.001)
    with pytest.raises(ValueError, match=r"command.start_time = 0\.15 s must be >= 0\.152 s"):
        simulate(centralised, given, 5, start=0.0)
    simulate(centralised, given, 5, start=0.0021)


def test_delayed_torques_are_predicted_with_33_wheels(distributed, flight):
    given = flight(distributed, measurement_delay=0.008, actuation_delay=0.009)
    found, expected = simulate(distributed, given, 40)
    scale = np.abs(expected).max(axis=0)
    assert np.all(np.abs(found - expected) < SAME * scale + 1e-15 * scale.max())


def test_estimation_goes_on_without_star_tracker(centralised, flight):
    """After one fix the star tracker is silent: the gains of the phase without it are used on."""
    found, expected = simulate(centralised, flight(centralised), 60, valid=lambda k: k == 0)
    scale = np.abs(expected).max(axis=0)
    assert np.all(np.isfinite(found))
    assert np.all(np.abs(found - expected) < SAME * scale + 1e-15 * scale.max())


def test_a_late_star_tracker_shifts_the_phase(centralised, flight):
    """Its gain is used when a sample comes, not by the clock."""
    found, expected = simulate(centralised, flight(centralised), 45, valid=lambda k: k in (7, 27))
    scale = np.abs(expected).max(axis=0)
    assert np.all(np.abs(found - expected) < SAME * scale + 1e-15 * scale.max())


def test_open_loop_estimates_and_commands_nothing(centralised, flight):
    found, expected = simulate(centralised, flight(centralised, open_loop=True), 30)
    assert not found[:, -6:].any()
    scale = np.abs(expected).max(axis=0)
    assert np.all(np.abs(found - expected) < SAME * scale + 1e-15 * scale.max())
    assert np.abs(found[-1, :-6]).max() > 0.0


@pytest.mark.parametrize("delays", [(0.0, 0.0), (0.005, 0.012)])
def test_shadow_controller_given_the_applied_torque_estimates_as_the_one_in_control(centralised, flight, delays):
    no_limits = {"torque_limit": 1e9, "speed_band": 1e9}
    given = flight(centralised, measurement_delay=delays[0], actuation_delay=delays[1], **no_limits)
    design = centralised.controller
    softer = stepper.prepare(replace(design, feedback=0.8 * design.feedback), given)
    active = stepper.prepare(design, given)
    rng, acted = np.random.default_rng(4), np.zeros(active.wheels)
    states = [stepper.init(c, np.zeros(3), 1.0) for c in (active, softer, softer)]
    for k in range(60):
        seen = measurements(centralised, 1e-8 * rng.standard_normal(36 + active.wheels + 3), k % 20 == 0)
        informed = replace(seen, applied_torque=acted, applied_valid=True)
        in_control = stepper.step(active, states[0], 5e-3 * k, seen)
        shadow = stepper.step(softer, states[1], 5e-3 * k, informed)
        uninformed = stepper.step(softer, states[2], 5e-3 * k, replace(informed, applied_valid=False))
        acted = in_control.torque.copy()
        np.testing.assert_array_equal(shadow.estimate, in_control.estimate)
        # no slew: feedback alone; sums of 60 terms that cancel to a hundredth of the largest
        assert_allclose(shadow.torque, 0.8 * acted, rtol=1e-12, atol=1e-14 * np.max(np.abs(acted)))
    assert np.max(np.abs(acted)) > 0.0
    assert np.max(np.abs(uninformed.torque - shadow.torque)) > 1e-3 * np.max(np.abs(acted))


def test_fine_sensor_uses_its_gain(centralised, flight):
    controller = stepper.prepare(centralised.controller, flight(centralised, fine_sensor=True, linear_attitude=True))
    state = stepper.init(controller, np.zeros(3), 5.0)
    y = np.ones(len(centralised.model.c))
    out = stepper.step(controller, state, 0.0, measurements(centralised, y, True))
    assert_allclose(out.estimate, centralised.fine.gain[0] @ y, rtol=1e-12, atol=1e-20)  # rounding of the nominal speed


@pytest.mark.parametrize("delay", [0.0, 0.005])
def test_known_jitter_is_fed_forward(distributed, flight, delay):
    """The prediction over the period after the measurement carries the harmonic at its middle (PHYSICS section 4)."""
    given = flight(distributed, feed_forward_jitter=True, open_loop=True, measurement_delay=delay)
    controller = stepper.prepare(distributed.controller, given)
    state = stepper.init(controller, np.zeros(3), 5.0)
    zero = np.zeros(len(distributed.model.c))
    first = round(delay / 0.005)  # before it, no measurement has come
    for k in range(first + 1):
        stepper.step(controller, state, 0.005 * k, measurements(distributed, zero, k == first, angle=0.3))
    x = state.estimate.copy()
    speed = distributed.model.nominal_speed
    middle = 0.3 + 0.0025 * speed
    s, c = given.imbalance_force * speed**2, given.imbalance_torque * speed**2
    jitter = np.concatenate([s * np.sin(middle), s * np.cos(middle), -c * np.cos(middle), c * np.sin(middle)])
    n = len(x)
    block = np.zeros((n + len(jitter), n + len(jitter)))
    block[:n, :n], block[:n, n:] = distributed.model.a, distributed.model.b_jitter
    expected = expm(0.005 * block)[:n] @ np.concatenate([x, jitter])
    seen = distributed.model.c @ expected  # what agrees with the prediction does not correct it
    out = stepper.step(controller, state, 0.005 * (first + 1), measurements(distributed, seen, False))
    assert np.abs(expected).max() > 1e-5
    # rounding of the nominal speeds, 1e-14, comes back through the gain
    assert_allclose(out.estimate, expected, atol=1e-9 * np.abs(expected).max())


def test_motor_limit_then_speed_band(centralised, flight):
    given = flight(centralised)
    controller = stepper.prepare(centralised.controller, given)
    state = stepper.init(controller, np.zeros(3), 5.0)
    speeds = centralised.model.index.wheel_speed
    y = np.zeros(len(centralised.model.c))

    def torque_of(estimate):
        state.estimate, state.count, state.history = estimate.copy(), 0, np.zeros_like(state.history)
        state.attitude[:] = (0.0, 0.0, 0.0, 1.0)
        # agree with the estimate, so that it stays
        out = stepper.step(controller, state, 0.0, measurements(centralised, centralised.model.c @ estimate, False))
        return out.torque

    far = np.zeros(controller.states)
    far[:3] = 0.01  # an attitude error of over 2 degrees asks for far more than there is
    assert_allclose(np.abs(torque_of(far)), given.torque_limit, rtol=1e-12)
    assert not torque_of(np.zeros(controller.states)).any()
    sign = np.sign(torque_of(far))
    near = far.copy()
    near[speeds] = sign * (given.speed_band - 1e-4)  # the last 1e-4 rad/s in the direction asked for
    room = centralised.controller.wheel_inertia[0] * 1e-4 / given.period
    assert room < given.torque_limit
    assert_allclose(sign * torque_of(near), room, rtol=1e-6)  # 1e-4 is a difference of numbers of 2.6 and 37
    beyond = far.copy()
    beyond[speeds] = sign * (given.speed_band + 1e-4)
    assert_allclose(sign * torque_of(beyond), -room, rtol=1e-6)  # out of the band, it leads back
    assert y.size


@pytest.mark.parametrize("name", ["measurement_delay", "actuation_delay"])
@pytest.mark.parametrize("value", [-0.001, 0.021, 0.0025, np.nan])
def test_invalid_delays_are_refused(centralised, flight, name, value):
    port = "delay." + name.removesuffix("_delay")
    with pytest.raises(ValueError, match=f"{port} must be whole milliseconds from 0 to 0.020 s"):
        flight(centralised, **{name: value})


@pytest.mark.parametrize(("name", "value"), [("authority", 0.0), ("authority", 1.1), ("torque_limit", 0.0), ("speed_band", -1.0)])  # fmt: skip  # noqa: E501
def test_other_parameters_are_refused(centralised, flight, name, value):
    with pytest.raises(ValueError, match=f"{name} must be"):
        flight(centralised, **{name: value})


def test_command_may_change_until_the_slew_begins(centralised, flight):
    controller = stepper.prepare(centralised.controller, flight(centralised))
    state = stepper.init(controller, ABOUT_X, 5.0)
    first = state.profile
    stepper.command(controller, state, 1.0, ABOUT_X, 5.0)
    assert state.profile is first  # the same command again is none
    stepper.command(controller, state, 1.0, 2.0 * ABOUT_X, 6.0)
    assert_allclose([state.profile.angle, state.profile.start], [1.0 * DEGREE, 6.0], rtol=1e-14)
    # shaped torque begins one spacing before the rigid one
    lead = controller.shaper.shifts[0]
    with pytest.raises(ValueError, match=r"command.rotation changed at [\d.]+ s, after the slew of 6.000 s had begun"):
        stepper.command(controller, state, 6.0 - lead + 1e-9, ABOUT_X, 5.0)
    stepper.command(controller, state, 6.0, 2.0 * ABOUT_X, 6.0)  # nothing new: accepted at any time


def test_a_late_command_is_accepted_without_a_planned_slew(centralised, flight):
    controller = stepper.prepare(centralised.controller, flight(centralised))
    state = stepper.init(controller, np.zeros(3), 0.0)
    stepper.command(controller, state, 50.0, ABOUT_X, 60.0)
    assert state.profile.start == 60.0


def references(design, given, times):
    """Return reference and feed-forward torque at every period up to the last time, by index of `times`."""
    controller = stepper.prepare(design.controller, given)
    state = stepper.init(controller, ABOUT_X, 5.0)
    y = np.zeros(len(design.model.c))
    quiet = measurements(design, y, False)
    found = {}
    for k in range(max(times) + 1):
        out = stepper.step(controller, state, 0.005 * k, quiet)
        if k in times:
            found[k] = (out.reference.copy(), out.reference_torque.copy())
    return controller, found


def test_smoothed_reference_is_the_rigid_profile(design, flight):
    times = [0, 1000, 1300, 4000]
    controller, found = references(design, flight(design, smoothed=True), times)
    profile = plan_slew(controller, ABOUT_X, 5.0)
    index, inertia = design.model.index, design.spacecraft.inertia
    for k, (reference, _) in found.items():
        time = np.array([0.005 * k])
        rate = profile.rate(time)[0] * np.array([1.0, 0.0, 0.0])
        assert_allclose(reference[:3], [np.tan(0.25 * profile.rotation(time)[0]), 0.0, 0.0], rtol=1e-13)
        assert_allclose(reference[index.rate], rate, rtol=1e-13)
        assert not reference[index.modal_displacement].any()
        wheels = design.plant.wheel_inertia[0] * design.plant.wheel_axis.T @ reference[index.wheel_speed]
        assert_allclose(wheels, -inertia @ rate, atol=1e-10)  # no net momentum; rounding of some 20 N.m.s


def test_time_optimal_reference_keeps_momentum_and_turns_as_planned(design, flight):
    """Body, modes and wheels have no net momentum, and together turn by the angle of the shaped profile."""
    times = [2000, 4400]
    controller, found = references(design, flight(design), times)
    profile = plan_slew(controller, ABOUT_X, 5.0)
    index, craft = design.model.index, design.spacecraft
    for k, (reference, _) in found.items():
        rate, flexing = reference[index.rate], reference[index.modal_velocity]
        body = craft.inertia @ rate + craft.rotation @ flexing
        wheels = design.plant.wheel_inertia[0] * design.plant.wheel_axis.T @ reference[index.wheel_speed]
        assert_allclose(body, -wheels, atol=1e-9 * np.abs(wheels).max())  # 4400 steps of rounding
        # the angle of the whole is that of the rigid profile: J p + L_w eta/4 integrates the momentum
        turned = craft.inertia @ reference[:3] + 0.25 * craft.rotation @ reference[index.modal_displacement]
        # in the coast, where the rotation is linear, shaping moves it by its mean shift: damping makes that 5 ms, not 0
        shift = controller.shaper.weights @ controller.shaper.shifts
        exact = 0.25 * craft.inertia[0, 0] * profile.rotation(np.array([0.005 * k]) + shift)[0]
        # the torque is held over periods of 5 ms: each of the profile's corners inside one moves the angle by a T^2/8
        corner = 0.25 * craft.inertia[0, 0] * profile.coast_rate / profile.ramp * 0.005**2
        assert_allclose(turned, [exact, 0.0, 0.0], atol=corner)


def test_reference_is_taken_when_the_torque_will_act(centralised, flight):
    """With 10 ms of actuation delay, feed-forward and reference are those of two periods later."""
    times = [1000, 1100, 1200]
    _, now = references(centralised, flight(centralised, smoothed=True), [k + 2 for k in times])
    _, early = references(centralised, flight(centralised, smoothed=True, actuation_delay=0.010), times)
    for k in times:
        for found, expected in zip(early[k], now[k + 2], strict=True):
            # times as sums of floats: 1e-15 of 6 s, over a period of 5 ms
            assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
            assert np.abs(expected).max() > 0.0
