"""What a shadow would have done otherwise: residuals of a run, and the jump at the hand-over, from its folder."""

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

NEIGHBOURS = 1.0  # s either side of the hand-over, whose steps its own is compared with
LARGEST_LAG = 200  # rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Ride:
    """A shadow's run: whose, what it gives, and when it took over. Times in s; `end` is where the record ends."""

    component: str
    outputs: tuple[str, ...]  # the Reals that can be handed over
    hand_over: float | None
    blend: float
    end: float
    manifest: Mapping[str, Any]  # of the shadow

    def name(self, prefix: str, output: str) -> str:
        """Return the column of an output: of what acts, of the original, of the shadow, or of the residual."""
        return f"{self.component}.{prefix}{output}"

    def matrix(self, signals: Signals, prefix: str = "") -> Array:
        """Return all outputs of one kind, (rows, outputs)."""
        return np.column_stack([signals[self.name(prefix, output)] for output in self.outputs])


@dataclass(frozen=True, slots=True, kw_only=True)
class Residual:
    """Shadow less original of one output, over the rows before the hand-over, in the output's unit.

    `lag` is how much later the shadow does what the original does, to a recorded row [s], where the two correlate most;
    `correlation` is that of the two without the lag, None for an output that is constant.
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
        """The residual's RMS over the original's; None if that is nothing."""
        return self.rms / self.original_rms if self.original_rms > 0.0 else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """How smoothly what acts passed from one to the other: largest sizes over all outputs, in their unit.

    `acting` and `at_once` are differences to what the original gives at the hand-over: of what acts, and of the shadow,
    which a switch would have let act. The steps are those of what acts from one recorded row to the next.
    """

    acting: float
    at_once: float
    step: float  # at the hand-over
    neighbours: float  # up to 1 s before and after


def has_shadow(folder: Path) -> bool:
    """Tell whether a shadow rode along in a run."""
    return _shadowed(folder) is not None


def _shadowed(folder: Path) -> dict[str, Any] | None:
    """Return the component of a run that had a shadow, as run.toml tells of it."""
    components = read_run_record(folder)[0].get("component", [])
    return next((component for component in components if "shadow" in component), None)


def read_ride(folder: Path) -> tuple[Ride, Signals]:
    """Read which shadow rode along, and what was recorded of it and of the component.

    Raises
    ------
    InputError
        If the run had none, was too short to tell, or did not record what is needed.
    """
    component = _shadowed(folder)
    if component is None:
        raise InputError(f"{folder}: no shadow rode along in this run; run with --shadow COMPONENT=FMU")
    shadow, name = component["shadow"], component["name"]
    outputs = tuple(shadow["compared"])
    kinds = ("", ORIGINAL, SHADOW, RESIDUAL)
    signals = read_signals(folder, [f"{name}.{prefix}{output}" for prefix in kinds for output in outputs])
    if len(signals.time) < 2:
        raise InputError(f"{folder}: holds {len(signals.time)} recorded rows, too few to judge a shadow; run longer")
    over = shadow.get("hand_over")
    return (
        Ride(
            component=name,
            outputs=outputs,
            hand_over=over if over is not None and over <= signals.time[-1] else None,
            blend=shadow["blend"],
            end=2.0 * float(signals.time[-1]) - float(signals.time[-2]),
            manifest=shadow,
        ),
        signals,
    )


def residuals(signals: Signals, ride: Ride, since: float = 0.0) -> tuple[Residual, ...]:
    """Return the residual of every output, over the rows from `since` [s] to the hand-over or the end."""
    rows = (signals.time >= since) & (signals.time < (np.inf if ride.hand_over is None else ride.hand_over))
    if np.count_nonzero(rows) < 2:
        raise InputError(f"no two rows were recorded from {since:g} s to the hand-over; choose an earlier start")
    interval = float(signals.time[1] - signals.time[0])
    return tuple(_residual(signals, ride, output, rows, interval) for output in ride.outputs)


def _residual(signals: Signals, ride: Ride, output: str, rows: NDArray[np.bool_], interval: float) -> Residual:
    original, shadow, residual = (
        signals[ride.name(prefix, output)][rows] for prefix in (ORIGINAL, SHADOW, RESIDUAL)
    )  # fmt: skip
    correlation, lag = _alike(original, shadow)
    return Residual(
        output=output,
        unit=signals.units[ride.name("", output)],
        rms=_rms(residual),
        largest=float(np.max(np.abs(residual))),
        bias=float(np.mean(residual)),
        original_rms=_rms(original),
        correlation=correlation,
        lag=None if lag is None else lag * interval,
    )


def _alike(original: Array, shadow: Array) -> tuple[float | None, int | None]:
    """Return the correlation coefficient, and by how many rows the shadow is later where the two correlate most."""
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


def jump(signals: Signals, ride: Ride) -> Jump | None:
    """Return the step at the hand-over beside its neighbours; None without a hand-over, or with no row before it."""
    if ride.hand_over is None:
        return None
    row = int(np.searchsorted(signals.time, ride.hand_over - 1e-9))
    if row == 0:
        return None
    acting, original, shadow = (ride.matrix(signals, prefix) for prefix in ("", ORIGINAL, SHADOW))
    steps = np.max(np.abs(np.diff(acting, axis=0)), axis=1)  # step k: from row k to k + 1
    near = np.flatnonzero(np.abs(signals.time[1:] - ride.hand_over) <= NEIGHBOURS)
    near = near[near != row - 1]
    return Jump(
        acting=float(np.max(np.abs(acting[row] - original[row]))),
        at_once=float(np.max(np.abs(shadow[row] - original[row]))),
        step=float(steps[row - 1]),
        neighbours=float(np.max(steps[near])) if len(near) else 0.0,
    )


def residual_lines(folder: Path) -> list[str]:
    """Return a run's residuals as lines; of a run that is too short, why there are none."""
    try:
        ride, signals = read_ride(folder)
        found = residuals(signals, ride)
        step = jump(signals, ride)
    except InputError as error:
        return [f"no residuals: {error}"]
    worst = max(found, key=lambda residual: residual.rms)
    share = "" if worst.relative is None else f", {100.0 * worst.relative:.3g} % of the original's"
    end = ride.end if ride.hand_over is None else ride.hand_over
    unit = f" {worst.unit}" if worst.unit else ""
    lines = [
        f"{ride.manifest['name']} less {ride.component}, {compact(ride.outputs)}, to {end:g} s: residual RMS "
        f"{total_rms(found):.4g}{unit}, at most {worst.rms:.4g} in {worst.output}{share}"
    ]
    if step is not None:
        lines.append(
            f"hand-over at {ride.hand_over:g} s: jump {step.acting:.4g}{unit}, without blending "
            f"{step.at_once:.4g}; step to it {step.step:.4g}, steps around up to {step.neighbours:.4g}"
        )
    return lines


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
