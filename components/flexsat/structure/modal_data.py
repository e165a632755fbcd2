"""Modal data as analysts have them, and their conversion to a structure that is clamped at its interface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from ..arrays import Array, Index
from ..parameters import HERTZ
from .structure import Structure

Kind = Literal["clamped", "free"]
KINDS: tuple[Kind, ...] = ("clamped", "free")
STILL = 1e-2  # of the first flexible mode's frequency: rigid modes of a free structure lie below


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModalData:
    """Frequencies, damping and shapes of a structure in its own axes, with what is known of its masses.

    Either participation, or masses at all nodes, from which it follows. None is what is not known. Of a free structure,
    `interface` names the node that the bus is: its motion makes the rest.
    """

    kind: Kind
    frequency: Array  # (m,) [Hz]
    damping_ratio: Array  # (m,)
    node_name: tuple[str, ...] = ()  # (n,)
    node_position: Array  # (n, 3) [m]
    node_translation: Array  # (n, 3, m): shapes, of the modal mass below
    node_rotation: Array | None = None  # (n, 3, m) [rad over the unit of the translations]
    modal_mass: Array | None = None  # (m,) [kg for shapes without unit]; None: shapes are mass-normalised
    mass: float | None = None  # kg
    centre_of_mass: Array | None = None  # (3,) [m]
    inertia: Array | None = None  # (3, 3) about the origin of the axes [kg.m2]
    translation: Array | None = None  # (3, m): participation along x, y, z, of the shapes as they are
    rotation: Array | None = None  # (3, m): about x, y, z through the origin
    node_mass: Array | None = None  # (n,) [kg]
    node_inertia: Array | None = None  # (n, 3, 3) [kg.m2]
    interface: str = ""
    edges: Index | None = None  # (e, 2): nodes that drawings join
    source: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidBody:
    """Mass properties about the origin of the axes."""

    mass: float  # kg
    first_moment: Array  # (3,) [kg.m]
    inertia: Array  # (3, 3) [kg.m2]


def body_of_nodes(data: ModalData) -> RigidBody | None:
    """Return the mass properties of the nodes' masses; None without them."""
    if data.node_mass is None:
        return None
    place, mass = data.node_position, data.node_mass
    own = np.zeros((3, 3)) if data.node_inertia is None else data.node_inertia.sum(axis=0)
    second = np.einsum("n,ni,nj->ij", mass, place, place)
    return RigidBody(
        mass=float(mass.sum()), first_moment=mass @ place, inertia=np.trace(second) * np.eye(3) - second + own
    )


def body_of(data: ModalData) -> RigidBody:
    """Return the mass properties: those stated, else those of the nodes.

    Raises
    ------
    ValueError
        If neither is there.
    """
    if data.mass is not None and data.inertia is not None and data.centre_of_mass is not None:
        return RigidBody(mass=data.mass, first_moment=data.mass * data.centre_of_mass, inertia=data.inertia)
    found = body_of_nodes(data)
    if found is None:
        lacking = [name for name in ("mass", "centre_of_mass", "inertia") if getattr(data, name) is None]
        raise ValueError(f"{', '.join(lacking)}: missing; give them, or node_mass of all nodes")
    return found


def normalised(data: ModalData) -> tuple[Array, Array]:
    """Return translations and rotations of the nodes for unit modal mass, (n, 3, m) each."""
    scale = np.ones(len(data.frequency)) if data.modal_mass is None else 1.0 / np.sqrt(data.modal_mass)
    turning = np.zeros_like(data.node_translation) if data.node_rotation is None else data.node_rotation
    return data.node_translation * scale, turning * scale


def participation_of_nodes(data: ModalData, moved: Array, turned: Array) -> Array | None:
    """Return momentum and angular momentum about the origin of unit modal velocities, (6, m); None without masses."""
    if data.node_mass is None:
        return None
    momentum = data.node_mass[:, None, None] * moved
    spin = (
        np.zeros_like(momentum) if data.node_inertia is None else np.einsum("nij,njm->nim", data.node_inertia, turned)
    )
    orbit = np.cross(data.node_position[:, :, None], momentum, axis=1)
    return np.vstack([momentum.sum(axis=0), (orbit + spin).sum(axis=0)])


