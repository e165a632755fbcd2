"""Compare a shadow with the original from the folder of a run: residuals, and the jump at the switchover."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.arrays import Array
from lockstep.errors import InputError, compact
from lockstep.results.read import Signals, read_signals
from lockstep.results.read_run_record import read_run_record
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW
from lockstep.system.clock import SAME_TIME

NEIGHBOURS = 1.0  # s before and after the switchover, whose steps are compared with the one at it
LARGEST_LAG = 200  # rows


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadowRun:
    """Hold what a run records of a shadow. Times in s; `end` is the end of the record."""

    component: str
    outputs: tuple[str, ...]  # the Reals that can act
    switchover: float | None
    blend: float
    end: float
    about: Mapping[str, Any]  # entry of the shadow in run.toml

    def name(self, prefix: str, output: str) -> str:
        """Return the column of an output: of what acts, of the original, of the shadow, or of the residual."""
        return f"{self.component}.{prefix}{output}"

    def matrix(self, signals: Signals, prefix: str = "") -> Array:
        """Return all outputs of one kind, (rows, outputs)."""
        return np.column_stack([signals[self.name(prefix, output)] for output in self.outputs])


@dataclass(frozen=True, slots=True, kw_only=True)
class Residual:
    """Describe shadow minus original of one output, over the rows before the switchover, in the output's unit.

    `lag` is the delay of the shadow behind the original at which the two correlate most, to a recorded row [s];
    `correlation` is that without a lag, None for a constant output.
    """

    output: str
    unit: str
    rms: float
    largest: float  # in size
    bias: float  # mean
    original_rms: float
    correlation: float | None
    lag: float | None

    @property
    def relative(self) -> float | None:
        """The residual's RMS over the original's; None if the original is zero."""
        return self.rms / self.original_rms if self.original_rms > 0.0 else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """Hold how smooth the switchover was: largest magnitudes over all outputs, in their unit.

    `acting` and `at_once` are differences from the original at the switchover: of the value that acts, and of the
    shadow, which would act without blending. A step is that of the acting value from one recorded row to the next.
    """

    acting: float
    at_once: float
    step: float  # at the switchover
    neighbours: float  # up to 1 s before and after


def has_shadow(folder: Path) -> bool:
    """Return whether a run had a shadow."""
    return _shadowed(folder) is not None


def _shadowed(folder: Path) -> dict[str, Any] | None:
    """Return the entry in run.toml of the component that had a shadow."""
    components = read_run_record(folder)[0].get("component", [])
    return next((component for component in components if "shadow" in component), None)


def read_shadow_run(folder: Path) -> tuple[ShadowRun, Signals]:
    """Read which shadow a run had, and the recorded signals of it and of the component.

    Raises
    ------
    InputError
        If the run had none, was too short, or did not record what is needed.
    """
    component = _shadowed(folder)
    if component is None:
        raise InputError(f"{folder}: this run had no shadow; run with --shadow COMPONENT=FMU")
    shadow, name = component["shadow"], component["name"]
    outputs = tuple(shadow["compared"])
    kinds = ("", ORIGINAL, SHADOW, RESIDUAL)
    signals = read_signals(folder, [f"{name}.{prefix}{output}" for prefix in kinds for output in outputs])
    if len(signals.time) < 2:
        raise InputError(f"{folder}: holds {len(signals.time)} recorded rows, too few to judge a shadow; run longer")
    over = shadow.get("switchover", shadow.get("hand_over"))  # its name in runs of earlier versions
    return (
        ShadowRun(
            component=name,
            outputs=outputs,
            switchover=over if over is not None and over <= signals.time[-1] else None,
            blend=shadow["blend"],
            end=_end(folder, signals),
            about=shadow,
        ),
        signals,
    )


def _end(folder: Path, signals: Signals) -> float:
    """Return the simulated time of a run [s]; for one that has not ended, one interval after its last row."""
    reached, (*_, before, last) = float(read_run_record(folder)[0].get("simulated_time", 0.0)), signals.time.tolist()
    return reached if reached >= last else 2.0 * last - before


def residuals(signals: Signals, recorded: ShadowRun, since: float = 0.0) -> tuple[Residual, ...]:
    """Return the residual of every output, over the rows from `since` [s] to the switchover or the end."""
    end = recorded.end if recorded.switchover is None else recorded.switchover
    rows = (signals.time >= since) & (signals.time < end)
    if np.count_nonzero(rows) < 2:
        raise InputError(f"no two rows were recorded from {since:g} s to the switchover; choose an earlier start")
    interval = float(signals.time[1] - signals.time[0])
    return tuple(_residual(signals, recorded, output, rows, interval) for output in recorded.outputs)


def _residual(signals: Signals, recorded: ShadowRun, output: str, rows: NDArray[np.bool_], interval: float) -> Residual:
    original, shadow, residual = (
        signals[recorded.name(prefix, output)][rows] for prefix in (ORIGINAL, SHADOW, RESIDUAL)
    )  # fmt: skip
    correlation, lag = _alike(original, shadow)
    return Residual(
        output=output,
        unit=signals.units[recorded.name("", output)],
        rms=_rms(residual),
        largest=float(np.max(np.abs(residual))),
        bias=float(np.mean(residual)),
        original_rms=_rms(original),
        correlation=correlation,
        lag=None if lag is None else lag * interval,
    )


def _alike(original: Array, shadow: Array) -> tuple[float | None, int | None]:
    """Return the correlation coefficient, and the delay of the shadow in rows at which the two correlate most."""
    a, b = original - original.mean(), shadow - shadow.mean()
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    if not size > 0.0:
        return None, None
    padded = 2 ** (2 * len(a) - 1).bit_length()
    product = np.fft.irfft(np.conj(np.fft.rfft(a, padded)) * np.fft.rfft(b, padded), padded)
    reach = min(LARGEST_LAG, len(a) - 1)
    lags = np.arange(-reach, reach + 1)
    return float(a @ b) / size, int(lags[int(np.argmax(product[lags]))])


def total_rms(found: tuple[Residual, ...]) -> float:
    """Return the RMS over the outputs of their residuals."""
    return float(np.sqrt(np.mean([residual.rms**2 for residual in found])))


def jump(signals: Signals, recorded: ShadowRun) -> Jump | None:
    """Return the step at the switchover and those around it; None without a switchover, or with no row before it."""
    if recorded.switchover is None:
        return None
    row = int(np.searchsorted(signals.time, recorded.switchover - SAME_TIME))
    if row == 0:
        return None
    acting, original, shadow = (recorded.matrix(signals, prefix) for prefix in ("", ORIGINAL, SHADOW))
    steps = np.max(np.abs(np.diff(acting, axis=0)), axis=1)  # step k: from row k to k + 1
    near = np.flatnonzero(np.abs(signals.time[1:] - recorded.switchover) <= NEIGHBOURS)
    near = near[near != row - 1]
    return Jump(
        acting=float(np.max(np.abs(acting[row] - original[row]))),
        at_once=float(np.max(np.abs(shadow[row] - original[row]))),
        step=float(steps[row - 1]),
        neighbours=float(np.max(steps[near])) if len(near) else 0.0,
    )


def residual_lines(folder: Path) -> list[str]:
    """Return a run's residuals as lines of text, or why there are none."""
    try:
        recorded, signals = read_shadow_run(folder)
        found = residuals(signals, recorded)
        step = jump(signals, recorded)
    except InputError as error:
        return [f"no residuals: {error}"]
    worst = max(found, key=lambda residual: residual.rms)
    share = "" if worst.relative is None else f", {100.0 * worst.relative:.3g} % of the original's"
    end = recorded.end if recorded.switchover is None else recorded.switchover
    unit = f" {worst.unit}" if worst.unit else ""
    lines = [
        f"{recorded.about['name']} minus {recorded.component}, {compact(recorded.outputs)}, to {end:g} s: residual RMS "
        f"{total_rms(found):.4g}{unit}, at most {worst.rms:.4g} in {worst.output}{share}"
    ]
    if step is not None:
        lines.append(
            f"switchover at {recorded.switchover:g} s: jump {step.acting:.4g}{unit}, without blending "
            f"{step.at_once:.4g}; step to it {step.step:.4g}, steps around up to {step.neighbours:.4g}"
        )
    return lines


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
