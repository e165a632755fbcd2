"""Linear-quadratic regulator on the stabilisable subspace: no translation, no net wheel momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from ..arrays import Array
from ..parameters import Weights
from ..spacecraft.assembly import Spacecraft
from ..spacecraft.linear_model import LinearModel
from .riccati import RiccatiStep, steady_state


@dataclass(frozen=True, slots=True, kw_only=True)
class Regulator:
    """State feedback tau = tau_ref - gain (x - x_ref) on the unfiltered linear state, and the weights behind it."""

    gain: Array  # (n, s) [N.m per unit of state]
    basis: Array  # (s, c): orthonormal basis of the controlled subspace
    state_weight: Array  # (c, c)
    torque_weight: Array  # (n, n) [1/(N.m)^2]


def null_wheel_basis(spacecraft: Spacecraft) -> Array:
    """Return an orthonormal basis, (n, n - 3), of wheel speed changes that leave the net momentum alone."""
    return np.asarray(null_space(spacecraft.wheels.axis.T))


def design_regulator(spacecraft: Spacecraft, model: LinearModel, weights: Weights, period: float) -> Regulator:
    """Solve the infinite-horizon problem for torques held over `period` [s].

    Source: P, section 6, with the weights of the authors' release; Riccati equation by doubling.
    """
    index = model.index
    null = null_wheel_basis(spacecraft)
    moving = index.wheel_speed.start
    basis = np.zeros((index.unfiltered, moving + null.shape[1]))
    basis[:moving, :moving] = np.eye(moving)
    basis[moving:, moving:] = null

    diagonal = np.empty(basis.shape[1])
    diagonal[index.mrp] = weights.mrp
    diagonal[index.rate] = weights.rate
    diagonal[index.modal_displacement] = weights.modal_displacement / spacecraft.frequency**2
    diagonal[index.modal_velocity] = weights.modal_velocity / spacecraft.frequency**2
    diagonal[moving:] = weights.null_wheel_speed / weights.scale
    state_weight = np.diag(diagonal)
    torque_weight = weights.torque / weights.scale * np.eye(spacecraft.wheel_count)

    ad, bd, _ = model.sampled(period)
    n = index.unfiltered
    a, b = basis.T @ ad[:n, :n] @ basis, basis.T @ bd[:n]
    spread = b @ np.linalg.solve(torque_weight, b.T)
    value = steady_state([RiccatiStep(a=a.T, g=state_weight, h=spread)])
    gain = np.asarray(np.linalg.solve(torque_weight + b.T @ value @ b, b.T @ value @ a) @ basis.T, dtype=float)
    return Regulator(gain=gain, basis=basis, state_weight=state_weight, torque_weight=torque_weight)
