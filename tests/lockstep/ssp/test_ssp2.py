"""SSP 2.0: what it shares with 1.0 is read, arrays are written out, the rest is left out with a warning or refused."""

import shutil

import pytest

from lockstep import InputError, load_system
from lockstep.ssp.step_times import Timing


@pytest.fixture
def load2(tmp_path, ssd):
    """Return a function that reads a system of SSP 2.0, stepped every millisecond."""
    head, _, rest = ssd.document("SYSTEM").partition("SYSTEM")

    def load_text(system):
        path = tmp_path / "foreign.ssd"
        path.write_text(head.replace('version="1.0"', 'version="2.0"') + system + rest)
        return load_system(path, Timing(period=1_000_000))

    return load_text


def said(system):
    """Return the warnings without their places, but for that of the toys' folder."""
    return [text.rpartition("line 1: ")[2] for text in system.warnings if "sources outside" not in text]


def test_the_types_of_fmi_3_are_those_of_1_0(load2, ssd, fmus, run):
    values = ssd.bindings(ssd.binding(ssd.values(("u[1]", "Float32", 2.5), ("number", "UInt16", 7))
                                      .replace('version="1.0"', 'version="2.0"')))  # fmt: skip
    system = load2(ssd.system("top", ssd.component("echo", fmus["echo"], "u[1] input Float64", "number input Int32",
                                                   inner=values)))  # fmt: skip
    assert said(system) == []
    seen = run(system)
    assert (seen["echo.y[1]"][-1], seen["echo.number_out"][-1]) == (2.5, 7)


def array(connectors, name, sizes="2"):
    """Return connectors in which one has dimensions."""
    dimensions = "".join(f'<ssc:Dimension size="{size}"/>' for size in sizes.split())
    head, middle, tail = connectors.partition(f'name="{name}"')
    kind, end, rest = tail.partition("</ssd:Connector>")
    return head + middle + kind + dimensions + end + rest


def test_arrays_are_connected_element_by_element(load2, ssd, fmus, run):
    def part(name, kind, port):
        return array(ssd.component(name, fmus["echo"], f"{port} {kind} Float64"), port)

    given = ssd.values(("u", "Float64", "3.0 4.0")).replace('version="1.0"', 'version="2.0"')
    values = ssd.bindings(ssd.binding(given))
    first = part("first", "output", "y").replace("</ssd:Component>", f"{values}</ssd:Component>")
    system = load2(ssd.system("top", first + part("second", "input", "u"), ssd.connection("first.y", "second.u")))
    assert [str(c) for c in system.connections] == [f"first.y[{i}] -> second.u[{i}]" for i in (1, 2)]
    seen = run(system)
    assert [seen[f"second.y[{i}]"][-1] for i in (1, 2)] == [3.0, 4.0]


def test_a_part_of_an_array_is_connected(load2, ssd, fmus):
    first = array(ssd.component("first", fmus["echo"], "y output Float64"), "y")
    wire = ssd.connection("first.y", "second.u[2]", startIndices="1")
    system = load2(ssd.system("top", first + ssd.component("second", fmus["echo"], "u[2] input"), wire))
    assert [str(c) for c in system.connections] == ["first.y[1] -> second.u[2]"]


def test_the_last_index_of_a_matrix_runs_fastest(load2, ssd, fmus):
    echo = array(ssd.component("echo", fmus["echo"], "m input Float64"), "m", sizes="2 2")
    system = load2(ssd.system("top", echo))
    assert [c.name for c in system.components[0].connectors] == ["m[1,1]", "m[1,2]", "m[2,1]", "m[2,2]"]


@pytest.mark.parametrize("dimension", ["<ssc:Dimension/>", '<ssc:Dimension sizeConnector="n"/>'])
def test_a_size_that_the_file_does_not_give_is_that_of_the_fmu(load2, ssd, fmus, dimension):
    first, second = (array(ssd.component(name, fmus["echo"], f"{port} {kind} Float64"), port)
                     for name, port, kind in (("first", "y", "output"), ("second", "u", "input")))  # fmt: skip
    open_ = first.replace('<ssc:Dimension size="2"/>', dimension)
    system = load2(ssd.system("top", open_ + second, ssd.connection("first.y", "second.u")))
    assert [str(c) for c in system.connections] == [f"first.y[{i}] -> second.u[{i}]" for i in (1, 2)]


