"""Plan the comparison, and hold what its runs gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName, Slew
from lockstep import InputError

from ...loop.scenarios import ScenarioName
from .dispersions import Dispersion, Errors
from .outcome import RunOutcome
from .wheels import Wheels

COMPARED: tuple[ScenarioName, ...] = ("fine_pointing", "slew")
DURATION: dict[ScenarioName, float] = {"fine_pointing": 200.0, "slew": 200.0}
# s of fine pointing: the error that a run begins with has decayed in half of that; the slew ends at 106 s
SPEED, NATIVE_SPEED = 5.0, 30.0  # s simulated in a second by a core of 2020, of either layout


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonPlan:
    """What is simulated."""

    seeds: Sequence[int]
    dispersion: Dispersion = field(default_factory=Dispersion)
    duration: Mapping[ScenarioName, float] = field(default_factory=lambda: dict(DURATION))  # s; of those compared
    band: float | None = None  # rad, of settling; None: 5 arcsec
    slew: Slew | None = None  # None: the paper's
    overrides: Mapping[str, Any] = field(default_factory=dict)  # for both layouts
    layouts: tuple[ConfigurationName, ...] = CONFIGURATIONS  # two: the second with the first

    def __post_init__(self) -> None:
        if len(self.seeds) < 2:
            raise InputError(f"--seeds {len(self.seeds)}: an interval needs 2 or more")
        for scenario in self.duration:
            if scenario not in COMPARED:
                raise InputError(f"--scenario {scenario}: no such scenario; there are {', '.join(COMPARED)}")

    def estimate(self, processes: int, native: bool = False) -> str:
        """Return how long the runs take, in words."""
        runs = len(self.layouts) * len(self.seeds) * len(self.duration)
        simulated = len(self.layouts) * len(self.seeds) * sum(self.duration.values())
        speed = NATIVE_SPEED if native else SPEED
        minutes = simulated / speed / min(processes, runs) / 60.0
        return (
            f"{runs} runs, {simulated:g} s to simulate: about {max(1.0, minutes):.0f} min with {processes} at once,"
            f" at {speed:g} x real time each"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """All numbers of the study."""

    plan: ComparisonPlan
    modes: tuple[int, ...]  # of the plant of each layout
    errors: Mapping[int, Errors]  # of the structure, by seed: the same for all layouts
    outcomes: Sequence[RunOutcome]
    wheels: Mapping[ConfigurationName, Wheels]
    fmus: str = "Python"  # kind of the runs' FMUs

    def of(self, name: ConfigurationName, scenario: ScenarioName) -> dict[int, RunOutcome]:
        """Return the outcomes of a layout in a scenario by seed."""
        return {one.seed: one for one in self.outcomes if (one.configuration, one.scenario) == (name, scenario)}
