"""Our LQG controller behind foreign ports: other names, axes, orders, signs and units, converted independently."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..fmu.python.controller import Controller
from ..ports.table import Port
from ..runtime import rotations

NAMES = {"gyro.rate": "w_meas", "star_tracker.mrp": "q_IB", "star_tracker.valid": "q_ok", "wheel.torque": "tau_cmd"}
# their x, y, z are our y, z, x: 120 degrees about the diagonal
THEIR_BODY_FROM_OURS = rotations.quaternion_from_rotation_vector([2.0 * math.pi / 3.0 / math.sqrt(3.0)] * 3)


def _conjugate(q):
    return (-q[0], -q[1], -q[2], q[3])


class ForeignController(Controller):
    """Take a scalar-first inertial-from-body quaternion, rates in deg/s from the last gyro on, and give -mN.m."""

    def ports(self):
        """Return our ports with four of them foreign."""
        self._inner = {}
        return [self._foreign(port) for port in super().ports()]

    def _foreign(self, port: Port) -> Port:
        if port.name in NAMES:
            self._inner[port.name] = np.zeros(port.length) if port.size else np.zeros((), bool)
        changes = {"depends_on": tuple(NAMES.get(name, name) for name in port.depends_on)}
        if port.name in NAMES:
            changes |= {"name": NAMES[port.name], "unit": "1", "display_unit": None}
        if port.name == "star_tracker.mrp":
            changes |= {"size": 4, "start": (1.0, 0.0, 0.0, 0.0)}
        if port.name == "star_tracker.valid":
            changes |= {"kind": "integer", "start": 0}
        return replace(port, **changes)

    def view(self, name):
        """Return the array that the controller works on: for a foreign port a separate one."""
        return self._inner[name] if name in self._inner else super().view(name)

    def advance(self, time, step, /):
        """Convert, step, convert."""
        w, x, y, z = super().view("q_IB")
        attitude = rotations.compose_quaternions(_conjugate(THEIR_BODY_FROM_OURS), (-x, -y, -z, w))
        self._inner["star_tracker.mrp"][:] = rotations.mrp_from_quaternion(attitude)
        self._inner["gyro.rate"][:] = np.radians(super().view("w_meas"))[::-1]
        self._inner["star_tracker.valid"][...] = super().view("q_ok") == 7
        super().advance(time, step)
        super().view("tau_cmd")[:] = -1e3 * self._inner["wheel.torque"]
