"""Systems in systems are flattened: names, ways through connectors, units and transformations on the way."""

from math import pi
from pathlib import Path

import fmpy
import pytest
from lxml import etree
from pyssp_standard.ssd import SSD

from lockstep import Component, Connection, InputError, RunError, System, load_system, write_ssd

SCHEMA = Path(fmpy.__file__).parent / "ssp" / "schema" / "SystemStructureDescription.xsd"

MS = 1_000_000


@pytest.fixture
def nested(ssd, fmus):
    """Return counter -> outer(inner(echo)) -> plant, with the second input of the echo fed by the same connector."""
    echo = ssd.component("echo", fmus["echo"], "u[1] input", "u[2] input", "y[1] output", "y[2] output",
                         "number input Integer", "flag input Boolean")  # fmt: skip
    link = ssd.connection
    inner = ssd.system(
        "inner",
        echo,
        link(".u", "echo.u[1]", ssd.linear(2.0)) + link(".u", "echo.u[2]") + link("echo.y[1]", ".y")
        + link(".number", "echo.number") + link(".flag", "echo.flag"),
        ("u input", "y output", "number input Integer", "flag input Boolean"),
    )  # fmt: skip
    outer = ssd.system(
        "outer",
        inner,
        link("inner.u", ".in") + link(".out", "inner.y", ssd.linear(1.0, 100.0))  # either end may come first
        + link(".steps", "inner.number") + link(".even", "inner.flag"),
        ("in input", "out output", "steps input Integer", "even input Boolean"),
    )  # fmt: skip
    counter = ssd.component("counter", fmus["counter"], "count output", "steps output Integer", "even output Boolean")
    plant = ssd.component("plant", fmus["integrator"], "u input", "x output")
    wires = (
        link("counter.count", "outer.in", ssd.linear(1.0, 0.5)) + link("outer.out", "plant.u")
        + link("counter.steps", "outer.steps") + link("outer.even", "counter.even")
    )  # fmt: skip
    return ssd.system("top", counter + outer + plant, wires)


def connect(start, end, **options):
    ends = [text.rpartition(".") for text in (start, end)]
    return Connection(
        from_component=ends[0][0], output=ends[0][2], to_component=ends[1][0], input=ends[1][2], delay=1, **options
    )


def test_a_nested_system_runs_like_the_same_system_written_flat(load, nested, fmus, run):
    system = load(nested)
    assert [c.name for c in system.components] == ["counter", "outer/inner/echo", "plant"]
    parts = {"counter": "counter", "outer/inner/echo": "echo", "plant": "integrator"}
    flat = System(
        name="flat",
        tick=MS,
        stop_time=10 * MS,
        components=tuple(
            Component(name=name, source=fmus[fmu], period=MS, kind="continuous") for name, fmu in parts.items()
        ),
        connections=(
            connect("counter.count", "outer/inner/echo.u[1]", factor=2.0, offset=1.0),
            connect("counter.count", "outer/inner/echo.u[2]", offset=0.5),
            connect("counter.steps", "outer/inner/echo.number"),
            connect("counter.even", "outer/inner/echo.flag"),
            connect("outer/inner/echo.y[1]", "plant.u", offset=100.0),
        ),
    )
    nested_run, flat_run = run(system), run(flat)
    assert list(nested_run) == list(flat_run)
    assert all((nested_run[name] == flat_run[name]).all() for name in nested_run)
    # the counter's output is k from k ms on, as others read it; the echo's output is 2 (k - 1 + 0.5) a step later
    assert nested_run["outer/inner/echo.y[1]"][5] == 2 * (4 + 0.5)
    expected = sum(100 + 2 * (k + 0.5) if k >= 0 else 100 for k in range(-1, 5)) * 1e-3
    assert nested_run["plant.x"][6] == pytest.approx(expected)


