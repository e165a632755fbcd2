"""A sampled feedback loop with one slow sensor: a linear system whose matrices repeat after a number of steps.

The loop is opened at the plant input. u is what acts on the plant, d what is added there, r what comes back with its
sign turned: r = L u, u = d - r, as in the textbooks' negative feedback.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, schur, solve_triangular

from flexsat.arrays import Array, Complex
from lockstep.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Phase:
    """The open loop over one step: x[k+1] = a x[k] + b u[k], r[k] = c x[k]. There is no way from u[k] to r[k]."""

    a: Array  # (s, s)
    c: Array  # (m, s)


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodicLoop:
    """An open loop that is in `first` every `steps` steps, and in `rest` in between. One step: time-invariant."""

    first: Phase
    rest: Phase
    b: Array  # (s, m)
    steps: int
    period: float  # s, of one step

    def __post_init__(self) -> None:
        size, channels = self.b.shape
        for phase in (self.first, self.rest):
            if phase.a.shape != (size, size) or phase.c.shape != (channels, size):
                raise InputError(
                    f"PeriodicLoop: a and c must be ({size}, {size}) and ({channels}, {size}) to match b, "
                    f"got {phase.a.shape} and {phase.c.shape}"
                )
        if self.steps < 1 or not self.period > 0.0:
            raise InputError(f"PeriodicLoop: steps and period must be > 0, got {self.steps} and {self.period!r}")

    @property
    def channels(self) -> int:
        """Number of inputs of the plant."""
        return int(self.b.shape[1])

    def closed(self, factor: complex | Array = 1.0) -> tuple[Array | Complex, Array | Complex]:
        """Return the transition of the closed loop over a step in `first` and over one in `rest`.

        `factor` multiplies what comes back: a number, or a matrix (m, m).
        """
        back = np.asarray(factor)
        if back.ndim == 0:
            return self.first.a - back * (self.b @ self.first.c), self.rest.a - back * (self.b @ self.rest.c)
        return self.first.a - self.b @ back @ self.first.c, self.rest.a - self.b @ back @ self.rest.c

    def monodromy(self, factor: complex | Array = 1.0) -> Array | Complex:
        """Return the transition of the closed loop over all the steps, (s, s)."""
        first, rest = self.closed(factor)
        return np.asarray(np.linalg.matrix_power(rest, self.steps - 1) @ first)

    def radius(self, factor: complex | Array = 1.0) -> float:
        """Return the spectral radius of one step's share of the monodromy: stable below one."""
        values = largest_eigenvalues(self.monodromy(factor))
        return float(np.max(np.abs(values)) ** (1.0 / self.steps))

    def complementary_sensitivity(self, frequency: Array, directions: Array | None = None) -> Complex:
        """Return T, from an injection at the plant input to what comes back, at the frequency of the injection.

        A sine of frequency f injected into a periodic loop comes back with f and with sidebands f + k / (steps x
        period). This is the part at f, the diagonal entry of the harmonic transfer matrix: what a frequency-response
        test finds. S = 1 - T.

        Parameters
        ----------
        frequency : (f,) [Hz]
        directions : (m, d) inputs along which to inject; None for each channel

        Returns
        -------
        (f, m, d)
        """
        return self.response(directions)(frequency)

    def response(self, directions: Array | None = None) -> Callable[[Array], Complex]:
        """Prepare `complementary_sensitivity` for frequencies that are not known yet.

        Notes
        -----
        The steady state is that of the loop without the slow sensor, q = (z - A)^-1 B w, and a part e that the slow
        sensor excites once in N steps and that decays freely in between:
        (z^N - A^(N-1) A0) e = A^(N-1) (A0 - A) q.
        """
        first, rest = self.closed()
        inject = self.b if directions is None else self.b @ directions
        between = np.linalg.matrix_power(rest, self.steps - 1)
        monodromy = between @ first
        jump = first - rest
        seen = self.first.c - self.rest.c
        one_phase = self.steps == 1 and not jump.any() and not seen.any()
        resolve = _resolvent(rest)
        resolve_whole = resolve if one_phase else _resolvent(monodromy)

        def respond(frequency: Array) -> Complex:
            found = np.empty((len(frequency), self.channels, inject.shape[1]), dtype=complex)
            for k, omega in enumerate(2.0 * np.pi * np.asarray(frequency)):
                z = np.exp(1j * omega * self.period)
                whole = z**self.steps
                fast = resolve(z, inject)
                found[k] = self.rest.c @ fast
                if one_phase:
                    continue
                kick = jump @ fast
                slow = resolve_whole(whole, between @ kick)
                after = first @ slow + kick  # one step after the slow sensor
                # the sum over k = 1 .. N - 1 of z^-k A^(k-1)
                summed = resolve(z, after - (z / whole) * (between @ after))
                found[k] += (seen @ fast + self.first.c @ slow + self.rest.c @ summed) / self.steps
            return found

        return respond


def largest_eigenvalues(matrix: Array | Complex) -> Complex:
    """Return the eigenvalues of a matrix without those that are zero to rounding.

    Notes
    -----
    Torques on their way, and filters that have decayed, leave a monodromy a rank far below its size. With
    matrix = q r, q of orthonormal columns, the eigenvalues that are not zero are those of the smaller matrix r q. What
    is left out is below the rounding of the norm, as is the backward error of the eigenvalues themselves.
    """
    q, r, order = qr(matrix, mode="economic", pivoting=True, check_finite=False)
    sizes = np.abs(np.diag(r))
    rank = max(1, int(np.sum(sizes > np.finfo(np.float64).eps * sizes[0])))
    rows = np.empty_like(r[:rank])
    rows[:, order] = r[:rank]
    return np.asarray(np.linalg.eigvals(rows @ q[:, :rank]))


def _resolvent(a: Array | Complex) -> Callable[[complex, Array | Complex], Complex]:
    """Return (z, right) -> (z - a)^-1 right: once the Schur form is known, a triangular system for each z."""
    triangle, unitary = schur(a, output="complex")
    back, diagonal = unitary.conj().T, np.diag_indices(len(triangle))

    def solve(z: complex, right: Array | Complex) -> Complex:
        shifted = -triangle
        shifted[diagonal] += z
        return np.asarray(unitary @ solve_triangular(shifted, back @ right, check_finite=False))

    return solve


def loop_of_sensitivity(t: Complex, inputs: Complex | None = None) -> Complex:
    """Return L = T S^-1 for each frequency, (f, m, m); `inputs` is S, if it is not 1 - T."""
    s = np.eye(t.shape[-1]) - t if inputs is None else inputs
    return np.asarray(np.linalg.solve(s.swapaxes(-1, -2), t.swapaxes(-1, -2)).swapaxes(-1, -2))
