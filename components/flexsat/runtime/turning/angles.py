"""The matrices of a spacecraft whose appendages stand at other angles than its file says. numpy alone.

The body axes begin at the centre of mass at rest, which moves as appendages turn, so that everything is measured from
the new one: a plant at some angles is the plant that is built with them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...arrays import Array, Index
from ...fixed_order import product
from ..plant_parameters import PlantMatrices, without_rounding
from ..rotations import skew

RIGHT = 2.0 * np.finfo(np.float64).eps  # off a whole number, of a sine or cosine of a right angle


def rotation(axis: Array, angle: float) -> Array:
    """Return the matrix of a rotation by an angle [rad] about a unit vector, (3, 3); right angles are exact."""
    cross = skew(axis.tolist())
    matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (np.outer(axis, axis) - np.eye(3))
    near = np.rint(matrix)
    return np.asarray(np.where(np.abs(matrix - near) < RIGHT, near, matrix) + 0.0)


def at_angles(matrices: PlantMatrices, angles: Array) -> PlantMatrices:
    """Return the matrices of a spacecraft with its appendages at angles, (t,) [rad]; the same ones at their own."""
    if np.array_equal(angles, matrices.turn_angle):
        return matrices
    own = [rotation(*each) for each in zip(matrices.turn_axis, (angles - matrices.turn_angle).tolist(), strict=True)]
    turns = np.array([*own, np.eye(3)])  # -1, what does not turn, picks the last
    points = np.vstack([matrices.turn_point, np.zeros(3)])
    of_mode, of_mount = turns[matrices.mode_part], turns[matrices.mount_part]
    of_wheel = of_mount[matrices.mount_of_wheel]
    moments = _turned(turns[:-1], matrices.turn_moment)
    centre = np.sum(moments - matrices.turn_moment, axis=0) / matrices.mass_matrix[0, 0]

    def moved(position: Array, parts: Index) -> Array:
        return np.asarray(points[parts] + _turned(turns[parts], position - points[parts]) - centre)

    inertias = np.array([product(product(turn, one), np.ascontiguousarray(turn.T))
                         for turn, one in zip(own, matrices.turn_inertia, strict=True)]).reshape(-1, 3, 3)  # fmt: skip
    mount_position = moved(matrices.mount_position, matrices.mount_part)
    wheel_axis = _turned(of_wheel, matrices.wheel_axis)
    torque, lateral = matrices.torque_influence.copy(), matrices.lateral_influence.copy()
    torque[3:6] = -wheel_axis.T
    by_wheel = lateral[3:6].reshape(3, 2, matrices.wheels)
    lateral[3:6] = np.einsum("nij,jkn->ikn", of_wheel, by_wheel).reshape(3, -1)
    return replace(
        matrices,
        mass_matrix=_mass(matrices, of_mode, points[matrices.mode_part], moments, inertias, centre),
        torque_influence=torque,
        wrench_influence=_wrenches(matrices, of_mount, mount_position),
        lateral_influence=lateral,
        wheel_axis=wheel_axis,
        wheel_slope=np.einsum("nij,njm->nim", of_wheel, matrices.wheel_slope),
        gyro_axis=_turned(turns[matrices.gyro_part], matrices.gyro_axis),
        accelerometer_axis=_turned(turns[matrices.accelerometer_part], matrices.accelerometer_axis),
        accelerometer_position=moved(matrices.accelerometer_position, matrices.accelerometer_part),
        turn_point=matrices.turn_point - centre,
        turn_angle=angles,
        turn_moment=moments,
        turn_inertia=inertias,
        mount_turn=np.einsum("sij,sjk->sik", of_mount, matrices.mount_turn),
        mount_position=mount_position,
    )


def _turned(turns: Array, vectors: Array) -> Array:
    """Return each vector, (k, 3), turned by its own rotation, (k, 3, 3)."""
    return np.asarray(np.einsum("kij,kj->ki", turns, vectors))


def _mass(
    matrices: PlantMatrices, of_mode: Array, points: Array, moments: Array, inertias: Array, centre: Array
) -> Array:
    """Return the mass matrix about the new centre of mass, which lies at `centre` from the old one.

    Mode by mode: its rotation, and the place of the interface of what it belongs to, (m, 3, 3) and (m, 3).
    """
    mass = matrices.mass_matrix.copy()
    momentum, about = mass[:3, 6:].T, mass[3:6, 6:].T  # of the modes, (m, 3): about the old centre
    turned = _turned(of_mode, momentum)
    turned_about = _turned(of_mode, about - np.cross(points, momentum)) + np.cross(points - centre, turned)
    mass[:3, 6:], mass[6:, :3] = turned.T, turned
    mass[3:6, 6:], mass[6:, 3:6] = turned_about.T, turned_about
    inertia = mass[3:6, 3:6]
    changes = zip(matrices.turn_point, moments - matrices.turn_moment, inertias - matrices.turn_inertia, strict=True)
    for point, moment, change in changes:
        mixed = np.outer(point, moment)
        inertia += change + 2.0 * (point @ moment) * np.eye(3) - mixed - mixed.T
    inertia -= mass[0, 0] * ((centre @ centre) * np.eye(3) - np.outer(centre, centre))
    return without_rounding(mass)


def _wrenches(matrices: PlantMatrices, of_mount: Array, position: Array) -> Array:
    """Return the generalised force of unit wrenches on the mounts, in body axes, (6 + m, 6 s)."""
    wrench, s = matrices.wrench_influence.copy(), matrices.mounts
    modal = wrench[6:].reshape(-1, 2, 3, s)
    wrench[6:] = np.einsum("sij,mkjs->mkis", of_mount, modal).reshape(-1, 6 * s)
    for k, axis in enumerate(np.eye(3)):
        wrench[3:6, k * s : (k + 1) * s] = np.cross(position, np.tile(axis, (s, 1))).T
    return wrench
