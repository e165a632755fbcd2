"""Designs and made-up runs that the tests of figures draw, and readers of what was drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexbench.figures.drawing import save_figure
from flexbench.runs.flown_design import FlownDesign, flown_part
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.design.chain import Design
from flexsat.parameters import ARCSECOND, ConfigurationName
from flexsat.runtime.rotations import rotate_mrp
from lockstep import Signals

PERIOD = 0.005  # s, of the controller
SHORT = 6001  # rows of 30 s: more than are drawn
WHOLE = 60_001  # rows of 300 s


def make_signals(design: Design, error: float, rows: int = SHORT) -> Signals:
    """Make a run at rest, `error` [rad] off about x, with one spike of deformation in row 1234."""
    plant, known, wheels = design.structure.mode_count, design.spacecraft.mode_count, design.spacecraft.wheel_count
    sizes = {"modal.displacement": (plant, known), "rate": (3, 3), "modal.velocity": (plant, known)}
    columns: dict[str, Any] = {}

    def add(name: str, values: Any) -> None:
        values = np.broadcast_to(np.asarray(values, dtype=float), (rows, np.shape(values)[-1]))
        columns.update({f"{name}[{i + 1}]": values[:, i] for i in range(values.shape[1])})

    for name, (true, reference) in sizes.items():
        add(f"plant.{name}", np.zeros(true))
        add(f"controller.reference.{name}", np.zeros(reference))
    add("plant.attitude.mrp", rotate_mrp((0.0, 0.0, 0.0), (error, 0.0, 0.0)))
    add("controller.reference.mrp", np.zeros(3))
    add("plant.wheel.speed", design.response.nominal)
    add("controller.reference.wheel.speed", np.zeros(wheels))
    add("controller.reference.torque", np.zeros(wheels))
    add("controller.wheel.torque", np.full(wheels, 0.25))
    columns["plant.rms_deformation"] = np.full(rows, 1e-7)
    columns["plant.rms_deformation"][1234:1235] = 5e-6
    return Signals(time=np.arange(rows) * PERIOD, columns=columns, units={}, descriptions={})


@pytest.fixture(scope="session")
def made_signals() -> Callable[..., Signals]:
    """Return the function that makes a run at rest."""
    return make_signals


@pytest.fixture(scope="session")
def flown(designs: dict[ConfigurationName, Design]) -> dict[ConfigurationName, FlownDesign]:
    """Return the part of each configuration's design that recorded signals are drawn with."""
    return {name: flown_part(design) for name, design in designs.items()}


@pytest.fixture(scope="session")
def runs(designs: dict[ConfigurationName, Design]) -> dict[ConfigurationName, Signals]:
    """Return runs of 30 s, 2 arcsec off with the centralised and 1 arcsec with the distributed wheels."""
    return {
        name: make_signals(designs[name], error)
        for name, error in zip(CONFIGURATIONS, (2.0 * ARCSECOND, 1.0 * ARCSECOND), strict=True)
    }


@pytest.fixture(scope="session")
def whole_runs(designs: dict[ConfigurationName, Design]) -> dict[ConfigurationName, Signals]:
    """Return runs of 300 s, 1 arcsec off."""
    return {name: make_signals(designs[name], ARCSECOND, WHOLE) for name in CONFIGURATIONS}


@pytest.fixture(scope="session")
def lines() -> Callable[[Axes, str], list[Line2D]]:
    """Return a function that finds the lines of a panel by the start of their label."""

    def find(axes: Axes, label: str) -> list[Line2D]:
        found = [line for line in axes.get_lines() if str(line.get_label()).startswith(label)]
        assert found, f"no line {label!r}"
        return found

    return find


@pytest.fixture(scope="session")
def heights() -> Callable[[Line2D], Any]:
    """Return a function that returns the y values of a line."""
    return lambda line: np.asarray(line.get_ydata(), dtype=float)


@pytest.fixture(scope="session")
def points() -> Callable[[Axes, str], Any]:
    """Return a function that returns the points, (k, 2), of the one line with a label."""

    def find(axes: Axes, label: str) -> Any:
        (line,) = [line for line in axes.get_lines() if line.get_label() == label]
        return np.column_stack([np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)])

    return find


@pytest.fixture(scope="session")
def legend() -> Callable[[Figure], list[str]]:
    """Return a function that returns the texts of a figure's legend."""
    return lambda figure: [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.fixture(scope="session")
def words() -> Callable[[Axes], str]:
    """Return a function that returns the texts in a panel."""
    return lambda axes: "\n".join(text.get_text() for text in axes.texts)


@pytest.fixture
def check_saved(tmp_path: Path, crowded: Callable[[Figure], list[str]]) -> Callable[[Figure, str], str]:
    """Return a function that checks that a figure is legible and saved as PNG and SVG; it returns the SVG."""

    def check(figure: Figure, name: str) -> str:
        assert crowded(figure) == []
        png, svg = save_figure(figure, tmp_path, name)
        assert png.read_bytes().startswith(b"\x89PNG")
        assert png.stat().st_size > 20_000
        assert 20_000 < svg.stat().st_size < 700_000
        assert ElementTree.parse(svg).getroot().tag.endswith("svg")
        return svg.read_text(encoding="utf-8")

    return check
