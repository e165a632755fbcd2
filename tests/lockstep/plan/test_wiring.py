"""A system against its FMUs: names, causalities, types, units and values, each refusal by name."""

from dataclasses import replace

import pytest

from lockstep import Component, Connection, Connector, InputError, System, Unit
from lockstep.fmi.model_description import read_description
from lockstep.plan.wiring import wire
from lockstep.results.signal_patterns import select
from lockstep.system.system import Feed, SystemInput
from lockstep.system.transformation import Hop
from lockstep.system.units import conversion

MS = 1_000_000
DEG = Unit(name="deg", exponents=(0, 0, 0, 0, 0, 0, 0, 1), factor=0.017453292519943295)
RAD = Unit(name="rad", exponents=(0, 0, 0, 0, 0, 0, 0, 1))
DEG_C = Unit(name="degC", exponents=(0, 0, 0, 0, 1, 0, 0, 0), offset=273.15)
DEG_F = Unit(name="degF", exponents=(0, 0, 0, 0, 1, 0, 0, 0), factor=5 / 9, offset=459.67 * 5 / 9)


def check(system, overrides=None):
    return wire(system, {c.name: read_description(c) for c in system.components}, overrides or {})


def connect(output, target, **options):
    start, _, source = output.partition(".")
    end, _, sink = target.partition(".")
    return Connection(from_component=start, output=source, to_component=end, input=sink, **options)


def test_the_loop_is_accepted_and_grouped_by_type_and_delay(loop):
    links = check(loop).links
    assert [(link.producer, link.consumer, link.delay, link.scalar, len(link.sources)) for link in links] == [
        ("counter", "echo", 0, "Real", 1),
        ("counter", "echo", 0, "Boolean", 1),
        ("counter", "echo", 0, "Integer", 1),
        ("counter", "plant", 2, "Real", 1),
    ]


@pytest.mark.parametrize(
    ("wire_", "message"),
    [
        (connect("counter.count", "echo.u[4]"), r"^echo\.u\[4\]: no such input; echo has u\[1\.\.2\]$"),
        (connect("counter.cuont", "echo.u[2]"), r"^counter\.cuont: no such output; .*; did you mean count\?$"),
        (connect("counter.gain", "echo.u[2]"), r"counter\.gain is the FMU's parameter, an output is needed"),
        (connect("counter.count", "echo.y[2]"), r"echo\.y\[2\] is the FMU's output, an input is needed"),
        (connect("counter.steps", "echo.u[2]"), r"connects Integer to Real; types must be equal"),
        (connect("counter.even", "echo.u[2]", factor=2.0), r"connects Boolean to Real"),
    ],
)
def test_a_wrong_connection_is_refused(loop, wire_, message):
    with pytest.raises(InputError, match=message):
        check(replace(loop, connections=(*loop.connections, wire_)))


def test_integers_take_whole_factors_only(loop):
    wires = (*loop.connections[:2], replace(loop.connections[2], factor=0.5), loop.connections[3])
    with pytest.raises(InputError, match=r"factor 0\.5 and offset 0 of an Integer must be whole numbers"):
        check(replace(loop, connections=wires))


def test_an_input_without_a_source_is_refused_with_all_its_names(loop):
    parts = (loop.components[0], replace(loop.components[1], parameters={}), loop.components[2])
    with pytest.raises(
        InputError, match=r"^echo\.u\[1\.\.2\], flag, number: not connected and without a value; connect"
    ):
        check(replace(loop, components=parts, connections=loop.connections[3:], strict_inputs=True))


def test_an_input_without_a_source_keeps_its_start_value(loop):
    parts = (loop.components[0], replace(loop.components[1], parameters={}), loop.components[2])
    found = check(replace(loop, components=parts, connections=loop.connections[3:]))
    assert found.unconnected == {"echo": ("u[1]", "u[2]", "flag", "number")}
    assert found.parameters["echo"] == {}


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (
            "counter.gian",
            1,
            r"counter\.gian: no such parameter; counter has gain, fail_at, nan_at; did you mean gain\?",
        ),
        ("conter.gain", 1, r"conter: no such component; .*did you mean counter\?"),
        ("gain", 1, r"gain: no parameter to set; write component\.parameter"),
        ("counter.count", 1, r"counter\.count: is the FMU's output; only parameters and inputs can be set"),
        (
            "counter.gain",
            "1e-6 m",
            r"counter\.gain: '1e-6 m' has a unit, and the variable has none; give the number alone",
        ),
        ("counter.gain", True, r"counter\.gain: True is not of its type Real"),
        ("counter.gain", "nan", r"counter\.gain: 'nan' must be finite"),
        ("counter.gain", [1, 2], r"counter\.gain: got 2 values for one parameter"),
        ("counter.fail_at", 1.5, r"counter\.fail_at: 1\.5 is not of its type Integer"),
        ("counter.fail_at", "3000000000", r"counter\.fail_at: .* is not of its type Integer"),
        ("echo.flag", "yes", r"echo\.flag: 'yes' is not of its type Boolean; write true or false"),
        ("echo.u", [1.0, 2.0, 3.0], r"echo\.u: got 3 values for u\[1\.\.2\]"),
        ("echo.u", "1,x", r"echo\.u\[2\]: 'x' is not of its type Real"),
    ],
)
def test_a_wrong_value_is_refused(loop, key, value, message):
    with pytest.raises(InputError, match=message):
        check(loop, {key: value})


