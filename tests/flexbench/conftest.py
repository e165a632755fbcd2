"""Runs and designs that several studies read, and a check of figures for words that overlap or are cut off."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axis import Tick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from flexbench.loop.native_fmus import with_native_fmus
from flexbench.loop.scenarios import ScenarioName, scalar_overrides, scenario_parameters
from flexbench.studies.health.replay import MEASURED
from flexbench.studies.layouts.outcome import QUANTITIES, RunOutcome
from flexbench.studies.layouts.plan import DURATION, Comparison, ComparisonPlan
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import Design, Designs, build_designs
from flexsat.parameters import ConfigurationName
from lockstep import load_system, simulate

TOUCH = 1.0  # pixel by which boxes of words may overlap: a box is a little larger than its ink
RECORDED = {1: 10.0, 2: 10.0}  # s, by seed
ON_ITS_OWN_MODES = {"controller.design": "published", "plant.modes": 25}


@pytest.fixture(scope="session")
def built() -> dict[ConfigurationName, Designs]:
    """Return both variants of each configuration's design."""
    return {name: build_designs(name) for name in CONFIGURATIONS}


@pytest.fixture(scope="session")
def designs(built: dict[ConfigurationName, Designs]) -> dict[ConfigurationName, Design]:
    """Return the corrected design of each configuration."""
    return {name: both.corrected for name, both in built.items()}


@pytest.fixture(scope="session")
def compare_made() -> Callable[..., Comparison]:
    """Return a function that makes a comparison of layouts from numbers of its runs.

    Every number is that of the centralised layout, by seed from 1 on; the distributed one has it times `factor`, but
    for what `distributed` gives by seed. A run in `lost`, by configuration and seed, is lost for the reason there.
    """

    def make(
        centralised: Sequence[float],
        factor: float = 0.5,
        distributed: Mapping[int, float | None] | None = None,
        lost: Mapping[tuple[str, int], str] | None = None,
        durations: Mapping[ScenarioName, float] = DURATION,
    ) -> Comparison:
        plan = ComparisonPlan(seeds=range(1, len(centralised) + 1), duration=durations)
        outcomes = []
        for seed, value in zip(plan.seeds, centralised, strict=True):
            other = (distributed or {}).get(seed, factor * value)
            for name, number in zip(CONFIGURATIONS, (value, other), strict=True):
                reason = (lost or {}).get((name, seed), "")
                for scenario in durations:
                    numbers = {one.key: number for one in QUANTITIES if one.scenario == scenario and not reason}
                    outcomes.append(RunOutcome(configuration=name, scenario=scenario, seed=seed, numbers=numbers,
                                            windows=("steady part, 1 to 2 s",), lost=reason))  # fmt: skip
        errors = {seed: plan.dispersion.draw(seed) for seed in plan.seeds}
        return Comparison(plan=plan, modes=(198, 198), errors=errors, outcomes=outcomes, wheels={})

    return make


@pytest.fixture(scope="session")
def recorded_runs(delivered: Path, once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return a folder with centralised fine pointing of seeds 1 and 2, measurements recorded: run once for all workers.

    With native FMUs: the published design on the modes that it knows, whose filter assumes the noise that there is.
    For reading only. Results are in the folders `1` and `2`.
    """

    def record(folder: Path) -> None:
        system = with_native_fmus(load_system(delivered / "centralised" / "fine_pointing.ssd"))
        for seed, stop_time in RECORDED.items():
            simulate(
                system,
                folder / str(seed),
                stop_time=stop_time,
                record=(*system.record, *MEASURED),
                overrides={**scalar_overrides(scenario_parameters("fine_pointing", seed=seed)), **ON_ITS_OWN_MODES},
            )

    return once("recorded", record)


def _words(figure: Figure) -> list[tuple[str, Bbox]]:
    """Return every visible text of a drawn figure and where it stands, in pixels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    found = []
    undrawn = _ticks(figure, drawn=False) - _ticks(figure, drawn=True)  # ticks beyond the limits keep their words
    for text in figure.findobj(lambda artist: isinstance(artist, Text) and artist not in undrawn):
        shown = text.get_visible() and (text.axes is None or text.axes.get_visible())
        if shown and text.get_text().strip() and text.get_alpha() != 0.0:
            found.append((text.get_text(), text.get_window_extent(renderer)))
    return found


def _ticks(figure: Figure, *, drawn: bool) -> set[object]:
    axis = [one for axes in figure.axes if axes.axison or not drawn for one in (axes.xaxis, axes.yaxis)]
    ticks = [tick for one in axis for tick in (one._update_ticks() if drawn else one.findobj(Tick))]
    return {label for tick in ticks for label in (tick.label1, tick.label2)}


@pytest.fixture(scope="session")
def crowded() -> Callable[[Figure], list[str]]:
    """Return a function that lists overlapping pairs of words in a figure, and words that its edge cuts."""

    def look(figure: Figure) -> list[str]:
        words, complaints = _words(figure), []
        width, height = figure.get_size_inches() * figure.dpi
        for text, box in words:
            if box.x0 < -TOUCH or box.y0 < -TOUCH or box.x1 > width + TOUCH or box.y1 > height + TOUCH:
                complaints.append(f"cut: {text!r}")
        boxes = np.array([box.extents for _, box in words]).reshape(-1, 4)
        low, high = (
            np.maximum(boxes[:, None, :2], boxes[None, :, :2]),
            np.minimum(boxes[:, None, 2:], boxes[None, :, 2:]),
        )
        for one, other in np.argwhere(np.triu(np.all(high - low > TOUCH, axis=2), k=1)).tolist():
            complaints.append(f"overlap: {words[one][0]!r} and {words[other][0]!r}")
        return complaints

    return look
