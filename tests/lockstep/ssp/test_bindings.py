"""Parameter bindings as SSP 1.0 has them: levels, order, prefixes, mappings, units, files in odd places."""

import shutil
import zipfile
from dataclasses import replace
from math import pi

import pytest

from lockstep import InputError, load_system, write_ssd
from lockstep.__main__ import main
from lockstep.ssp.step_times import Timing


@pytest.fixture
def echo(ssd, fmus):
    """Return an echo with bindings."""

    def component(*bindings, name="echo", **attributes):
        ports = ("u[1] input", "u[2] input", "number input Integer", "y[1] output")
        return ssd.component(
            name, fmus["echo"], *ports, inner=ssd.bindings(*bindings) if bindings else "", **attributes
        )

    return component


def parameters(system, name="echo"):
    return dict(system.component(name).parameters)


def test_a_higher_level_wins_and_a_later_binding_wins_at_one_level(load, ssd, echo):
    own = [ssd.binding(ssd.values(("u[1]", "Real", n), ("number", "Integer", n), ("u[2]", "Real", n))) for n in (1, 2)]
    middle = ssd.values(("echo.number", "Integer", 3), ("echo.u[2]", "Real", 3))
    sub = ssd.system("sub", echo(*own), bindings=ssd.bindings(ssd.binding(middle)))
    top = ssd.values(("sub.echo.u[2]", "Real", 4))
    system = load(ssd.system("top", sub, bindings=ssd.bindings(ssd.binding(top))))
    assert parameters(system, "sub/echo") == {"u[1]": 2.0, "number": 3, "u[2]": 4.0}


def test_prefix_is_put_before_the_names_of_the_values(load, ssd, echo):
    values = ssd.values(("u[1]", "Real", 5))
    system = load(ssd.system("top", echo(), bindings=ssd.bindings(ssd.binding(values, prefix="echo."))))
    assert parameters(system) == {"u[1]": 5.0}


def test_a_dot_in_a_name_becomes_a_slash(load, ssd, fmus):
    """SSP allows dots, so that a system may take the place of a component without a change of its variables' names."""
    inner = ssd.system("a", ssd.system("b", ssd.component("one", fmus["echo"])))
    dotted = ssd.component("a.one", fmus["echo"])
    values = ssd.bindings(ssd.binding(ssd.values(("a.one.u[1]", "Real", 5))))
    both = ssd.system("a", ssd.component("one", fmus["echo"]))
    system = load(ssd.system("top", inner + dotted, bindings=values))
    assert [c.name for c in system.components] == ["a/b/one", "a/one"]
    assert parameters(system, "a/one") == {"u[1]": 5.0}
    with pytest.raises(InputError, match="element a/one: declared twice; names must be unique"):
        load(ssd.system("top", both + dotted, bindings=values))  # --set and --record could not distinguish them


def test_mapping_renames_and_transforms_and_omits_the_rest(load, ssd, echo, run):
    values = ssd.values(
        ("a", "Real", 2.5), ("n", "Integer", 3), ("flag", "Boolean", "true"), ("u[2]", "Real", 9), ("u[1]", "Real", 9)
    )
    mapping = ssd.map(
        ("p.a", "u[1]", ssd.linear(4.0, 1.0)),
        ("p.a", "u[2]"),
        ("p.n", "number", ssd.mapping("Integer", (3, 33))),
        ("p.flag", "flag", ssd.mapping("Boolean", ("true", "false"))),
        ("p.none", "refuse_at"),
    )
    system = load(ssd.system("top", echo(ssd.binding(values, mapping, prefix="p."))))
    assert parameters(system) == {"u[1]": 11.0, "u[2]": 2.5, "number": 33, "flag": False}
    assert run(system)["echo.y[1]"][-1] == 11.0


def test_units_of_values_and_of_mappings(load, ssd, fmus, run):
    values = ssd.values(("a", "Real", 90.0, "deg"), ("t", "Real", 20.0, "degC"))
    mapping = ssd.map(
        ("a", "radians", ssd.linear(2.0, 0.5)),
        ("a", "free", ssd.linear(3.0), 'suppressUnitConversion="true"'),
        ("t", "kelvin"),
    )
    angle = ssd.component("angle", fmus["angle"], inner=ssd.bindings(ssd.binding(values, mapping)))
    seen = run(load(ssd.system("top", angle)))
    assert seen["angle.radians_seen"][-1] == pytest.approx(2 * pi / 2 + 0.5, rel=1e-15)
    assert seen["angle.free_seen"][-1] == 270.0
    assert seen["angle.kelvin_seen"][-1] == pytest.approx(293.15, rel=1e-15)


