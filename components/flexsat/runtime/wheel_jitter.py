"""Run-time wheel jitter: the first harmonic of the imbalance. numpy alone.

Along the wheel's lateral axes a, b at angle th and speed W: force C_f W^2 (sin th, cos th), torque
C_t W^2 (-cos th, sin th) (P, section 4). A value that is held over a step is taken at the middle of the step.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array


def harmonic(speed: Array, angle: Array, hold: float, force: float, torque: float, out: Array) -> Array:
    """Write the harmonic jitter of n wheels, held over `hold` [s] from now, into `out`.

    Parameters
    ----------
    speed, angle : (n,) [rad/s], [rad] at the start of the step
    hold : [s]; at 5 ms, mid-step costs 0.4 % of the deformation, the start of the step 10 % (PHYSICS section 4)
    force, torque : imbalance coefficients [N.s2/rad2], [N.m.s2/rad2]
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
