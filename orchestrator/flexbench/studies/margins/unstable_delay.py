"""Find the delay that makes a co-simulation unstable: delay the plant's input until an excited loop diverges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexsat.arrays import Array
from lockstep import InputError, System
from lockstep.system.clock import seconds
from lockstep.system.component import Value

from .injection import NAME, open_loop_at, record_injection
from .multisine import Multisine, design_multisine
from .stability import LONGEST_DELAY
from .system_loop import SystemLoop

FINE_TICK = 100_000  # ns: the resolution of the delay
EXCITATION = 1.0  # s of test signal
WINDOW = 2.0  # s: growth is estimated from two consecutive windows after the excitation
WINDOWS = (WINDOW, 6.0)  # s: the longer one where nothing grows or decays enough to be sure
SURE = 1.0  # growth rate times window: modes of half a percent of damping beat, and look like growth in short windows
LOWEST = 8.0  # periods in a window: slower motion hardly grows or decays within two
FAINT = 1e-4  # of the strongest line: below it is leakage of the windows
SHARE_OF_AMPLITUDE = 1e-3  # of the test signal's peak: without noise a small excitation suffices, far from any limit
FIRST_STEP = 20  # ticks, then twice as many
RESOLUTION = 0.005  # relative, of a long delay; the tick, of a short one
ALIKE = 0.1  # relative: lines that grow as fast as the fastest; the strongest of them is named
NEAR = 1.0  # Hz, in which the strongest line is looked for
Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnstableDelay:
    """The delay at the plant input that makes the co-simulation unstable; None where there is none up to `stable`."""

    stable: float  # s, the longest delay tried at which everything decays
    unstable: float | None  # s, the shortest at which something grows
    delay: float | None  # s, in between where the growth rate passes zero
    frequency: float | None  # Hz, of what grows
    runs: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """Growth rate of an excited loop's motion, line by line, and the line that grows fastest."""

    rate: float  # 1/s
    frequency: float  # Hz
    lines: Array  # (f,) [Hz]
    rates: Array  # (f,) [1/s]
    power: Array  # (f,)

    def at(self, frequency: float) -> float:
        """Return the rate of the strongest line near a frequency [1/s]."""
        near = np.flatnonzero(np.abs(self.lines - frequency) <= NEAR)
        return float(self.rates[near[np.argmax(self.power[near])]])


def destabilising_delay(
    loop: SystemLoop,
    folder: Path,
    between: tuple[float, float] = (0.0, LONGEST_DELAY),
    amplitude: float | None = None,
    progress: Progress | None = None,
    overrides: Mapping[str, Value] | None = None,
) -> UnstableDelay:
    """Bisect the delay at the plant input in co-simulations of a few seconds, without noise.

    Parameters
    ----------
    loop : what `read_loop` returns
    folder : for the runs
    between : delays between which to look [s]: the loop is stable at the first
    amplitude : peak of the excitation in the unit of the plant's inputs; None for a thousandth of the test signal's
    overrides : values by `component.parameter`, beside those that make a run quiet
    progress : called after each run with its delay [s] and the fastest growth rate found [1/s]

    The system runs on a tick of 0.1 ms, with the plant stepped at it, so that the delay can be any number of ticks.
    A test signal excites all directions at once for a second. The spectra of two windows after it give the growth rate
    of each line; where that is too near zero for their length, a longer run decides.

    Raises
    ------
    InputError
        If the loop is unstable without a delay, or the amplitude is not known.
    """
    peak = SHARE_OF_AMPLITUDE * loop.amplitude if amplitude is None and loop.amplitude is not None else amplitude
    if peak is None:
        raise InputError("amplitude: not known for this plant; give one in the unit of its inputs")
    fine = fine_system(loop)
    tick = seconds(FINE_TICK)
    given = replace(loop, quiet={**(overrides or {}), **loop.quiet})
    done: dict[int, Growth] = {}

    def grows(ticks: int) -> bool:
        if ticks not in done:
            done[ticks] = _growth_with_delay(fine, given, folder / f"delay{ticks}", ticks, peak)
            if progress is not None:
                progress(ticks * tick, done[ticks].rate)
        return done[ticks].rate > 0.0

    stable, unstable = (round(delay / tick) for delay in between)
    if grows(stable):
        raise InputError(f"system {loop.system.name}: unstable with a delay of {stable * tick * 1e3:g} ms; start lower")
    step = FIRST_STEP
    while stable + step < unstable and not grows(stable + step):
        stable, step = stable + step, 2 * step
    unstable = min(stable + step, unstable)
    if not grows(unstable):
        return UnstableDelay(stable=unstable * tick, unstable=None, delay=None, frequency=None, runs=len(done))
    while unstable - stable > max(1.0, RESOLUTION * stable):
        middle = (stable + unstable) // 2
        if grows(middle):
            unstable = middle
        else:
            stable = middle
    critical = done[unstable].frequency
    low, high = done[stable].at(critical), done[unstable].at(critical)
    share = -low / (high - low) if low < 0.0 < high else 0.5
    return UnstableDelay(
        stable=stable * tick,
        unstable=unstable * tick,
        delay=(stable + share * (unstable - stable)) * tick,
        frequency=critical,
        runs=len(done),
    )


