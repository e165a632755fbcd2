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
        _, cost, poles = control.dlqr(a, b, state_weight, torque_weight, method="scipy")
        slowest = float(np.max(np.abs(poles)))
        if not slowest < SLOWEST_POLE:
            raise np.linalg.LinAlgError(f"a closed-loop pole at {slowest:.9f} is not inside the unit circle")
    except ValueError as error:  # numpy's LinAlgError is one; SciPy's reordering raises no other
        raise ValueError(
            f"design_regulator: no stabilising gain with {weights}: {error}; mrp and null_wheel_speed must be > 0, and"
            " the momenta of the wheels at their nominal speeds should cancel"
        ) from error
    gain = refined_gain(a, b, state_weight, torque_weight, cost)
    return Regulator(gain=product(gain, basis.T), basis=basis, state_weight=state_weight, torque_weight=torque_weight)
