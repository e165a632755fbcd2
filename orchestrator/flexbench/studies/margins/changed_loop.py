"""Co-simulate a loop with a changed gain, phase or delay at the plant's input, and see whether its motion decays.

Gain and delay are changed on the connections to the plant. A phase common to all frequencies is complex: two copies of
the loop carry its real and its imaginary part, and each plant gets a share of the torques of both controllers. All
parts are the FMUs of the system.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexsat.parameters import ARCSECOND
from lockstep import Component, Connection, InputError, System, read_signals, simulate
from lockstep.system.clock import seconds
from lockstep.system.component import Value
from lockstep.system.sums import Sums

from .injection import loop_channels
from .system_loop import SystemLoop
from .unstable_delay import Growth, growth_of

COPY, MIX = "_imaginary", "phase_shift"  # of the components that are added
SETTLE = 5.0  # s, left out: what is well damped decays
WINDOW = 20.0  # s: growth is estimated from two consecutive windows
BINS = 5  # of a window's spectrum that a slow drift reaches
ATTITUDE = 0.025 * ARCSECOND * np.array([1.0, 0.7, 0.4])  # initial MRP: 0.1 arcsec or less
MODAL_VELOCITY = 1e-6  # m kg^0.5/s, of each mode: far below what the noise of the sensors makes
FIXED: Mapping[str, Value] = {"plant.initial.random_wheel_phases": False}


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A change of all inputs of the plant together, which the controller does not know."""

    gain: float = 1.0
    phase: float = 0.0  # deg, of lead; lag is the same with real and imaginary part exchanged
    delay: float = 0.0  # s, in whole ticks of the system

    def __post_init__(self) -> None:
        if not (np.isfinite(self.gain) and np.isfinite(self.phase) and 0.0 <= self.delay < np.inf):
            raise InputError(f"{self}: gain and phase must be finite, the delay 0 s or more")

    @property
    def title(self) -> str:
        """The change in words."""
        parts = [f"gain {self.gain:g}"] if self.gain != 1.0 else []
        parts += [f"phase {self.phase:g} deg"] if self.phase else []
        parts += [f"delay {1e3 * self.delay:g} ms"] if self.delay else []
        return ", ".join(parts) or "no change"


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """What became of the motion from one window to the next."""

    total: float  # 1/s, growth of the RMS of all motion
    lines: Growth  # of each line of the spectrum

    @property
    def rate(self) -> float:
        """Growth of the line that grows fastest [1/s]."""
        return self.lines.rate

    @property
    def frequency(self) -> float:
        """Frequency of the line that grows fastest [Hz]."""
        return self.lines.frequency


def changed_system(loop: SystemLoop, change: Change) -> System:
    """Return the system with the change at the plant's input; with a phase, of two copies of its components.

    Raises
    ------
    InputError
        For a delay that is no whole number of ticks.
    """
    system = loop.system
    ticks = change.delay / seconds(system.tick)
    if abs(ticks - round(ticks)) > 1e-6:
        raise InputError(f"{change.title}: the delay must be a whole multiple of the tick, {seconds(system.tick):g} s")
    wires = loop_channels(system, loop.controller, loop.plant)
    if not change.phase:
        late = {w: replace(w, factor=change.gain * w.factor, delay=w.delay + round(ticks)) for w in wires}
        return replace(system, connections=tuple(late.get(c, c) for c in system.connections))
    copies = tuple(replace(c, name=c.name + COPY) for c in system.components)
    kept = [c for c in system.connections if c not in wires]
    kept += [replace(c, from_component=c.from_component + COPY, to_component=c.to_component + COPY) for c in kept]
    factor = change.gain * np.exp(1j * np.deg2rad(change.phase))
    terms: dict[str, tuple[str, ...]] = {}
    for part, shares in (("", (factor.real, -factor.imag)), (COPY, (factor.imag, factor.real))):
        for wire in wires:
            total = wire.input + part
            terms[total] = tuple(f"{total}.{source}" for source in ("real", "imaginary"))
            for name, source, share in zip(terms[total], ("", COPY), shares, strict=True):
                kept.append(
                    replace(wire, from_component=loop.controller + source, to_component=MIX, input=name,
                            factor=share * wire.factor, delay=0, convert_units=False)
                )  # fmt: skip
            kept.append(
                Connection(from_component=MIX, output=total, to_component=loop.plant + part, input=wire.input,
                           delay=wire.delay + round(ticks), convert_units=False)
            )  # fmt: skip
    producer = system.component(loop.controller)
    mix = Component(name=MIX, source=producer.source, period=producer.period, offset=producer.offset, kind="sampled",
                    sums=Sums(inputs=terms))  # fmt: skip
    controllers = [c for c in (*system.components, *copies) if c.name.removesuffix(COPY) == loop.controller]
    others = [c for c in (*system.components, *copies) if c not in controllers]
    return replace(system, components=(*controllers, mix, *others), connections=tuple(kept))


