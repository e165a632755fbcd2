"""Turns and chains of turns that stay outside keep-out cones: against dense samples of the attitudes, by SciPy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from flexsat.runtime.keep_out import LEGS, is_clear, keep_out, plan_legs

DEGREE = np.pi / 180.0
BORESIGHT = np.array([0.0, 0.0, 1.0])
ONE = np.array([[0.0, np.sin(20.0 * DEGREE), np.cos(20.0 * DEGREE)], [0.0, 0.0, 0.0]])  # 20 deg from the boresight
HERE, ABOUT_X = np.array([0.0, 0.0, 0.0, 1.0]), np.array([-40.0 * DEGREE, 0.0, 0.0])  # leads through that direction
ENTERED = 1e-9  # rad, required


def by_angle(turns):
    return np.linalg.norm(turns, axis=1) + 0.01


def above(cones, attitude, turn, samples=101):
    """Return how far outside the cones the axis stays at least [rad], at samples of a turn."""
    attitudes = Rotation.from_quat(attitude) * Rotation.from_rotvec(np.outer(np.linspace(0.0, 1.0, samples), turn))
    pointing = attitudes.apply(cones.axis.copy())  # SciPy's rotations turn vectors: from body to inertial
    angles = [
        np.arctan2(np.linalg.norm(np.cross(pointing, direction), axis=1), pointing @ direction) - half
        for direction, half in zip(cones.directions, cones.half_angles, strict=True)
        if half > 0.0
    ]
    return float(np.min(angles))


def drawn(rng, wide):
    """Return cones, an attitude and a rotation, all random."""
    halves = [rng.uniform(2.0, wide) * DEGREE, rng.choice([0.0, rng.uniform(2.0, 35.0)]) * DEGREE]
    cones = keep_out(rng.standard_normal(3), rng.standard_normal((2, 3)), np.array(halves))
    rotation = rng.standard_normal(3)
    return cones, Rotation.random(rng=rng).as_quat(), rotation * rng.uniform(0.0, np.pi) / np.linalg.norm(rotation)


def test_turns_are_clear_where_no_sample_is_inside():
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(400):
        cones, attitude, turn = drawn(rng, 80.0)
        least = above(cones, attitude, turn)
        if abs(least) > 1e-3:  # rad: between the samples
            assert is_clear(cones, attitude[np.newaxis], turn[np.newaxis])[0] == (least > 0.0)
            seen.add(least > 0.0)
    assert seen == {True, False}


def test_chains_never_enter_a_cone_and_end_on_the_commanded_attitude():
    """Random commands, also past cones of more than a hemisphere; one cone can always be passed."""
    rng = np.random.default_rng(4)
    counts = np.zeros(LEGS + 1, int)
    longer = []
    for case in range(400):
        cones, attitude, rotation = drawn(rng, 40.0 if case % 4 else 120.0)
        try:
            turns = plan_legs(cones, attitude, rotation, by_angle)
        except ValueError as error:
            inside = "within keep_out." in str(error)
            assert inside or cones.half_angles.all()  # none round two cones
            if inside:
                end = (Rotation.from_quat(attitude) * Rotation.from_rotvec(rotation)).as_quat()
                assert min(above(cones, attitude, 0.0 * rotation), above(cones, end, 0.0 * rotation)) < 0.0
            continue
        flown = turns[np.any(turns, axis=1)]
        counts[len(flown)] += 1
        assert not turns[len(flown) :].any()
        at = Rotation.from_quat(attitude)
        target = at * Rotation.from_rotvec(rotation)
        for turn in flown:
            assert above(cones, at.as_quat(), turn) > -ENTERED
            at = at * Rotation.from_rotvec(turn)
        assert (at.inv() * target).magnitude() < ENTERED
        if len(flown) > 1:
            longer.append(np.linalg.norm(flown, axis=1).sum() / np.linalg.norm(rotation))
    assert counts[1] > 100
    assert counts[2:].sum() > 10
    assert np.median(longer) < 1.3


def test_the_way_round_a_cone_is_short():
    """Over 40 deg past a cone of 15 deg half-angle: on the sphere, two tangents and an arc on the cone are shortest."""
    half = 15.0 * DEGREE
    cones = keep_out(BORESIGHT, ONE, np.array([half, 0.0]))
    turns = plan_legs(cones, HERE, ABOUT_X, by_angle)
    to_centre = 20.0 * DEGREE
    tangent = np.arccos(np.cos(to_centre) / np.cos(half))
    arc = np.sin(half) * (np.pi - 2.0 * np.arccos(np.tan(half) / np.tan(to_centre)))
    assert np.linalg.norm(turns, axis=1).sum() < 1.15 * (2.0 * tangent + arc)
    assert_allclose(plan_legs(cones, HERE, -ABOUT_X, by_angle)[0], -ABOUT_X)  # away from it, as commanded


@pytest.mark.parametrize(
    ("half", "message"),
    [
        (20.1, r"the slew begins with keep_out\.axis at 20 deg from keep_out\.first\.direction, within"
         r" keep_out\.first\.half_angle = 20\.1 deg; command another attitude, or set that angle lower"),
        (16.0, r"the slew ends with keep_out\.axis at 15 deg from keep_out\.first\.direction, within"),
    ],
)  # fmt: skip
def test_a_slew_from_or_to_within_a_cone_is_refused(half, message):
    cones = keep_out(BORESIGHT, ONE, np.array([half * DEGREE, 0.0]))
    with pytest.raises(ValueError, match=message):
        plan_legs(cones, HERE, ABOUT_X * 5.0 / 40.0, by_angle)


def test_a_slew_may_begin_and_end_at_the_edge():
    cones = keep_out(BORESIGHT, ONE, np.array([20.0 * DEGREE, 0.0]))
    turns = plan_legs(cones, HERE, ABOUT_X, by_angle)
    assert np.count_nonzero(np.any(turns, axis=1)) > 1
    assert above(cones, HERE, turns[0]) > -ENTERED


def test_cones_without_sense_are_refused():
    with pytest.raises(ValueError, match=r"keep_out\.second\.half_angle must be in \[0, pi\), got -1\.0"):
        keep_out(BORESIGHT, ONE, np.array([0.0, -1.0]))
    with pytest.raises(ValueError, match=r"keep_out\.second\.direction must not be zero where its half_angle is > 0"):
        keep_out(BORESIGHT, ONE, np.array([0.0, 1.0]))
    with pytest.raises(ValueError, match=r"keep_out\.axis must not be zero"):
        keep_out(np.zeros(3), ONE, np.zeros(2))
