"""Which wheel, gyro or accelerometer each element of an array belongs to, as rows of text; and the mass properties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...design.chain import Design
from ...parameters import RPM

Rows = tuple[tuple[str, ...], ...]
WHEEL_COLUMNS = ("wheel", "mount", "site", "axis x, y, z", "inertia [kg.m2]", "limit [N.m]", "nominal speed [rpm]")
DEVICE_COLUMNS = ("element", "site", "axis x, y, z", "position x, y, z [m]")


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceRows:
    """The devices of a spacecraft in the order of the arrays' elements, and its mass properties."""

    mass: str
    wheels: Rows
    gyros: Rows
    accelerometers: Rows


def device_rows(design: Design) -> DeviceRows:
    """Return the devices of a design and its mass properties."""
    plant, craft, config = design.plant, design.spacecraft, design.config
    limits = plant.torque_limit * plant.torque_limit_factor
    wheels = zip(craft.mount_of_wheel, config.wheels, plant.wheel_axis, plant.wheel_inertia, limits,
                 plant.nominal_speed / RPM, strict=True)  # fmt: skip
    return DeviceRows(
        mass=mass_text(craft.mass, craft.inertia),
        wheels=tuple(
            (str(i), str(int(mount) + 1), wheel.site, _vector(axis), f"{inertia:.4g}", f"{limit:.4g}", f"{speed:.1f}")
            for i, (mount, wheel, axis, inertia, limit, speed) in enumerate(wheels, 1)
        ),
        gyros=_devices([one.site for one in config.gyros], craft.gyros.axis, craft.gyros.position),
        accelerometers=_devices(
            [one.site for one in config.accelerometers], craft.accelerometers.axis, craft.accelerometers.position
        ),
    )


def mass_text(mass: float, inertia: Array) -> str:
    """Return mass and inertia about the centre of mass as a sentence."""
    xx, yy, zz = (float(value) for value in np.diag(inertia))
    xy, xz, yz = (float(inertia[k]) + 0.0 for k in ((0, 1), (0, 2), (1, 2)))
    largest = 1e-9 * max(xx, yy, zz)
    xy, xz, yz = (0.0 if abs(value) < largest else value for value in (xy, xz, yz))
    return (
        f"Total mass {mass:.6g} kg; inertia about the centre of mass: xx {xx:.6g}, yy {yy:.6g}, zz "
        f"{zz:.6g}, xy {xy:.4g}, xz {xz:.4g}, yz {yz:.4g} kg.m2 (elements of the matrix)."
    )


def _devices(sites: Sequence[str], axes: Array, positions: Array) -> Rows:
    return tuple(
        (str(i), site, _vector(axis), _vector(position))
        for i, (site, axis, position) in enumerate(zip(sites, axes, positions, strict=True), 1)
    )


def _vector(values: Array) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in np.round(values, 12))  # no -0
