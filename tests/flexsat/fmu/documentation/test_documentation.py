"""Documentation, terminals, drawings and reference results, made from the same tables as the ports."""

from dataclasses import replace
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import image

from flexbench.loop.systems import WIRES
from flexsat.closed_loop import PORTS
from flexsat.description.built_in import configuration
from flexsat.design.chain import Designs
from flexsat.fmu.build import SHELLS, component_resources
from flexsat.fmu.documentation import drawing
from flexsat.fmu.documentation.component_text import Equation
from flexsat.fmu.documentation.content import TEXTS, draw
from flexsat.fmu.documentation.device_rows import DeviceRows, device_rows
from flexsat.fmu.documentation.drawing import number_ranges
from flexsat.fmu.documentation.experiments import EXPERIMENTS, Experiment
from flexsat.fmu.documentation.licences import licence_files
from flexsat.fmu.documentation.page import page
from flexsat.fmu.documentation.port_rows import name_range
from flexsat.fmu.documentation.reference_results import reference_files, run_experiments
from flexsat.fmu.documentation.terminals import TERMINALS, terminals_of
from flexsat.ports.table import Port, PortTable
from flexsat.variants import VARIANTS

COMPONENTS = tuple(PORTS)


@pytest.fixture(params=COMPONENTS)
def component(request):
    """Return each component in turn."""
    return request.param


def table_of(design, component, naming="structured"):
    return PortTable(PORTS[component](getattr(design, component)), naming)


def page_of(design, component, naming="structured"):
    return page(
        table_of(design, component, naming),
        TEXTS[component],
        EXPERIMENTS[component],
        file=f"{component}.fmu",
        model_name=f"{component}_{design.config.name}",
        configuration="A layout of wheels.",
        devices=device_rows(design),
        version="0",
        step=0.001,
        stop=1.0,
    )


def tree_of(content):
    return ElementTree.fromstring(content.partition(b"\n")[2])


@pytest.mark.parametrize("naming", ["structured", "flat"])
def test_every_port_has_a_row_with_its_references_unit_and_description(design, component, naming):
    table = table_of(design, component, naming)
    page_rows = tree_of(page_of(design, component, naming)).iter("tr")
    rows = [["".join(cell.itertext()) for cell in row.findall("td")] for row in page_rows]
    of_name = {row[0]: row for row in rows if row}

    for port in table:
        row = of_name[name_range(table, port)]
        of_port = [v.value_reference for v in table.variables if v.port is port]
        assert row[1] == (str(of_port[0]) if port.length == 1 else f"{of_port[0]}…{of_port[-1]}")
        if port.kind == "real":
            assert port.unit in row[3], row
        assert any(port.description in cell for cell in row), row
        assert (port.frame or "-") in row


def test_the_page_is_self_contained_and_repeats_byte_by_byte(centralised, component):
    first = page_of(centralised, component)

    assert first == page_of(centralised, component)
    for outside in (b"http:", b"https:", b"//", b"<script", b"@import", b"url("):
        assert outside not in first, outside


def test_the_page_has_all_words_of_the_text(centralised, component):
    text, found = TEXTS[component], page_of(centralised, component)
    shown = "".join(tree_of(found).itertext())

    for words in (text.summary, *text.models, *text.timing, *text.state):
        assert words in shown
    for equation in text.equations:
        assert equation.formula in found.decode()
        assert f"{equation.meaning}. [{equation.source}]" in shown
        assert equation.source.startswith("P, ")
    assert len(text.equations) >= 4


def test_markup_in_texts_is_shown_and_not_obeyed():
    markup = "<script>alert('&amp;')</script>"
    text = replace(TEXTS["plant"], title=markup, summary=markup, models=(markup,), timing=(markup,), state=(markup,))
    text = replace(text, equations=(Equation(formula="<i>y</i>", meaning=markup, source=markup),))
    ports = [Port(name=name, causality=name, description=markup) for name in ("input", "output", "parameter")]
    experiments = [Experiment(name=markup, description=markup, step=1.0, stop_time=1.0, record_every=1)]
    names = dict.fromkeys(("file", "model_name", "configuration", "version"), markup)
    none = DeviceRows(mass="", wheels=(), gyros=(), accelerometers=())
    root = tree_of(page(PortTable(ports), text, experiments, devices=none, step=1.0, stop=1.0, **names))

    assert list(root.iter("script")) == []
    shown = "".join(root.itertext())
    assert shown.count(markup) == 2 * 2 + 3 + 3 + 2 + 3 + 2 + 3  # title, head, texts, equation, ports, experiment, file


def test_the_page_states_which_parameters_may_change_in_a_run(centralised):
    plant, controller = (page_of(centralised, name).decode() for name in ("plant", "controller"))
    assert "Real[6], tunable" in plant
    assert "Tunable parameters may be set at any time" in plant
    assert "All are fixed: set them before initialisation ends." in controller


def test_a_picture_states_the_modes_that_its_component_has(centralised, monkeypatch):
    titles = []
    monkeypatch.setattr(drawing, "_png", lambda figure: titles.extend(a.get_title() for a in figure.axes) or b"")
    for name in ("plant", "sensors", "controller"):
        draw(centralised.spacecraft, configuration("centralised"), name)
    assert [title for title in titles if title] == [
        "plant: 6 wheels, 198 modes", "sensors: 6 wheels", "controller: 6 wheels, 25 modes",
    ]  # fmt: skip