def fine_system(loop: SystemLoop) -> System:
    """Return the system on a tick of 0.1 ms, with the plant stepped at it, and the same delays in time."""
    system = loop.system
    times, rest = divmod(system.tick, FINE_TICK)
    if rest:
        raise InputError(f"system {system.name}: its tick must be a whole multiple of 0.1 ms to look for a delay")
    continuous = {component.name for component in system.components if component.kind == "continuous"}
    connections = tuple(
        # one tick after a continuous component is the value that is true now
        replace(c, delay=(c.delay - 1) * times + 1 if c.from_component in continuous else c.delay * times)
        for c in system.connections
    )
    components = tuple(
        replace(c, period=FINE_TICK) if c.name == loop.plant and c.kind == "continuous" else c
        for c in system.components
    )
    return replace(system, tick=FINE_TICK, components=components, connections=connections)


def growth_of(
    signals: Array, sample: float, peak: float, lowest: float | None = None, repeats: float | None = None
) -> Growth:
    """Estimate growth rates from free motion.

    Parameters
    ----------
    signals : (2 k, m) two windows long
    sample : [s]
    peak : of the excitation; a loop that exceeds it a hundredfold grows, even if it is at its limits by then
    lowest : [Hz]; slower motion is left out; None for LOWEST periods in a window
    repeats : period of the slowest sampler [s], at multiples of whose rate slow motion appears too; None: not
    """
    from scipy.signal.windows import blackmanharris  # here, as most margins are found without it

    count = len(signals) // 2
    slowest = LOWEST / (count * sample) if lowest is None else lowest
    taper = blackmanharris(count)[:, None]  # slow motion leaks less than 1e-4 of its size into any line
    windows = (signals[:count], signals[count : 2 * count])
    early, late = (np.linalg.norm(np.fft.rfft(window * taper, axis=0), axis=1) for window in windows)
    frequency: Array = np.fft.rfftfreq(count, sample).astype(np.float64)
    power = np.maximum(early, late)
    rates = np.log((late + 1e-300) / (early + 1e-300)) / (count * sample)
    near = frequency if repeats is None else np.abs(frequency - np.round(frequency * repeats) / repeats)
    strong = np.flatnonzero((near >= slowest) & (power > FAINT * power.max()))
    if not len(strong):
        return Growth(rate=-np.inf, frequency=np.nan, lines=frequency, rates=rates, power=power)
    most = float(rates[strong].max())
    alike = strong[rates[strong] >= most - ALIKE * abs(most)]
    fastest = alike[np.argmax(power[alike])]
    away = float(np.abs(signals).max() / peak)
    if away > 100.0:
        fastest = strong[np.argmax(power[strong])]
    rate = max(float(rates[fastest]), np.log(away) / (2.0 * count * sample)) if away > 100.0 else float(rates[fastest])
    return Growth(rate=rate, frequency=float(frequency[fastest]), lines=frequency, rates=rates, power=power)


def _excitation(period: float, window: float) -> Multisine:
    """Return a second of all frequencies, and nothing after it for two windows."""
    signal = design_multisine(period, EXCITATION, (1.0 / EXCITATION, 0.45 / period), round(0.4 * EXCITATION / period))
    silent = np.zeros(round(2.0 * window / period))
    return replace(signal, values=np.concatenate([signal.values, silent]))


def _growth_with_delay(system: System, loop: SystemLoop, folder: Path, ticks: int, peak: float) -> Growth:
    """Return the growth from the shortest windows in which it is sure."""
    direction = loop.directions.sum(axis=1)
    for window in WINDOWS:
        excitation = _excitation(loop.period, window)
        opened = open_loop_at(system, loop.controller, loop.plant, excitation, folder / f"window{window:g}")
        late = tuple(
            replace(c, delay=c.delay + ticks) if c.from_component == NAME else c for c in opened.system.connections
        )
        delayed = replace(opened, system=replace(opened.system, connections=late))
        run = folder / f"window{window:g}" / "run"
        before, _ = record_injection(delayed, run, direction / np.abs(direction).max(), peak, 1, loop.quiet)
        found = growth_of(before[0, round(EXCITATION / loop.period) :], loop.period, peak)
        if abs(found.rate) * window > SURE:
            break
    return found
