"""The appendages of a spacecraft that turn about a drive: what they carry, and what turning them moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index
from ..description.configuration import Configuration
from ..description.placement import Device, Site
from ..fixed_order import product
from ..structure.structure import Structure
from .flexible import appendage_at, appendages_of_modes


@dataclass(frozen=True, slots=True, kw_only=True)
class Turning:
    """The t appendages that turn, in the order of the file, at the angles of the file; body axes.

    Mass properties are those without the motion of modes. Parts say which of the appendages that turn something belongs
    to, from 0; -1: it does not turn.
    """

    axis: Array  # (t, 3), unit vectors: the drive
    point: Array  # (t, 3) [m] of the interface, from the spacecraft's centre of mass at rest
    angle: Array  # (t,) [rad]
    moment: Array  # (t, 3) [kg.m]: mass times centre of mass, from the interface
    inertia: Array  # (t, 3, 3) [kg.m2] about the interface
    mount_turn: Array  # (s, 3, 3): rotation of each mount of wheels from where it is at angle 0
    mode_part: Index  # (m,)
    mount_part: Index  # (s,)
    gyro_part: Index  # (g,)
    accelerometer_part: Index  # (k,)


def turns_of(config: Configuration, sites: Sequence[Site]) -> Array | None:
    """Return the rotation of sites from where they are at angle 0, (k, 3, 3), in body axes; None where none turns."""
    owners = [appendage_at(config, site) for site in sites]
    if not any(k >= 0 and config.appendages[k].turns for k in owners):
        return None
    turning = [k >= 0 and config.appendages[k].turns for k in owners]
    return np.array(
        [config.appendages[k].turn if turns else np.eye(3) for k, turns in zip(owners, turning, strict=True)]
    )


def turned_axes(config: Configuration, placed: Sequence[Device]) -> Array:
    """Return the axes of devices, (n, 3), in body axes: those on appendages that turn are stated at angle 0."""
    stated = np.array([device.axis for device in placed])
    turns = turns_of(config, [config.site(device.site) for device in placed])
    return stated if turns is None else np.einsum("nij,nj->ni", turns, stated)


def turning_of(config: Configuration, structure: Structure, mounts: Sequence[Site], centre: Array) -> Turning:
    """Return the appendages that turn.

    Parameters
    ----------
    mounts : the sites that carry wheels
    centre : (3,) of mass at rest, from the origin [m]
    """
    found = [k for k, one in enumerate(config.appendages) if one.turns]
    moving = [config.appendages[k] for k in found]
    place = {k: part for part, k in enumerate(found)}
    none = np.full(structure.mode_count, -1)
    owners = appendages_of_modes(config) if found else none
    turns = turns_of(config, mounts)

    def parts(sites: Sequence[Site]) -> Index:
        return np.array([place.get(appendage_at(config, site), -1) for site in sites])

    def vectors(values: Sequence[Array]) -> Array:
        return np.array(values).reshape(len(moving), 3)

    return Turning(
        axis=vectors([one.drive_axis for one in moving]),
        point=vectors([np.array(one.at) - centre for one in moving]),
        angle=np.array([one.angle for one in moving], dtype=np.float64),
        moment=vectors([one.body_from_own @ one.structure.first_moment for one in moving]),
        inertia=np.array(
            [product(product(one.body_from_own, one.structure.inertia), np.ascontiguousarray(one.body_from_own.T))
             for one in moving]
        ).reshape(len(moving), 3, 3),
        mount_turn=np.tile(np.eye(3), (len(mounts), 1, 1)) if turns is None else turns,
        mode_part=np.array([place.get(int(k), -1) for k in owners], dtype=np.intp),
        mount_part=parts(mounts),
        gyro_part=parts([config.site(device.site) for device in config.gyros]),
        accelerometer_part=parts([config.site(device.site) for device in config.accelerometers]),
    )  # fmt: skip
