"""Compare the co-simulation through FMUs with the same steppers called in one Python loop (the monolith)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexsat.closed_loop import ClosedLoop
from flexsat.design.chain import build_designs
from flexsat.parameters import ConfigurationName
from lockstep import load_system, read_signals, simulate
from lockstep.array_names import array_of
from lockstep.cli.progress import show_progress

from .scenarios import Parameters, ScenarioName, scalar_overrides, scenario_parameters

TOLERANCE = 1e-12  # relative to a signal's largest value: what a different order of additions may change


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Largest difference of one port, relative to its largest value in the monolith."""

    port: str
    scalars: int
    relative: float

    @property
    def met(self) -> bool:
        """Whether the tolerance is met for this port."""
        return self.relative <= TOLERANCE


def compare(
    fmus: Path,
    folder: Path,
    name: ConfigurationName,
    scenario: ScenarioName,
    seed: int,
    duration: float,
    record: Sequence[str] | None = None,
) -> list[Difference]:
    """Run both and compare every recorded signal, port by port.

    Parameters
    ----------
    fmus : folder that `flexsat build` filled
    folder : results folder of the co-simulation
    name, scenario, seed : of the run
    duration : [s]
    record : patterns; None for the default recording
    """
    parameters = scenario_parameters(scenario, seed=seed)
    system = load_system(fmus / name / f"{scenario}.ssd")
    with show_progress(f"{name} {scenario}") as progress:
        simulate(
            system,
            folder,
            stop_time=duration,
            overrides=scalar_overrides(parameters),
            record=record,
            progress=progress,
            overwrite=True,
        )
    return compare_run(folder, name, parameters, duration)


def compare_run(folder: Path, name: ConfigurationName, parameters: Parameters, duration: float) -> list[Difference]:
    """Compare every recorded signal of a run with the monolith, port by port.

    Parameters
    ----------
    folder : results folder of the run
    name : its configuration
    parameters : those of the run, by component and port, as `scenario_parameters` returns them
    duration : of the run [s]
    """
    signals = read_signals(folder)
    ports = list(dict.fromkeys(map(array_of, signals.columns)))
    expected = ClosedLoop(build_designs(name), parameters).run(duration, ports)
    if not np.array_equal(expected.time, signals.time):
        return [Difference(port="time", scalars=1, relative=float("inf"))]
    return [
        Difference(
            port=port,
            scalars=int(np.prod(np.shape(expected.signals[port])[1:])),
            relative=relative_difference(signals[port], expected.signals[port]),
        )
        for port in ports
    ]


def relative_difference(values: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the largest difference over the reference's largest value; for a reference of zeros, zero or infinity."""
    difference, size = float(np.abs(values - reference).max()), float(np.abs(reference).max())
    if difference == 0.0:
        return 0.0
    return difference / size if size > 0.0 else float("inf")
