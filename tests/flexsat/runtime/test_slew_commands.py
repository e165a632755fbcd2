"""Slew commands: where they lead, chains of them, and commands that come during a slew."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexsat.fmu.python.saved_state import pack_state, unpack_state
from flexsat.runtime import controller as stepper
from flexsat.runtime import slew_commands as commands
from flexsat.runtime import slew_motion
from flexsat.runtime.named_state import named_values, restore_values
from flexsat.runtime.prepared_controller import wheel_momentum

DEGREE = np.pi / 180.0
QUICK = {"torque_limit": 1e5, "speed_band": 1e5}  # slews of a fraction of a second
PLANNED = 1e-9  # rad, required of a reference


def attitude(quaternion):
    """Return SciPy's rotation, which turns vectors, of attitudes (4,) or (n, 4)."""
    return Rotation.from_quat(quaternion)


def angle_between(quaternion, expected):
    return (attitude(quaternion).inv() * expected).magnitude()


def ready(design, flight, rotation=(0.0, 0.0, 0.0), start=5.0, **changes):
    prepared = stepper.prepare(design.controller, flight(design, **(QUICK | changes)))
    return prepared, stepper.init(prepared, np.array(rotation), start)


def quiet(design, valid=False):
    n = design.plant.wheels
    return stepper.Measurements(
        gyro_rate=np.zeros(23),
        accelerometer=np.zeros(13),
        encoder_speed=design.model.nominal_speed.copy(),
        encoder_angle=np.zeros(n),
        star_tracker_mrp=np.zeros(3),
        star_tracker_valid=valid,
    )


def fly(prepared, state, design, start, stop, given):
    """Return MRP, rate and torque of the reference at each step from `start` on, with commands by step."""
    found, held = [], (state.commanded_rotation.copy(), state.commanded_start)
    measured = quiet(design)
    for k in range(start, stop):
        held = given.get(k, held)
        commands.command(prepared, state, 0.005 * k, np.array(held[0]), held[1])
        out = stepper.step(prepared, state, 0.005 * k, measured)
        found.append(np.concatenate([out.reference[:3], out.reference[design.model.index.rate], out.reference_torque]))
    return np.array(found)


def test_ten_thousand_commands_end_on_the_commanded_attitude(centralised, flight):
    """A chain of slews about any axis, each commanded after the last has ended: none aborts, none misses."""
    prepared, state = ready(centralised, flight)
    rng = np.random.default_rng(5)
    axes = rng.standard_normal((10_000, 3))
    axes *= (60.0 * DEGREE * rng.random(10_000) / np.linalg.norm(axes, axis=1))[:, None]
    time, began, ended, held = 0.0, np.empty((10_000, 4)), np.empty((10_000, 4)), np.empty(10_000)
    for k, rotation in enumerate(axes):
        commands.command(prepared, state, time, rotation, time + 1.0 + 1e-3 * (k % 5))
        planned = state.profile
        commands.command(prepared, state, time, rotation.copy(), state.commanded_start)
        assert state.profile is planned  # the same again is no command
        began[k], ended[k] = state.origin, commands._end_attitude(state)
        # what the rate does between samples
        held[k] = planned.scale * slew_motion._sampled_angle(planned.times, planned.rates, prepared.period, 0.0)
        time = planned.end + 1.0
    expected = attitude(began) * Rotation.from_rotvec(axes)
    assert np.max((attitude(ended).inv() * expected).magnitude()) < PLANNED
    assert_allclose((attitude(began[1:]).inv() * attitude(ended[:-1])).magnitude(), 0.0, atol=PLANNED)
    assert_allclose(held, np.linalg.norm(axes, axis=1), atol=PLANNED)


ENDS = [(degrees, guidance) for degrees in (1.0, 20.0, 90.0, 179.0) for guidance in ("bang-coast-bang", "smoothed")]


@pytest.mark.parametrize(("degrees", "guidance"), [*ENDS, (179.0, "qp")])
def test_the_reference_ends_on_the_commanded_attitude(centralised, flight, degrees, guidance):
    axis = np.array([0.0, 0.0, 1.0])  # modes do not turn with z: the linear reference has no vibration about it
    prepared, state = ready(centralised, flight, degrees * DEGREE * axis, 0.3013, guidance=guidance)
    steps = round((state.profile.end + 0.3) / 0.005)
    last = fly(prepared, state, centralised, 0, steps, {})[-1]
    assert_allclose(last[:3], np.tan(0.25 * degrees * DEGREE) * axis, atol=0.25 * PLANNED)
    assert_allclose(last[3:6], 0.0, atol=1e-9)


def test_a_chain_of_slews_has_a_continuous_reference(centralised, flight):
    """Rates and attitudes agree from step to step through two slews about two axes."""
    first, second = 40.0 * DEGREE * np.array([1.0, 0.0, 0.0]), 50.0 * DEGREE * np.array([0.0, 0.6, 0.8])
    prepared, state = ready(centralised, flight, first, 0.5, smoothed=True)
    ended = state.profile.end
    after = round(ended / 0.005) + 100
    found = fly(prepared, state, centralised, 0, after + 1, {after: (second, 0.0)})
    found = np.vstack(
        [found, fly(prepared, state, centralised, after + 1, round((state.profile.end + 0.5) / 0.005), {})]
    )
    seen = Rotation.from_mrp(found[:, :3])
    turned = (seen[:-1].inv() * seen[1:]).as_rotvec()
    # a trapezium's rate is linear within a period, but for one corner of a T^2/8
    corner = np.abs(np.diff(found[:, 3:6], axis=0)).max() * 0.005
    assert_allclose(turned, 0.0025 * (found[:-1, 3:6] + found[1:, 3:6]), atol=corner)
    assert (seen[-1].inv() * Rotation.from_rotvec(first) * Rotation.from_rotvec(second)).magnitude() < PLANNED


