"""Compute the numbers of a loop: RMS and peak of its errors, deformation and torque in windows, and its settling."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND, DEGREE, ConfigurationName
from lockstep import InputError, Signals
from lockstep.array_names import elements_of
from lockstep.faults.windows import fault_windows
from lockstep.results.read_run_record import read_run_record

from . import histories
from .loop_signals import LoopSignals, read_loop
from .slews import Slew, slews_of
from .windows import COARSE_BAND, FINE_BAND, Settling, Window, settlings, windows_of


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopQuantity:
    """A history of the loop whose RMS and peak are given. Printed is the value over `scale`, in `unit`."""

    key: str
    label: str
    unit: str
    scale: float
    of: Callable[[Signals], Array]  # in SI
    needs: tuple[str, ...]  # vectors or scalars that must be recorded


def _largest_torque(signals: Signals) -> Array:
    return np.asarray(np.max(np.abs(signals[histories.TORQUE]), axis=1))


QUANTITIES = (
    LoopQuantity(key="pointing_error", label="pointing error", unit="arcsec", scale=ARCSECOND,
             of=histories.pointing_error, needs=(histories.ATTITUDE, histories.ATTITUDE_REFERENCE)),
    LoopQuantity(key="rate_error", label="rate error", unit="deg/s", scale=DEGREE,
             of=histories.rate_error, needs=(histories.RATE, histories.RATE_REFERENCE)),
    LoopQuantity(key="deformation", label="deformation", unit="µm", scale=1e-6,
             of=histories.deformation, needs=(histories.DEFORMATION,)),
    LoopQuantity(key="torque", label="torque, sum over wheels", unit="N.m", scale=1.0,
             of=histories.torque_norm, needs=(histories.TORQUE,)),
    LoopQuantity(key="wheel_torque", label="torque, largest of a wheel", unit="N.m", scale=1.0,
             of=_largest_torque, needs=(histories.TORQUE,)),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowNumbers:
    """RMS and largest value of each quantity in a window, in SI, by key."""

    window: Window
    rms: Mapping[str, float]
    peak: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopNumbers:
    """The numbers of one run."""

    configuration: ConfigurationName
    reference: str  # what the errors refer to
    slews: tuple[Slew, ...]
    settlings: tuple[Settling, ...]
    windows: tuple[WindowNumbers, ...]
    end: float  # s, of the last row

    @property
    def steady(self) -> WindowNumbers | None:
        """The last window that is no slew: settled, steady or after the faults; None if the run ends in a slew."""
        ends_in_slew = bool(self.slews) and (self.slews[-1].end is None or self.slews[-1].end > self.end)
        return self.windows[-1] if self.windows and not ends_in_slew else None


def loop_numbers(folder: Path, band: float | None = None) -> LoopNumbers:
    """Return the numbers of a run with a plant of flexsat, whatever its controller, of any length.

    Parameters
    ----------
    folder : results folder of a run
    band : that the pointing error must stay within to be settled [rad]; None: 5 arcsec, or 0.5 with the fine sensor

    Raises
    ------
    InputError
        If the run has no plant of flexsat, no row, or none of the signals.
    """
    loop = read_loop(folder)
    if loop is None:
        raise InputError(f"{folder}: not a run of a flexsat system, whose plant is called plant_<configuration>")
    faults = [(window.begin, window.end) for window in fault_windows(folder)]
    record, _ = read_run_record(folder)
    return numbers_of(loop, faults, settling_band(record) if band is None else band)


def settling_band(record: Mapping[str, Any]) -> float:
    """Return the band of settling for the attitude sensor of a run [rad]."""
    fine = any(
        bool(c.get("parameters", {}).get(name))
        for c in record.get("component", [])
        if str(c.get("model", "")).startswith("sensors_")
        for name in ("star_tracker.fine", "star_tracker_fine")
    )
    return FINE_BAND if fine else COARSE_BAND


def numbers_of(loop: LoopSignals, faults: Sequence[tuple[float, float | None]], band: float) -> LoopNumbers:
    """Return the numbers of recorded signals, with the begin and end of each fault [s]; None: it did not end."""
    signals = loop.signals
    chosen = [one for one in QUANTITIES if all(_whole(signals, name) for name in one.needs)]
    if not len(signals.time) or not chosen:
        what = "no row" if chosen else "neither attitude, rate, deformation nor torque"
        raise InputError(f"{what} was recorded; record them, or run longer")
    values = {one.key: one.of(signals) for one in chosen}
    error = values.get("pointing_error", np.full(len(signals.time), np.nan))  # unknown: not settled
    slews = slews_of(signals)
    windows = windows_of(signals.time, error, slews, faults, band)
    return LoopNumbers(
        configuration=loop.names.configuration,
        reference=loop.reference,
        slews=slews,
        settlings=settlings(signals.time, error, slews, faults, band) if "pointing_error" in values else (),
        windows=tuple(_numbers(window, signals.time, values) for window in windows),
        end=float(signals.time[-1]),
    )


def _whole(signals: Signals, name: str) -> bool:
    """Return whether a scalar, or all elements of a vector, were recorded; wheels are taken as they are."""
    if name == histories.DEFORMATION or name == histories.TORQUE:
        return name in signals
    return len(elements_of(name, signals.columns)) == len("xyz")


def _numbers(window: Window, time: Array, values: Mapping[str, Array]) -> WindowNumbers:
    rows = window.rows(time)
    return WindowNumbers(
        window=window,
        rms={key: float(np.sqrt(np.mean(history[rows] ** 2))) for key, history in values.items()},
        peak={key: float(np.max(np.abs(history[rows]))) for key, history in values.items()},
    )
