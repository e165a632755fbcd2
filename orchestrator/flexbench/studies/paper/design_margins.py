"""Margins and spillover of the loops that the paper's study flies: the analysis of `flexsat margins`, one job a loop.

A loop that is there is not analysed again: it depends on its system, the values set, and the code.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, log, log10
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array, Complex
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName
from lockstep import load_system
from lockstep.errors import InputError
from lockstep.system.component import Value

from ...engine.dispatch import dispatch
from ...engine.fingerprint import fingerprint, of_system
from ...engine.jobs import DONE
from ...engine.pools import LocalPool, settings_of
from ...engine.tasks import Task
from ...loop.scenarios import ScenarioName
from ...runs.json_file import read_json, write_json
from ..margins.stability_table import Grid
from ..margins.study import FILE, MeasurementSettings, curves, read_study, run_study
from ..margins.system_loop import read_loop
from .paper import run_overrides
from .published import TITLES, VARIANTS, VariantName

FOLDER = "margins"  # in that of the study
SCENARIO: ScenarioName = "fine_pointing"  # whose loop is analysed; the slew has the same with the coarse star tracker
FIGURES = ("bandwidth", "nichols", "sensitivity", "spillover")  # names, before that of the layout
AXES = ("x", "y", "z")
GAINS = (-6.0, 0.0, 6.0)  # dB, of the map of spillover: what is required of the robust design, and nominal
TITLE = "Margins and spillover"
HEADER = (
    *("layout", "design", "modes of the plant", "up to [Hz]", "loop", "gain [dB]", "phase [deg]", "delay [ms]"),
    *("disk margin [1]", "gain 1 last reached, x, y, z [Hz]"),
)
EXPLANATION = (
    "The loop of fine pointing, opened at the plant's input on all wheels together, analysed as `flexsat margins"
    " --analytic-only` does. Gain, phase, delay: the change of all inputs that makes the loop unstable, exact over the"
    " star tracker's period. Disk margin: the change of gain and phase together, of the response over frequency; 0"
    " is unstable, 2 bears any. Spillover: where the plant has more modes than the controller knows, the published"
    " design is unstable. Last column: the bandwidth, as the highest frequency at which the gain of a body axis'"
    " loop is 1."
)
LONGEST = 7200.0  # s, of one analysis, which shows no progress: a minute of an idle machine


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopMargins:
    """What the analysis of one loop found."""

    configuration: ConfigurationName
    variant: VariantName
    content: Mapping[str, Any]  # of margins.json

    @property
    def title(self) -> str:
        """Name of the design in tables and figures."""
        return TITLES[self.variant]

    @property
    def stable(self) -> bool:
        """Whether the loop is stable on the plant that flew."""
        return bool(self.content["stability"]["growth"] < 0.0)

    def axes(self) -> dict[str, tuple[Array, Complex]]:
        """Return frequencies [Hz] and response of each body axis' loop; none of an unstable loop."""
        found = {curve.name: curve for curve in curves(self.content)}
        named = {axis: found.get(f"design: axis {axis}") for axis in AXES}
        return {axis: (curve.frequency, curve.values) for axis, curve in named.items() if curve is not None}


def loop_folder(folder: Path, name: ConfigurationName, variant: VariantName) -> Path:
    """Return where the analysis of one loop goes in a study's folder."""
    return folder / FOLDER / f"{name}-{variant.replace('_', '-')}"


def analyse_loop(system: Path, folder: Path, overrides: Mapping[str, Value]) -> None:
    """Analyse the loop of a system, unless its folder holds just this."""
    loaded = load_system(system)
    mark = fingerprint(of_system(loaded), dict(overrides), FOLDER)
    try:
        if (folder / FILE).is_file() and (read_json(folder / DONE) or {}).get("depends_on") == mark:
            read_study(folder)
            return
    except (InputError, AttributeError):  # damaged: analysed again
        pass
    settings, grid = MeasurementSettings(overrides=overrides), Grid(gains=GAINS)
    run_study(read_loop(loaded, overrides), folder, settings, analytic_only=True, grid=grid)
    write_json(folder / DONE, {"depends_on": mark})


def find_margins(
    fmus: Path, folder: Path, variants: Sequence[VariantName], seed: int, processes: int | None = None
) -> list[str]:
    """Analyse the loops of a study's variants on their plants, in parallel; return a line for each that failed."""
    loops = [(name, variant) for variant in ordered(variants) for name in reversed(CONFIGURATIONS)]
    forget(folder, kept=[loop_folder(folder, name, variant) for name, variant in loops])
    tasks = [
        Task(
            number=number,
            title=f"margins of {name}, {TITLES[variant]}",
            function=analyse_loop,
            arguments=(
                fmus / name / f"{SCENARIO}.ssd",
                loop_folder(folder, name, variant),
                run_overrides(SCENARIO, variant, seed),
            ),
        )
        for number, (name, variant) in enumerate(loops)
    ]
    pool = LocalPool(settings_of(LONGEST), processes)
    failed = []
    try:
        for outcome in dispatch(tasks, pool):
            if outcome.failure:
                failed.append(f"{tasks[outcome.number].title}: {outcome.error or outcome.cause}")
    except BaseException:
        pool.end()
        raise
    finally:
        pool.close()
    return failed