def test_a_queued_slew_begins_when_the_first_has_ended(centralised, flight):
    first, second = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.2, 0.1])
    prepared, state = ready(centralised, flight, first, 0.5)
    later = state.profile.end + 1.0
    fly(prepared, state, centralised, 0, 110, {105: (second, later)})
    assert state.following.start == later
    assert state.profile.angle == pytest.approx(0.3)
    fly(prepared, state, centralised, 110, round((later + 0.2) / 0.005), {})
    assert state.profile.start == later
    expected = Rotation.from_rotvec(first) * Rotation.from_rotvec(second)
    assert angle_between(commands._end_attitude(state), expected) < PLANNED


def test_a_start_time_that_has_passed_means_at_once(centralised, flight):
    prepared, state = ready(centralised, flight)
    commands.command(prepared, state, 50.0, np.array([0.1, 0.0, 0.0]), 5.0)
    assert_allclose(state.profile.start, 50.0 + commands.lead(prepared), rtol=1e-15)


def test_a_rotation_of_zero_commands_no_slew(centralised, flight):
    prepared, state = ready(centralised, flight, (0.1, 0.0, 0.0), 5.0)
    commands.command(prepared, state, 1.0, np.zeros(3), 5.0)
    assert state.profile.angle == 0.0  # taken back before it began
    commands.command(prepared, state, 1.0, np.array([0.1, 0.0, 0.0]), 5.0)
    commands.command(prepared, state, 5.01, np.zeros(3), 5.0)
    assert state.profile.angle == 0.1  # in flight: it goes on
    ended = state.profile.end + 1.0
    commands.command(prepared, state, ended, np.array([0.1, 0.0, 0.0]), 5.0)  # the same again turns again
    assert angle_between(commands._end_attitude(state), Rotation.from_rotvec([0.2, 0.0, 0.0])) < PLANNED


def test_a_command_during_a_slew_is_refused(centralised, flight):
    prepared, state = ready(centralised, flight, (0.3, 0.0, 0.0), 0.5)
    before = named_values(state)
    with pytest.raises(ValueError, match=r"command.rotation changed at 0\.600 s, after the slew of 0\.500 s had begun"
                       r".* to begin at [\d.]+ s or later, or set command.during_slew to 'replan'"):  # fmt: skip
        commands.command(prepared, state, 0.6, np.array([0.1, 0.0, 0.0]), 0.7)
    assert all(np.array_equal(value, before[name]) for name, value in named_values(state).items())


@pytest.mark.parametrize("smoothed", [True, False])
@pytest.mark.parametrize("at", [0.51, 0.6, 0.65])
def test_a_command_during_a_slew_is_replanned(centralised, flight, at, smoothed):
    """It brakes within the limits and turns to where the new command leads from the start of the first slew."""
    first, second = np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.0, 0.7])
    prepared, state = ready(centralised, flight, first, 0.5, during_slew="replan", smoothed=smoothed)
    limit = np.abs(wheel_momentum(prepared, state.profile)).max()
    acceleration = state.profile.rates.max() / (state.profile.times[1] - state.profile.times[0])
    k = round(at / 0.005)
    found = fly(prepared, state, centralised, 0, k + 1, {k: (second, 0.0)})
    assert state.braking
    assert 0.0 < state.profile.angle <= 0.5
    end = round((commands.planned_motions(prepared, state)[-1].end + 0.5) / 0.005)
    found = np.vstack([found, fly(prepared, state, centralised, k + 1, end, {})])
    assert angle_between(commands._end_attitude(state), Rotation.from_rotvec(second)) < PLANNED
    assert_allclose(np.abs(np.diff(found[:k, 6:], axis=0)).max(), 0.0, atol=2.0 * limit * acceleration)
    change = np.abs(np.diff(found[:, 6:], axis=0)).max()
    assert change <= 2.0 * max(limit * acceleration, np.abs(found[:, 6:]).max())
    if smoothed:
        assert (Rotation.from_mrp(found[-1, :3]).inv() * Rotation.from_rotvec(second)).magnitude() < 1e-6


def test_commands_are_saved_and_restored(centralised, flight):
    """A restored state flies on as the saved one, whether a slew is in flight or waits."""
    first, second = np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.2, 0.1])
    prepared, state = ready(centralised, flight, first, 0.5)
    later = state.profile.end + 0.5
    fly(prepared, state, centralised, 0, 110, {105: (second, later)})
    saved = unpack_state("x", pack_state("x", named_values(state)))
    stop = round((later + 0.3) / 0.005)
    expected = fly(prepared, state, centralised, 110, stop, {})
    _, other = ready(centralised, flight)
    restore_values(other, saved)
    assert np.array_equal(fly(prepared, other, centralised, 110, stop, {}), expected)
