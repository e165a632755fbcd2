"""Slews of wheels with unequal limits: what each gives, against linear programmes, and what it is asked for."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from flexsat.runtime import controller as stepper
from flexsat.runtime import slew_commands as commands
from flexsat.runtime.prepared_controller import limits_of, plan_motion, wheel_momentum
from flexsat.runtime.slew_guidance import limits_about, wheels_for

DEGREE = np.pi / 180.0


def most(axes, body, limits):
    """Return by a linear programme how much of a body torque wheels give, each within (lowest, highest)."""
    n = len(axes)
    balance = np.hstack([axes.T, body[:, np.newaxis]])  # the wheels' torques and the body's add up to nothing
    bounds = [*zip(*limits, strict=True), (0.0, None)]
    found = linprog(np.append(np.zeros(n), -1.0), A_eq=balance, b_eq=np.zeros(3), bounds=bounds)
    return found.x[-1]


def test_an_offset_without_net_momentum_is_kept_room_for_at_both_ends():
    """Two wheels against each other, each at 1 N.m.s: the regulator takes both back to zero meanwhile."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    momentum, offset = np.full(6, 4.0), np.array([1.0, 0.0, 2.0, 1.0, 0.0, 0.0])
    wheels = wheels_for(axes, np.ones(6), momentum, offset)
    # of 2 N.m.s of net momentum along z each of its wheels keeps 1
    assert_allclose(1.0 / wheels.per_rise, [3.0, 4.0, 2.0, 3.0, 4.0, 4.0])
    assert_allclose(1.0 / wheels.per_fall, [4.0, 4.0, 5.0, 4.0, 4.0, 3.0])


def test_the_third_division_is_between_the_others():
    torque, momentum = np.array([1.0, 4.0, 2.0]), np.array([9.0, 1.0, 4.0])
    by_momentum, by_torque, between = wheels_for(np.eye(3), torque, momentum, np.zeros(3)).limits
    assert_allclose(by_torque, torque / 4.0)
    assert_allclose(by_momentum, momentum / 9.0)
    assert_allclose(between, np.sqrt(torque / 4.0 * momentum / 9.0))


@pytest.mark.parametrize("axis", range(3))
def test_divisions_by_one_limit_are_the_best_there_are(design, axis):
    """About a body axis the wheels along it give all their torque together, or reach their speeds together."""
    rng = np.random.default_rng(axis)
    axes, n = design.plant.wheel_axis, design.plant.wheels
    torque, momentum = rng.uniform(0.2, 1.0, n), rng.uniform(5.0, 9.0, n)
    body = 3.0 * np.eye(3)[axis]
    accelerations, rates = limits_about(wheels_for(axes, torque, momentum, np.zeros(n)), body[:, np.newaxis])
    assert accelerations.shape == (3, 1)
    assert_allclose(accelerations[1, 0], most(axes, body, (-torque, torque)), rtol=1e-9)
    assert_allclose(rates[0, 0], most(axes, body, (-momentum, momentum)), rtol=1e-9)
    assert np.all(accelerations <= accelerations[1] * (1.0 + 1e-12))
    assert np.all(rates <= rates[0] * (1.0 + 1e-12))


def test_equal_wheels_share_equally(design, flight):
    """One division, the pseudo-inverse; all wheels of an axis together give their number times one."""
    given = flight(design)
    prepared = stepper.prepare(design.controller, given)
    axes, inertia = design.plant.wheel_axis, design.controller.inertia
    (shares,) = prepared.slew_wheels.allocations
    assert_allclose(shares, -np.linalg.pinv(axes.T), atol=1e-15)
    number = np.abs(axes[:, 0]).sum()
    acceleration, rate = limits_of(prepared, np.array([1.0, 0.0, 0.0]), 0)
    assert_allclose(acceleration, 0.8 * number * given.torque_limit / inertia[0, 0], rtol=1e-12)
    stored = design.config.wheel.inertia * given.speed_band
    assert_allclose(rate, 0.8 * number * stored / inertia[0, 0], rtol=1e-12)


@pytest.mark.parametrize("guidance", ["bang-coast-bang", "qp"])
def test_every_wheel_stays_within_its_own_limits(centralised, flight, guidance):
    rng = np.random.default_rng(8)
    inertia, reached = centralised.config.wheel.inertia, []
    for case in range(300 if guidance != "qp" else 8):
        if case % 10 == 0:
            torque, band = rng.uniform(0.2, 1.0, 6), rng.uniform(0.3, 1.0, 6)
            offset = rng.uniform(-0.2, 0.2, 6)  # rad/s, of a band of 2.6 rad/s
            unequal = {"torque_factor": torque, "band_factor": band, "speed_offset": offset}
            prepared = stepper.prepare(centralised.controller, flight(centralised, guidance=guidance, **unequal))
            assert_allclose(prepared.torque_limit, torque * centralised.config.wheel.torque_limit, rtol=1e-15)
        rotation = rng.standard_normal(3) * 10.0 ** rng.uniform(-5.0, -1.0)
        motion = plan_motion(prepared, rotation, 5.0)
        share = wheel_momentum(prepared, motion)
        assert_allclose(share @ centralised.plant.wheel_axis, -prepared.inertia @ motion.axis, rtol=1e-9, atol=1e-6)
        slopes = np.abs(np.diff(motion.rates) / np.diff(motion.times)).max() * motion.scale
        speed = offset + share / inertia * motion.rates.max() * motion.scale
        used = np.abs(share) * slopes / (0.8 * prepared.torque_limit), np.abs(speed) / (0.8 * prepared.speed_band)
        # a motion is scaled so that held torques turn by its angle: most for the shortest
        assert max(part.max() for part in used) < 1.0 + 1e-3
        reached.append([part.max() for part in used])
    assert np.max(reached, axis=0) == pytest.approx([1.0, 1.0], abs=1e-3)