def test_units_and_transformations_are_composed_along_a_path(load, ssd, fmus, run):
    angle = ssd.component("source", fmus["angle"], "degrees output Real unit=deg", "celsius output")
    sink = ssd.component("sink", fmus["angle"], "radians input", "kelvin input", "free input")
    link = ssd.connection
    sub = ssd.system(
        "sub",
        sink,
        link(".a", "sink.radians", ssd.linear(3.0, 1.0))
        + link(".t", "sink.kelvin", ssd.linear(1.0, 1.0))
        + link(".raw", "sink.free"),
        ("a input Real unit=deg", "t input", "raw input Real unit=rad"),
    )
    system = load(
        ssd.system(
            "top",
            angle + sub,
            link("source.degrees", ".shown", ssd.linear(2.0))
            + link("source.degrees", "sub.a", ssd.linear(1.0, 10.0))
            + link("source.celsius", "sub.t", ssd.linear(2.0))
            + link("source.degrees", "sub.raw", suppressUnitConversion="true"),
            ("shown output Real unit=rad",),
        )
    )
    values = run(system, overrides={"source.radians": 0, "source.kelvin": 0, "source.free": 0})
    # 180 deg + 10 deg, to rad, times 3, plus 1 rad; 20 degC times 2, to K, plus 1 K; 180 as it is
    assert values["sub/sink.radians_seen"][2] == pytest.approx(3 * 190 * pi / 180 + 1, rel=1e-15)
    assert values["sub/sink.kelvin_seen"][2] == pytest.approx(2 * 20 + 273.15 + 1, rel=1e-15)
    assert values["sub/sink.free_seen"][2] == 180.0


ENUMERATIONS = """<ssd:Enumerations><ssc:Enumeration name="Mode">
  <ssc:Item name="off" value="1"/><ssc:Item name="coarse" value="2"/><ssc:Item name="fine" value="4"/>
</ssc:Enumeration></ssd:Enumerations>"""


def test_mapping_transformations_convert_types(load, ssd, fmus, run):
    steps = [f"{name} {kind}" for name, kind in (("steps output", "Integer"), ("even output", "Boolean"))]
    ports = ("number input Integer", "flag input Boolean")
    parts = ssd.component("counter", fmus["counter"], *steps)
    parts += "".join(ssd.component(name, fmus["echo"], *ports) for name in ("plain", "table", "crossed"))
    link = ssd.connection
    wires = (
        link("counter.steps", "plain.number", ssd.linear(-3, 7))
        + link("counter.even", "plain.flag")
        + link("counter.steps", "table.number", ssd.mapping("Integer", (1, 10), (3, -30)))
        + link("counter.even", "table.flag", ssd.mapping("Boolean", ("true", "false"), (0, 1)))
        + link("counter.steps", "crossed.flag", ssd.mapping("Integer", (2, 0), (0, 5)))
        + link("counter.even", "crossed.number", ssd.mapping("Boolean", ("true", "false"), ("false", "true")))
    )
    loose = {f"{name}.u": 0 for name in ("plain", "table", "crossed")}
    values = run(load(ssd.system("top", parts, wires)), overrides=loose)
    steps = values["counter.steps"][:-1].astype(int)  # what the others read one tick later
    even = values["counter.even"][:-1].astype(bool)
    assert steps.tolist()[:5] == [0, 1, 2, 3, 4]
    table = {1: 10, 3: -30}
    crossing = {2: 0, 0: 5}
    assert (values["plain.number_out"][1:] == 7 - 3 * steps).all()
    assert (values["plain.flag_out"][1:] == even).all()
    assert (values["table.number_out"][1:] == [table.get(k, k) for k in steps]).all()
    assert (values["table.flag_out"][1:] == ~even).all()
    assert (values["crossed.flag_out"][1:] == [crossing.get(k, k) != 0 for k in steps]).all()
    assert (values["crossed.number_out"][1:] == ~even).all()


