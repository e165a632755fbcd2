"""Bound the memory of the exported controller, for the largest that its parameters can make.

The state's bound is checked where the C code is compiled; that of the memory by a test, and by `flexsat_prepare`, which
refuses less than it needs.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...runtime.controller_parameters import LONGEST_DELAY, ControllerMatrices
from ...runtime.keep_out import AZIMUTHS, CONES, LEGS, RINGS
from ...runtime.slew_optimum import STEPS

DOUBLE, INTEGER, PANEL = 8, 4, 8  # bytes of a double and an int; rows of a panel
BLOCK = 40  # bytes of a block beside what is taken
KNOTS = 4 + 2 * (STEPS + 1)  # of a motion
STRUCTURES = 32_768  # bytes of what is prepared, apart from arrays of the wheels


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Sizes of a controller, and of its numbers."""

    states: int
    controlled: int
    measured: int
    wheels: int
    gyros: int
    phases: int
    delay: int  # most whole periods of both delays
    real: int  # bytes of a number of a step


def sizes_of(matrices: ControllerMatrices, real: int) -> Sizes:
    """Return the sizes of a design; `real` is the size of a number of a step [bytes]."""
    return Sizes(
        states=len(matrices.a),
        controlled=len(matrices.reference_a),
        measured=len(matrices.c),
        wheels=len(matrices.nominal_speed),
        gyros=matrices.gyros,
        phases=max(len(matrices.gain_coarse), len(matrices.gain_fine)),
        delay=int(2.0 * LONGEST_DELAY / matrices.period + 1e-6),
        real=real,
    )


def state_size(sizes: Sizes) -> int:
    """Return the size of a saved state [bytes]."""
    motion = DOUBLE * (3 + 5 + 2 + 3 * KNOTS)
    commanded = 2 * motion + DOUBLE * (2 * 3 * LEGS + 3 * 4 + 3 + 3 + 3) + DOUBLE * sizes.controlled
    history = (sizes.delay + 2) * sizes.wheels
    numbers = sizes.states + 2 * sizes.wheels + history
    slow = 4 + 3 + 3 + sizes.gyros
    return _rounded(DOUBLE * (3 + 3 + 4 + slow) + sizes.real * numbers + commanded + 64)


def memory_size(sizes: Sizes) -> int:
    """Return the memory of a controller [bytes]."""
    s, n, r, y = sizes.states, sizes.wheels, sizes.controlled, sizes.measured
    history = (sizes.delay + 2) * n
    products = [(s, y)] * sizes.phases + [(y, s), (n, r), (n, 2 * n), (s, s), (s, n), (s, n), (s, 2 * n), (r, r),
                                          (r, n), (r, s), (r, history)]  # fmt: skip
    products += [(s, 3), (r, 3), (n, 3)]
    kept = sum(_panels(rows, columns, sizes.real) for rows, columns in products)
    nodes = 2 + len(CONES) * (2 * len(RINGS) * AZIMUTHS + 2)
    search = DOUBLE * (4 * nodes + nodes * nodes + 2 * nodes) + INTEGER * LEGS * nodes
    bounds = 4 * STEPS - 2
    optimum = DOUBLE * (10 * STEPS + 8 * bounds + 16 + 2 * STEPS * STEPS)
    wheels = DOUBLE * n * (3 * 3 + 12 + 6)
    # what sampling works in: models before and after the delays, prediction over the delays, matrix exponentials
    sampling = DOUBLE * (9 * s * s + 10 * s * n + 2 * s * (s + history) + 5 * r * r + r * n)
    blocks = BLOCK * (5 * len(products) + 64)
    return _rounded(kept + search + optimum + wheels + STRUCTURES + 2 * state_size(sizes) + sampling + blocks)


def _panels(rows: int, columns: int, real: int) -> int:
    most = (rows + PANEL - 1) // PANEL
    return most * (PANEL * INTEGER + 2 * INTEGER + DOUBLE) + most * PANEL * columns * real


def _rounded(size: int) -> int:
    return (size + 63) // 64 * 64
