"""The study of margins: analysis, measurement and the delay that destabilises the co-simulation, in one JSON file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array, Complex
from flexsat.spacecraft.variation import ModelErrors
from lockstep import InputError
from lockstep.fmi.model_description import read_description
from lockstep.system.component import Value

from ...loop.fmu_choice import kind_of
from ...runs.json_file import read_table, write_json
from .analysis import Analysis, analyse
from .designed_loop import DesignedLoop
from .estimate import TOGETHER, MeasuredLoop, Replica, estimate_loop, measured_margins, merged
from .injection import open_loop_at, run_experiment
from .multisine import Multisine, design_multisine, multisine_at, room
from .real_plant import Plants, growth_of_loop
from .response import characteristic_loci
from .stability_table import Grid, as_table, stability_over_modes_and_gain
from .system_loop import SystemLoop
from .unstable_delay import UnstableDelay, destabilising_delay

FILE = "margins.json"
_LONGEST_PERIOD, _MOST_ZOOM = 1e5, 1e3  # [s], 1: beyond them a measurement takes days
SCOUT_MODES = 60  # up to 17 Hz, where the loops have rolled off
ATTEMPTS, WEAKER = 3, 4.0  # a nearly unstable loop answers many times the test signal: then a weaker one is injected
LOCI_KEPT = 3  # of all wheels together: those that come nearest to -1
Log = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasurementSettings:
    """Settings of a measurement."""

    band: tuple[float, float] | None = None  # Hz; None for one period's frequency to nearly half the sampling rate
    length: float = 20.0  # s, of a period of the test signal
    settle: int = 2  # periods
    periods: int = 4
    lines: int | None = None
    amplitude: float | None = None  # peak; None for the loop's
    quiet: bool = False
    zoom: float = 0.0  # length of a period over this one's, to measure again where lines were too far apart; 0: not
    overrides: Mapping[str, Value] = field(default_factory=dict)

    def __post_init__(self) -> None:
        band = self.band
        for name, accepted, must in (
            ("band", band is None or 0.0 < band[0] < band[1], "must be two frequencies in Hz, 0 < LOW < HIGH"),
            ("length", 0.0 < self.length <= _LONGEST_PERIOD, f"must be > 0 and at most {_LONGEST_PERIOD:g} s"),
            ("settle", self.settle >= 0, "must be 0 periods or more"),
            ("periods", self.periods >= 2, "must be 2 or more, for an uncertainty"),
            ("lines", self.lines is None or self.lines >= 1, "must be 1 or more"),
            ("amplitude", self.amplitude is None or 0.0 < self.amplitude < np.inf, "must be > 0"),
            ("zoom", self.zoom == 0.0 or 1.0 < self.zoom <= _MOST_ZOOM, f"must be 0, or > 1 and <= {_MOST_ZOOM:g}"),
        ):
            if not accepted:
                raise InputError(f"--{name} {getattr(self, name)}: {must}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """One loop to draw: a characteristic locus or the response of one direction."""

    name: str
    frequency: Array  # (f,) [Hz]
    values: Complex  # (f,)
    uncertainty: Array | None = None  # (f,) half width of the modulus; None for a computed one


def measure(
    loop: SystemLoop, settings: MeasurementSettings, folder: Path, log: Log = lambda _: None
) -> tuple[MeasuredLoop, dict[str, Any]]:
    """Run one experiment a direction, and return the loop and its margins with their uncertainties by direction.

    Raises
    ------
    InputError
        If the amplitude is not known, or what is asked for does not fit together.
    """
    amplitude = loop.amplitude if settings.amplitude is None else settings.amplitude
    if amplitude is None:
        raise InputError("--amplitude: not known for this plant; give the peak of the test signal in its inputs' unit")
    multisine = _test_signal(loop, settings)
    measured, replicas = _estimated(loop, settings, folder, multisine, amplitude, log)
    if settings.zoom:
        length = settings.length * settings.zoom
        wanted = zoomed_lines(measured, replicas, room(loop.period, length, loop.slow_period))
        if len(wanted):
            multisine = multisine_at(loop.period, length, wanted, loop.slow_period)
            again = _estimated(loop, settings, folder / "zoom", multisine, amplitude, log)
            measured, replicas = merged((measured, replicas), again)
    margins: dict[str, Any] = {}
    for name in (TOGETHER, *loop.names):
        try:
            found = measured_margins(measured, replicas, name)
        except InputError as error:
            margins[name] = {"problem": str(error)}
            continue
        margins[name] = {"value": _plain(asdict(found.value)), "uncertainty": _plain(found.uncertainty)}
    return measured, margins


def zoomed_lines(measured: MeasuredLoop, replicas: list[Replica], count: int) -> Array:
    """Return frequencies [Hz] between lines too far apart, at most `count`; none where all crossings are resolved."""
    gaps = set()
    for name in (TOGETHER, *measured.names):
        _, keep = measured.of(name)
        if np.sum(keep) < 2:
            continue
        frequency = measured.frequency[keep]
        for low in measured_margins(measured, replicas, name).value.unresolved:
            high = frequency[frequency > low][0]
            inside = measured.frequency[(measured.frequency >= low) & (measured.frequency <= high)]
            gaps |= {(float(a), float(b)) for a, b in pairwise(inside)}
    if not gaps:
        return np.empty(0)
    each = max(2, count // len(gaps))
    return np.unique(np.concatenate([np.geomspace(low, high, each) for low, high in gaps]))


def _estimated(
    loop: SystemLoop, settings: MeasurementSettings, folder: Path, multisine: Multisine, amplitude: float, log: Log
) -> tuple[MeasuredLoop, list[Replica]]:
    """Run one experiment a direction, and estimate the loop."""
    opened = open_loop_at(loop.system, loop.controller, loop.plant, multisine, folder)
    overrides = {**settings.overrides, **(loop.quiet if settings.quiet else {})}
    experiments = []
    for k, name in enumerate(loop.names):
        along = loop.directions[:, k]
        seconds = (settings.settle + settings.periods) * multisine.length
        peak = amplitude
        for attempt in range(ATTEMPTS):
            log(f"direction {name}: {len(multisine.lines)} lines, {seconds:g} s, peak {peak:g}")
            found = run_experiment(
                opened,
                folder / f"direction-{k + 1}",
                along,
                peak / float(np.abs(along).max()),
                settings.settle,
                settings.periods,
                overrides,
            )
            share = 0.0 if loop.limit is None else float(np.mean(np.abs(found).max(axis=(0, -1)) >= loop.limit))
            if share == 0.0:
                break
            if attempt == ATTEMPTS - 1:
                raise InputError(
                    f"direction {name}: the plant's inputs are at their limit of {loop.limit:g} for {100 * share:.2g} %"
                    f" of the time, with a test signal of {peak:g} too: the loop is unstable, or its noise drives it to"
                    " the limit; measure a loop that is stable, or set --noise-free"
                )
            peak /= WEAKER
        experiments.append(found)
    return estimate_loop(experiments, multisine, loop.makes, loop.names)


def _test_signal(loop: SystemLoop, settings: MeasurementSettings) -> Multisine:
    band = settings.band or (1.0 / settings.length, 0.475 / loop.period)
    return design_multisine(loop.period, settings.length, band, settings.lines, loop.slow_period)


def run_study(
    loop: SystemLoop,
    folder: Path,
    settings: MeasurementSettings,
    analytic_only: bool = False,
    find_delay: bool = False,
    log: Log = lambda _: None,
    grid: Grid | None = None,
) -> Path:
    """Analyse and measure a loop as far as possible; write margins.json to the folder and return its path.

    A designed loop that is unstable on the plant of the run is not measured: `stability` in the file has how it grows.
    """
    chosen = grid or Grid()
    if loop.real is not None:
        chosen.counts(loop.real.spacecraft.mode_count)  # before anything is computed
    if loop.designed is None and chosen != Grid():
        raise InputError(f"--modes, --gains: have no effect: {loop.controller} is not a controller of flexsat, and the"
                         " table of stability is that of a design; leave them out")  # fmt: skip
    if not analytic_only:
        _test_signal(loop, settings)  # so too
    folder.mkdir(parents=True, exist_ok=True)
    controller = loop.system.component(loop.controller)
    content: dict[str, Any] = {
        "system": loop.system.name,
        "controller": str(controller.source),
        "controller_sha256": read_description(controller).sha256,
        "seed": settings.overrides.get("sensors.seed", loop.system.component(loop.plant).parameters.get("seed", 0)),
        "held": loop.period,
        "fmus": kind_of([loop.system]),
    }
    unstable = False
    if loop.designed is not None and loop.real is not None:
        log("stability over mode count and gain")
        content["stability"] = _stability(loop.designed, loop.real, chosen)
        unstable = content["stability"]["growth"] >= 0.0
        if not unstable:
            log("analysis of the designed loop")
            content["analysis"] = _analysis(analyse(loop.designed, _scout(loop.designed, loop.real)))
    elif analytic_only:
        raise InputError(
            f"{loop.controller}: not a controller of flexsat, so there is no design to analyse; measure it"
        )
    if not analytic_only and not unstable:  # an unstable loop has no margins to measure
        measured, margins = measure(loop, settings, folder / "experiments", log)
        content["measured"] = _measured(measured, margins, settings)
    if find_delay and not unstable:
        content["real"] = asdict(_find_delay(loop, folder, settings, log))
    return write_json(folder / FILE, content, indent=1)


def _stability(designed: DesignedLoop, real: Plants, chosen: Grid) -> dict[str, Any]:
    """Return the growth of the loop as it is, and its stability over mode count and gain."""
    opened = designed.at()
    growth, frequency = growth_of_loop(opened)
    carried = real.spacecraft.mode_count
    flown = designed.plant.index.modes if designed.plant is not None else carried
    grid = stability_over_modes_and_gain(real, chosen.counts(carried), chosen.gains, loop=designed)
    return {
        "modes": flown,
        "highest": real.highest(flown),
        "growth": growth,
        "frequency": frequency,
        "grid": as_table(grid),
    }


def _scout(designed: DesignedLoop, real: Plants) -> DesignedLoop | None:
    """Return the loop with fewer modes, where that is much smaller: it has nearly the same margins."""
    if designed.plant is None or designed.plant.index.modes <= SCOUT_MODES + 20:
        return None
    return replace(designed, plant=real.model(SCOUT_MODES, ModelErrors()))


def _find_delay(loop: SystemLoop, folder: Path, settings: MeasurementSettings, log: Log) -> UnstableDelay:
    return destabilising_delay(
        loop,
        folder / "delays",
        overrides=settings.overrides,
        progress=lambda delay, rate: log(f"delay {delay * 1e3:.1f} ms: fastest growth {rate:+.3f} 1/s"),
    )


_CURVE = {"frequency": ["number"], "real": ["number"], "imaginary": ["number"], "?uncertainty": ["number"]}
_SHAPE = {
    "seed": "number",
    "?stability": {
        "modes": "number",
        "highest": "number",
        "growth": "number",
        "frequency": "number",
        "grid": ["table"],
    },
    "?analysis": {
        "exact": {"*": "number?"},
        "margins": {"*": "table"},
        "frequency": ["number"],
        "largest_s": ["number"],
        "largest_t": ["number"],
        "curves": {"*": _CURVE},
    },
    "?measured": {
        "margins": {"*": "table"},
        "frequency": ["number"],
        "coherence": {"*": ["number"]},
        "curves": {"*": _CURVE},
        "settings": {"length": "number", "periods": "number", "quiet": "flag"},
    },
    "?real": {"stable": "number", "unstable": "number?", "delay": "number?", "frequency": "number?"},
}


def read_study(folder: Path) -> dict[str, Any]:
    """Return what `run_study` left; raise InputError if there is nothing."""
    path = folder / FILE
    if not path.is_file():
        raise InputError(f"{folder}: holds no {FILE}; `flexsat margins SYSTEM --out {folder}` makes it")
    return read_table(path, _SHAPE) or {}


def curves(content: Mapping[str, Any]) -> list[Curve]:
    """Return the computed and measured loops of a study."""
    found = []
    for part, prefix in (("analysis", "design"), ("measured", "measured")):
        for name, curve in content.get(part, {}).get("curves", {}).items():
            uncertainty = curve.get("uncertainty")
            found.append(
                Curve(
                    name=f"{prefix}: {name}",
                    frequency=np.array(curve["frequency"]),
                    values=np.array(curve["real"]) + 1j * np.array(curve["imaginary"]),
                    uncertainty=None if uncertainty is None else np.array(uncertainty),
                )
            )
    return found


def _analysis(found: Analysis) -> dict[str, Any]:
    loci = characteristic_loci(found.all_wheels)
    nearest = np.argsort(np.min(np.abs(1.0 + loci), axis=0))[:LOCI_KEPT]
    drawn = {f"all wheels, locus {k + 1}": loci[:, column] for k, column in enumerate(nearest)}
    drawn |= {f"axis {axis}": found.axes[:, k] for k, axis in enumerate("xyz")}
    return {
        "exact": _plain(asdict(found.exact)),
        "margins": {name: _plain(asdict(margins)) for name, margins in found.margins.items()},
        "frequency": found.frequency.tolist(),
        "largest_s": found.sensitivity.tolist(),
        "largest_t": found.complementary.tolist(),
        "curves": {name: _curve(found.frequency, values) for name, values in drawn.items()},
    }


def _measured(found: MeasuredLoop, margins: Mapping[str, Any], settings: MeasurementSettings) -> dict[str, Any]:
    drawn = {}
    for k, name in enumerate(found.names):
        response, keep = found.of(name)
        if keep.any():
            drawn[name] = _curve(found.frequency[keep], response[keep])
            drawn[name]["uncertainty"] = found.single_uncertainty[keep, k].tolist()
    return {
        "margins": dict(margins),
        "frequency": found.frequency.tolist(),
        "coherence": dict(zip(found.names, found.coherence.T.tolist(), strict=True)),
        "coherence_together": found.coherence_together.tolist(),
        "curves": drawn,
        "settings": {
            "length": settings.length,
            "settle": settings.settle,
            "periods": settings.periods,
            "quiet": settings.quiet,
        },
    }


def _curve(frequency: Array, values: Complex) -> dict[str, list[float]]:
    return {"frequency": frequency.tolist(), "real": values.real.tolist(), "imaginary": values.imag.tolist()}


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return numbers that JSON can hold: nothing found, or no limit, is null."""
    return {
        name: list(value) if isinstance(value, tuple) else (float(value) if np.isfinite(value) else None)
        for name, value in values.items()
    }
