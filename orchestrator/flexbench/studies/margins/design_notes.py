"""What a build states about the loops of a spacecraft: whether they are stable, and which modes nothing reaches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexsat.arrays import Array, Flags
from flexsat.design.chain import Designs
from flexsat.parameters import CONTROLLER_DESIGNS
from flexsat.spacecraft.properties import mode_table
from flexsat.variants import OF_DESIGN

from .real_plant import Corner, Plants, stability

NOTHING = 1e-9  # of the largest response: less is rounding


def design_notes(designs: Designs) -> Iterator[str]:
    """Yield a line for each controller about the closed loop on the plant with all its modes, and one about modes.

    Both star trackers' gains count, without delays. Poles that no weight moves decay by the damping of their modes.
    """
    for name in CONTROLLER_DESIGNS:
        design = designs.variant(OF_DESIGN[name])
        plants, corner = Plants(design), Corner(modes=design.structure.mode_count)
        worst = max((stability(plants, corner, fine) for fine in (False, True)), key=lambda one: one.growth)
        if worst.stable:
            yield (
                f"design {name}: the closed loop is stable on all {corner.modes} modes, its slowest pole decays in"
                f" {-1.0 / worst.growth:.3g} s"
            )
        else:
            doubling = np.log(2.0) / worst.growth if worst.growth > 0.0 else np.inf
            yield (
                f"design {name}: warning: the closed loop is unstable on all {corner.modes} modes: the motion at"
                f" {worst.frequency:.3g} Hz doubles in {doubling:.3g} s; set controller.torque,"
                " controller.gyro_noise or modes.design higher"
            )
    table = mode_table(designs.corrected.structure)
    unreached, unseen = table.controllability < NOTHING, table.observability < NOTHING
    if unreached.any() or unseen.any():
        yield (
            f"of {len(table.free)} modes of the free spacecraft the wheels do not excite"
            f" {_these(table.free, unreached)}, the gyros do not sense {_these(table.free, unseen)}"
        )


def _these(frequency: Array, chosen: Flags) -> str:
    if not chosen.any():
        return "none"
    return f"{np.count_nonzero(chosen)}, the lowest at {frequency[chosen][0] / (2.0 * np.pi):.3g} Hz"
