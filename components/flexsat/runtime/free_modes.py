"""The vibration of the free structure in coordinates that do not couple: one 2 by 2 block for each mode. numpy alone.

Momentum p = M_r V + L eta' of body and structure changes with the resultant F of all forces alone, V' = (v, w)'.
Without V the modes of the clamped structure obey

    (I - L^T M_r^-1 L) eta'' + D eta' + K eta = f - L^T M_r^-1 F,      D, K diagonal,

whose 2 m eigenvalues are those of the free structure without its six rigid motions. Its eigenvectors in (omega eta,
eta') are well conditioned (98 for 198 modes of the mesh of record), so that transforming costs two digits. Where a
mode is damped critically there are fewer eigenvectors than coordinates; then, or where the same bits are wanted on
every processor, the coordinates are eta and eta' themselves, and a step costs the square of their number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Complex, Flags, make_read_only
from ..fixed_order import inverse, product
from .zero_order_hold import transition, transition_and_half

WORST_CONDITION = 1e6  # of the eigenvectors, by the root of the sum of squares: six digits are lost


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
class Coupled:
    """A matrix of coordinates that couple, with the products of `Blocks`."""

    matrix: Array  # (2 m, 2 m)

    def times(self, rows: Array) -> Array:
        """Return the product with (2 m, k)."""
        return product(self.matrix, rows)

    def after(self, columns: Array) -> Array:
        """Return the product of (k, 2 m) with this."""
        return product(columns, self.matrix)


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
        return self._blocks(power, real_power), self._blocks(integral, real_integral)

    def transition_and_half(self, time: float) -> tuple[tuple[Blocks, Blocks], tuple[Blocks, Blocks]]:
        """Return the transition over a time and that over half of it."""
        return self.transition(time), self.transition(0.5 * time)

    def _blocks(self, pair: Complex, alone: Array) -> Blocks:
        second = np.where(self.oscillates, pair.real, alone)
        return Blocks(pp=pair.real, pq=pair.imag, qp=-pair.imag, qq=second)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClampedModes:
    """Coordinates z = (eta, eta'), (2 m,), with what `FreeModes` has."""

    matrix: Array  # (2 m, 2 m): z' = matrix @ z
    displacement: Array  # (m, 2 m)
    velocity: Array  # (m, 2 m)
    of_structure: Array  # (2 m, 2 m): identity

    def __post_init__(self) -> None:
        make_read_only(self)

    def transition(self, time: float) -> tuple[Coupled, Coupled]:
        """Return exp(A t) and its integral from 0 to t."""
        exponential, integral = transition(self.matrix, time)
        return Coupled(matrix=exponential), Coupled(matrix=integral)

    def transition_and_half(self, time: float) -> tuple[tuple[Coupled, Coupled], tuple[Coupled, Coupled]]:
        """Return exp(A t) and its integral from 0 to t, over a time and over half of it."""
        whole, half = transition_and_half(self.matrix, time)
        return (Coupled(matrix=whole[0]), Coupled(matrix=whole[1])), (Coupled(matrix=half[0]), Coupled(matrix=half[1]))


def _mean_growth(exponent: Array | Complex) -> Complex:
    """Return (exp(x) - 1)/x, 1 at x = 0."""
    still = exponent == 0.0
    return np.where(still, 1.0, np.expm1(exponent) / np.where(still, 1.0, exponent))


def vibration(mass: Array, stiffness: Array, damping: Array, *, fixed_order: bool = False) -> FreeModes | ClampedModes:
    """Return coordinates of the free structure's vibration; those of its free modes if there are as many.

    Parameters
    ----------
    mass : (6 + m, 6 + m) of (v, w, eta')
    stiffness : (m,) [1/s2]
    damping : (m,) [1/s]
    fixed_order : eta and eta' in any case, which are the same bits on every processor
    """
    m = len(stiffness)
    coupling = mass[:6, 6:]
    effective = inverse(mass[6:, 6:] - product(coupling.T, product(inverse(mass[:6, :6]), coupling)))
    free = None if fixed_order else _free_modes(effective, np.sqrt(stiffness), damping)
    if free is not None:
        return free
    a = np.zeros((2 * m, 2 * m))
    a[:m, m:] = np.eye(m)
    a[m:, :m], a[m:, m:] = -effective * stiffness, -effective * damping
    both = np.eye(2 * m)
    return ClampedModes(matrix=a, displacement=both[:m].copy(), velocity=both[m:].copy(), of_structure=both)


def _free_modes(effective: Array, frequency: Array, damping: Array) -> FreeModes | None:
    """Return the free modes, or None where there are fewer than coordinates but for rounding."""
    m = len(frequency)
    a = np.zeros((2 * m, 2 * m))  # of (omega eta, eta')
    a[:m, m:] = np.diag(frequency)
    a[m:, :m], a[m:, m:] = -effective * frequency, -effective * damping
    value, vector = (array.astype(complex) for array in np.linalg.eig(a))
    pairs, alone = np.flatnonzero(value.imag > 0.0), np.flatnonzero(value.imag == 0.0)
    firsts, seconds = alone[::2], alone[1::2]
    basis = np.hstack([vector[:, pairs].real, vector[:, firsts].real, vector[:, pairs].imag, vector[:, seconds].real])
    try:
        back = np.linalg.inv(basis)
    except np.linalg.LinAlgError:
        return None
    if not np.linalg.norm(basis) * np.linalg.norm(back) < WORST_CONDITION:
        return None
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