def ordered(variants: Sequence[VariantName]) -> list[VariantName]:
    """Return the variants, that with the longest analysis first."""
    return sorted(variants, key=lambda variant: variant != "corrected")


def forget(folder: Path, kept: Sequence[Path] = ()) -> None:
    """Remove the analyses of an earlier study, but those kept, and their figures."""
    for path in (folder / FOLDER).glob(f"*/{FILE}"):
        if path.parent not in kept:
            shutil.rmtree(path.parent)
    for pattern in FIGURES:
        for path in (folder / "figures").glob(f"{pattern}-*"):
            path.unlink()


def read_margins(folder: Path) -> list[LoopMargins]:
    """Return what the analysis left in a study's folder; nothing without one."""
    return [
        LoopMargins(configuration=name, variant=variant, content=read_study(loop_folder(folder, name, variant)))
        for name in CONFIGURATIONS
        for variant in VARIANTS
        if (loop_folder(folder, name, variant) / FILE).is_file()
    ]


def last_crossover(frequency: Array, values: Complex) -> float | None:
    """Return the highest frequency at which the gain is 1, interpolated over its logarithm; None if it is less."""
    decibel = 20.0 * np.log10(np.abs(values))
    above = np.flatnonzero(decibel >= 0.0)
    if not len(above) or above[-1] == len(frequency) - 1:
        return float(frequency[-1]) if len(above) else None
    k = above[-1]
    share = decibel[k] / (decibel[k] - decibel[k + 1])
    return float(frequency[k] * (frequency[k + 1] / frequency[k]) ** share)


def bandwidth(loop: LoopMargins) -> float | None:
    """Return the highest frequency at which the gain of some body axis' loop is 1 [Hz]; None if there is none."""
    found = [last_crossover(*response) for response in loop.axes().values()]
    return max((one for one in found if one is not None), default=None)


def rows(loops: Sequence[LoopMargins]) -> list[list[str]]:
    """Return a row of the table for each loop."""
    return [_row(loop) for loop in loops]


def _row(loop: LoopMargins) -> list[str]:
    stability = loop.content["stability"]
    first = [loop.configuration, loop.title, f"{stability['modes']:g}", f"{stability['highest']:.1f}"]
    if not loop.stable:
        doubling = 1e3 * log(2.0) / stability["growth"] if stability["growth"] > 0.0 else inf
        return [*first, f"unstable: doubles in {doubling:.3g} ms", *["-"] * 5]
    found = loop.content["analysis"]
    exact = found["exact"]
    down = f"{20.0 * log10(exact['gain_down']):+.1f}" if exact["gain_down"] else "to 0"
    up = f"{20.0 * log10(exact['gain_up']):+.1f}" if exact["gain_up"] else "no limit"
    phase = "any" if exact["phase"] is None else f"{exact['phase']:.0f}"
    delay = "> 100" if exact["delay"] is None else f"{1e3 * exact['delay']:.1f}"
    responses = list(loop.axes().values())
    crossings = [last_crossover(*response) for response in responses]
    lowest = min((float(frequency[0]) for frequency, _ in responses), default=0.0)
    return [
        *first, "stable", f"{down}, {up}", phase, delay, f"{found['margins']['all wheels']['disk']:.2f}",
        ", ".join(f"< {lowest:.2g}" if one is None else f"{one:.3g}" for one in crossings),
    ]  # fmt: skip


def sentences(loops: Sequence[LoopMargins]) -> list[str]:
    """Return a sentence about each design: on which plant it is stable in which layout, and by how much."""
    found = []
    for variant in VARIANTS:
        own = [loop for loop in loops if loop.variant == variant]
        if own:
            stability = own[0].content["stability"]
            plant = f"{stability['modes']:g} modes, up to {stability['highest']:.1f} Hz"
            title = TITLES[variant]
            found.append(f"{title[0].upper()}{title[1:]}, on {plant}: {', '.join(map(_verdict, own))}.")
    return found


def _verdict(loop: LoopMargins) -> str:
    if not loop.stable:
        return f"{loop.configuration} unstable (it grows by {loop.content['stability']['growth']:.3g} 1/s)"
    delay = loop.content["analysis"]["exact"]["delay"]
    return f"{loop.configuration} stable up to {'more than 100' if delay is None else f'{1e3 * delay:.1f}'} ms of delay"