def test_enumerations_are_mapped_by_the_names_of_their_items(load, ssd, fmus, run):
    ports = ("number input Enumeration name=Mode", "number_out output Enumeration name=Mode")
    parts = "".join(ssd.component(name, fmus["modes"], *ports) for name in ("first", "second", "third"))
    table = ssd.mapping("Enumeration", ("fine", "off"), ("off", "coarse"))
    wires = ssd.connection("first.number_out", "second.number", table)
    wires += ssd.connection("second.number_out", "third.number", ssd.mapping("Integer", (1, 4)))
    top = ssd.system("top", parts, wires, bindings=ssd.bindings(ssd.binding(
        ssd.values(("first.number", "Enumeration", "fine"), ("first.flag", "Boolean", "true")))))  # fmt: skip
    system = load(top, enumerations=ENUMERATIONS)
    loose = {f"{name}.{port}": "0" for name in ("first", "second", "third") for port in ("u", "flag")}
    values = run(system, overrides=loose)
    assert [int(values[f"{name}.number_out"][-1]) for name in ("first", "second", "third")] == [4, 1, 4]


REFUSED = [
    (
        "counter.steps",
        "echo.flag",
        "",
        r"steps -> echo\.flag: connects Integer to Boolean; types must be equal, or a Boo",
    ),
    ("counter.even", "echo.number", "", r"connects Boolean to Integer; types must be equal, or a BooleanMapping"),
    (
        "counter.steps",
        "echo.u[1]",
        "",
        r"counter\.steps -> echo\.u\[1\]: connects Integer to Real; types must be equal",
    ),
    ("counter.steps", "echo.number", "linear 0.5", r"factor 0\.5 and offset 0 of an Integer must be whole numbers"),
    ("counter.even", "echo.flag", "linear 2", r"a linear transformation is not for Boolean; use a mapping"),
    ("counter.count", "echo.u[1]", "Integer 1 2", r"IntegerMappingTransformation is not for Real"),
    ("counter.steps", "echo.number", "Integer 1 2 1 3", r"IntegerMappingTransformation maps 1 twice"),
    ("counter.steps", "echo.number", "Enumeration on 1", r"no enumeration item on; there are none"),
    ("counter.count", "echo.number", "", r"connects Real to Integer; types must be equal"),
    ("counter.count", "echo.u[1]", "linear INF", r"its factors and offsets come to inf and nan; they must be finite"),
]


@pytest.mark.parametrize(("start", "end", "how", "message"), REFUSED)
def test_a_wrong_mapping_is_refused_by_name(load, ssd, fmus, run, start, end, how, message):
    kind, *numbers = how.split() or [""]
    inner = ssd.mapping(kind, *zip(numbers[::2], numbers[1::2], strict=True)) if kind[:1].isupper() else ""
    inner = ssd.linear(numbers[0]) if kind == "linear" else inner
    counter = ssd.component("counter", fmus["counter"], "steps output Integer", "even output Boolean", "count output")
    echo = ssd.component("echo", fmus["echo"], "number input Integer", "flag input Boolean", "u[1] input")
    system = load(ssd.system("top", counter + echo, ssd.connection(start, end, inner)))
    with pytest.raises(InputError, match=message) as caught:
        run(system)
    assert "\n" not in str(caught.value)


def test_a_number_too_large_for_an_integer_ends_the_run_by_name(load, ssd, fmus, run):
    counter = ssd.component("counter", fmus["counter"], "steps output Integer")
    echo = ssd.component("echo", fmus["echo"], "number input Integer")
    wire = ssd.connection("counter.steps", "echo.number", ssd.linear(500_000_000))
    system = load(ssd.system("top", counter + echo, wire))
    with pytest.raises(
        RunError, match=r"^counter\.steps -> echo\.number: 500000000 \* 5 \+ 0 does not fit into 32 bits at"
    ):
        run(system, overrides={"echo.u": 0, "echo.flag": False})


