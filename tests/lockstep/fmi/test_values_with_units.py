"""Values with a unit: --set, the API and adapters take units that convert to that of the variable."""

import shutil

import numpy as np
import pytest

from fmus.setup.setup_fmu import setup_fmu
from lockstep import Component, InputError, System, read_signals, simulate
from lockstep.__main__ import main
from lockstep.adapter.bind import bind
from lockstep.adapter.read import read_adapter
from lockstep.fmi.declared_units import DeclaredUnits, DisplayUnit
from lockstep.fmi.model_description import Description, Variable, read_description
from lockstep.fmi.parameter_values import parse_value
from lockstep.plan.overrides import resolve_overrides
from lockstep.system.system import Feed, SystemInput
from lockstep.system.transformation import Hop
from lockstep.system.unit_table import UNITS
from lockstep.system.units import Unit

STEP = 10_000_000  # [ns]
ARCSECOND = np.pi / 648000.0
KELVIN = '<Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/>{more}</Unit>'
FURLONG = '<Unit name="fu"><BaseUnit K="1" factor="3"/></Unit>'  # three kelvin
INVERSE = '<DisplayUnit name="per_K" factor="1" inverse="true"/>'


def variable(unit, **more):
    """Return a parameter in a unit."""
    return Variable(name="k", reference=0, type="Real", causality="parameter", unit=unit, **more)


def component(folder, fmi):
    """Return a component whose p, an output y too, is a temperature."""
    units = KELVIN.format(more=INVERSE if fmi == 3 else "") + FURLONG
    start = {2: '<Real start="0.5"', 3: 'variability="fixed" start="0.5"'}[fmi]
    attributes = ' unit="K" min="100" max="400" displayUnit="degC"'
    edits = {
        start: start.replace("0.5", "150") + attributes,
        "  <DefaultExperiment": f"  <UnitDefinitions>{units}</UnitDefinitions>\n  <DefaultExperiment",
    }
    return Component(name="c", source=setup_fmu(folder, fmi=fmi, edits=edits), period=STEP, kind="sampled",
                     isolated=False)  # fmt: skip


@pytest.fixture(scope="module", params=[2, 3])
def system(request, tmp_path_factory):
    if shutil.which("gcc") is None:
        pytest.skip("the FMUs are compiled with gcc")
    made = component(tmp_path_factory.mktemp("units"), request.param)
    return System(name="demo", tick=STEP, components=(made,), stop_time=STEP, record=("c.y",))