def test_a_matrix_of_fmi_3_whose_size_is_a_structural_parameter(load2, ssd, reference_fmu, run):
    fmu = reference_fmu("feedthrough", "3.0")
    given = ssd.values(("matrix_in", "Float64", "1 2 3 4 5 6"), ("columns", "UInt64", 3))
    given = given.replace("</ssv:Parameter>", '<ssc:Dimension size="2"/><ssc:Dimension size="3"/></ssv:Parameter>', 1)
    values = ssd.bindings(ssd.binding(given.replace('version="1.0"', 'version="2.0"')))
    size = '<ssc:Dimension size="2"/><ssc:Dimension sizeConnector="columns"/>'
    first = ssd.component("first", fmu, "columns structuralParameter UInt64", "matrix_out output Float64")
    second = ssd.component("second", fmu, "matrix_in input Float64")
    first, second = (
        array(part, name).replace('<ssc:Dimension size="2"/>', size)
        for part, name in ((first, "matrix_out"), (second, "matrix_in"))
    )
    parts = first.replace("</ssd:Component>", f"{values}</ssd:Component>") + second
    system = load2(ssd.system("top", parts, ssd.connection("first.matrix_out", "second.matrix_in")))
    assert said(system) == ["first.columns: a structural parameter keeps the value of the FMU, and arrays their sizes"]
    seen = run(system)
    assert [seen[f"second.matrix_out[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2, 3)] == [
        1.0,
        2.0,
        3.0,
        4.0,
        5.0,
        6.0,
    ]


def test_the_entries_of_a_dictionary_may_be_arrays(load2, ssd, fmus, tmp_path):
    entries = ssd.dictionary("u Float64").replace(
        "</ssb:DictionaryEntry>", '<ssc:Dimension size="2"/></ssb:DictionaryEntry>'
    )
    (tmp_path / "bus.ssb").write_text(entries.replace('version="1.0"', 'version="2.0"'))
    parts = array(ssd.component("first", fmus["echo"], "y output Float64"), "y")
    parts += array(ssd.component("second", fmus["echo"], "u input Float64"), "u")
    parts += array(ssd.reference("bus", "signals", "u inout Float64"), "u")
    wires = ssd.connection("first.y", "bus.u") + ssd.connection("bus.u", "second.u")
    dictionaries = (
        '<ssd:SignalDictionaries><ssd:SignalDictionary name="signals" source="bus.ssb"/></ssd:SignalDictionaries>'
    )
    text = ssd.system("top", parts, wires).replace("</ssd:System>", f"{dictionaries}</ssd:System>")
    assert [str(c) for c in load2(text).connections] == [f"first.y[{i}] -> second.u[{i}]" for i in (1, 2)]


def test_a_mapping_applies_to_all_elements_of_an_array(load2, ssd, fmus):
    given = ssd.values(("speeds", "Float64", "3.0 4.0"), ("other", "Float64", 1.0)).replace(
        'version="1.0"', 'version="2.0"'
    )
    mapping = ssd.map(("speeds", "u", ssd.linear(2.0, 1.0))).replace('version="1.0"', 'version="2.0"')
    values = ssd.bindings(ssd.binding(given, mapping))
    system = load2(ssd.system("top", ssd.component("echo", fmus["echo"], inner=values)))
    assert system.components[0].parameters == {"u[1]": 7.0, "u[2]": 9.0}


def test_a_single_value_element_is_the_value(load2, ssd, fmus, run):
    given = ssd.values(("number", "Enumeration", "fine")).replace('version="1.0"', 'version="2.0"')
    given = given.replace(
        '<ssv:Enumeration value="fine"/>', '<ssv:Enumeration><ssv:Value value="fine"/></ssv:Enumeration>'
    )
    system = load2(ssd.system("top", ssd.component("modes", fmus["modes"], inner=ssd.bindings(ssd.binding(given)))))
    assert run(system)["modes.number_out"][-1] == 4


def test_scheduled_execution_is_run_as_co_simulation(load2, ssd, fmus):
    system = load2(ssd.system("top", ssd.component("echo", fmus["echo"], implementation="ScheduledExecution")))
    assert said(system) == ["implementation ScheduledExecution is run as CoSimulation"]


def test_what_1_0_lacks_is_left_out_with_a_warning(load2, ssd, fmus, run):
    echo = ssd.component("echo", fmus["echo"], "u[1] input Float64", "tick input Clock", "hidden local Float64")
    meta = '<ssc:MetaData kind="general" type="text/plain" source="notes.txt"/>'
    text = ssd.system("top", echo.replace("</ssd:Connectors>", f"</ssd:Connectors>{meta}"))
    system = load2(text)
    assert said(system) == [
        "connectors of type Clock are left out",
        "connectors of kind constant, local, unspecified are left out",
    ]
    assert [c.name for c in system.components[0].connectors] == ["u[1]"]
    assert run(system)["echo.y[1]"][-1] == 0.0


REFUSED = [
    (lambda ssd, e: array(ssd.component("a", e, "z output"), "z").replace('size="2"', 'sizeConnector="n"')
        + ssd.component("b", e), "", r"a\.z: its size is that of the connector n, and no FMU has such an array; give"),
    (lambda ssd, e: array(ssd.component("a", e, "y output"), "y")
        + array(ssd.component("b", e, "u input"), "u", "3"), "a.y b.u", r"y -> u: connects 2 elements to 3"),
    (lambda ssd, e: ssd.component("a", e, inner=ssd.bindings(ssd.binding(
        ssd.values(("u", "Float64", "1 2 3")).replace("</ssv:Parameter>", '<ssc:Dimension size="2"/></ssv:Parameter>')
        .replace('version="1.0"', 'version="2.0"')))), "", r"parameter u: has 3 values for 2 elements"),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "wire", "message"), REFUSED)
def test_arrays_that_do_not_fit_are_refused_in_one_line(load2, ssd, fmus, parts, wire, message):
    wires = ssd.connection(*wire.split()) if wire else ""
    with pytest.raises(InputError, match=message) as caught:
        load2(ssd.system("top", parts(ssd, fmus["echo"]), wires))
    assert "\n" not in str(caught.value)


def test_a_lone_file_of_2_0_values_is_read(load2, ssd, fmus, tmp_path):
    values = ssd.values(("u[1]", "Float64", 5.5)).replace('version="1.0"', 'version="2.0"')
    (tmp_path / "v.ssv").write_text(values)
    shutil.copy(fmus["echo"], tmp_path / "echo.fmu")
    system = load2(
        ssd.system("top", ssd.component("echo", "echo.fmu", inner=ssd.bindings(ssd.binding(source="v.ssv"))))
    )
    assert system.components[0].parameters == {"u[1]": 5.5}
    assert system.warnings == ()
