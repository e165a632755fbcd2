"""Choose the time windows that the numbers of a run refer to, from its slews and faults, and judge its settling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND
from lockstep.system.clock import SAME_TIME

from .slews import Slew

TRANSIENT = 150.0  # s from the start of a run without a slew: P evaluates t > 150 s
# rad: the pointing error has settled when it stays below; half the noise of the star tracker, 5 times that of the
# fine guidance sensor, so that the noise of a loop that works stays inside
COARSE_BAND, FINE_BAND = 5.0 * ARCSECOND, 0.5 * ARCSECOND


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """A named part of a run: stretches from a begin up to an end, exclusive [s]."""

    name: str
    spans: tuple[tuple[float, float], ...]

    def rows(self, time: Array) -> NDArray[np.bool_]:
        """Return which rows belong to the window."""
        inside = np.zeros(len(time), bool)
        for begin, end in self.spans:
            inside |= (time >= begin - SAME_TIME) & (time < end - SAME_TIME)
        return inside

    @property
    def text(self) -> str:
        """The name with its times."""
        first, last = self.spans[0][0], self.spans[-1][1]
        return f"{self.name}, {first:.4g} to {last:.4g} s"


@dataclass(frozen=True, slots=True, kw_only=True)
class Settling:
    """When the pointing error last enters a band, and stays in it to the end of the run."""

    after: str  # what the time counts from
    since: float  # s
    band: float  # rad
    time: float | None  # s from `since` on; None: it does not stay within the band


def settling_time(time: Array, error: Array, since: float, band: float) -> float | None:
    """Return how long after `since` [s] the error enters the band for the last time, and stays to the end [s].

    Zero if it never leaves the band from `since` on; None if it is outside at the end, or nothing was recorded.
    """
    rows = np.flatnonzero(time >= since - SAME_TIME)
    if not len(rows):
        return None
    outside = rows[~(error[rows] <= band)]  # the negation also counts NaN
    if not len(outside):
        return 0.0
    return None if outside[-1] == rows[-1] else float(time[outside[-1] + 1]) - since


def steady_since(time: Array, error: Array, slews: Sequence[Slew], band: float) -> float | None:
    """Return from when on a run is steady [s]; None if it ends in a slew.

    After the last slew: from when the error has settled, or the second half of what is left if it does not settle, or
    only within the second half. Without a slew: from 150 s on, or the second half of a run shorter than 300 s.
    """
    if not slews:
        begin = float(time[0])
        return begin + max(0.0, min(TRANSIENT, 0.5 * (end_of(time) - begin)))
    end = slews[-1].end
    if end is None or end > time[-1]:
        return None
    half = 0.5 * (end_of(time) - end)
    settled = settling_time(time, error, end, band)
    return end + (half if settled is None else min(settled, half))


def windows_of(
    time: Array, error: Array, slews: Sequence[Slew], faults: Sequence[tuple[float, float | None]], band: float
) -> tuple[Window, ...]:
    """Return the windows of a run that hold a row.

    Parameters
    ----------
    time, error : (rows,) [s], [rad] of pointing, without the row at the stop time
    slews : in their order
    faults : begin and end [s] of each fault; None: it lasted to the end of the run
    band : of settling [rad]

    Returns
    -------
    tuple
        The slews; then, without faults, the steady part; with faults what is steady before, during and after them.
    """
    if not len(time):
        return ()
    last = end_of(time)
    windows = []
    if moving := tuple((slew.start, slew.end if slew.end is not None else last) for slew in slews
                       if slew.end is None or slew.end > slew.start):  # fmt: skip
        name = "slew" if len(moving) == 1 else f"{len(moving)} slews"
        windows.append(Window(name=name, spans=moving))
    if faults:
        first = min(begin for begin, _ in faults)
        ends = [last if end is None else end for _, end in faults]
        before = time < first - SAME_TIME
        known = [slew for slew in slews if slew.start < first]
        start = steady_since(time[before], error[before], known, band) if np.any(before) else None
        word = "fault" if len(faults) == 1 else "faults"
        if start is not None:
            windows.append(Window(name=f"before the {word}", spans=((start, first),)))
        spans = tuple((begin, end) for (begin, _), end in zip(faults, ends, strict=True))
        windows.append(Window(name=f"during the {word}", spans=spans))
        if max(ends) < last:
            windows.append(Window(name=f"after the {word}", spans=((max(ends), last),)))
    else:
        start = steady_since(time, error, slews, band)
        if start is not None and slews and slews[-1].start == slews[-1].end:
            windows.append(Window(name="response to the step", spans=((slews[-1].start, start),)))
        if start is not None:
            windows.append(Window(name=_steady_name(time, error, slews, band), spans=((start, last),)))
    return tuple(window for window in windows if np.any(window.rows(time)))


def _steady_name(time: Array, error: Array, slews: Sequence[Slew], band: float) -> str:
    if not slews:
        return "steady part"
    settled = settling_time(time, error, slews[-1].end or 0.0, band)
    return "second half after the slew" if settled is None else "settled"


def end_of(time: Array) -> float:
    """Return the end of the last row's interval [s]."""
    if len(time) < 2:
        return float(time[-1]) + 1e-6
    return float(time[-1] + (time[-1] - time[0]) / (len(time) - 1))


def settlings(
    time: Array, error: Array, slews: Sequence[Slew], faults: Sequence[tuple[float, float | None]], band: float
) -> tuple[Settling, ...]:
    """Return the settling after the last slew and the last fault that ended in the run, or else after its start."""
    found = []
    if not slews and not faults and len(time):
        since = float(time[0])
        taken = settling_time(time, error, since, band)
        found.append(Settling(after="the start", since=since, band=band, time=taken))
    if slews and slews[-1].end is not None and slews[-1].end <= time[-1]:
        since = slews[-1].end
        jump = slews[-1].start == since
        name = "the commanded step" if jump else "the slew's end" if len(slews) == 1 else "the last slew's end"
        found.append(Settling(after=name, since=since, band=band, time=settling_time(time, error, since, band)))
    ends = [end for _, end in faults if end is not None and end <= time[-1]]
    if ends and len(ends) == len(faults):
        since = max(ends)
        name = "the fault's end" if len(faults) == 1 else "the last fault's end"
        found.append(Settling(after=name, since=since, band=band, time=settling_time(time, error, since, band)))
    return tuple(found)