def structure_from(data: ModalData) -> Structure:
    """Return the structure clamped at its interface; modes of a free one are transformed, without loss.

    Raises
    ------
    ValueError
        For data that are incomplete, or are those of no structure.
    """
    return _clamped(data) if data.kind == "clamped" else _freed(data)


def _clamped(data: ModalData) -> Structure:
    body = body_of(data)
    moved, turned = normalised(data)
    scale = np.ones(len(data.frequency)) if data.modal_mass is None else 1.0 / np.sqrt(data.modal_mass)
    if data.translation is not None and data.rotation is not None:
        participation = np.vstack([data.translation, data.rotation]) * scale
    else:
        found = participation_of_nodes(data, moved, turned)
        if found is None:
            raise ValueError("translation, rotation: missing; give the participation, or node_mass of all nodes")
        participation = found
    order = np.argsort(data.frequency, kind="stable")
    omega = HERTZ * data.frequency[order]
    return _structure(
        data,
        body,
        omega,
        2.0 * data.damping_ratio[order] * omega,
        participation[:, order],
        (moved[:, :, order], turned[:, :, order]),
        data.node_position,
    )


def _freed(data: ModalData) -> Structure:
    """Hold the interface of a free structure, by the coordinates of its motion in place of the mean motion.

    With the free modes q and the rigid motion r of the whole, the interface moves by b = r + B q. In b and q the mass
    matrix is [[M, -M B], [-B^T M, I + B^T M B]] and the stiffness still that of q; the modes for b = 0 are the clamped
    ones. Nothing is left out, so that the frequencies of the free spacecraft are the given ones.
    """
    if data.interface not in data.node_name:
        raise ValueError(f"interface {data.interface!r}: no such node; name the node that the bus is")
    if data.node_rotation is None:
        raise ValueError("node_rotation: missing; of a free structure the rotation of the interface is needed")
    at = data.node_name.index(data.interface)
    origin = data.node_position[at]
    moved, turned = normalised(data)
    order = np.argsort(data.frequency, kind="stable")
    if len(order) > 6 and data.frequency[order[5]] < STILL * data.frequency[order[6]]:
        order = order[6:]  # the rigid modes
    moved, turned = moved[:, :, order], turned[:, :, order]
    omega = HERTZ * data.frequency[order]
    given = body_of(data)
    first = given.first_moment - given.mass * origin
    mixed = np.outer(origin, given.first_moment)
    square = (origin @ origin) * np.eye(3) - np.outer(origin, origin)
    inertia = given.inertia - 2.0 * (origin @ given.first_moment) * np.eye(3) + mixed + mixed.T + given.mass * square
    body = RigidBody(mass=given.mass, first_moment=first, inertia=inertia)
    x, y, z = first
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rigid = np.block([[given.mass * np.eye(3), -cross], [cross, inertia]])
    held = np.vstack([moved[at], turned[at]])  # (6, m)
    values, mixing = scipy.linalg.eigh(np.diag(omega**2), np.eye(len(omega)) + held.T @ rigid @ held)
    clamped = np.sqrt(values)
    position = data.node_position - origin
    lever = np.cross(turned[at].T[:, None, :], position[None, :, :]).transpose(1, 2, 0)  # (n, 3, m)
    relative = (moved - moved[at] - lever) @ mixing, (turned - turned[at]) @ mixing
    damping = 2.0 * data.damping_ratio[order] * omega
    own = np.einsum("km,k,km->m", mixing, damping, mixing)  # the diagonal: damping does not couple clamped modes
    return _structure(data, body, clamped, own, -rigid @ held @ mixing, relative, position)


def _structure(
    data: ModalData,
    body: RigidBody,
    omega: Array,
    damping: Array,
    participation: Array,
    shapes: tuple[Array, Array],
    position: Array,
) -> Structure:
    return Structure(
        frequency=omega,
        damping=damping,
        translation=participation[:3],
        rotation=participation[3:],
        total_mass=body.mass,
        first_moment=body.first_moment,
        inertia=0.5 * (body.inertia + body.inertia.T),
        position=position,
        deflection=shapes[0],
        slope=shapes[1],
        names=data.node_name,
        edges=np.zeros((0, 2), dtype=np.intp) if data.edges is None else data.edges,
    )
