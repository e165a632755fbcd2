"""A sweep of short co-simulations over wheel speed: all wheels at one speed, no torque commanded.

Each run starts at rest with the wheels at its speed, through the parameter `plant.initial.wheel.speed_offset`, with
jitter on and the loop open. What is measured is the second half of each run: the density of the deformation, and its
RMS. In a run of 20 s a mode at 4 Hz and half a percent of damping has reached nine tenths of its amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.parameters import RPM
from flexsat.spacecraft.campbell_crossings import modal_frequencies
from flexsat.variants import CORRECTED, VARIANT_PORT, Variant
from lockstep import InputError, load_system, read_signals

from ...engine.jobs import Job, run_jobs
from ...loop.fmu_choice import PrintLine, choose_fmus, silent
from ...loop.loop_parts import loop_parts
from ...loop.spacecraft import designs_for
from ...runs.json_file import read_table, write_json
from ..spectra.welch import estimate, noise_bandwidth
from .campbell import imbalance_deformation
from .crossings import Crossing, find_crossings

RESULT = "waterfall.json"
RECORD = ("plant.modal.displacement", "plant.wheel.speed")
SLOWEST = 20.0 * RPM
GRID = 60  # speeds at which modes are computed to find crossings


@dataclass(frozen=True, slots=True, kw_only=True)
class Waterfall:
    """Deformation over wheel speed."""

    configuration: str
    seed: int
    stop: float  # s, of each run
    fmus: str  # their kind: native or Python
    speed: Array  # (k,) [rad/s]
    frequency: Array  # (f,) [Hz]
    density: Array  # (f, k) [m^2/Hz]
    rms: Array  # (k,) [m], over the second half
    predicted: Array  # (k,) [m]: steady, linear, first harmonics of all wheels as if their phases were unrelated
    crossings: Sequence[Crossing]


def default_range(design: Design) -> tuple[float, float]:
    """Return the range of speeds [rad/s] that holds every allowed band, and as much again beside the fastest."""
    return SLOWEST, float(design.response.nominal.max()) + 2.0 * float(design.config.wheel_set.speed_band.max())


def sweep(
    system: Path,
    design: Design,
    folder: Path,
    points: int,
    stop: float,
    seed: int,
    span: tuple[float, float] | None = None,
    processes: int | None = None,
    python: bool = False,
    report: PrintLine = silent,
) -> Waterfall:
    """Run the sweep; write one folder a speed, and waterfall.json.

    Parameters
    ----------
    system : of flexsat, any scenario
    design : that it was built from
    folder : results folder
    points : number of speeds, evenly spaced
    stop : simulated time of each run [s]
    seed : of plant and sensors
    span : lowest and highest speed [rad/s]; None as `default_range`
    processes : at once; None for one a core
    python : simulate the FMUs in Python; else the native ones where they are built
    report : called with the kind of the FMUs, as a line

    Raises
    ------
    InputError
        For a number out of range.
    """
    if points < 2:
        raise InputError(f"--points {points}: must be 2 or more")
    if not (np.isfinite(stop) and stop >= 1.0):
        raise InputError(f"--stop-time {stop:g}: must be 1 s or more, for the slowest modes to move")
    low, high = span or default_range(design)
    if not 0.0 < low < high:
        raise InputError(f"--speed-range {low / RPM:g} {high / RPM:g}: must be two rising speeds > 0 rpm")
    chosen = choose_fmus([load_system(system)], python)
    report(chosen.text)
    speeds = np.linspace(low, high, points)
    jobs = [
        Job(
            system=system,
            folder=folder / f"speed-{speed / RPM:07.2f}rpm",
            overrides=_overrides(design, speed, seed),
            stop_time=stop,
            record=RECORD,
            metrics=False,
            native=chosen.native,
        )
        for speed in speeds.tolist()
    ]
    run_jobs(jobs, processes)
    spectra = [measure(job.folder, design, stop) for job in jobs]
    grid = np.linspace(low, high, GRID)
    modes = modal_frequencies(design.structure, grid, float(grid[-1]))
    result = Waterfall(
        configuration=design.config.name,
        seed=seed,
        stop=stop,
        fmus=chosen.kind,
        speed=speeds,
        frequency=spectra[0][0],
        density=np.column_stack([density for _, density, _ in spectra]),
        rms=np.array([rms for _, _, rms in spectra]),
        predicted=predict(design, speeds),
        crossings=find_crossings(grid, modes, design.response.nominal, design.config.wheel_set.speed_band),
    )
    write_waterfall(result, design, folder)
    return result


def _overrides(design: Design, speed: float, seed: int) -> dict[str, Any]:
    offset = {
        f"plant.initial.wheel.speed_offset[{i}]": speed - nominal
        for i, nominal in enumerate(design.response.nominal.tolist(), start=1)
    }
    return {
        **offset,
        "plant.seed": seed,
        "sensors.seed": seed,
        "plant.initial.attitude_deviation": 0.0,
        "plant.initial.random_wheel_phases": True,
        "sensors.jitter.enabled": True,
        "controller.open_loop": True,
        **{
            f"{component}.{name}": value
            for component in ("plant", "sensors", "controller")
            for name, value in design.variant.switch.items()
        },
        **{f"controller.command.rotation[{axis}]": 0.0 for axis in (1, 2, 3)},
    }


def design_of(system: Path, variant: Variant = CORRECTED) -> Design:
    """Return the design of a system of flexsat; raise InputError for any other, or a variant that there is not."""
    parts = loop_parts(load_system(system))
    if parts is None:
        raise InputError(
            f"{system}: not a system of flexsat; `flexsat build` writes fmus/<configuration>/<scenario>.ssd"
        )
    designs = designs_for(parts.configuration, parts.plant.source)
    if variant not in designs.variants:
        raise InputError(f"{system}: nothing of {parts.configuration} was published; leave out --as-published")
    return designs.variant(variant)


def measure(folder: Path, design: Design, stop: float) -> tuple[Array, Array, float]:
    """Return frequencies [Hz], density of the deformation [m^2/Hz] and its RMS [m], over the second half of a run."""
    signals = read_signals(folder)
    later = (signals.time >= 0.5 * stop) & (signals.time < stop)  # at the stop time no interval begins
    history = signals["plant.modal.displacement"][later] / np.sqrt(design.structure.mass)
    interval = float(signals.time[1] - signals.time[0])
    resolution = noise_bandwidth("hann") / (len(history) * interval)  # one segment: lines, not noise, matter here
    spectrum = estimate(history, interval, resolution)
    return spectrum.frequency, spectrum.total, float(np.sqrt(spectrum.mean_square))


def predict(design: Design, speeds: Array) -> Array:
    """Return the steady deformation of the linear model, (k,) [m] RMS: root-sum-square over the wheels."""
    return np.array(
        [np.linalg.norm(imbalance_deformation(design.structure, w, np.array([w]))[:, 0]) for w in speeds.tolist()]
    )


def write_waterfall(result: Waterfall, design: Design, folder: Path) -> None:
    """Write waterfall.json: the table of speeds, and the crossings."""
    by_wheel = [crossing_deformation(design, crossing) for crossing in result.crossings]
    content = {
        "configuration": result.configuration,
        **design.variant.switch,
        "seed": result.seed,
        "stop": result.stop,
        "fmus": result.fmus,
        "speed_rpm": (result.speed / RPM).tolist(),
        "deformation_rms_m": result.rms.tolist(),
        "linear_prediction_rms_m": result.predicted.tolist(),
        "crossings": [
            {
                "speed_rpm": crossing.speed / RPM,
                "mode": crossing.mode,
                "inside_band_of_wheels": list(crossing.wheels),
                "linear_deformation_of_those_m": deformation,
            }
            for crossing, deformation in zip(result.crossings, by_wheel, strict=True)
        ],
    }
    write_json(folder / RESULT, content)


def crossing_deformation(design: Design, crossing: Crossing) -> float | None:
    """Return the largest steady deformation [m] that a wheel allowed to run there makes at a crossing, alone."""
    if not crossing.flagged:
        return None
    made = imbalance_deformation(design.structure, crossing.speed, np.array([crossing.speed]))[:, 0]
    return float(max(made[number - 1] for number in crossing.wheels))


_SHAPE = {
    "configuration": "text",
    f"?{VARIANT_PORT}": "flag",
    "seed": "number",
    "stop": "number",
    "speed_rpm": ["number"],
    "crossings": [
        {
            "speed_rpm": "number",
            "mode": "number",
            "inside_band_of_wheels": ["whole number"],
            "linear_deformation_of_those_m": "number?",
        }
    ],
}


def read_waterfall(folder: Path) -> Mapping[str, Any] | None:
    """Return what `write_waterfall` left in a folder, None if there is none."""
    return read_table(folder / RESULT, _SHAPE)