def test_a_value_in_another_unit_than_the_connector_declares(load, ssd, fmus, run):
    values = ssd.bindings(ssd.binding(ssd.values(("radians", "Real", 90.0, "deg"), ("kelvin", "Real", 300.0))))
    ports = ("radians input Real unit=rad", "kelvin input", "free input Real unit=deg")
    angle = ssd.component("angle", fmus["angle"], *ports, inner=values)
    seen = run(load(ssd.system("top", angle)), overrides={"angle.free": 1})
    assert seen["angle.radians_seen"][-1] == pytest.approx(pi / 2, rel=1e-15)


def test_a_radian_may_be_written_as_1_but_only_under_its_own_name(tmp_path, load, ssd, fmus, run):
    """OMSimulator writes rad without its base unit. Between Hz and rad/s the rad counts: a factor is missing there."""
    angle = ssd.component("angle", fmus["angle"], inner=ssd.bindings(ssd.binding(source="p.ssv")))
    system = ssd.system("top", angle)
    values = ssd.values(("radians", "Real", 2.5, "rad"), ("kelvin", "Real", 1.0), ("free", "Real", 1.0))
    (tmp_path / "p.ssv").write_text(values.replace('<ssc:BaseUnit rad="1"/>', "<ssc:BaseUnit/>"))
    assert run(load(system))["angle.radians_seen"][-1] == 2.5
    (tmp_path / "p.ssv").write_text(
        values.replace('<ssc:BaseUnit rad="1"/>', "<ssc:BaseUnit/>").replace('"rad"', '"turn"')
    )
    with pytest.raises(InputError, match=r"angle\.radians: unit 'turn' \[1\] does not convert to 'rad' \[rad\]"):
        run(load(system))


def test_value_of_a_system_connector_reaches_all_its_inputs(load, ssd, fmus, run):
    angle = ssd.component("angle", fmus["angle"], "radians input", "kelvin input", "free input")
    link = ssd.connection
    sub = ssd.system(
        "sub",
        angle,
        link(".a", "angle.radians", ssd.linear(2.0)) + link(".a", "angle.free") + link(".t", "angle.kelvin"),
        ("a input Real unit=deg", "t input Real unit=degC"),
        ssd.bindings(ssd.binding(ssd.values(("a", "Real", 1.0), ("t", "Real", 10.0)))),
    )
    top = ssd.system(
        "top", sub, link(".a", "sub.a", ssd.linear(1.0, 5.0)), ("a input Real unit=rad",),
        ssd.bindings(ssd.binding(ssd.values(("a", "Real", pi)))),
    )  # fmt: skip
    seen = run(load(top))
    assert seen["sub/angle.radians_seen"][-1] == pytest.approx(2 * 185 * pi / 180, rel=1e-15)
    assert seen["sub/angle.free_seen"][-1] == pytest.approx(185, rel=1e-15)
    assert seen["sub/angle.kelvin_seen"][-1] == pytest.approx(283.15, rel=1e-15)


def test_inputs_of_the_whole_system_need_a_value(load, ssd, fmus, run):
    angles = "".join(ssd.component(name, fmus["angle"], "radians input", "free input") for name in ("one", "two"))
    link = ssd.connection
    wires = link(".turn[1]", "one.radians") + link(".turn[1]", "two.radians", ssd.linear(-1.0))
    wires += link(".turn[2]", "one.free") + link(".turn[2]", "two.free")
    top = ssd.system("top", angles, wires, ("turn[1] input Real unit=deg", "turn[2] input"))
    system = replace(load(top), strict_inputs=True)
    loose = {"one.kelvin": 1, "two.kelvin": 1}
    with pytest.raises(
        InputError,
        match=r"^one\.radians, free: not connected and without a value; the input turn\[1\.\.2\] of the system feeds "
        r"it: give --set turn\[1\]=VALUE$",
    ):
        run(system, overrides=loose)
    seen = run(system, overrides={**loose, "turn": "180,7"})
    assert seen["one.radians_seen"][-1] == pytest.approx(pi, rel=1e-15)
    assert seen["two.radians_seen"][-1] == pytest.approx(-pi, rel=1e-15)
    assert (seen["one.free_seen"][-1], seen["two.free_seen"][-1]) == (7.0, 7.0)
    with pytest.raises(
        InputError,
        match=r"turm: no parameter to set; write component\.parameter, .*; inputs of the system are turn\[1\.\.2\]",
    ):
        run(system, overrides={**loose, "turm": 1})
    with pytest.raises(InputError, match=r"turn: got 3 values for turn\[1\.\.2\]"):
        run(system, overrides={**loose, "turn": "1,2,3"})