@pytest.mark.parametrize("value", [2.5, "2.5", [2.5]])
def test_one_value_is_for_all_elements_of_an_array(loop, value):
    parameters = check(replace(loop, connections=loop.connections[1:]), {"echo.u": value}).parameters

    assert {name: parameters["echo"][name] for name in ("u[1]", "u[2]")} == {"u[1]": 2.5, "u[2]": 2.5}


def test_values_and_texts_are_converted_to_the_declared_type(loop):
    given = {"counter.gain": "1e-6", "counter.fail_at": "12", "echo.flag": "true", "echo.u": "3,4", "plant.x0": 2}
    parameters = check(replace(loop, connections=loop.connections[2:]), given).parameters
    assert parameters["counter"] == {"gain": 1e-6, "fail_at": 12}
    assert parameters["echo"] == {"u[1]": 3.0, "u[2]": 4.0, "flag": True}
    assert parameters["plant"] == {"x0": 2.0}
    assert isinstance(parameters["plant"]["x0"], float)


@pytest.mark.parametrize(
    ("key", "value"),
    [("echo.u[1]", 2.0), ("echo.u", [2.0, 3.0]), ("echo.u", "2"), ("plant.u", 1.0), ("echo.flag", True)],
)
def test_a_value_for_a_connected_input_is_refused_by_name(loop, key, value):
    name = {"echo.u": "echo.u[1]"}.get(key, key)
    source = "counter.even" if key == "echo.flag" else "counter.count"
    why = f"{name}: is connected to {source}, so that a value for it has no effect; "
    with pytest.raises(InputError) as caught:
        check(loop, {key: value})
    assert str(caught.value).startswith(f"{why}leave {key} out, remove the connection, or inject a fault of kind stuck")
    if "[" in key or key != "echo.u":
        component, _, port = key.partition(".")
        changed = [
            replace(c, parameters={**c.parameters, port: value}) if c.name == component else c for c in loop.components
        ]
        with pytest.raises(InputError) as caught:
            check(replace(loop, components=tuple(changed)))
        assert str(caught.value).startswith(f"{why}remove it from the system's parameters, remove the connection")


def test_two_values_for_one_variable_with_two_names_are_refused(loop):
    descriptions = {c.name: read_description(c) for c in loop.components}
    x0 = descriptions["plant"].variables["x0"]
    alias, fixed = replace(x0, name="alias"), replace(x0, name="fixed", reference=99, variability="constant")
    variables = {**descriptions["plant"].variables, "alias": alias, "fixed": fixed}
    descriptions["plant"] = replace(descriptions["plant"], variables=variables)
    assert wire(loop, descriptions, {"plant.alias": 3.0}).parameters["plant"] == {"x0": 3.0, "alias": 3.0}
    message = r"plant\.alias: is 4\.0, and x0, another name of the same variable, 3\.0; give one of them"
    with pytest.raises(InputError, match=message):
        wire(loop, descriptions, {"plant.alias": 4.0})
    with pytest.raises(InputError, match=r"plant\.fixed: is constant in the FMU; remove the value"):
        wire(loop, descriptions, {"plant.fixed": 4.0})


def test_one_variable_has_one_value_but_an_element_may_differ_from_its_array(loop):
    free = replace(loop, connections=loop.connections[1:])
    assert check(free, {"echo.u": 1.0, "echo.u[2]": 5.0}).parameters["echo"] == {"u[1]": 1.0, "u[2]": 5.0}
    with pytest.raises(InputError, match=r"echo\.u\[2\]: has a value by echo\.u\[2\] and by echo\.u; give one of"):
        check(free, {"echo.u[2]": 5.0, "echo.u": 1.0})
    given = SystemInput(name="in", unit=None, feeds=(Feed(component="echo", input="u[1]", hops=(Hop(),)),))
    with pytest.raises(InputError, match=r"echo\.u\[1\]: has a value by in and by echo\.u\[1\]; give one of them"):
        check(replace(free, inputs=(given,)), {"in": 5.0, "echo.u[1]": 1.0})


def test_declared_connector_must_match_the_fmu(loop):
    def declare(**fields):
        counter = replace(loop.components[0], connectors=(Connector(**fields),))
        return replace(loop, components=(counter, *loop.components[1:]))

    with pytest.raises(InputError, match=r"counter\.count: declared as input, but it is the FMU's output"):
        check(declare(name="count", kind="input"))
    with pytest.raises(InputError, match=r"counter\.count: declared as Integer, but the FMU says Real"):
        check(declare(name="count", kind="output", type="Integer"))
    with pytest.raises(InputError, match=r"counter\.cnt: no such output"):
        check(declare(name="cnt", kind="output"))


