"""Division of a body torque between redundant wheels. numpy alone.

Two ways: least squares over weights (a weighted pseudo-inverse, linear in the torque), and least peak (minimum infinity
norm), by which the largest share of a wheel's limit is as small as it can be. The torques that wheels give together at
one peak fill a zonotope, whose faces are spanned by two axes each: the peak that a torque needs is where its direction
leaves that of peak one, and there all wheels but those along the face give that peak. What is left for these is the
same problem in the plane of the face, then along one axis: so the second largest share is least as well, and so on.
Markley, Reynolds, Liu, Lebsock (2010), J. Guidance, Control, and Dynamics 33(5), 1606-1614, for the first of these.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array, Flags, make_read_only
from .fixed_order import inverse, product

ALONG = 1e-9  # of the length of a limit's axis: less across a face is rounding


def least_squares(axes: Array, weight: Array) -> Array:
    """Return the least wheel torques (n, 3), squared over the weights (n,), of a body torque."""
    weighted = axes * weight[:, np.newaxis]
    return -product(weighted, inverse(product(axes.T, weighted)))


def least_peak(axes: Array, limits: Array, torque: Array) -> Array:
    """Return the wheel torques (n,) of a body torque (3,) whose largest shares of the limits (n,) are the least.

    Wheels of limit zero give none. The reaction of the wheels is the body torque: axes.T @ result = -torque.

    Raises
    ------
    ValueError
        If the wheels that have a limit cannot turn the body about all axes.
    """
    spans = axes * limits[:, np.newaxis]
    scale = float(np.linalg.norm(spans, axis=1).max(initial=0.0))
    if not scale > 0.0 or np.linalg.matrix_rank(spans, tol=ALONG * scale) < 3:
        raise ValueError("least_peak: the wheels that have torque cannot turn the body about all axes")
    spans, left = spans / scale, -torque / scale
    share, free = np.zeros(len(axes)), np.linalg.norm(spans, axis=1) > ALONG
    across = np.zeros((0, 3))  # normals of what is solved
    while np.any(free) and np.any(left):
        normal, peak = _face(spans, free, left, across)
        crossing = spans @ normal
        settled = free & (np.abs(crossing) > ALONG)
        share[settled] = np.sign(crossing[settled]) * peak
        left = left - share[settled] @ spans[settled]
        free &= ~settled
        across = np.vstack([across, normal])
    return share * limits


@dataclass(frozen=True, slots=True, kw_only=True)
class NullMotion:
    """Motion of redundant wheels that gives the body no torque: it brings their momenta towards the least peak."""

    rate: float  # 1/s: of what is left to the least peak
    axes: Array  # (n, 3); zero for wheels that have no torque, which take no part
    inverse: Array  # (3, 3): of the sum of axis times axis
    limits: Array  # (n,) [N.m.s]: momentum that each wheel may have beside the nominal one

    def __post_init__(self) -> None:
        make_read_only(self)


def null_motion(axes: Array, limits: Array, works: Flags, rate: float) -> NullMotion:
    """Prepare the null motion of the wheels that work, which turn the body about all axes."""
    used = axes * works[:, np.newaxis]
    return NullMotion(rate=rate, axes=used, inverse=inverse(product(used.T, used)), limits=limits * works)


def null_part(motion: NullMotion, momenta: Array) -> Array:
    """Return the part of wheels' momenta (n,) without a resultant; zero for wheels that take no part."""
    works = motion.limits > 0.0
    return np.asarray(momenta * works - motion.axes @ (motion.inverse @ (momenta @ motion.axes)))


def null_torque(motion: NullMotion, momenta: Array, least: Array, most: Array) -> Array:
    """Return the torques (n,) towards the least peak of the momenta's shares of the limits; their resultant is zero.

    Parameters
    ----------
    momenta : (n,) beside the nominal ones [N.m.s]
    least, most : (n,) what each wheel has left [N.m]; all torques are made smaller alike until they fit
    """
    aim = least_peak(motion.axes, motion.limits, -(momenta @ motion.axes))
    torque = motion.rate * null_part(motion, aim - momenta)
    moved = torque != 0.0
    room = np.where(torque > 0.0, np.maximum(most, 0.0), np.minimum(least, 0.0))
    return np.asarray(torque * np.min(room[moved] / torque[moved], initial=1.0))


def _face(spans: Array, free: Flags, left: Array, across: Array) -> tuple[Array, float]:
    """Return the unit normal of the face by which a torque leaves, and the peak that it needs, with its sign."""
    own = spans[free]
    if len(across) == 2:  # along one axis
        normals = np.cross(across[0], across[1])[np.newaxis]
    elif len(across) == 1:
        normals = np.cross(across[0], own)
    else:
        first, second = np.triu_indices(len(own), 1)
        normals = np.cross(own[first], own[second])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > ALONG] / lengths[lengths > ALONG, np.newaxis]
    needed = (normals @ left) / np.abs(normals @ own.T).sum(axis=1)
    k = int(np.argmax(np.abs(needed)))
    return normals[k], float(needed[k])