def test_files_are_next_to_the_system_or_inside_the_component(tmp_path, load, ssd, fmus):
    inside = tmp_path / "with values.fmu"
    shutil.copy(fmus["echo"], inside)
    with zipfile.ZipFile(inside, "a") as archive:
        archive.writestr("resources/start.ssv", ssd.values(("a", "Real", 1.5)))
        archive.writestr("resources/names.ssm", ssd.map(("a", "u[1]")))
    (tmp_path / "p q.ssv").write_text(ssd.values(("b", "Real", 2.0)))
    (tmp_path / "names.ssm").write_text(ssd.map(("b", "u[2]", ssd.linear(10.0))))
    of_component = {"source": "resources/start.ssv", "sourceBase": "component"}
    bindings = ssd.bindings(
        ssd.binding(**of_component).replace(
            "></", '><ssd:ParameterMapping source="resources/names.ssm" sourceBase="component"/></'
        ),
        ssd.binding(source="p%20q.ssv").replace("></", '><ssd:ParameterMapping source="names.ssm"/></'),
    )
    system = load(ssd.system("top", ssd.component("echo", inside.name, "u[1] input", inner=bindings)))
    assert parameters(system) == {"u[1]": 1.5, "u[2]": 20.0}


def test_initial_values_of_outputs_can_be_set_where_the_fmu_allows_it(tmp_path, load, ssd, fmus, run):
    free = tmp_path / "free.fmu"
    with zipfile.ZipFile(fmus["integrator"]) as source, zipfile.ZipFile(free, "w") as target:
        for member in source.infolist():
            old, new = b'name="clock" valueReference="2" causality="output">', b' initial="exact">'
            content = source.read(member)
            assert member.filename != "modelDescription.xml" or old in content
            head, found, tail = content.partition(old)
            if found:
                content = head + found[:-1] + new + tail.replace(b"<Real/>", b'<Real start="0"/>', 1)
            target.writestr(member, content)
    values = ssd.bindings(ssd.binding(ssd.values(("clock", "Real", 7.5), ("x", "Real", 3.0))))
    system = load(ssd.system("top", ssd.component("plant", free, inner=values)))
    assert parameters(system, "plant") == {"clock": 7.5}
    assert system.ignored == ("x (inline)",)  # calculated by the FMU
    clock = run(system, overrides={"plant.u": 0})["plant.clock"]
    assert clock[0] == 7.5
    assert run(system, overrides={"plant.u": 0, "plant.clock": 2})["plant.clock"][0] == 2.0
    with pytest.raises(
        InputError, match=r"plant\.x: is the FMU's output; only parameters and inputs can be set, and what"
    ):
        run(system, overrides={"plant.u": 0, "plant.x": 2})


def test_values_without_a_variable_are_left_out_and_listed(load, ssd, echo):
    values = ssd.values(("u[1]", "Real", 1), ("u[7]", "Real", 1), ("y[1]", "Real", 1))
    system = load(ssd.system("top", echo(ssd.binding(values))))
    assert parameters(system) == {"u[1]": 1.0}
    assert system.ignored == ("u[7] (inline)", "y[1] (inline)")


def test_values_of_connected_inputs_are_start_values_and_listed(load, ssd, fmus, run, tmp_path, capsys):
    counter = ssd.component("counter", fmus["counter"], "count output")
    values = ssd.bindings(ssd.binding(ssd.values(("u", "Real", 7.0), ("x0", "Real", 3.0))))
    plant = ssd.component("plant", fmus["integrator"], "u input", inner=values)
    system = load(ssd.system("top", plant + counter, ssd.connection("counter.count", "plant.u")))
    assert parameters(system, "plant") == {"u": 7.0, "x0": 3.0}
    assert system.start_values == ("plant.u",)
    run(system)
    with pytest.raises(InputError, match=r"plant\.u: is connected to counter\.count, .* no effect; leave plant\.u out"):
        run(system, overrides={"plant.u": 1.0})
    write_ssd(system, tmp_path / "own.ssd")  # in a file with annotations such a value is refused
    assert parameters(load_system(tmp_path / "own.ssd"), "plant") == {"x0": 3.0}
    assert main(["show", str(system.path), "--step-size", "0.001"]) == 0
    assert "apply at initialization only, as the inputs are connected: plant.u" in capsys.readouterr().out


@pytest.mark.parametrize("value", ["NaN", "INF", "1e400"])
def test_values_that_are_not_finite_are_refused_by_name(load, ssd, echo, run, value):
    with pytest.raises(InputError, match=r"echo\.u\[1\]: (nan|inf) must be finite"):
        run(load(ssd.system("top", echo(ssd.binding(ssd.values(("u[1]", "Real", value)))))))


