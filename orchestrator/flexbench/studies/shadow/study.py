"""What a run with a shadow comes to: residual of each wheel, the jump, and the closed loop before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND
from lockstep import InputError, Signals
from lockstep.shadow.residual import Jump, Residual, ShadowRun, jump, read_shadow_run, residuals
from lockstep.system.clock import SAME_TIME

from ...runs import histories
from ...runs.flown_design import FlownDesign
from ...runs.metrics import root_mean_square
from ...runs.run_folder import Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """A number of the closed loop over a window of time. Printed is the value times `scale`, in `unit`."""

    key: str
    label: str
    unit: str
    scale: float
    of: Callable[[Signals, FlownDesign], float]  # in SI
    weighted: bool = False  # needs the weights of the original's regulator


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadowWindow:
    """A stretch of the run, from `start` up to `end` [s], and its numbers in SI."""

    start: float
    end: float
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A judged run. Without a switchover there is the window `before` only: the whole run from `since` on."""

    recorded: ShadowRun
    since: float  # s
    residuals: tuple[Residual, ...]
    jump: Jump | None
    before: ShadowWindow
    blending: ShadowWindow | None
    after: ShadowWindow | None


def _rms(history: Callable[[Signals], Array]) -> Callable[[Signals, FlownDesign], float]:
    return lambda signals, _: root_mean_square(history(signals))


def _cost(part: int) -> Callable[[Signals, FlownDesign], float]:
    def mean(signals: Signals, design: FlownDesign) -> float:
        return float(np.mean(histories.lqr_cost(signals, design)[part][histories.controller_rows(signals, design)]))

    return mean


def _largest(history: Callable[[Signals], Array]) -> Callable[[Signals, FlownDesign], float]:
    return lambda signals, _: float(np.max(np.abs(history(signals))))


def _torque(signals: Signals) -> Array:
    return signals[histories.TORQUE]


MEASURES = (
    Measure(key="pointing_error", label="pointing error, RMS", unit="arcsec", scale=1.0 / ARCSECOND,
            of=_rms(histories.pointing_error)),
    Measure(key="largest_pointing_error", label="pointing error, largest", unit="arcsec", scale=1.0 / ARCSECOND,
            of=_largest(histories.pointing_error)),
    Measure(key="rate_error", label="rate error, RMS", unit="deg/s", scale=180.0 / np.pi,
            of=_rms(histories.rate_error)),
    Measure(key="deformation", label="deformation, RMS", unit="µm", scale=1e6, of=_rms(histories.deformation)),
    Measure(key="torque", label="sum of |torque|, RMS", unit="N.m", scale=1.0, of=_rms(histories.torque_norm)),
    Measure(key="largest_torque", label="torque of a wheel, largest", unit="N.m", scale=1.0, of=_largest(_torque)),
    Measure(key="total_cost", label="LQR cost a sample", unit="1", scale=1.0, of=_cost(0),
            weighted=True),
    Measure(key="control_cost", label="control cost a sample", unit="1", scale=1.0, of=_cost(1),
            weighted=True),
)  # fmt: skip


def study(run: Run, since: float | None = None, window: float | None = None) -> Study:
    """Judge a run with a shadow.

    Parameters
    ----------
    run : with a shadow beside its controller
    since : leave out what is before [s]; None: 0
    window : length of the windows before and after [s]; None: as long as both sides have room for

    Raises
    ------
    InputError
        If no shadow rode along, a signal was not recorded, or there is no room for the windows.
    """
    recorded, _ = read_shadow_run(run.folder)
    signals, design = run.signals(), run.flown
    since = 0.0 if since is None else since
    found = residuals(signals, recorded, since)
    if recorded.switchover is None:
        if window is not None:
            raise InputError(f"--window {window:g}: this run has no switchover; give --from instead")
        return Study(
            recorded=recorded, since=since, residuals=found, jump=None, blending=None, after=None,
            before=_window(signals, design, since, recorded.end),
        )  # fmt: skip
    blended = recorded.switchover + recorded.blend
    room = min(recorded.switchover - since, recorded.end - blended)
    if window is not None and not 0.0 < window <= room + SAME_TIME:
        raise InputError(
            f"--window {window:g}: must be > 0 and at most {max(room, 0.0):g} s, the room before the switchover at "
            f"{recorded.switchover:g} s and after the blend, which ends at {blended:g} s"
        )
    length = room if window is None else window
    after = _window(signals, design, recorded.end - length, recorded.end) if length > 0.0 else None
    return Study(
        recorded=recorded,
        since=since,
        residuals=found,
        jump=jump(signals, recorded),
        before=_window(
            signals,
            design,
            recorded.switchover - (length if after else recorded.switchover - since),
            recorded.switchover,
        ),
        blending=_window(signals, design, recorded.switchover, min(blended, recorded.end))
        if recorded.blend > 0.0
        else None,
        after=after,
    )


def _window(signals: Signals, design: FlownDesign, start: float, end: float) -> ShadowWindow:
    # a row belongs to the window that it begins in; half a nanosecond for times that are sums
    rows = (signals.time >= start - 5e-10) & (signals.time < end - 5e-10)
    if not np.any(rows):
        raise InputError(f"no row was recorded from {start:g} to {end:g} s; run longer, or record more often")
    part = replace(
        signals, time=signals.time[rows], columns={name: values[rows] for name, values in signals.columns.items()}
    )
    chosen = [measure for measure in MEASURES if design.cost is not None or not measure.weighted]
    values = {measure.key: measure.of(part, design) for measure in chosen}
    return ShadowWindow(start=start, end=end, values=values)
