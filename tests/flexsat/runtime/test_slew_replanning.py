"""Slews that begin while the body turns: replanned by the quadratic programme, and led round keep-out cones."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexsat.runtime import controller as stepper
from flexsat.runtime import slew_commands as commands
from flexsat.runtime.keep_out import keep_out
from flexsat.runtime.named_state import named_values
from flexsat.runtime.prepared_controller import wheel_momentum

DEGREE = np.pi / 180.0
PERIOD = 0.005
QUICK = {"torque_limit": 1e6, "speed_band": 3e4}  # 10 rad/s2, and some rad/s
PLANNED = 1e-9  # rad, required of a reference
ABOUT_X = np.array([0.5 * DEGREE, 0.0, 0.0])
CONES = keep_out(
    np.array([0.0, 0.0, 1.0]),
    np.array([[0.0, np.sin(0.7), np.cos(0.7)], [0.8, 0.0, 0.6]]),
    np.array([0.4, 0.3]),
)


def ready(design, flight, rotation=(0.0, 0.0, 0.0), **changes):
    prepared = stepper.prepare(design.controller, flight(design, guidance="qp", during_slew="replan", **changes))
    state = stepper.init(prepared, np.array(rotation), 5.0)
    commands.start_from(prepared, state, 0.0, (0.0, 0.0, 0.0, 1.0))
    return prepared, state


def flown(prepared, spans):
    """Return attitude, rates and torques [N.m] (steps, n) of a rigid body under the torques held over periods.

    `spans` are motions with the times [s] up to which they are flown, each about its axis.
    """
    attitude, rates, torques, first, shaper = Rotation.identity(), [], [], 0, prepared.shaper
    for motion, until in spans:
        last = round(until / PERIOD)
        times = PERIOD * np.arange(first, last + 1)
        shaped = [w * motion.rate(times + t) for w, t in zip(shaper.weights, shaper.shifts, strict=True)]
        rate = motion.scale * np.sum(shaped, axis=0)
        torques.append(np.outer(np.diff(rate) / PERIOD, wheel_momentum(prepared, motion)))
        turned = PERIOD * (rate.sum() - 0.5 * (rate[0] + rate[-1]))
        attitude, first = attitude * Rotation.from_rotvec(turned * motion.axis), last
        rates.append(rate)
    return attitude, rates, np.vstack(torques)


def to_their_ends(prepared, turns):
    """Return the turns with the times at which the shaped torque of each has ended."""
    return [(turn, PERIOD * np.ceil((turn.end + prepared.shaper.shifts[0]) / PERIOD)) for turn in turns]


# new commands 30 s after the first began at 5 s, which has then turned .127 deg of .5 deg
@pytest.mark.parametrize(
    ("second", "quicker"),
    [
        ((0.3, 0.0, 0.0), True),  # nearer, and still ahead
        ((0.9, 0.0, 0.0), True),  # farther
        ((-0.2, 0.0, 0.0), False),  # behind: it has to stop
        ((0.6, 0.0, 0.1), False),  # about another axis: quicker by one turn than by two
        ((0.0, 0.3, 0.1), False),
    ],
)
def test_a_command_during_a_slew_is_planned_from_its_rate(centralised, flight, second, quicker):
    """The reference ends on it at rest, and torques and momenta stay within what slews may use."""
    prepared, state = ready(centralised, flight, ABOUT_X)
    before, target = state.profile, np.array(second) * DEGREE
    commands.command(prepared, state, 35.0, target, 0.0)
    turns = commands.planned_motions(prepared, state)
    assert state.braking != quicker
    attitude, rates, torques = flown(prepared, [(before, 35.0), *to_their_ends(prepared, turns)])
    assert (attitude.inv() * Rotation.from_rotvec(target)).magnitude() < PLANNED
    assert rates[0][-1] > 0.0  # it was turning
    assert_allclose(rates[1][0], rates[0][-1], rtol=1e-13)  # and goes on at the same rate
    assert_allclose([rate[-1] for rate in rates[1:]], 0.0, atol=1e-15)
    wheel = centralised.config.wheel
    within = 0.8 * (1.0 + 1e-6)  # of the method that solves the programme
    assert np.abs(torques).max() <= within * wheel.torque_limit
    assert np.abs(np.cumsum(torques, axis=0)).max() * PERIOD <= within * wheel.inertia * wheel.speed_band


def test_going_on_is_quicker_than_braking(centralised, flight):
    """To .9 deg from .5 deg in flight: one coast at the largest rate, where braking would add a ramp and the rest."""
    prepared, state = ready(centralised, flight, ABOUT_X)
    commands.command(prepared, state, 35.0, 1.8 * ABOUT_X, 0.0)
    (motion,) = commands.planned_motions(prepared, state)
    rate = state.profile.rates.max()
    # the first had its ramp: what is left at 35 s is coasted, and the end is that of the programme
    alone = stepper.init(prepared, 1.8 * ABOUT_X, 5.0).profile
    assert_allclose(motion.end, alone.end, atol=0.2)
    assert_allclose(rate, alone.rates.max(), rtol=1e-6)


def test_a_replanned_slew_is_flown_by_the_controller(centralised, flight):
    """About z, where modes do not turn with the body: the reference of every step is continuous, and ends there."""
    axis = np.array([0.0, 0.0, 1.0])
    prepared, state = ready(centralised, flight, 0.5 * axis, **QUICK)
    measured = stepper.Measurements(
        gyro_rate=np.zeros(23), accelerometer=np.zeros(13), encoder_speed=centralised.model.nominal_speed.copy(),
        encoder_angle=np.zeros(6), star_tracker_mrp=np.zeros(3), star_tracker_valid=False,
    )  # fmt: skip
    found = []
    for k in range(900, 4200):
        if k == 1080:
            commands.command(prepared, state, PERIOD * k, 0.9 * axis, 0.0)
        out = stepper.step(prepared, state, PERIOD * k, measured)
        found.append([4.0 * np.arctan(out.reference[2]), out.reference[centralised.model.index.rate][2]])
    angle, rate = np.array(found).T
    assert_allclose(angle[-1], 0.9, atol=PLANNED)
    assert_allclose(rate[-1], 0.0, atol=PLANNED)
    assert not state.braking
    assert_allclose(np.diff(angle), PERIOD * 0.5 * (rate[1:] + rate[:-1]), atol=1e-9)  # as torques held over periods
    assert np.abs(np.diff(rate)).max() < 1.01 * 0.8 * PERIOD * 2e6 / centralised.controller.inertia[2, 2]
    assert rate[180] > 0.05  # it was turning


@pytest.mark.parametrize("guidance", ["bang-coast-bang", "qp"])
def test_commands_at_any_time_end_where_they_lead_outside_the_cones(centralised, flight, guidance):
    """Chains cut short and replanned again and again: the attitude never enters a cone, wheels keep their limits."""
    rng = np.random.default_rng(11)
    unequal = {"torque_factor": rng.uniform(0.3, 1.0, 6), "band_factor": rng.uniform(0.3, 1.0, 6)}
    prepared = stepper.prepare(
        centralised.controller,
        flight(centralised, guidance=guidance, during_slew="replan", keep_out=CONES, **QUICK, **unequal),
    )
    state = stepper.init(prepared, np.zeros(3), 5.0)
    commands.start_from(prepared, state, 0.0, (0.0, 0.0, 0.0, 1.0))
    k, accepted, chains = 0, 0, 0
    for number in range(6 if guidance == "qp" else 100):
        rotation = rng.standard_normal(3)
        rotation *= rng.uniform(0.1, 2.5) / np.linalg.norm(rotation)
        commands.proceed(prepared, state, PERIOD * k)
        before = named_values(state)
        try:
            commands.command(prepared, state, PERIOD * k, rotation, PERIOD * k)
        except ValueError as error:
            assert "within keep_out" in str(error)  # noqa: PT017  others are not excepted
            assert all(np.array_equal(value, before[name]) for name, value in named_values(state).items())
            continue
        accepted += 1
        target = Rotation.from_quat(state.base) * Rotation.from_rotvec(rotation)
        turns = commands.planned_motions(prepared, state)
        chains += len(turns) > 1
        at = Rotation.from_quat(state.origin)
        for turn in turns:
            part = Rotation.from_rotvec(np.outer(np.linspace(0.0, turn.angle, 60), turn.axis))
            pointing = (at * part).apply([0.0, 0.0, 1.0])
            for direction, half in zip(CONES.directions, CONES.half_angles, strict=True):
                assert np.arccos(pointing @ direction).min() > half - 1e-9
            at = at * part[-1]
        assert (at.inv() * target).magnitude() < PLANNED
        k += round((turns[-1].end - PERIOD * k) * rng.uniform(0.1, 1.1 if number % 3 else 0.5) / PERIOD)
    assert accepted > (2 if guidance == "qp" else 40)
    assert chains > 0


def test_a_chain_round_a_cone_is_flown_to_its_end(centralised, flight):
    """Every turn of the chain as torques held over periods, from the initial command to the commanded attitude."""
    rotation = np.array([-1.4, 0.0, 0.0])  # through the middle of the first cone
    prepared = stepper.prepare(centralised.controller, flight(centralised, keep_out=CONES, **QUICK))
    state = stepper.init(prepared, rotation, 0.5)
    commands.start_from(prepared, state, 0.0, (0.0, 0.0, 0.0, 1.0))
    turns = commands.planned_motions(prepared, state)
    assert len(turns) > 1
    attitude, rates, _ = flown(prepared, to_their_ends(prepared, turns))
    assert (attitude.inv() * Rotation.from_rotvec(rotation)).magnitude() < PLANNED
    assert_allclose([rate[-1] for rate in rates], 0.0, atol=1e-12)
    for k in range(round((turns[-1].end + 1.0) / PERIOD)):
        commands.proceed(prepared, state, PERIOD * k)  # as the steps do
    assert not state.turns.any()
    assert state.profile.start == turns[-1].start


def test_a_slew_within_a_cone_is_refused_when_the_attitude_is_known(centralised, flight):
    """At the first sample of the star tracker, from where the run begins; and a slew before it is refused."""
    prepared = stepper.prepare(centralised.controller, flight(centralised, keep_out=CONES))
    inside = Rotation.from_rotvec([-0.7, 0.0, 0.0])
    state = stepper.init(prepared, ABOUT_X, 5.0)
    x, y, z, w = inside.as_quat()
    with pytest.raises(ValueError, match=r"the slew begins with keep_out\.axis at .* deg from keep_out\.first"):
        commands.start_from(prepared, state, 0.0, (x, y, z, w))
    state = stepper.init(prepared, ABOUT_X, 5.0)
    with pytest.raises(ValueError, match=r"slew of 5\.000 s begins before the star tracker has given an attitude"):
        commands.proceed(prepared, state, 6.0)
    with pytest.raises(ValueError, match=r"keep_out: as_published has attitudes as sums"):
        flight(centralised, keep_out=CONES, linear_attitude=True)