WRONG_ENDS = [
    ("counter.count", "plant.x", r"counter\.count -> plant\.x: both ends are sources; connect an output to an input"),
    ("plant.u", "echo.u[1]", r"both ends are inputs"),
    (".drive", ".bias", r"drive -> bias: both ends are sources"),
    ("counter.count", "plant.v", r"plant declares no connector v; it declares u, x"),
    ("counter.count", "plan.u", r"plan: no such component; .*did you mean plant\?"),
    ("counter.count", ".shwon", r"the system declares no connector shwon; .*did you mean shown\?"),
    ("counter.count", ".shown", r"counter\.count -> shown: the input is already connected to plant\.x; remove one"),
    ("counter.image", "echo.u[1]", r"counter\.image -> echo\.u\[1\]: type Binary cannot be connected; use one of Real"),
]


@pytest.mark.parametrize(("start", "end", "message"), WRONG_ENDS)
def test_a_connection_between_wrong_ends_is_refused_by_name(load, ssd, fmus, start, end, message):
    parts = ssd.component("counter", fmus["counter"], "count output", "image output Binary")
    parts += ssd.component("plant", fmus["integrator"], "u input", "x output")
    parts += ssd.component("echo", fmus["echo"], "u[1] input")
    wires = ssd.connection("plant.x", ".shown") + ssd.connection(start, end)
    with pytest.raises(InputError, match=message):
        load(ssd.system("top", parts, wires, ("drive input", "bias input", "shown output")))


def test_connectors_that_feed_each_other_are_refused(load, ssd, fmus):
    loop = ssd.system("loop", "", ssd.connection(".a", ".b"), ("a input", "b output"))
    echo = ssd.component("echo", fmus["echo"], "u[1] input")
    wires = ssd.connection("loop.b", "loop.a") + ssd.connection("loop.b", "echo.u[1]")
    with pytest.raises(InputError, match=r"echo\.u\[1\]: the connectors loop\.., loop\.. feed each other"):
        load(ssd.system("top", loop + echo, wires))


def test_flattened_system_is_written_as_a_valid_file(load, ssd, fmus, run, tmp_path):
    mode = "Enumeration name=Mode"
    parts = ssd.component("a", fmus["angle"], "degrees output")
    parts += ssd.component("b", fmus["modes"], f"number input {mode}", "y[1] output")
    through = ssd.system(
        "sub",
        ssd.component("c", fmus["angle"], "radians input", "kelvin input")
        + ssd.component("d", fmus["modes"], f"number_out output {mode}"),
        ssd.connection(".x", "c.radians", ssd.linear(2.0)) + ssd.connection("d.number_out", ".m"),
        ("x input Real unit=rad", f"m output {mode}"),
        ssd.bindings(ssd.binding(ssd.values(("d.number", "Enumeration", "fine"), ("c.kelvin", "Real", 20.0, "degC")))),
    )  # fmt: skip
    wires = ssd.connection("a.degrees", "sub.x", ssd.linear(1.0, 30.0))
    wires += ssd.connection("sub.m", "b.number", ssd.mapping("Enumeration", ("off", "coarse"), ("fine", "off")))
    top = ssd.system("top", parts + through, wires)
    loose = {"a.radians": 0, "a.kelvin": 0, "a.free": 0, "sub/c.free": 0, "b.u": 0, "sub/d.u": 0}
    loose |= {"b.flag": False, "sub/d.flag": False}
    system = load(top, enumerations=ENUMERATIONS)
    write_ssd(system, tmp_path / "written.ssd")
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.parse(tmp_path / "written.ssd"))
    with SSD(tmp_path / "written.ssd") as read:  # an independent reader
        assert not read.check_connections()
        assert sorted(c.end_element for c in read.connections()) == ["b", "sub/c"]
    again = load_system(tmp_path / "written.ssd")
    assert [c.name for c in again.components] == ["a", "b", "sub/c", "sub/d"]
    assert not any(c.via for c in again.connections)
    before, after = run(system, overrides=loose), run(again, overrides=loose)
    assert list(before) == list(after)
    assert all(before[name] == pytest.approx(after[name], rel=1e-15) for name in before)
    assert before["b.number_out"][-1] == 1  # fine, then off
    assert before["sub/c.radians_seen"][-1] == pytest.approx(
        2 * (pi + 30), rel=1e-15
    )  # the offset is in the target's unit
