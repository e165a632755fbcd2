"""Plan a slew as the optimum of the paper's quadratic programme, with an interior-point method. numpy alone.

Attitude and rate errors squared, torque and wheel momentum bounded (P, section 4), about one axis, with angle and rate
in units of the slew angle, from rest or from the rate of a slew in flight. The end is prescribed, at rest on the
commanded angle and without overshoot, where the paper's only tends to it: the next slew begins from there.
flexsat.design.slew_programme solves the same programme without the prescribed end.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array

RATE_WEIGHT = 1.0  # s2, of the rate error squared; without it the optimum overshoots
STEPS = 200  # of constant torque
TAIL = 12.0  # s after the shortest time: the optimum comes to rest with the time constant of the rate weight, 1 s
ITERATIONS = 60
DONE = 1e-12  # of the duality gap, relative to the cost's gradient
STATIONARY = 1e-6  # of the Lagrangian's gradient: rounding of multipliers that no unique value has, 1e-8
KEPT = 1e-9  # what the constraints are missed by, in units of the bounds


def time_grid(duration: float, ramp: float) -> Array:
    """Return the knots (STEPS + 1,) [s] from 0 to beyond the shortest duration; dense where the torque changes."""
    end = duration + TAIL
    if duration <= 8.0 * ramp + TAIL:
        return np.linspace(0.0, end, STEPS + 1)
    quarter = STEPS // 4
    begin = np.linspace(0.0, 2.0 * ramp, quarter + 1)
    middle = np.linspace(2.0 * ramp, duration - 2.0 * ramp, quarter + 1)
    rest = np.linspace(duration - 2.0 * ramp, end, STEPS - 2 * quarter + 1)
    return np.concatenate([begin, middle[1:], rest[1:]])


def optimal_rates(angle: float, acceleration: float, rate: float, times: Array, initial: float = 0.0) -> Array:
    """Return the rates [rad/s] at the knots of the optimal turn, which ends at rest.

    Parameters
    ----------
    angle : [rad], > 0
    acceleration, rate : bounds [rad/s2], [rad/s]
    times : (k + 1,) [s] from the start of the slew; the torque is constant between them
    initial : rate at the start [rad/s], from 0 to `rate`

    Raises
    ------
    ValueError
        If the method finds no optimum, as for times or an angle that are too short for the turn.
    """
    steps = np.diff(times)
    n = len(steps)
    most, first = rate / angle, initial / angle
    # rates and angles at the knots 1..n, in units of the angle, are linear in the changes of rate over their bounds;
    # over a step that could pass the whole range of rates, the range is the bound
    to_rate = np.tril(np.broadcast_to(np.minimum(acceleration / angle * steps, most), (n, n)))
    mean = np.vstack([to_rate[:1] * 0.5, 0.5 * (to_rate[1:] + to_rate[:-1])])
    to_angle = np.cumsum(mean * steps[:, None], axis=0)
    weight = steps / steps.sum()
    quadratic = 2.0 * ((to_angle.T * weight) @ to_angle + RATE_WEIGHT * (to_rate.T * weight) @ to_rate)
    coasted = first * times[1:]  # angle that the initial rate alone would turn
    linear = 2.0 * (to_angle.T @ (weight * (coasted - 1.0)) + RATE_WEIGHT * first * (to_rate.T @ weight))
    # the last: no overshoot, which would be the optimum of a slew of long ramps
    inequalities = np.vstack([np.eye(n), -np.eye(n), to_rate[:-1] / most, -to_rate[:-1] / most])
    bounds = np.concatenate([np.ones(2 * n), np.full(n - 1, 1.0 - first / most), np.full(n - 1, first / most)])
    end = np.vstack([to_angle[-1], to_rate[-1] / most])
    drive = _solve(quadratic, linear, inequalities, bounds, end, np.array([1.0 - coasted[-1], -first / most]))
    rates = np.concatenate([[initial], initial + angle * (to_rate @ drive)])
    rates[-1] = 0.0
    return np.asarray(np.maximum(rates, 0.0))  # zero but for what the method leaves


def _solve(h: Array, g: Array, c: Array, d: Array, e: Array, f: Array) -> Array:
    """Minimise x^T h x / 2 + g^T x over c x <= d, e x = f: Mehrotra's predictor-corrector method.

    Source: Nocedal and Wright, Numerical Optimization, section 16.6.
    """
    n, m, k = len(g), len(d), len(f)
    x, slack, dual, multiplier = np.zeros(n), np.ones(m), np.ones(m), np.zeros(k)
    system = np.zeros((n + k, n + k))
    system[:n, n:], system[n:, :n] = e.T, e
    scale = float(np.abs(g).max())
    for _ in range(ITERATIONS):
        stationary = h @ x + g + c.T @ dual + e.T @ multiplier
        inside, on = c @ x + slack - d, e @ x - f
        gap = float(slack @ dual) / m
        missed = max(np.abs(inside).max(), np.abs(on).max())
        if gap < DONE * scale and np.abs(stationary).max() < STATIONARY * scale and missed < KEPT:
            return x
        ratio = dual / slack
        system[:n, :n] = h + (c.T * ratio) @ c

        def direction(complementary: Array) -> tuple[Array, Array, Array, Array]:
            push = c.T @ (ratio * inside - complementary / slack)  # noqa: B023  called at once
            step = np.linalg.solve(system, np.concatenate([-stationary - push, -on]))  # noqa: B023
            dx = step[:n]
            ds = -inside - c @ dx  # noqa: B023
            return dx, ds, -(complementary + dual * ds) / slack, step[n:]  # noqa: B023

        try:
            _, ds, dz, _ = direction(slack * dual)
        except np.linalg.LinAlgError:  # far from every solution the system loses its rank, on some processors
            break
        ahead = min(_longest(slack, ds), _longest(dual, dz))
        after = float((slack + ahead * ds) @ (dual + ahead * dz)) / m
        centred = slack * dual + ds * dz - (after / gap) ** 3 * gap
        dx, ds, dz, dy = direction(centred)
        length = 0.99 * min(_longest(slack, ds), _longest(dual, dz))
        x, slack, dual, multiplier = x + length * dx, slack + length * ds, dual + length * dz, multiplier + length * dy
    raise ValueError("slew.guidance = 'qp': the quadratic programme has no optimum within these limits")


def _longest(value: Array, change: Array) -> float:
    """Return the longest step up to 1 / 0.99 that keeps the values positive."""
    shrinking = change < 0.0
    return min(1.0 / 0.99, float(np.min(-value[shrinking] / change[shrinking], initial=np.inf)))