def test_pictures_repeat_and_differ_between_components_and_layouts(centralised, distributed, component):
    pictures = draw(centralised.spacecraft, centralised.config, component)

    assert pictures == draw(centralised.spacecraft, centralised.config, component)
    assert pictures != draw(distributed.spacecraft, distributed.config, component)
    for other in set(COMPONENTS) - {component}:
        assert pictures["model.png"] != draw(centralised.spacecraft, centralised.config, other)["model.png"]
    drawn = image.imread(BytesIO(pictures["model.png"]))
    assert drawn.shape[:2] == (480, 480)
    assert np.ptp(drawn[..., 0]) == 1.0  # from black to white
    assert b"matplotlib" not in pictures["model.png"]  # no version in the file


@pytest.mark.parametrize(
    ("numbers", "text"), [((1, 2, 3), "1-3"), ((1, 2, 4, 7, 8), "1-2, 4, 7-8"), ((5,), "5"), ((), "")]
)
def test_numbers_of_wheels_are_written_as_ranges(numbers, text):
    assert number_ranges(numbers) == text


def test_wheels_are_numbered_where_the_picture_is_about_them(centralised, monkeypatch):
    """Without their numbers the pictures of plant and controller differ, that of the sensors does not."""
    numbered = {name: draw(centralised.spacecraft, centralised.config, name)["model.png"] for name in COMPONENTS}
    monkeypatch.setattr(drawing, "number_ranges", lambda _: "")
    changed = {
        name
        for name in COMPONENTS
        if draw(centralised.spacecraft, centralised.config, name)["model.png"] != numbered[name]
    }

    assert changed == {"plant", "controller"}


def test_terminals_connect_what_the_closed_loop_connects():
    plugs = {frozenset(terminal.ports) for terminal in TERMINALS if terminal.matching == "plug"}

    assert plugs == {frozenset(names) for _, _, names, _ in WIRES}


def test_terminals_of_one_name_have_equal_members_wherever_they_are(design):
    tables = {component: table_of(design, component) for component in COMPONENTS}
    for source, target, names, _ in WIRES:
        (found,) = (t for t in terminals_of(tables[source]) if set(t.ports) == set(names))
        assert found in terminals_of(tables[target])
        for name in names:
            assert tables[source][name].length == tables[target][name].length
            assert tables[source][name].unit == tables[target][name].unit


def test_licences_name_every_file_that_travels():
    files = licence_files()
    entry = files.pop("license.txt").decode()

    assert all(name in entry for name in files)
    assert "BSD-3-Clause AND MIT" in entry
    assert sorted(content.split(b"\n")[0] for content in files.values()) == [b"BSD 3-Clause License", b"MIT License"]


@pytest.fixture(scope="session")
def resources(centralised):
    """Return the resources of each component; the published variant is not asked for here."""
    designs = Designs(dict.fromkeys(VARIANTS, centralised))
    return {component: component_resources(designs, component) for component in COMPONENTS}


def test_experiments_move_every_input_and_nearly_every_output(resources, component):
    table, runs = run_experiments(SHELLS[component], resources[component], EXPERIMENTS[component])
    moved = set()
    for run in runs:
        for causality, rows in (("input", run.inputs), ("output", run.outputs)):
            names = [v.port.name for v in table.variables if v.port.causality == causality]
            for name, *values in zip(names, *(row[1:] for row in rows), strict=True) if rows else ():
                if len(set(values)) > 1 or name.startswith("command."):
                    moved.add(name)
        assert np.isfinite([row[1:] for row in run.outputs]).all()
        assert len(run.outputs) == run.experiment.steps // run.experiment.record_every + 1

    assert len(runs) >= 2
    still = {"estimate.gyro_bias", "estimate.disturbance"}  # of options that the experiments leave off
    assert {port.name for port in table if port.causality != "parameter"} - moved - still == set()


def test_reference_results_do_not_depend_on_what_ran_before(resources, component):
    table, runs = run_experiments(SHELLS[component], resources[component], EXPERIMENTS[component])
    _, backwards = run_experiments(SHELLS[component], resources[component], EXPERIMENTS[component][::-1])

    assert reference_files(table, runs) == reference_files(table, backwards[::-1])


def test_an_experiment_that_the_component_refuses_stops_the_build(resources):
    wrong = Experiment(name="wrong", description="a step it does not take", step=2e-3, stop_time=0.01, record_every=1)
    with pytest.raises(
        ValueError, match=r"experiment wrong: .* fast_period = 0.005 s must be a whole multiple of the step of 0.002 s"
    ):
        run_experiments(SHELLS["sensors"], resources["sensors"], [wrong])


def test_stimuli_for_an_input_that_is_not_there_stop_the_build(resources):
    wrong = Experiment(
        name="wrong",
        description="an input it does not have",
        step=1e-3,
        stop_time=0.01,
        record_every=1,
        stimuli=lambda _, time: {"thrust": time},
    )
    with pytest.raises(ValueError, match="experiment wrong: no such inputs: thrust"):
        run_experiments(SHELLS["sensors"], resources["sensors"], [wrong])


def test_flat_names_that_fall_together_are_refused():
    ports = [Port(name=name, causality="input", description=name) for name in ("wheel.speed", "wheel_speed")]

    assert len(PortTable(ports).variables) == 2
    with pytest.raises(ValueError, match=r"wheel.speed and wheel_speed both have a variable 'wheel_speed'"):
        PortTable(ports, "flat")
