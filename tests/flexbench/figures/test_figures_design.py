"""What the figures of the design draw: data against the design and the system, units, legends, legibility."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver
from matplotlib.text import Annotation
from numpy.testing import assert_allclose

from flexbench import figures
from flexbench.figures.architecture import wires
from flexbench.figures.campbell import HARMONIC_SPEEDS, MAP_SPEEDS
from flexbench.figures.drawing import AXES, axis_name
from flexbench.figures.structure import ARROW
from flexbench.figures.wheels import equal_wheels
from flexbench.html.document import Heading
from flexbench.loop.systems import WIRES, build_system
from flexbench.report.sections.design import section
from flexbench.runs.run_folder import Run
from flexbench.studies.waterfall.campbell import harmonic_deformation, imbalance_deformation, modal_frequencies
from flexsat.design.chain import Design, Designs, build_designs
from flexsat.parameters import CONFIGURATIONS, RPM, ConfigurationName
from lockstep import Component, Connection, InputError, System
from lockstep.plan.timeline import timeline

HERTZ = 2.0 * np.pi
Built = dict[ConfigurationName, Designs]
Crowded = Callable[[Figure], list[str]]


@pytest.fixture(scope="module")
def built() -> Built:
    return {name: build_designs(name) for name in CONFIGURATIONS}


@pytest.fixture(scope="module")
def corrected(built: Built) -> dict[ConfigurationName, Design]:
    return {name: both.corrected for name, both in built.items()}


@pytest.fixture(scope="module")
def structure(corrected: Any) -> Figure:
    return figures.structure_layout(corrected)


@pytest.fixture(scope="module")
def campbell(corrected: Any) -> Figure:
    return figures.campbell_diagram(corrected)


@pytest.fixture(scope="module")
def responses(corrected: Any) -> dict[ConfigurationName, Figure]:
    return {name: figures.wheel_responses(design) for name, design in corrected.items()}


@pytest.fixture(scope="module")
def system(built: Built) -> System:
    return build_system(built["distributed"], "fine_pointing", Path())


@pytest.fixture(scope="module")
def architecture(system: System) -> Figure:
    return figures.architecture_diagram(system)


def points(axes: Axes, label: str) -> Any:
    """Return the points of the one line with a label, (k, 2)."""
    (line,) = [line for line in axes.get_lines() if line.get_label() == label]
    return np.column_stack([np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)])


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def words(axes: Axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)


@pytest.mark.parametrize("number", [0, 1])
def test_structure_draws_each_wheel_where_it_sits_and_along_its_axis(structure: Figure, corrected: Any, number: int):
    axes, craft = structure.axes[number], corrected[CONFIGURATIONS[number]].spacecraft
    names = np.array([axis_name(axis) for axis in craft.wheels.axis])
    arrows = {str(one.get_label())[-1]: one for one in axes.collections if isinstance(one, Quiver)}
    for name in "xy":
        drawn, chosen = arrows[name], names == name
        assert_allclose(drawn.XY, craft.wheels.position[chosen, :2], atol=0.0)
        assert_allclose(np.column_stack([drawn.U, drawn.V]) / ARROW, craft.wheels.axis[chosen, :2], atol=1e-12)
        assert_allclose(drawn.get_facecolor()[0], to_rgba(AXES[name].colour))
    for sign, label in ((1.0, "about +z"), (-1.0, "about -z")):
        chosen = (names == "z") & (craft.wheels.axis[:, 2] == sign)
        rings = points(axes, label)
        assert len(rings) == np.count_nonzero(chosen)
        distance = np.linalg.norm(rings - craft.wheels.position[chosen, :2], axis=1)
        assert np.all(distance < 2.0)  # m: beside its own site; sites are 6 m apart and more
    counted = sum(len(one.U) for one in arrows.values()) + sum(len(points(axes, f"about {s}z")) for s in "+-")
    assert counted == craft.wheel_count


@pytest.mark.parametrize("number", [0, 1])
def test_structure_draws_the_sensors_of_each_place(structure: Figure, corrected: Any, number: int):
    axes, craft = structure.axes[number], corrected[CONFIGURATIONS[number]].spacecraft
    sites = points(axes, "site")
    assert_allclose(np.unique(sites, axis=0), np.unique(craft.accelerometers.position[:, :2], axis=0), atol=0.0)
    for label in ("gyros", "accelerometers"):
        distance = np.linalg.norm(points(axes, label)[:, None] - sites, axis=2)
        assert_allclose(np.sort(np.argmin(distance, axis=0)), np.arange(11))  # one each
        assert np.all(distance.min(axis=1) < 3.5)  # m
    assert len(points(axes, "star tracker")) == 1
    # 60 tiles of 2 m side: 623.538 m2 (PHYSICS section 1)
    x, y = np.moveaxis(np.array([path.vertices[:6] for path in axes.collections[0].get_paths()]), 2, 0)
    area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1))
    assert area == pytest.approx(623.538, abs=1e-3)


def test_structure_tells_numbers_units_and_what_the_marks_mean(structure: Figure):
    centralised, distributed = structure.axes
    assert centralised.get_title("left") == "centralised: 6 wheels of 4.62 kg·m², 4.4 N·m"
    assert distributed.get_title("left") == "distributed: 33 wheels of 0.84 kg·m², 0.8 N·m"
    assert (centralised.get_xlabel(), centralised.get_ylabel()) == ("x [m]", "y [m]")
    assert words(centralised) == "wheels 1-6"
    assert sorted(words(distributed).split("\n")) == sorted(f"wheels {3 * k + 1}-{3 * k + 3}" for k in range(11))
    assert "gyros, 23: x, y, z on the bus; x, y at each site" in legend(structure)
    assert "accelerometers, 13: x, y, z on the bus; z at each site" in legend(structure)


@pytest.mark.parametrize("number", [0, 1])
def test_campbell_draws_modes_harmonic_and_chosen_speeds(campbell: Figure, corrected: Any, number: int):
    axes, design = campbell.axes[number], corrected[CONFIGURATIONS[number]]
    modes = modal_frequencies(design.spacecraft, MAP_SPEEDS) / HERTZ
    for k in (0, 12, 24):
        assert_allclose(points(axes, f"mode {k + 1}"), np.column_stack([MAP_SPEEDS / RPM, modes[k]]), rtol=1e-12)
    assert len([line for line in axes.get_lines() if str(line.get_label()).startswith("mode")]) == 25
    assert_allclose(points(axes, "first harmonic"), [[0.0, 0.0], [1000.0, 1000.0 / 60.0]], rtol=1e-12)
    nominal, names = design.response.nominal / RPM, [axis_name(axis) for axis in design.spacecraft.wheels.axis]
    lines = [drawn for drawn in axes.collections if isinstance(drawn, LineCollection)]
    for name in "xyz":
        speed = nominal[[one == name for one in names]]
        drawn = points(axes, f"chosen, about {name}")
        assert_allclose(drawn, np.column_stack([speed, speed / 60.0]), rtol=1e-12)
        (bands,) = [one for one in lines if np.allclose(one.get_edgecolor(), to_rgba(AXES[name].colour))]
        reach = np.array(bands.get_segments())
        assert_allclose(reach[:, :, 0], np.column_stack([speed - 25.0, speed + 25.0]), rtol=1e-12)


def test_campbell_marks_the_speeds_of_the_mesh_of_record(campbell: Figure):
    """PHYSICS section 5: 351 and 223 rpm; from 223 to 833 rpm."""
    central, spread = ([points(axes, f"chosen, about {name}")[:, 0] for name in "xyz"] for axes in campbell.axes[:2])
    assert_allclose([np.unique(np.round(speed)).item() for speed in central], [351.0, 351.0, 223.0])
    everything = np.concatenate(spread)
    assert_allclose([np.round(everything.min()), np.round(everything.max())], [223.0, 833.0])


@pytest.mark.parametrize("number", [0, 1])
def test_campbell_colours_are_the_response_of_the_worst_wheel(campbell: Figure, corrected: Any, number: int):
    axes, craft = campbell.axes[number], corrected[CONFIGURATIONS[number]].spacecraft
    mesh = axes.collections[0]
    grid, values = mesh.get_coordinates(), np.asarray(mesh.get_array()).reshape(mesh.get_coordinates().shape[:2])
    assert_allclose(grid[0, :, 0], MAP_SPEEDS / RPM, rtol=1e-12)
    for column in (3, 20):
        frequency = grid[::40, column, 1] * HERTZ
        expected = imbalance_deformation(craft, MAP_SPEEDS[column], frequency).max(axis=0) * 1e6
        assert_allclose(values[::40, column], expected, rtol=1e-9)
    low, high = mesh.get_clim()
    assert high >= values.max()
    assert high / low == pytest.approx(1e5)
    assert mesh.get_cmap().name == "cividis"


@pytest.mark.parametrize("number", [0, 1])
def test_campbell_draws_the_first_harmonic_of_every_wheel(campbell: Figure, corrected: Any, number: int):
    axes, design = campbell.axes[2 + number], corrected[CONFIGURATIONS[number]]
    craft = design.spacecraft
    expected = harmonic_deformation(craft, HARMONIC_SPEEDS) * 1e6
    drawn = {}
    for line in axes.get_lines():
        kind, _, wheel = str(line.get_label()).partition(" ")
        if kind == "wheel":
            drawn[int(wheel) - 1] = np.asarray(line.get_ydata(), dtype=float)
            assert line.get_color() == AXES[axis_name(craft.wheels.axis[int(wheel) - 1])].colour
    for wheel, values in drawn.items():
        assert_allclose(values, expected[wheel], rtol=1e-12)
    for wheel in range(craft.wheel_count):  # drawn itself, or by another that answers alike
        gaps = [np.max(np.abs(np.log10(expected[wheel] / values))) for values in drawn.values()]
        assert min(gaps) < 0.002
    nominal = design.response.nominal
    for name in "xyz":
        wheels = [k for k, axis in enumerate(craft.wheels.axis) if axis_name(axis) == name]
        made = [imbalance_deformation(craft, nominal[k], nominal[[k]])[k, 0] * 1e6 for k in wheels]
        assert_allclose(points(axes, f"chosen, about {name}")[:, 1], made, rtol=1e-9)


def test_campbell_has_units_and_a_legend(campbell: Figure):
    upper, _, lower, _, bar = campbell.axes
    assert upper.get_ylabel() == "frequency [Hz]"
    assert lower.get_ylabel().endswith("RMS deformation [µm]")
    assert lower.get_xlabel() == "wheel speed [rpm]"
    assert bar.get_ylabel() == "RMS deformation, worst wheel [µm]"
    assert lower.get_yscale() == "log"
    assert {"first harmonic: Hz = rpm/60", "mode of the free spacecraft", "below 200 rpm: not searched"} < set(
        legend(campbell)
    )
    assert sum("chosen, ±25 rpm" in text for text in legend(campbell)) == 3


@pytest.mark.parametrize(("name", "panels"), [("centralised", 2), ("distributed", 13)])
def test_wheel_responses_show_every_wheel_once(responses: Any, corrected: Any, name: ConfigurationName, panels: int):
    groups = equal_wheels(corrected[name])
    assert len(groups) == panels
    assert sorted(wheel for group in groups for wheel in group) == list(range(corrected[name].spacecraft.wheel_count))
    shown = [axes for axes in responses[name].axes if axes.get_visible()]
    numbers = ", ".join(axes.get_title("left").split("\n")[1].split(" ", 1)[1] for axes in shown)
    assert sorted(map(int, numbers.split(", "))) == list(range(1, corrected[name].spacecraft.wheel_count + 1))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_wheel_responses_draw_response_maximum_choice_and_band(responses: Any, corrected: Any, name: ConfigurationName):
    result, craft = corrected[name].response, corrected[name].spacecraft
    shown = [axes for axes in responses[name].axes if axes.get_visible()]
    for axes, group in zip(shown, equal_wheels(corrected[name]), strict=True):
        wheel, nominal = group[0], result.nominal[group[0]] / RPM
        drawn, worst = points(axes, "response"), points(axes, "worst")
        assert_allclose(drawn[:, 0], result.speed / RPM, rtol=1e-12)
        assert_allclose(drawn[:, 1], result.response[wheel] * HERTZ**2, rtol=1e-12)
        assert_allclose(worst[:, 1], result.worst[wheel] * HERTZ**2, rtol=1e-12)
        (band,) = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
        assert_allclose((band.get_x(), band.get_width()), (nominal - 25.0, 50.0), rtol=1e-9)
        upright = [line for line in axes.get_lines() if len(np.asarray(line.get_xdata())) == 2]
        assert [float(np.asarray(line.get_xdata())[0]) for line in upright] == [nominal]
        # the choice is the least of the maximum, where the band lies inside the range
        inside = (worst[:, 0] >= worst[0, 0] + 22.0) & (worst[:, 0] <= worst[-1, 0] - 22.0)
        at = np.argmin(np.abs(worst[:, 0] - nominal))
        assert worst[at, 1] == worst[inside, 1].min()
        assert f"{nominal:.0f} rpm" in axes.get_title("left")
        assert axes.get_xscale() == axes.get_yscale() == "log"
        line = next(line for line in axes.get_lines() if line.get_label() == "worst")
        assert line.get_color() == AXES[axis_name(craft.wheels.axis[wheel])].colour
    assert responses[name].get_supxlabel() == "wheel speed [rpm]"
    assert "[m·kg$^{1/2}$/s]" in responses[name].get_supylabel()
    assert legend(responses[name])[1:] == [
        "its maximum over 50 rpm",
        "chosen speed: the least of that",
        "allowed: ±25 rpm",
    ]


def test_architecture_tells_every_connection_of_the_real_system(architecture: Figure, system: System):
    text = words(architecture.axes[0])
    found = {(wire.producer, wire.consumer, wire.delay): wire.ports for wire in wires(system)}
    assert found.keys() == {(source, target, delay) for source, target, _, delay in WIRES}
    sizes = Counter((c.from_component, c.output.partition("[")[0]) for c in system.connections)
    for source, target, ports, delay in WIRES:
        assert list(found[source, target, delay]) == list(ports)
        for port in ports:
            count = sizes[source, port] // sum(w[0] == source and port in w[2] for w in WIRES)
            assert found[source, target, delay][port] == count
            assert (port if count == 1 else f"{port} [{count}]") in text
    assert sum(sum(ports.values()) for ports in found.values()) == len(system.connections)
    for line in ("106 values, delay 1 tick: true now", "106 values, same tick", "66 values, same tick",
                 "33 values, same tick"):  # fmt: skip
        assert line in text


def test_architecture_draws_components_with_rates_and_ports(architecture: Figure):
    boxes = [
        patch.get_label()
        for patch in architecture.axes[0].patches
        if patch.get_label() in ("sensors", "controller", "plant")
    ]
    assert boxes == ["sensors", "controller", "plant"]  # in the order of a tick
    text = words(architecture.axes[0])
    assert "every 5 ms, sampled\n106 in, 33 out" in text
    assert "every 1 ms, continuous\n99 in, 106 out" in text
    assert "every 1 ms, sampled\n106 in, 172 out" in text


def test_architecture_draws_the_schedule_of_two_periods(architecture: Figure, system: System):
    axes = architecture.axes[1]
    steps = timeline(system, 10)
    drawn = Counter(
        (patch.get_label(), round(patch.get_x(), 6)) for patch in axes.patches if isinstance(patch, Rectangle)
    )
    assert drawn == Counter((f"{step.component}, step", step.start / 1e6) for step in steps)
    true = {(str(line.get_label()), float(np.asarray(line.get_xdata())[0])) for line in axes.get_lines()}
    assert true == {(f"{step.component}, true", (step.end if step.continuous else step.start) / 1e6) for step in steps}
    arrows = [text for text in axes.texts if isinstance(text, Annotation)]
    assert len(arrows) == sum(not read.initial for step in steps for read in step.reads)
    assert axes.get_xlabel() == "time [ms]"
    assert [label.get_text() for label in axes.get_yticklabels()] == ["sensors", "controller", "plant"]


def test_architecture_shows_a_delay_in_place(system: System):
    figure = figures.architecture_diagram(system.with_delay("sensors", "controller", 5))
    assert "106 values, delay 5 ticks = 5 ms" in words(figure.axes[0])


def test_architecture_draws_any_system(crowded: Crowded):
    offsets = {"a": 0, "b": 0, "c": 1_000_000, "lone": 0}
    components = tuple(
        Component(name=name, source=Path(f"{name}.fmu"), period=2_000_000, offset=offset)
        for name, offset in offsets.items()
    )
    ends = (("a", "y", "b", 0), ("a", "z", "b", 2), ("a", "y", "c", 0), ("c", "y", "a", 2), ("b", "y", "b", 1))
    connections = [
        Connection(
            from_component=source,
            output=f"{port}[{k}]",
            to_component=target,
            input=f"{port}_{source}[{k}]",
            delay=delay,
        )
        for source, port, target, delay in ends
        for k in (1, 2)
    ]
    system = System(name="any", tick=1_000_000, components=components, connections=tuple(connections))

    figure = figures.architecture_diagram(system, {"a": ("a note",)})

    text = words(figure.axes[0])
    assert text.count("2 values") == 5
    assert {"lone", "a note"} <= set(text.split("\n"))
    assert "every 2 ms from 1 ms on\nsampled" in text
    assert crowded(figure) == []


def test_architecture_refuses_what_cannot_be_scheduled(system: System):
    with pytest.raises(InputError, match="one of the future"):
        figures.architecture_diagram(system.with_delay("plant", "sensors", 0))


def test_figures_of_both_configurations_are_legible(
    structure: Figure, campbell: Figure, responses: Any, architecture: Figure, crowded: Crowded
):
    for figure in (structure, campbell, responses["centralised"], architecture):
        assert crowded(figure) == []


def test_there_is_a_figure_of_everything_and_each_is_drawn_when_asked_for(built: Built):
    assert set(figures.design_figures(built)) == {
        "structure", "mode-shapes", "campbell", "wheel-responses-centralised", "wheel-responses-distributed",
        "architecture-centralised", "architecture-distributed",
    }  # fmt: skip


def test_every_design_figure_is_legible_and_saved_as_png_and_svg(tmp_path: Path, built: Built, crowded: Crowded):
    drawn = figures.design_figures({"distributed": built["distributed"]})
    for name, draw in drawn.items():
        figure = draw()
        assert crowded(figure) == [], name
        png, svg = figures.save_figure(figure, tmp_path, name)
        assert png.read_bytes().startswith(b"\x89PNG")
        assert png.stat().st_size > 20_000
        assert 20_000 < svg.stat().st_size < 700_000
        assert ElementTree.parse(svg).getroot().tag.endswith("svg")


def test_figures_of_no_design_are_refused():
    for draw in (figures.structure_layout, figures.campbell_diagram):
        with pytest.raises(ValueError, match="one configuration at least"):
            draw({})


def run_of(name: ConfigurationName, **kind: Any) -> Run:
    given = {"as_published": False, "slew": True, "seed": 1, "open_loop": False} | kind
    return Run(folder=Path("unread"), configuration=name, **given)


def test_runs_of_both_configurations_share_a_figure_and_others_do_not():
    runs = [run_of(name, slew=True) for name in CONFIGURATIONS]
    runs += [run_of(name, slew=False, open_loop=loop) for name in CONFIGURATIONS for loop in (False, True)]
    runs += [run_of("centralised", slew=True, seed=2), run_of("centralised", slew=True, as_published=True)]
    runs += [run_of("centralised", slew=True)]  # once more, as of another controller

    drawn = figures.result_figures(runs)

    assert list(drawn) == ["slew-seed1", "fine-pointing-seed1", "slew-seed2", "slew-as-published-seed1", "slew-seed1-2"]


def test_a_report_is_given_the_design_of_a_run_as_pictures():
    heading, *pictures = section(run_of("distributed"))

    assert isinstance(heading, Heading)
    assert [picture.file for picture in pictures] == [
        "structure-distributed.svg",
        "wheel-responses-distributed.svg",
        "architecture-distributed.svg",
    ]
    for picture in pictures:
        assert ElementTree.fromstring(picture.svg).tag.endswith("svg")
        assert picture.description
    assert "<!-- wheels 31-33 -->" in pictures[0].svg
