"""Loop shapes of a design on the full structure: the response of each body axis, opened at the plant's input."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array, Complex
from flexsat.design.chain import Design
from flexsat.spacecraft.variation import ModelErrors

from ..margins.analysis import body_loops
from ..margins.designed_loop import DesignedLoop
from ..margins.real_plant import Plants
from ..margins.response import refine

LOWEST, HIGHEST = 1e-3, 95.0  # Hz: below the crossover of the attitude, to nearly half the controller's rate
COARSE = 300  # lines to begin with
ROUNDS = 4  # of halving where the loop turns fast


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopShape:
    """The loop of each body axis, the others closed; of an unstable loop too."""

    frequency: Array  # (f,) [Hz]
    axes: Complex  # (f, 3)


def loop_shape(design: Design, modes: int) -> LoopShape:
    """Return the loops of a design on the lowest modes of its structure, on a grid that follows the resonances."""
    plant = Plants(design).model(modes, ModelErrors())
    loop = DesignedLoop(design=design, plant=plant)
    share, makes = loop.body_axes
    respond = loop.at().response(share)

    def loops(frequency: Array) -> tuple[Complex, Complex]:
        return body_loops(respond(frequency), makes)

    frequency: Array = np.geomspace(LOWEST, HIGHEST, COARSE)
    together, axes = loops(frequency)
    for _ in range(ROUNDS):
        more = refine(frequency, together)
        if not len(more):
            break
        frequency = np.concatenate([frequency, more])
        order = np.argsort(frequency)
        found = loops(more)
        together, axes = (np.concatenate([old, new])[order] for old, new in zip((together, axes), found, strict=True))
        frequency = frequency[order]
    return LoopShape(frequency=frequency, axes=axes)
