"""Linear-quadratic regulator on the stabilisable subspace: no translation, no net wheel momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..description.wheel_set import over_largest
from ..fixed_order import complement, product
from ..parameters import Weights
from ..spacecraft.assembly import Spacecraft
from ..spacecraft.linear_model import LinearModel
from .refined_gain import refined_gain
from .riccati import RiccatiStep, steady_state

# of the sampled closed loop: what the weights do not see stays at 1, and the solver errs by 1e-8 there
SLOWEST_POLE = 1.0 - 1e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Regulator:
    """State feedback tau = tau_ref - gain (x - x_ref) on the unfiltered linear state, and the weights behind it."""

    gain: Array  # (n, s) [N.m per unit of state]
    basis: Array  # (s, c): orthonormal basis of the controlled subspace
    state_weight: Array  # (c, c)
    torque_weight: Array  # (n, n) [1/(N.m)^2]


def null_wheel_basis(spacecraft: Spacecraft) -> Array:
    """Return an orthonormal basis, (n, n - 3), of wheel speed changes that leave the net momentum alone."""
    _, share = over_largest(spacecraft.wheel_set.inertia)
    return complement(spacecraft.wheels.axis * share[:, np.newaxis])


def design_regulator(spacecraft: Spacecraft, model: LinearModel, weights: Weights, period: float) -> Regulator:
    """Solve the infinite-horizon problem for torques held over `period` [s].

    Source: P, section 6, with the weights of the authors' release; Riccati equation by python-control. Its solver in
    SciPy is used and not the one in slycot, which fails on the distributed layout.

    Raises
    ------
    ValueError
        If no gain stabilises what these weights see.
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
    diagonal[index.modal_displacement] = weights.modal_displacement / spacecraft.frequency**2 + weights.deformation
    diagonal[index.modal_velocity] = weights.modal_velocity / spacecraft.frequency**2
    diagonal[moving:] = weights.null_wheel_speed / weights.scale
    state_weight = np.diag(diagonal)
    # each wheel's torque weighs as a share of its limit
    _, limits = over_largest(spacecraft.wheel_set.torque_limit)
    torque_weight = weights.torque / weights.scale * np.diag(1.0 / limits**2)

    ad, bd, _ = model.sampled(period)
    n = index.unfiltered
    a, b = product(product(basis.T, ad[:n, :n]), basis), product(basis.T, bd[:n])
    try:
        cost, poles = _solved(a, b, state_weight, torque_weight)
        slowest = float(np.max(np.abs(poles)))
        if not slowest < SLOWEST_POLE:
            raise np.linalg.LinAlgError(f"a closed-loop pole at {slowest:.9f} is not inside the unit circle")
    except ValueError as error:
        raise ValueError(
            f"design_regulator: no stabilising gain with {weights}: {error}; mrp and null_wheel_speed must be > 0, and"
            " the momenta of the wheels at their nominal speeds should cancel"
        ) from error
    gain = refined_gain(a, b, state_weight, torque_weight, cost)
    return Regulator(gain=product(gain, basis.T), basis=basis, state_weight=state_weight, torque_weight=torque_weight)


def _solved(a: Array, b: Array, state_weight: Array, torque_weight: Array) -> tuple[Array, Array]:
    """Return the cost matrix (n, n) and the closed-loop poles (n,).

    SciPy orders eigenvalues of a pencil, which fails on some processors and not on others where poles are near the unit
    circle. Doubling orders nothing; either solution is refined afterwards, to the same gain.
    """
    import control  # here, as it loads matplotlib and scipy.stats: most commands design nothing and start without it

    try:
        _, cost, poles = control.dlqr(a, b, state_weight, torque_weight, method="scipy")
    except ValueError:  # numpy's LinAlgError is one; SciPy's reordering raises no other
        acting = b @ np.linalg.solve(torque_weight, b.T)
        cost = steady_state([RiccatiStep(a=a.T, g=state_weight, h=0.5 * (acting + acting.T))])
        gain = np.linalg.solve(torque_weight + b.T @ cost @ b, b.T @ cost @ a)
        poles = np.linalg.eigvals(a - b @ gain)
    return cost, poles
