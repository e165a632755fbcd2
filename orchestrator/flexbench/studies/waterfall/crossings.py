"""Where the first harmonic of the wheels meets a mode, and which of these lie in a wheel's allowed speed band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexsat.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """One mode met by the first harmonic."""

    speed: float  # rad/s, of the wheels, and of the mode
    mode: int  # from 1, in the order of the frequencies
    wheels: Sequence[int]  # from 1: those whose allowed band holds the speed

    @property
    def flagged(self) -> bool:
        """Whether it lies in an allowed band."""
        return bool(self.wheels)


def find_crossings(speed: Array, modes: Array, nominal: Array, band: Array | float) -> list[Crossing]:
    """Return every crossing of the harmonic with a mode in the range of speeds, lowest first.

    Parameters
    ----------
    speed : (k,) [rad/s], rising
    modes : (m, k) [rad/s]: frequencies at these speeds, taken as straight between them
    nominal : (n,) [rad/s]: chosen speed of each wheel
    band : allowed either side of it [rad/s], of all wheels or (n,)
    """
    found = []
    for number, mode in enumerate(modes, start=1):
        gap = mode - speed
        at = [float(w) for w in speed[gap == 0.0]]
        for k in np.flatnonzero(gap[:-1] * gap[1:] < 0.0):
            share = gap[k] / (gap[k] - gap[k + 1])
            at.append(float(speed[k] + share * (speed[k + 1] - speed[k])))
        for w in at:
            inside = np.flatnonzero(np.abs(nominal - w) <= band)
            found.append(Crossing(speed=w, mode=number, wheels=tuple(int(i) + 1 for i in inside)))
    return sorted(found, key=lambda crossing: crossing.speed)
