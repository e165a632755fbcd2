"""Differences of temperatures between FMUs in degC and in K: the offset of a unit does not apply to them."""

import shutil
from dataclasses import replace

import pytest

from fmus.setup.setup_fmu import setup_fmu
from lockstep import Component, Connection, System, read_signals, simulate
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.faults.read import read_scenario
from lockstep.shadow.component import with_shadow
from lockstep.system.unit_table import UNITS

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="the FMUs are compiled with gcc")
STEP = 10_000_000  # [ns]
UNIT = {
    "degC": '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>',
    "K": '<Unit name="K"><BaseUnit K="1"/></Unit>',
}
TYPES = '<TypeDefinitions><SimpleType name="Change"><Real {attributes}/></SimpleType></TypeDefinitions>'


def in_unit(folder, unit, relative):
    """Make an FMU whose p, y, u and v are in this unit; their type says that they are differences, or they do."""
    flag = 'relativeQuantity="true"' if relative != "no" else ""
    own = f'unit="{unit}" {flag if relative == "itself" else ""}'
    given = own if relative != "type" else 'declaredType="Change"'
    types = TYPES.format(attributes=f'unit="{unit}" {flag}') if relative == "type" else ""
    edits = {
        "  <DefaultExperiment": f"<UnitDefinitions>{UNIT[unit]}</UnitDefinitions>{types}<DefaultExperiment",
        "<Real start": f"<Real {given} start",
        '"output"><Real/></ScalarVariable>\n    <ScalarVariable name="v"': f'"output"><Real {given}/></ScalarVariable>'
        '<ScalarVariable name="v"',
        '"3" causality="output"><Real/>': f'"3" causality="output"><Real {given}/>',
    }
    return setup_fmu(folder, edits=edits)


@pytest.fixture(scope="module", params=["itself", "type", "no"])
def case(request, tmp_path_factory):
    """Return the offset to expect in degC to K, and two FMUs that feed each other, one in degC and one in K."""
    folder = tmp_path_factory.mktemp("relative")
    fmus = [in_unit(folder / unit, unit, request.param) for unit in UNIT]
    warm, cold = (
        Component(
            name=name,
            source=fmu,
            period=STEP,
            kind="sampled",
            isolated=False,
            parameters={"p": value},
            units={"p": UNITS["K"]},
        )
        for name, fmu, value in zip(("warm", "cold"), fmus, (5.0, 2.0), strict=True)
    )
    wires = (
        Connection(from_component="warm", output="y", to_component="cold", input="u"),
        Connection(from_component="cold", output="y", to_component="warm", input="u", delay=1),
    )
    system = System(name="s", tick=STEP, stop_time=9 * STEP, components=(warm, cold), connections=wires)
    return 273.15 if request.param == "no" else 0.0, system


def test_connections_values_and_faults_treat_differences_as_such(case, tmp_path):
    offset, system = case
    scenario = tmp_path / "faults.toml"
    scenario.write_text(
        '[[fault]]\nconnection = "warm.u"\nkind = "stuck"\nvalue = 7\nunit = "K"\nfrom = 0.05\nto = 0.2\n'
    )
    simulate(system, tmp_path / "out", faults=[read_scenario(scenario)])
    signals = read_signals(tmp_path / "out")

    assert signals["warm.y"][-1] == 5.0 - offset  # of a value in K
    assert signals["cold.v"][-1] == pytest.approx(5.0, abs=1e-12)  # rounding of numbers near 300
    assert signals["warm.v"][3] == 2.0 - offset
    assert signals["warm.v"][-1] == 7.0 - offset


def test_adapters_treat_differences_as_such(case, tmp_path):
    offset, system = case
    adapter = tmp_path / "a.toml"
    adapter.write_text(
        'ignore = ["*tol*", "shown"]\n[[input]]\nport = "u"\nvariable = "u"\n'
        '[[output]]\nport = "y"\nvariable = "y"\n[[output]]\nport = "v"\nvariable = "v"\n[parameters]\np = 3.0\n'
    )
    kelvin = system.component("cold").source
    warm = replace(system.component("warm"), parameters={}, units={})
    system = replace(system, components=(warm, system.component("cold")))
    simulate(replace_component(system, "warm", kelvin, read_adapter(adapter)), tmp_path / "out")
    signals = read_signals(tmp_path / "out")

    assert signals["warm.y"][-1] == 3.0 - offset
    assert signals["cold.v"][-1] == pytest.approx(3.0, abs=1e-12)
    assert signals["warm.v"][-1] == pytest.approx(2.0 - offset, abs=1e-12)


def test_shadows_treat_differences_as_such(case, tmp_path):
    offset, system = case
    shadowed = with_shadow(system, "warm", system.component("cold").source)
    simulate(shadowed, tmp_path / "out", overrides={"warm.shadow.p": 6.0}, record=["all"])
    signals = read_signals(tmp_path / "out")

    assert signals["warm.shadow.y"][-1] == pytest.approx(6.0 - offset, abs=1e-12)
    assert signals["warm.residual.y"][-1] == pytest.approx(1.0, abs=1e-12)
    assert signals["warm.shadow.v"][-1] == pytest.approx(2.0, abs=1e-12)


def test_offsets_count_where_one_end_alone_is_a_difference(case, tmp_path):
    _, system = case
    other = in_unit(tmp_path / "other", "K", "no" if case[0] == 0.0 else "itself")
    mixed = replace(system, components=(system.component("warm"), replace(system.component("cold"), source=other)))
    simulate(mixed, tmp_path / "mixed")
    simulate(with_shadow(system, "warm", other), tmp_path / "shadow", overrides={"warm.shadow.p": 6.0}, record=["all"])

    signals = read_signals(tmp_path / "mixed")
    assert signals["cold.v"][-1] == pytest.approx(signals["warm.y"][-1] + 273.15, abs=1e-12)  # rounding near 300
    assert signals["warm.v"][-1] == pytest.approx(signals["cold.y"][-1] - 273.15, abs=1e-12)
    shadowed = read_signals(tmp_path / "shadow")
    assert shadowed["warm.shadow.y"][-1] == pytest.approx(6.0 - 273.15, abs=1e-12)
