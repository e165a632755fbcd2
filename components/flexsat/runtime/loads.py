"""The few numbers through which everything that acts on the structure acts on it. numpy alone.

What is held over a step - wheel torques, jitter wrenches on the mounts, external force and torque, gyroscopic torques
about the wheels' lateral axes (2 n) and momentum terms (6) - has a resultant on the body, (6,), and acts on the modes
through the components of the mounts' wrenches that move them: for a plate the lateral force and two torques of each
mount. The last three loads are w x p, through which P's momentum term acts on the modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Flags, make_read_only
from ..fixed_order import product
from .plant_parameters import PlantMatrices


@dataclass(frozen=True, slots=True, kw_only=True)
class Loads:
    """Maps between what is held over a step, the loads, and generalised forces on (v, w, eta')."""

    of_held: Array  # (r, held)
    force: Array  # (6 + m, r): generalised force of each load; the first six are the resultant itself
    slopes: Array  # (u, m): rates of rotation of the mounts and gyros per unit modal velocity, each row once
    mount_slopes: Array  # (3 s, u): picks those of the mounts about x, y, z
    gyro_slopes: Array  # (g, u)

    def __post_init__(self) -> None:
        make_read_only(self)


def lateral_axes(matrices: PlantMatrices) -> tuple[Array, Array]:
    """Return the axes a and b of each wheel, (n, 3) each."""
    first, second = np.split(matrices.lateral_influence[3:6], 2, axis=1)
    return first.T, second.T


def at_mounts(matrices: PlantMatrices, vectors: Array) -> Array:
    """Return (3 s, n): each wheel's vector, (n, 3), in the rows of its mount, ordered x, y, z, each over the mounts."""
    s, n = matrices.mounts, matrices.wheels
    placed = np.zeros((3, s, n))
    for component in range(3):
        placed[component, matrices.mount_of_wheel, np.arange(n)] = vectors[:, component]
    return placed.reshape(3 * s, n)


def prepare_loads(matrices: PlantMatrices) -> Loads:
    """Return the loads of a spacecraft."""
    s, m, wrench = matrices.mounts, matrices.modes, matrices.wrench_influence
    first, second = lateral_axes(matrices)
    torques = [at_mounts(matrices, -vectors) for vectors in (matrices.wheel_axis, first, second)]
    no_force = np.zeros((3 * s, matrices.wheels))
    on_wheel, about_a, about_b = (np.vstack([no_force, torque]) for torque in torques)
    given = _in_body(matrices)
    wrench_of_held = np.hstack([on_wheel, given, np.zeros((6 * s, 6)), about_a, about_b, np.zeros((6 * s, 6))])
    held, momentum_terms = wrench_of_held.shape[1], slice(wrench_of_held.shape[1] - 6, None)
    resultant = product(wrench[:6], wrench_of_held)
    resultant[:, matrices.wheels + 6 * s : matrices.wheels + 6 * s + 6] = np.eye(6)
    resultant[:, momentum_terms] = -np.eye(6)
    moving = _moving(matrices)
    turning = np.zeros((3, held))
    turning[:, held - 6 : held - 3] = np.eye(3)
    force = np.zeros((6 + m, 6 + np.count_nonzero(moving) + 3))
    force[:6, :6] = np.eye(6)
    force[6:, 6:-3] = wrench[6:, moving]
    # P has the other sign here; then uniform motion of the whole would shake the modes and feed them energy
    force[6:, -3:] = -matrices.mass_matrix[:3, 6:].T / matrices.mass_matrix[0, 0]
    slopes, picks = distinct_rows(np.vstack([wrench[6:, 3 * s :].T, matrices.gyro_slope]))
    return Loads(
        of_held=np.vstack([resultant, wrench_of_held[moving], turning]),
        force=force,
        slopes=slopes,
        mount_slopes=picks[: 3 * s],
        gyro_slopes=picks[3 * s :],
    )


def _in_body(matrices: PlantMatrices) -> Array:
    """Return the wrenches on the mounts in body axes, from those in axes that turn with the mounts, (6 s, 6 s)."""
    s = matrices.mounts
    turns = np.zeros((2, 3, s, 2, 3, s))
    for mount in range(s):
        for kind in range(2):
            turns[kind, :, mount, kind, :, mount] = matrices.mount_turn[mount]
    return turns.reshape(6 * s, 6 * s)


def _moving(matrices: PlantMatrices) -> Flags:
    """Return the components of the mounts' wrenches that move modes, (6 s,): at any angle, where a mount turns."""
    moving = np.any(matrices.wrench_influence[6:] != 0.0, axis=0).reshape(2, 3, matrices.mounts)
    turning = matrices.mount_part >= 0
    moving[:, :, turning] = np.any(moving[:, :, turning], axis=1, keepdims=True)
    return np.asarray(moving.reshape(-1))


def tilted_axes(matrices: PlantMatrices, loads: Loads, eta: Array) -> Array:
    """Return the axes of the wheels as the structure tilts them, (n, 3), to second order in eta, (m,)."""
    slope = (loads.mount_slopes @ (loads.slopes @ eta)).reshape(3, -1)[:, matrices.mount_of_wheel]
    axis, tilted = matrices.wheel_axis.T, np.empty_like(matrices.wheel_axis)
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):  # slope x axis; np.cross takes twice the time
        tilted[:, i] = axis[i] + (slope[j] * axis[k] - slope[k] * axis[j])
    return tilted


def distinct_rows(matrix: Array) -> tuple[Array, Array]:
    """Return the rows (u, m) that differ and are not zero, and the map (r, u) of zeros and ones back to all rows."""
    places: dict[bytes, int] = {}
    rows = matrix + 0.0  # zeros have no sign
    for row in rows:
        if np.any(row):
            places.setdefault(row.tobytes(), len(places))
    picks = np.zeros((len(rows), len(places)))
    for k, row in enumerate(rows):
        if np.any(row):
            picks[k, places[row.tobytes()]] = 1.0
    kept = np.array([np.frombuffer(row) for row in places]).reshape(len(places), matrix.shape[1])
    return kept, picks