def fly(
    loop: SystemLoop,
    change: Change,
    folder: Path,
    overrides: Mapping[str, Value] | None = None,
    settle: float = SETTLE,
    window: float = WINDOW,
) -> Motion:
    """Co-simulate the changed loop without noise from a small deflection of everything; return how its motion grows.

    Parameters
    ----------
    loop : what `read_loop` returns, with a plant of flexsat
    change : of the plant's inputs
    folder : of the run, replaced
    overrides : values by `component.parameter`, beside those that make a run quiet
    settle, window : seconds left out, and length of each of the two windows that are compared

    The result has the rate of each line of the spectrum of the controller's outputs, from BINS / window on: what
    changes more slowly is not seen. Differences from sample to sample are compared, which have little of a drift.
    """
    if loop.real is None and loop.amplitude is None:
        raise InputError(f"{loop.plant}: not a plant of flexsat, so that its initial deflection cannot be set")
    system = changed_system(loop, change)
    wires = loop_channels(loop.system, loop.controller, loop.plant)
    outputs = list(dict.fromkeys(wire.output.partition("[")[0] for wire in wires))
    given: dict[str, Value] = {**(overrides or {}), **loop.quiet, **FIXED, **_deflection(loop)}
    if change.phase:  # the copy has the same parameters, and starts at rest
        own = {name.partition(".") for name in given if ".initial.m" not in name}
        given |= {f"{component}{COPY}.{name}": given[f"{component}.{name}"] for component, _, name in own}
    copies = ("", COPY) if change.phase else ("",)
    recorded = [f"{loop.controller}{copy}.{output}" for copy in copies for output in outputs]
    simulate(
        system,
        folder,
        stop_time=settle + 2.0 * window,
        overrides=given,
        record=recorded,
        record_period=loop.period,
        overwrite=True,
    )
    from scipy.signal import detrend  # here, as it takes longer to import than a table of stability

    signals = read_signals(folder)
    count = round(window / loop.period)
    changes = np.diff(np.column_stack([signals[name] for name in recorded]), axis=0)[-2 * count :]
    halves = [detrend(half, axis=0) for half in (changes[:count], changes[count:])]
    early, late = (float(np.linalg.norm(half)) for half in halves)
    return Motion(
        total=float(np.log(late / early)) / window,
        lines=growth_of(np.concatenate(halves), loop.period, np.inf, lowest=BINS / window, repeats=loop.slow_period),
    )


def _deflection(loop: SystemLoop) -> dict[str, Value]:
    """Return an initial attitude error, and a velocity of every mode that the plant carries."""
    found: dict[str, Value] = {
        f"{loop.plant}.initial.mrp[{axis}]": float(value) for axis, value in enumerate(ATTITUDE, start=1)
    }
    modes = 0 if loop.real is None else loop.real.spacecraft.mode_count
    for mode in range(modes):
        found[f"{loop.plant}.initial.modal.velocity[{mode + 1}]"] = (-1.0) ** mode * MODAL_VELOCITY
    return found
