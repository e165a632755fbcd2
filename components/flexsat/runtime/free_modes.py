"""The vibration of the free structure in coordinates that do not couple: one 2 by 2 block for each mode. numpy alone.

Momentum p = M_r V + L eta' of body and structure changes with the resultant F of all forces alone, V' = (v, w)'.
Without V the modes of the clamped structure obey

    (I - L^T M_r^-1 L) eta'' + D eta' + K eta = f - L^T M_r^-1 F,      D, K diagonal,

whose 2 m eigenvalues are those of the free structure without its six rigid motions. Its eigenvectors in (omega eta,
eta') are well conditioned (98 for 198 modes of the mesh of record), so that transforming costs two digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Flags, make_read_only
from ..fixed_order import inverse, product

WORST_CONDITION = 1e8  # of the eigenvectors: half of the digits are left


@dataclass(frozen=True, slots=True, kw_only=True)
class Blocks:
    """A matrix of 2 by 2 blocks, one for each pair of coordinates: [p, q] becomes [pp p + pq q, qp p + qq q]."""

    pp: Array  # (m,) each
    pq: Array
    qp: Array
    qq: Array

    @property
    def diagonal(self) -> Array:
        """What multiplies p and q themselves, (2, m)."""
        return np.stack([self.pp, self.qq])

    @property
    def crossed(self) -> Array:
        """What multiplies the other of the two, (2, m)."""
        return np.stack([self.pq, self.qp])

    def times(self, rows: Array) -> Array:
        """Return the product with (2 m, k)."""
        p, q = np.split(rows, 2)
        above = self.pp[:, None] * p + self.pq[:, None] * q
        return np.vstack([above, self.qp[:, None] * p + self.qq[:, None] * q])

    def after(self, columns: Array) -> Array:
        """Return the product of (k, 2 m) with this."""
        p, q = np.split(columns, 2, axis=1)
        return np.hstack([p * self.pp + q * self.qp, p * self.pq + q * self.qq])


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeModes:
    """Coordinates z = (p, q), (2 m,), of the free structure's vibration."""

    eigenvalue: Array  # (2, m): real parts and imaginary parts of one of each pair; two real ones: (first, second)
    oscillates: Flags  # (m,): a pair of conjugates, otherwise two real ones
    displacement: Array  # (m, 2 m): eta = displacement @ z
    velocity: Array  # (m, 2 m): eta' = velocity @ z
    of_structure: Array  # (2 m, 2 m): z = of_structure @ (eta, eta')

    def __post_init__(self) -> None:
        make_read_only(self)

    def transition(self, time: float) -> tuple[Blocks, Blocks]:
        """Return exp(A t) and its integral from 0 to t, both in the coordinates z."""
        first, second = self.eigenvalue
        complex_one = np.where(self.oscillates, first + 1j * second, first)
        other = np.where(self.oscillates, 0.0, second)
        power, integral = np.exp(complex_one * time), time * _mean_growth(complex_one * time)
        real_power, real_integral = np.exp(other * time), time * _mean_growth(other * time).real
        return (
            Blocks(
                pp=power.real,
                pq=power.imag,
                qp=-power.imag,
                qq=np.where(self.oscillates, power.real, real_power),
            ),
            Blocks(
                pp=integral.real,
                pq=integral.imag,
                qp=-integral.imag,
                qq=np.where(self.oscillates, integral.real, real_integral),
            ),
        )


def _mean_growth(exponent: Array) -> Array:
    """Return (exp(x) - 1)/x, 1 at x = 0."""
    still = exponent == 0.0
    return np.where(still, 1.0, np.expm1(exponent) / np.where(still, 1.0, exponent))


def free_modes(mass: Array, stiffness: Array, damping: Array) -> FreeModes:
    """Return the coordinates of the free structure's vibration.

    Parameters
    ----------
    mass : (6 + m, 6 + m) of (v, w, eta')
    stiffness : (m,) [1/s2]
    damping : (m,) [1/s]

    Raises
    ------
    ValueError
        If a mode's damping is within 1e-8 of its critical one: such a mode has no two coordinates.
    """
    m = len(stiffness)
    rigid, coupling = mass[:6, :6], mass[:6, 6:]
    effective = mass[6:, 6:] - product(coupling.T, product(inverse(rigid), coupling))
    lighter = inverse(effective)
    frequency = np.sqrt(stiffness)
    a = np.zeros((2 * m, 2 * m))  # of (omega eta, eta')
    a[:m, m:] = np.diag(frequency)
    a[m:, :m] = -lighter * frequency
    a[m:, m:] = -lighter * damping
    value, vector = np.linalg.eig(a)
    value, vector = value.astype(complex), vector.astype(complex)
    pairs = np.flatnonzero(value.imag > 0.0)
    alone = np.flatnonzero(value.imag == 0.0)
    firsts, seconds = alone[::2], alone[1::2]
    basis = np.hstack([vector[:, pairs].real, vector[:, firsts].real, vector[:, pairs].imag, vector[:, seconds].real])
    condition = np.linalg.cond(basis)
    if not condition < WORST_CONDITION:
        raise ValueError(
            "a mode is damped so nearly critically that it cannot be told from its double; change"
            " dispersion.damping of it by a millionth"
        )
    back = np.linalg.inv(basis)
    return FreeModes(
        eigenvalue=np.array(
            [
                np.concatenate([value[pairs].real, value[firsts].real]),
                np.concatenate([value[pairs].imag, value[seconds].real]),
            ]
        ),
        oscillates=np.arange(m) < len(pairs),
        displacement=basis[:m] / frequency[:, None],
        velocity=basis[m:].copy(),
        of_structure=np.hstack([back[:, :m] * frequency, back[:, m:]]),
    )
