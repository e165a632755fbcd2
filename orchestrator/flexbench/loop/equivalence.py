"""Compare the co-simulation through FMUs with the same steppers called in one Python loop (the monolith).

The FMUs are those in Python, whose steppers are the same, or the native ones; two co-simulations are compared as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexsat.closed_loop import ClosedLoop
from flexsat.design.chain import Designs
from flexsat.parameters import ConfigurationName
from flexsat.spacecraft.assembly import Spacecraft
from lockstep import load_system, read_signals, simulate
from lockstep.array_names import array_of, in_order
from lockstep.cli.progress import show_progress
from lockstep.errors import InputError, compact
from lockstep.results.read import Signals, open_batches

from .chosen_spacecraft import slew_of
from .native_fmus import with_native_fmus
from .scenarios import Parameters, ScenarioName, scalar_overrides, scenario_parameters
from .spacecraft import designs_for

TOLERANCE = 1e-12  # relative to a signal's largest value: what a different order of additions may change
NATIVE_TOLERANCE = 1e-10  # of the native FMUs, which round otherwise at each step; 3e-11 was seen over 300 s


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Largest difference of one port, relative to its largest value in what it is compared with."""

    port: str
    scalars: int
    relative: float
    signal: str  # the element of the port where it is largest
    tolerance: float = TOLERANCE

    @property
    def met(self) -> bool:
        """Whether the tolerance is met for this port."""
        return self.relative <= self.tolerance


def compare(
    fmus: Path,
    folder: Path,
    name: ConfigurationName,
    scenario: ScenarioName,
    seed: int,
    duration: float,
    record: Sequence[str] | None = None,
    *,
    native: bool = False,
) -> list[Difference]:
    """Run both and compare every recorded signal, port by port.

    Parameters
    ----------
    fmus : folder that `flexsat build` filled
    folder : results folder of the co-simulation
    name, scenario, seed : of the run
    duration : [s]
    record : patterns; None for the default recording
    native : with the native FMUs

    Raises
    ------
    InputError
        If there are no native FMUs, or they have other matrices than those in Python.
    """
    plant = fmus / name / "plant.fmu"
    parameters = scenario_parameters(scenario, seed=seed, slew=slew_of(name, plant))
    system = load_system(fmus / name / f"{scenario}.ssd")
    with show_progress(f"{name} {scenario}") as progress:
        simulate(
            with_native_fmus(system) if native else system,
            folder,
            stop_time=duration,
            overrides=scalar_overrides(parameters),
            record=record,
            progress=progress,
            overwrite=True,
        )
    return compare_run(folder, designs_for(name, plant), parameters, duration, native=native)


def compare_run(
    folder: Path, designs: Designs, parameters: Parameters, duration: float, *, native: bool = False
) -> list[Difference]:
    """Compare every recorded signal of a run with the monolith, port by port.

    Parameters
    ----------
    folder : results folder of the run
    designs : of its spacecraft
    parameters : those of the run, by component and port, as `scenario_parameters` returns them
    duration : of the run [s]
    native : whether it was one of the native FMUs
    """
    tolerance = NATIVE_TOLERANCE if native else TOLERANCE
    signals = read_signals(folder)
    ports = list(dict.fromkeys(map(array_of, signals.columns)))
    exchanged = _exchanged(designs.corrected.spacecraft) if native else {}
    needed = [port for port, _ in exchanged.values() if port not in ports]
    expected = ClosedLoop(designs, parameters).run(duration, [*ports, *needed])
    if not np.array_equal(expected.time, signals.time):
        return [_other_times(tolerance)]
    sizes = {port: f * float(np.abs(expected.signals[other]).max()) for port, (other, f) in exchanged.items()}
    return _differences(ports, signals, expected.signals.__getitem__, tolerance, sizes)


def _exchanged(spacecraft: Spacecraft) -> dict[str, tuple[str, float]]:
    """Return what gives the size of ports that are conserved where nothing acts from outside: another port, times this.

    Those consist of rounding alone. Their size is that of the velocity of the structure, and of the body's momentum.
    """
    return {
        "plant.velocity": ("plant.modal.velocity", spacecraft.mass**-0.5),
        "plant.angular_momentum": ("plant.rate", float(np.abs(spacecraft.inertia).max())),
    }


def compare_folders(folder: Path, reference: Path, tolerance: float = NATIVE_TOLERANCE) -> list[Difference]:
    """Compare every signal of a run with that of another one, port by port: one port of each is in memory at a time.

    Raises
    ------
    InputError
        If the runs have recorded different signals.
    """
    names = _names(reference)
    differing = sorted(set(names) ^ set(_names(folder)))
    if differing:
        raise InputError(f"{folder}: {compact(differing)} recorded in one of it and {reference} only; record the same")
    found = []
    for port in dict.fromkeys(map(array_of, names)):
        signals, expected = read_signals(folder, [port]), read_signals(reference, [port])
        if not np.array_equal(expected.time, signals.time):
            return [_other_times(tolerance)]
        found += _differences([port], signals, expected.__getitem__, tolerance, {})
    return found


def _names(folder: Path) -> list[str]:
    with open_batches(folder) as (schema, _):
        return [name for name in schema.names if name != "time"]


def _other_times(tolerance: float) -> Difference:
    return Difference(port="time", scalars=1, relative=float("inf"), signal="time", tolerance=tolerance)


def _differences(
    ports: Sequence[str],
    signals: Signals,
    expected: Callable[[str], NDArray[np.float64]],
    tolerance: float,
    sizes: Mapping[str, float],
) -> list[Difference]:
    return [
        Difference(
            port=port,
            scalars=int(np.prod(np.shape(signals[port])[1:])),
            relative=relative_difference(signals[port], expected(port), sizes.get(port, 0.0)),
            signal=_farthest(signals, port, expected(port)),
            tolerance=tolerance,
        )
        for port in ports
    ]


def _farthest(signals: Signals, port: str, reference: NDArray[np.float64]) -> str:
    """Return the name of the element of a port that differs most from its reference."""
    names = [name for name in signals.columns if array_of(name) == port]
    difference = np.abs(signals[port] - reference).reshape(len(signals.time), -1).max(axis=0)
    return in_order(names)[int(np.argmax(difference))]


def relative_difference(
    values: NDArray[np.float64], reference: NDArray[np.float64], smallest_size: float = 0.0
) -> float:
    """Return the largest difference over the reference's largest value, or over a size if that is larger.

    For a reference of zeros without a size it is zero or infinity, and infinity for a value that is no number.
    """
    difference, size = float(np.abs(values - reference).max()), max(float(np.abs(reference).max()), smallest_size)
    if difference == 0.0:
        return 0.0
    return difference / size if size > 0.0 and math.isfinite(difference) else float("inf")