def test_what_a_wheel_already_stores_counts_by_direction(centralised, flight):
    """Both wheels about x turn as the slew will: less is left for it, and more for its reverse."""
    axes, wheel = centralised.plant.wheel_axis, centralised.config.wheel
    offset = 0.3 * wheel.speed_band * axes[:, 0]
    prepared = stepper.prepare(centralised.controller, flight(centralised, speed_offset=offset))
    rates = [plan_motion(prepared, np.array([sign * 0.1, 0.0, 0.0]), 5.0).rates.max() for sign in (1.0, -1.0)]
    nominal = 0.8 * 2.0 * wheel.inertia * wheel.speed_band / centralised.controller.inertia[0, 0]
    # a body that turns about +x drives the wheels' speeds against it
    assert_allclose(rates, np.array([1.1, 0.5]) / 0.8 * nominal, rtol=1e-6)


def test_the_reference_drives_each_wheel_by_its_share(centralised, flight):
    """A failed wheel has none of the torque; the rest of its axis gives it, and is limited by itself."""
    factor = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    quick = {"torque_limit": 1e5, "speed_band": 1e5}
    prepared = stepper.prepare(centralised.controller, flight(centralised, torque_factor=factor, **quick))
    state = stepper.init(prepared, np.array([0.3, 0.0, 0.0]), 0.5)
    measured = stepper.Measurements(
        gyro_rate=np.zeros(23), accelerometer=np.zeros(13), encoder_speed=centralised.model.nominal_speed.copy(),
        encoder_angle=np.zeros(6), star_tracker_mrp=np.zeros(3), star_tracker_valid=False,
    )  # fmt: skip
    torques = []
    for k in range(round((state.profile.end + 0.3) / 0.005)):
        out = stepper.step(prepared, state, 0.005 * k, measured)
        torques.append(out.reference_torque.copy())
        assert out.torque[0] == 0.0
    largest = np.abs(torques).max(axis=0)
    assert_allclose(largest, [0.0, 0.0, 0.0, 0.8e5, 0.0, 0.0], rtol=0.02, atol=1e-6)  # shaped; held over periods
    assert np.all(largest <= 0.8 * prepared.torque_limit * (1.0 + 1e-3))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"torque_factor": np.array([0.0, 1.0, 1.0, 0.0, 1.0, 1.0])},
         r"wheel\.torque_limit_factor: the wheels that have torque cannot turn the body about all axes"),
        ({"torque_factor": np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])},
         r"wheel\.torque_limit_factor\[2\] must be >= 0, got -1\.0"),
        ({"band_factor": np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])},
         r"wheel\.speed_band_factor\[3\] must be > 0, got 0\.0"),
        ({"speed_offset": np.array([0.0, 0.0, 0.0, 0.0, 2.5, 0.0])},
         r"wheel\.speed_offset: wheel 5 has 11\.55 N\.m\.s at rest, of 9\.676 N\.m\.s that a slew may use"),
    ],
)  # fmt: skip
def test_limits_without_sense_are_refused(centralised, flight, changes, message):
    with pytest.raises(ValueError, match=message):
        stepper.prepare(centralised.controller, flight(centralised, **changes))


def test_slews_of_a_chain_are_timed_by_each_turn(centralised, flight):
    """The time at which a queued slew may begin is that at which the chain of the first has ended."""
    prepared = stepper.prepare(centralised.controller, flight(centralised, torque_limit=1e5, speed_band=1e5))
    state = stepper.init(prepared, np.array([0.3, 0.0, 0.0]), 0.5)
    state.turns[:2] = [[0.0, 0.0, 0.4], [0.0, 0.2, 0.0]]
    first, second, third = commands.planned_motions(prepared, state)
    pause = 2.0 * prepared.shaper.shifts[0] + 0.005
    assert [second.start, third.start] == pytest.approx([first.end + pause, second.end + pause], abs=1e-12)
    after = third.end + pause
    with pytest.raises(ValueError, match=rf"to begin at {after:.3f} s or later"):
        commands.command(prepared, state, 0.6, np.array([0.1, 0.0, 0.0]), after - 0.01)
    commands.command(prepared, state, 0.6, np.array([0.1, 0.0, 0.0]), after + 0.01)
    planned = commands.planned_motions(prepared, state)
    assert [motion.angle for motion in planned] == pytest.approx([0.3, 0.4, 0.2, 0.1])
    begun = {}
    for k in range(120, round((planned[-1].end + 1.0) / 0.005)):
        commands.proceed(prepared, state, 0.005 * k)  # as every step does
        begun[state.profile.start] = state.profile.angle
    assert begun == {motion.start: motion.angle for motion in planned}
    expected = Rotation.identity()
    for turn in ([0.3, 0.0, 0.0], [0.0, 0.0, 0.4], [0.0, 0.2, 0.0]):
        expected = expected * Rotation.from_rotvec(turn)
    assert (Rotation.from_quat(state.origin).inv() * expected).magnitude() < 1e-14