@pytest.mark.parametrize(
    ("text", "kelvin"),
    [("26.85degC", 300.0), ("300 K", 300.0), (" 1e2 fu ", 300.0), ("300", 300.0), ("-3.15e0 degC", 270.0)],
)
def test_a_value_is_converted_by_the_units_of_the_fmu(system, tmp_path, text, kelvin):
    simulate(system, tmp_path / "run", overrides={"c.p": text})
    assert read_signals(tmp_path / "run")["c.y"][0] == pytest.approx(kelvin, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("3 parsec", r"c\.p = '3 parsec': unit 'parsec' is no unit that is known; give it in K or in degC, fu$"),
        ("3 degc", r"'degc' is no unit that is known; give it in K or in degC, fu; did you mean degC\?$"),
        ("3m", r"c\.p = '3m': unit 'm' does not convert to K"),
        ("3per_K", r"'per_K' is no unit that is known"),
        ("90", r"c\.p: '90' is outside \[100\.0, 400\.0\] K, which the FMU declares; if it is in degC, write 90degC$"),
        ("-300", r"'-300' is outside \[100\.0, 400\.0\] K, which the FMU declares$"),
        ("-200degC", r"'-200degC' is outside \[100\.0, 400\.0\] K"),
        ("K", r"c\.p: 'K' is not of its type"),
        ("1,5", r"c\.p: '1,5' is not of its type"),
    ],
)
def test_what_does_not_convert_is_refused_in_one_line(system, tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        simulate(system, tmp_path / "run", overrides={"c.p": text})
    assert not (tmp_path / "run").exists()


def test_the_command_line_takes_units(system, tmp_path, capsys):
    path, out = str(system.components[0].source), str(tmp_path / "run")
    assert (
        main(["run", path, "--stop-time", "0.01", "--out", out, "--share-process", "*", "--set", "setup.p=27 degC"])
        == 0
    )
    assert main(["run", path, "--out", str(tmp_path / "other"), "--set", "setup.p=27 deg"]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert "setup.p = '27 deg': unit 'deg' does not convert to K" in error


def test_a_parameter_in_an_adapter_takes_units(system, tmp_path):
    adapter = tmp_path / "a.toml"
    adapter.write_text('ignore = ["*"]\n[parameters]\np = "26.85 degC"\n[[output]]\nport = "y"\nvariable = "y"\n'
                       '[constants]\n', encoding="utf-8")  # fmt: skip
    variables = {name: read_description(system.components[0]).variables[name] for name in "py"}
    bound = bind(read_adapter(adapter), {"y": variables["y"]}, variables)
    assert bound.starts[variables["p"]] == pytest.approx(300.0, rel=1e-15)


def test_units_of_the_table_count_where_the_fmu_defines_none():
    assert parse_value("1arcsec", variable(UNITS["rad"]), "c.k") == pytest.approx(ARCSECOND, rel=1e-15)
    assert parse_value("5 ms", variable(UNITS["s"]), "c.k") == 5e-3
    assert parse_value("2%", variable(UNITS["1"]), "c.k") == 0.02
    assert parse_value("3 1/s", variable(UNITS["1/s"]), "c.k") == 3.0
    nameless = Unit(name="rad")  # FMI 1.0 has no base units
    assert parse_value("180deg", variable(nameless), "c.k") == pytest.approx(np.pi, rel=1e-15)
    without_rad = Unit(name="rad/s", exponents=(0, 0, -1, 0, 0, 0, 0, 0))  # as some tools write it
    assert parse_value("60rpm", variable(without_rad), "c.k") == pytest.approx(2.0 * np.pi, rel=1e-15)


def test_an_angle_is_not_converted_to_a_number():
    """An MRP is tan(angle/4): an angle given for it would be four times too large."""
    with pytest.raises(InputError, match="'arcsec' does not convert to 1"):
        parse_value("1arcsec", variable(UNITS["1"]), "c.k")


def test_a_unit_for_a_variable_without_one_is_refused():
    with pytest.raises(InputError, match=r"c\.k: '1 m' has a unit, and the variable has none; give the number alone"):
        parse_value("1 m", variable(None), "c.k")


def test_a_difference_has_no_offset():
    declared = DeclaredUnits(display={"K": {"degC": DisplayUnit(gain=1.0, bias=273.15)}})
    for relative, kelvin in ((False, 283.15), (True, 10.0)):
        one = variable(UNITS["K"], relative=relative, declared_units=declared)
        assert parse_value("10degC", one, "c.k") == kelvin


@pytest.fixture
def vector(tmp_path):
    """Return a system with an input `angle` in deg, and descriptions with an array in rad."""
    names = [f"r[{k}]" for k in (1, 2, 3)]
    variables = {name: Variable(name=name, reference=k, type="Real", causality="input", unit=UNITS["rad"], maximum=0.1)
                 for k, name in enumerate(names)}  # fmt: skip
    description = Description(model="m", guid="g", identifier="i", once_per_process=False, saves_state=False,
                              sha256="", variables=variables)  # fmt: skip
    feed = Feed(component="c", input="r[1]", hops=(Hop(),))
    component = Component(name="c", source=tmp_path / "c.fmu", period=1)
    inputs = (SystemInput(name="angle", unit=UNITS["deg"], feeds=(feed,)),)
    return System(name="demo", tick=1, components=(component,), inputs=inputs), {"c": description}


def test_a_list_has_a_unit_for_each_number(vector):
    found = resolve_overrides("c.r", "1arcsec, 0, 2 mrad", *vector)
    assert [value for _, _, value in found] == pytest.approx([ARCSECOND, 0.0, 2e-3], rel=1e-15)
    assert [value for _, _, value in resolve_overrides("c.r", "1 mrad", *vector)] == [1e-3] * 3
    with pytest.raises(InputError, match=r"c\.r: '1' has no unit, and others have deg; give each number its unit"):
        resolve_overrides("c.r", "1,2,3deg", *vector)


def test_an_input_of_the_system_is_given_in_its_unit_or_another(vector):
    for text in ("1", "60 arcmin", "0.017453292519943295rad"):
        ((_, _, value),) = resolve_overrides("angle", text, *vector)
        assert value == pytest.approx(np.pi / 180.0, rel=1e-14)
