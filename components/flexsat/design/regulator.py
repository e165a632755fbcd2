"""Linear-quadratic regulator on the stabilisable subspace: no translation, no net wheel momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space, solve_discrete_lyapunov

from ..arrays import Array
from ..parameters import Weights
from ..spacecraft.assembly import Spacecraft
from ..spacecraft.linear_model import LinearModel


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

    Source: P, section 6, with the weights of the authors' release; Riccati equation by python-control. Its solver in
    SciPy is used and not the one in slycot, which fails on the distributed layout.

    Raises
    ------
    ValueError
        If no gain stabilises what these weights see.
    """
    import control  # here, as it loads matplotlib and scipy.stats: most commands design nothing and start without it

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
    try:
        gain, _, _ = control.dlqr(a, b, state_weight, torque_weight, method="scipy")
    except np.linalg.LinAlgError as error:
        raise ValueError(
            f"design_regulator: no stabilising gain with {weights}: {error}; mrp and null_wheel_speed must be > 0"
        ) from error
    gain = _improved_gain(a, b, state_weight, torque_weight, gain)
    return Regulator(gain=gain @ basis.T, basis=basis, state_weight=state_weight, torque_weight=torque_weight)


def _improved_gain(a: Array, b: Array, state_weight: Array, torque_weight: Array, gain: Array) -> Array:
    """Return the gain after one step of policy iteration, whose error is of the order of the given gain's squared.

    `dlqr` leaves a relative error of up to 2e-6 that depends on the processor's linear algebra; after this step 3e-9
    is left, so that a design is the same on every machine. Source: Hewer (1971), IEEE Trans. Automatic Control 16(4).
    """
    cost = solve_discrete_lyapunov((a - b @ gain).T, state_weight + gain.T @ torque_weight @ gain)
    return np.asarray(np.linalg.solve(torque_weight + b.T @ cost @ b, b.T @ cost @ a), dtype=float)
