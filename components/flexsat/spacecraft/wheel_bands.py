"""Nominal speeds and speed bands of the wheels, between crossings of the Campbell diagram where a file asks for it.

A band is as wide as the file says where a gap between crossings holds it, at the quietest such speed. Where none does,
it is what the widest gap leaves, about its middle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Flags
from ..description.configuration import Configuration
from ..parameters import HERTZ, RPM
from .assembly import Spacecraft
from .campbell_crossings import crossings
from .wheel_speeds import TIE, WheelResponse, select_speeds

DIGITS = 6  # of speeds in rad/s that follow from eigenvalues: the same bits on every processor


@dataclass(frozen=True, slots=True, kw_only=True)
class Banded:
    """A spacecraft whose wheels have the speed bands that were chosen."""

    config: Configuration
    spacecraft: Spacecraft
    response: WheelResponse


def choose_bands(config: Configuration, spacecraft: Spacecraft) -> Banded:
    """Choose nominal speeds, and bands if they are to avoid crossings; without that the bands are those of the file.

    Raises
    ------
    ValueError
        If no speed leaves a wheel's band below its speed limit, or no gap between crossings is wider than the
        clearances.
    """
    selection, wheels = config.speeds, spacecraft.wheel_set
    if not selection.avoid_crossings:
        return Banded(config=config, spacecraft=spacecraft, response=select_speeds(spacecraft, selection))
    lowest, highest = HERTZ * selection.lowest, HERTZ * selection.highest
    fastest = np.where(wheels.speed_limit > 0.0, np.minimum(wheels.speed_limit, highest), highest)
    found = crossings(spacecraft, lowest, float(fastest.max()))
    gaps = []
    for k, end in enumerate(fastest.tolist()):
        speeds = np.round(found.of_wheel(k, selection.crossing_response), DIGITS)
        gaps.append(_Gaps.of(speeds, lowest, end, HERTZ * selection.clearance))

    def allowed(speed: Array) -> Flags:
        return np.array([gap.holds(speed, band) for gap, band in zip(gaps, wheels.speed_band.tolist(), strict=True)])

    response = select_speeds(spacecraft, selection, allowed)
    nominal, band = response.nominal.copy(), wheels.speed_band.copy()
    quiet = np.diagonal(allowed(nominal))
    for k in np.flatnonzero(~quiet).tolist():
        nominal[k], half = gaps[k].widest()
        if not half > 0.0:
            widest = float(np.diff(gaps[k].edges).max())
            raise ValueError(
                f"SpeedSelection.clearance of {selection.clearance * 60.0:.4g} rpm leaves wheel {k + 1} no speeds: its"
                f" widest gap between crossings is {widest / RPM:.4g} rpm; set clearance lower, or crossing_response"
                " higher, so that weaker crossings do not count"
            )
        band[k] = min(half, band[k])
    own = [
        replace(device, wheel=replace(device.wheel or config.wheel, speed_band=one))
        for device, one in zip(config.wheels, band.tolist(), strict=True)
    ]
    gap = np.array([one.around(speed) for one, speed in zip(gaps, nominal.tolist(), strict=True)])
    return Banded(
        config=replace(config, wheels=tuple(own)),
        spacecraft=replace(spacecraft, wheel_set=replace(wheels, speed_band=band)),
        response=replace(response, nominal=nominal, gap=gap),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Gaps:
    """Speeds between the crossings of one wheel."""

    edges: Array  # (g + 1,) [rad/s], rising: ends of the range and crossings
    lower: Array  # (g,) [rad/s]: ends of what the clearance leaves of each gap
    upper: Array

    @classmethod
    def of(cls, found: Array, lowest: float, highest: float, clearance: float) -> _Gaps:
        """Return the gaps between crossings within a range; its ends need no clearance."""
        edges = np.concatenate([[lowest], found[(found > lowest) & (found < highest)], [highest]])
        lower, upper = edges[:-1] + clearance, edges[1:] - clearance
        lower[0], upper[-1] = lowest, highest
        return cls(edges=edges, lower=lower, upper=upper)

    def holds(self, speed: Array, band: float) -> Flags:
        """Return at which of some speeds a band either side is free of crossings."""
        inside = (speed - band >= self.lower[:, np.newaxis]) & (speed + band <= self.upper[:, np.newaxis])
        return np.asarray(inside.any(axis=0))

    def widest(self) -> tuple[float, float]:
        """Return the middle of the widest gap, and half of what is left of it; of those alike the slowest."""
        width = self.upper - self.lower
        k = int(np.argmax(width >= width.max() - TIE * abs(width.max())))
        return float(0.5 * (self.lower[k] + self.upper[k])), 0.5 * float(width[k])

    def around(self, speed: float) -> tuple[float, float]:
        """Return the edges either side of a speed."""
        k = int(np.searchsorted(self.edges, speed))
        return float(self.edges[k - 1]), float(self.edges[k])
