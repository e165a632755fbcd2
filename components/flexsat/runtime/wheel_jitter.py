"""Run-time wheel jitter: harmonics of the imbalance. numpy alone.

Along the wheel's lateral axes a, b at angle th and speed W: force C_f W^2 (sin th, cos th), torque
C_t W^2 (-cos th, sin th) (P, section 4). Other harmonics have a multiple of the angle in its place, and a phase; those
of bearings are not whole (Masterson, Miller, Grogan (2002), Journal of Sound and Vibration 249(3), 575-598). A value
that is held over a step is taken at the middle of the step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, make_read_only


def harmonic(speed: Array, angle: Array, hold: float, force: Array, torque: Array, out: Array) -> Array:
    """Write the harmonic jitter of n wheels, held over `hold` [s] from now, into `out`.

    Parameters
    ----------
    speed, angle : (n,) [rad/s], [rad] at the start of the step
    hold : [s]; at 5 ms, mid-step costs 0.4 % of the deformation, the start of the step 10 % (PHYSICS section 4)
    force, torque : (n,) imbalance coefficients [N.s2/rad2], [N.m.s2/rad2]
    out : (4, n): force a, force b [N], torque a, torque b [N.m]
    """
    middle = angle + (0.5 * hold) * speed
    square = speed * speed
    sine, cosine = np.sin(middle), np.cos(middle)
    sine *= square
    cosine *= square
    np.multiply(sine, force, out=out[0])
    np.multiply(cosine, force, out=out[1])
    np.multiply(cosine, -torque, out=out[2])
    np.multiply(sine, torque, out=out[3])
    return out


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonics:
    """Harmonics beside the first, (p, n) each; those that a wheel lacks have no size."""

    order: Array
    force: Array  # N.s2/rad2
    torque: Array  # N.m.s2/rad2
    phase: Array  # rad

    def __post_init__(self) -> None:
        make_read_only(self)


def add_harmonics(harmonics: Harmonics, speed: Array, angle: Array, hold: float, out: Array) -> None:
    """Add the jitter of further harmonics to `out`, (4, n), in place; arguments as of `harmonic`."""
    middle = harmonics.order * (angle + (0.5 * hold) * speed) + harmonics.phase
    square = speed * speed
    sine, cosine = np.sin(middle) * square, np.cos(middle) * square
    out[0] += np.sum(harmonics.force * sine, axis=0)
    out[1] += np.sum(harmonics.force * cosine, axis=0)
    out[2] -= np.sum(harmonics.torque * cosine, axis=0)
    out[3] += np.sum(harmonics.torque * sine, axis=0)
