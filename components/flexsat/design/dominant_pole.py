"""Find the pole that the input shaper cancels: that of the free spacecraft which a torque about x moves most."""

from __future__ import annotations

import numpy as np
import scipy

from ..fixed_order import on_grid
from ..spacecraft.assembly import RIGID, Spacecraft
from ..structure.modes import degenerate_pairs, turn_pair
from ..structure.refinement import Eigenpairs, refine

ABOUT_X = 3  # of (v, w, eta')


def dominant_pole(spacecraft: Spacecraft) -> tuple[float, float]:
    """Return frequency [rad/s] and damping ratio of the free mode that a torque about x moves most.

    The modes of the whole free spacecraft (the bus turns with the structure); the one with the largest attitude
    response to an impulse about x, over its frequency squared. Of a degenerate pair, one member does not turn about x.
    """
    size = RIGID + spacecraft.mode_count
    stiffness = np.zeros((size, size))
    stiffness[RIGID:, RIGID:] = np.diag(spacecraft.frequency**2)
    found = Eigenpairs(*scipy.linalg.eigh(stiffness, spacecraft.mass_matrix))
    square, shapes = found.values[RIGID:], found.vectors[:, RIGID:].copy()
    about_x = np.zeros(size)
    about_x[ABOUT_X] = 1.0
    pairs = degenerate_pairs(np.sqrt(square))
    for k in pairs:
        turn_pair(shapes, k, about_x)
    dominant = int(np.argmax(shapes[ABOUT_X] ** 2 / square))
    members = slice(dominant, dominant + (2 if dominant in pairs else 1))
    values, refined = refine(
        stiffness,
        spacecraft.mass_matrix,
        found,
        shapes[:, members],
        {0: about_x} if dominant in pairs else {},
        RIGID + dominant,
    )
    frequency = float(np.sqrt(values[0]))
    strain = on_grid(refined[:, 0])[RIGID:] ** 2 * spacecraft.damping
    return frequency, float(np.cumsum(strain)[-1]) / (2.0 * frequency)
