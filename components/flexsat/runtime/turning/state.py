"""The state of a plant when the angle of an appendage changes. numpy alone.

Turning is quasi-static: the motion of the drive itself, and its torque, are not modelled. What a change keeps are the
modal displacements, the momenta that belong to velocity and modal velocities, the wheels' axial momenta, and the
angular momentum of the whole, wheels that turn with their appendage included.
"""

from __future__ import annotations

import numpy as np

from ...arrays import Array
from .. import plant
from ..bearing_friction import PreparedFriction
from ..loads import tilted_axes
from ..plant import PlantState
from ..prepared_plant import PreparedPlant


def turned_state(
    before: PreparedPlant,
    after: PreparedPlant,
    state: PlantState,
    inputs: Array,
    friction: PreparedFriction | None = None,
) -> PlantState:
    """Return a state of the plant at new angles that continues one at the old ones; its outputs are true.

    Parameters
    ----------
    before, after : the plant at both angles, for steps of one length
    state : of the plant before
    inputs, friction : as of `plant.step`: what is held
    """
    m, old, new = before.modes, before.motion, after.motion
    moving = plant.structure_motion(before, state)
    eta, momenta = moving[:m], old.mass @ moving[m:]
    spin = [tilted_axes(one.matrices, one.loads, eta) for one in (old, new)]
    momenta[:6] = state.work.moving[2 * m :]
    momenta[3:6] += state.momentum @ (spin[0] - spin[1])
    turned = plant.init(after)
    turned.mrp = state.mrp
    turned.momentum[:], turned.angle[:] = state.momentum, state.angle
    plant.set_motion(after, turned, np.concatenate([eta, np.linalg.solve(new.mass, momenta)]))
    turned.work.moving[2 * m :] = momenta[:6]
    turned.speed[:] = plant.feed_through(after, turned, inputs, friction).wheel_speed
    return turned