def units_system(toys, *wires, **fields):
    angle = Component(name="a", source=toys / "toy_angle.fmu", period=MS, **fields)
    return System(name="u", tick=MS, components=(angle, replace(angle, name="b")), connections=wires)


ALL = {"radians": 0.0, "kelvin": 0.0, "free": 0.0}


def test_units_are_converted_and_an_undeclared_unit_is_that_of_the_other_end(toys):
    wires = (
        connect("a.degrees", "b.radians"),
        connect("a.celsius", "b.kelvin"),
        connect("a.mass", "b.free"),
        connect("b.bare", "a.radians", factor=2.0, offset=1.0),
        connect("b.degrees", "a.kelvin", convert_units=False),
    )
    system = units_system(toys, *wires)
    alone = replace(system.components[0], parameters={"free": 0.0})
    links = check(replace(system, components=(alone, system.components[1]))).links
    gains = {
        (link.consumer, target): (g, b)
        for link in links
        for target, g, b in zip(link.targets, link.gains, link.biases, strict=True)
    }
    angle = read_description(Component(name="a", source=toys / "toy_angle.fmu", period=MS, kind="sampled")).variables
    assert gains["b", angle["radians"].reference] == (pytest.approx(0.017453292519943295, rel=1e-15), 0.0)
    assert gains["b", angle["kelvin"].reference] == (1.0, 273.15)
    assert gains["b", angle["free"].reference] == (1.0, 0.0)
    assert gains["a", angle["radians"].reference] == (2.0, 1.0)
    assert gains["a", angle["kelvin"].reference] == (1.0, 0.0)


def test_units_of_different_dimensions_are_refused_with_both_ends(toys):
    with pytest.raises(InputError, match=r"a\.mass -> b\.radians: unit 'kg' \[kg\] does not convert to 'rad' \[rad\]"):
        check(units_system(toys, connect("a.mass", "b.radians"), parameters=ALL))


def test_unit_of_the_system_file_is_used_where_the_fmu_has_none(toys):
    with pytest.raises(InputError, match=r"a\.bare -> b\.kelvin: unit 'deg' \[rad\] does not convert to 'K' \[K\]"):
        check(units_system(toys, connect("a.bare", "b.kelvin"), parameters=ALL, units={"bare": DEG}))


def test_a_parameter_given_in_another_unit_is_converted(toys):
    wiring = check(units_system(toys, parameters=ALL | {"radians": 180.0}, units={"radians": DEG}))
    assert wiring.parameters["a"]["radians"] == pytest.approx(3.141592653589793, rel=1e-15)  # one rounding


def test_conversion_has_the_offset_of_temperatures_but_not_of_their_differences():
    gain, bias = conversion(DEG_F, DEG_C)
    assert gain * 212.0 + bias == pytest.approx(100.0, abs=1e-12)  # rounding of a few operations
    assert conversion(DEG_F, DEG_C, relative=True) == (pytest.approx(5 / 9), 0.0)
    assert conversion(RAD, RAD) == conversion(None, RAD) == (1.0, 0.0)
    with pytest.raises(ValueError, match="cannot be compared without base units"):
        conversion(Unit(name="rpm"), RAD)


@pytest.mark.parametrize(
    ("patterns", "names"),
    [
        (["plant.*"], ["plant.x", "plant.clock"]),
        (["echo.y"], ["echo.y[1]", "echo.y[2]"]),
        (["echo.y[2]", "counter.e?en"], ["counter.even", "echo.y[2]"]),
        (["*.count"], ["counter.count"]),
    ],
)
def test_patterns_choose_outputs_in_the_order_of_the_system(loop, patterns, names):
    descriptions = {c.name: read_description(c) for c in loop.components}
    assert [signal.name for signal in select(loop, descriptions, patterns)] == names
    assert len(select(loop, descriptions, ["all"])) == 10


def test_a_pattern_without_a_match_is_refused(loop):
    descriptions = {c.name: read_description(c) for c in loop.components}
    with pytest.raises(
        InputError, match=r"record 'plant\.y' matches no output or other variable; there are .*did you mean plant\.x\?"
    ):
        select(loop, descriptions, ["plant.y"])


def test_files_that_are_no_fmus_are_refused(loop, tmp_path):
    def with_source(name, content):
        (tmp_path / name).write_bytes(content)
        return replace(loop.components[0], source=tmp_path / name)

    with pytest.raises(InputError, match=r"counter: no such file .*none\.fmu"):
        read_description(replace(loop.components[0], source=tmp_path / "none.fmu"))
    with pytest.raises(InputError, match=r"counter: .*broken\.fmu: not a readable zip file"):
        read_description(with_source("broken.fmu", b"PK\x03\x04 and no more"))
    with pytest.raises(InputError, match=r"counter: .*loop\.fmu: not a readable zip file"):
        read_description(with_source("loop.fmu", loop.components[0].source.read_bytes()[:-300]))
