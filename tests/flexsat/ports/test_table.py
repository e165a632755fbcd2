"""The port table: numbering, feedthrough, and what is refused."""

import pytest

from flexsat.ports.table import Port, PortTable
from flexsat.ports.units import UNITS, unit_of


def port(**changes):
    """Return a valid output, changed."""
    return Port(**{"name": "a.b", "causality": "output", "description": "something", **changes})


TABLE = PortTable(
    (
        port(name="gain", causality="parameter", unit="1/s", start=2),
        port(name="speed", unit="rad/s", size=2, depends_on=("torque[i]",)),
        port(name="valid", kind="boolean", depends_on=("torque",), initial_depends_on=()),
        port(name="torque", causality="input", unit="N.m", size=2, start=(1.0, 2.0)),
        port(name="count", kind="integer", causality="parameter"),
        port(name="angle", unit="rad", display_unit="arcsec"),
    )
)


def test_inputs_outputs_and_parameters_are_runs():
    assert [v.name for v in TABLE.of_kind("real")] == [
        "torque[1]",
        "torque[2]",
        "speed[1]",
        "speed[2]",
        "angle",
        "gain",
    ]
    assert [v.value_reference for v in TABLE.of_kind("real")] == list(range(6))
    assert (TABLE.run("input"), TABLE.run("output"), TABLE.run("parameter")) == (slice(0, 2), slice(2, 5), slice(5, 6))
    assert TABLE.run("input", "string") == slice(0, 0)
    assert TABLE.span("speed") == slice(2, 4)
    assert [v.index for v in TABLE.variables] == list(range(1, 9))


def test_no_two_variables_have_the_same_value_reference_whatever_their_kinds():
    references = {v.name: v.value_reference for v in TABLE.variables}

    assert sorted(references.values()) == list(range(len(TABLE.variables)))
    assert (references["gain"], references["count"], references["valid"]) == (5, 6, 7)
    assert dict(TABLE.first_reference) == {"real": 0, "integer": 6, "boolean": 7, "string": 8}


def test_feedthrough_names_indices_of_the_model_description():
    index = {v.name: v.index for v in TABLE.variables}
    by_name = {v.name: v for v in TABLE.variables}

    assert TABLE.dependencies(by_name["speed[2]"], initial=False) == (index["torque[2]"],)
    assert TABLE.dependencies(by_name["speed[2]"], initial=True) == (index["gain"], index["count"])
    assert TABLE.dependencies(by_name["valid"], initial=False) == (index["torque[1]"], index["torque[2]"])
    assert TABLE.dependencies(by_name["valid"], initial=True) == ()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "a[1]"}, "not a structured FMI name"),
        ({"causality": "local"}, "causality must be one of input, output, parameter, got 'local'"),
        ({"kind": "float"}, "kind must be one of"),
        ({"description": " "}, "a description is required"),
        ({"size": 0}, "size must be None or a whole number from 1, got 0"),
        ({"unit": "lbf"}, "port a.b: unit 'lbf' is unknown"),
        ({"unit": "rad", "display_unit": "grad"}, "rad has no display unit 'grad'; it has deg, arcsec"),
        ({"kind": "integer", "unit": "rad"}, "only a real has a unit"),
        ({"kind": "boolean", "variability": "continuous"}, "a boolean output cannot be 'continuous'"),
        ({"start": 1.0}, "an output is calculated"),
        ({"causality": "input", "on_demand": True}, "only an output has dependencies or is on demand"),
        ({"causality": "input", "size": 3, "start": (1.0, 2.0)}, "3 start values are needed, got 2"),
        ({"causality": "input", "start": (1.0,)}, "a scalar has one start value"),
        ({"causality": "input", "start": float("nan")}, "start must be finite, got nan"),
        ({"causality": "input", "kind": "integer", "start": True}, "start must be integer, got True"),
        ({"causality": "parameter", "start": -1.0, "minimum": 0.0}, "start must be >= 0.0, got -1.0"),
        ({"causality": "parameter", "start": 2.0, "maximum": 1.0}, "start must be <= 1.0, got 2.0"),
        ({"kind": "string", "minimum": 0.0}, "only a real or an integer has a minimum"),
    ],
)
def test_a_bad_port_is_refused_with_name_and_reason(changes, message):
    with pytest.raises(ValueError, match="port ") as refusal:
        port(**changes)
    assert message in str(refusal.value)


@pytest.mark.parametrize(
    ("ports", "message"),
    [
        ((port(), port()), "port a.b is declared twice"),
        ((port(depends_on=("c",)), port(name="d", causality="input")), "depends on 'c', which is no port here"),
        ((port(depends_on=("c",)), port(name="c")), "depends_on names 'c', which is not an input"),
        ((port(initial_depends_on=("c",)), port(name="c")), "names 'c', which is an output"),
        ((port(size=2, depends_on=("c[i]",)), port(name="c", causality="input", size=3)), "equal sizes, got 2 and 3"),
    ],
)
def test_a_bad_table_is_refused(ports, message):
    with pytest.raises(ValueError, match="port") as refusal:
        PortTable(ports)
    assert message in str(refusal.value)


def test_display_units_are_what_one_turn_is():
    turn = 6.283185307179586
    few_ulp = 1e-14  # one division each

    assert turn * UNITS["rad"].display["deg"] == pytest.approx(360.0, rel=few_ulp)
    assert turn * UNITS["rad"].display["arcsec"] == pytest.approx(1296000.0, rel=few_ulp)
    assert turn * UNITS["rad/s"].display["rpm"] == pytest.approx(60.0, rel=few_ulp)


def test_composed_units_multiply_their_parts():
    names = {"N": "N", "N.m": "N m", "N.m.s": "N m s", "N.s": "N s", "kg.m2": "kg m m", "J": "N m"}
    for composed, parts in names.items():
        total = {}
        for part in parts.split():
            for base, exponent in unit_of(part).exponents.items():
                total[base] = total.get(base, 0) + exponent
        assert {base: n for base, n in total.items() if n} == dict(UNITS[composed].exponents), composed