REFUSED = [
    (lambda t: t.binding(), r"echo: a ParameterBinding has neither source nor|neither source and ParameterValues"),
    (lambda t: t.binding(source="no.ssv"), r"echo: no such file .*no\.ssv"),
    (lambda t: t.binding(source="https://example.org/p.ssv"), r"echo: source https://example.org/p.ssv is not a file"),
    (
        lambda t: t.binding(source="no.ssv", type="text/csv"),
        r"echo: parameter binding of type text/csv is not supported",
    ),
    (lambda t: t.binding(source="no.ssv", sourceBase="component"), r"echo: no such file no\.ssv in .*toy_echo\.fmu"),
    (
        lambda t: t.binding(source="../a.ssv", sourceBase="component"),
        r"echo: source \.\./a\.ssv is not inside toy_echo",
    ),
    (lambda t: t.binding(t.values(("u[1]", "Real", "one"))), r"not valid SSP 1\.0: .*'one' is not a valid value"),
    (
        lambda t: t.binding(t.values(("a", "Real", 1)), t.map(("a", "u[1]"), ("a", "u[1]"))),
        r"target u\[1\]: declared twice",
    ),
    (
        lambda t: t.binding("<p/>"),
        r"its root p in namespace .* is not one of SSP 1\.0's SystemStructureParameterValues",
    ),
    (
        lambda t: t.binding(t.values(("a", "Boolean", 1)), t.map(("a", "u[1]", t.linear(2)))),
        r"u\[1\]: True is not of its",
    ),
    (
        lambda t: t.binding(t.values(("a", "String", "x")), t.map(("a", "u[1]", t.linear(2)))),
        r"of the text 'x' is not def",
    ),
]


@pytest.mark.parametrize(("binding", "message"), REFUSED)
def test_a_wrong_binding_is_refused_in_one_line(load, ssd, echo, binding, message):
    with pytest.raises(InputError, match=message) as caught:
        load(ssd.system("top", echo(binding(ssd))))
    assert "\n" not in str(caught.value)


def test_a_system_has_no_files_of_a_component(load, ssd, echo):
    bindings = ssd.bindings(ssd.binding(source="a.ssv", sourceBase="component"))
    with pytest.raises(InputError, match=r"the system: a\.ssv: sourceBase component needs a component"):
        load(ssd.system("top", echo(), bindings=bindings))


def test_a_wrong_enumeration_item_is_refused_with_the_right_ones(load, ssd, fmus, run):
    def system(type_, value):
        values = ssd.bindings(ssd.binding(ssd.values(("number", type_, value))))
        return load(ssd.system("top", ssd.component("echo", fmus["modes"], inner=values)))

    loose = {"echo.u": 0, "echo.flag": "false"}
    message = r"echo\.number: 'fien' is no item of its Enumeration; there are off, coarse, fine; did you mean fine\?"
    with pytest.raises(InputError, match=message):
        run(system("Enumeration", "fien"), overrides=loose)
    with pytest.raises(InputError, match=r"echo\.number: 3 is no item"):
        run(system("Integer", 3), overrides=loose)
    assert run(system("Integer", 2), overrides=loose)["echo.number_out"][-1] == 2


def test_bindings_of_a_component_that_is_a_system_come_after_its_own(tmp_path, load, ssd, echo):
    ones = ssd.binding(ssd.values(("echo.u[1]", "Real", 1), ("echo.u[2]", "Real", 1)))
    inner = ssd.system("any", echo(), bindings=ssd.bindings(ones))
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "inner.ssd").write_text(ssd.document(inner))
    (tmp_path / "sub" / "p.ssv").write_text(ssd.values(("echo.u[2]", "Real", 2)))
    bindings = ssd.bindings(ssd.binding(source="p.ssv", sourceBase="component"))
    part = ssd.component("part", "sub/inner.ssd", type="application/x-ssp-definition", inner=bindings)
    assert parameters(load(ssd.system("top", part)), "part/echo") == {"u[1]": 1.0, "u[2]": 2.0}


def test_wrong_name_in_an_annotated_file_is_refused(tmp_path, load, ssd, echo):
    load(ssd.system("top", echo()))
    path = tmp_path / "foreign.ssd"
    own = '<ssd:Annotations><ssc:Annotation type="lockstep"><x:System xmlns:x="urn:lockstep:1"/></ssc:Annotation>'
    values = ssd.bindings(ssd.binding(ssd.values(("eco.u[1]", "Real", 1))))
    text = ssd.document(ssd.system("top", echo(), bindings=values))
    path.write_text(text.replace("</ssd:Elements>", f"</ssd:Elements>{own}</ssd:Annotations>"))
    with pytest.raises(InputError, match=r"eco\.u\[1\]: no component eco; there are echo; did you mean echo\?"):
        load_system(path, Timing(period=1_000_000))
