"""The paper's quadratic programme for the slew: what the bang-coast-bang profile is the near-optimum of.

Attitude and rate errors squared, summed over the steps; torque and wheel momentum bounded (P, section 4). It is solved
about one axis, with angle and rate both in units of the slew angle. Design time only, with a well-known solver: what
flies solves it itself (flexsat.runtime.slew_optimum), or has nearly this optimum in closed form (slew_guidance).
"""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy import sparse

from ..arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Programme:
    """Optimal single-axis slew. Angles count from the start attitude."""

    time: Array  # (k + 1,) [s] from the start of the slew
    rotation: Array  # (k + 1,) [rad]
    rate: Array  # (k + 1,) [rad/s]
    torque: Array  # (k,) [N.m] on the spacecraft, held over each step
    angle: float  # rad

    def settling_time(self, fraction: float = 0.01) -> float:
        """Return when the rotation is last off the target by more than a fraction of it [s], interpolated."""
        off = np.abs(self.rotation - self.angle) - fraction * abs(self.angle)
        last = int(np.flatnonzero(off > 0.0)[-1])
        share = off[last] / (off[last] - off[last + 1])
        return float(self.time[last] + share * (self.time[last + 1] - self.time[last]))

    @property
    def coast_rate(self) -> float:
        """The rate half way through the slew [rad/s]."""
        return float(np.interp(0.5 * self.settling_time(), self.time, self.rate))


def solve_slew_programme(
    angle: float,
    inertia: float,
    torque: float,
    momentum: float,
    duration: float = 150.0,
    step: float = 0.25,
    rate_weight: float = 1.0,
    initial: float = 0.0,
) -> Programme:
    """Solve the programme for a turn from rest, or from an initial rate, with an interior-point method.

    Parameters
    ----------
    angle : [rad]
    inertia : about the axis [kg.m2]
    torque, momentum : bounds [N.m], [N.m.s]
    duration, step : horizon and step [s]
    rate_weight : of the rate error [s2]; without it the optimum overshoots
    initial : rate at the start [rad/s]

    Returns
    -------
    Programme
        Exact for torque held over each step.

    Raises
    ------
    ValueError
        If the solver finds no optimum.
    """
    count = round(duration / step)
    # variables: rotation and rate in units of the angle at 1..count, then torque over its bound at 0..count-1
    rotation, rate, drive = (slice(k * count, (k + 1) * count) for k in range(3))
    gain = torque / (inertia * angle)  # 1/s2 for a full torque
    identity = sparse.identity(count, format="csc")
    before = sparse.diags_array(np.ones(count - 1), offsets=-1, shape=(count, count), format="csc")
    dynamics = sparse.vstack(
        [
            sparse.hstack([identity - before, -step * before, -0.5 * step**2 * gain * identity]),
            sparse.hstack([sparse.csc_array((count, count)), identity - before, -step * gain * identity]),
        ]
    )
    most = momentum / (inertia * angle)  # 1/s
    picks = sparse.hstack([sparse.csc_array((2 * count, count)), sparse.identity(2 * count)])
    limits = np.concatenate([np.full(count, most), np.ones(count)])
    constraints = sparse.csc_matrix(sparse.vstack([dynamics, picks, -picks]))
    bounds = np.concatenate([np.zeros(2 * count), limits, limits])
    bounds[0], bounds[count] = step * initial / angle, initial / angle  # the first step, from the initial rate
    quadratic = np.zeros(3 * count)
    quadratic[rotation], quadratic[rate] = 2.0, 2.0 * rate_weight
    linear = np.zeros(3 * count)
    linear[rotation] = -2.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(sparse.diags_array(quadratic)),
        linear,
        constraints,
        bounds,
        [clarabel.ZeroConeT(2 * count), clarabel.NonnegativeConeT(4 * count)],
        settings,
    )
    solution = solver.solve()
    if str(solution.status) != "Solved":
        raise ValueError(f"solve_slew_programme: the solver ended with {solution.status}, not with an optimum")
    values = np.array(solution.x)
    return Programme(
        time=step * np.arange(count + 1, dtype=np.float64),
        rotation=angle * np.concatenate([[0.0], values[rotation]]),
        rate=np.concatenate([[initial], angle * values[rate]]),
        torque=torque * values[drive],
        angle=angle,
    )
