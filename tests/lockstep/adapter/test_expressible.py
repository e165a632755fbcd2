"""Adapter entries as SSP connections: element by element what the adapter computes, or refused with the reason."""

from pathlib import Path

import numpy as np
import pytest

from lockstep.adapter.bind import bind
from lockstep.adapter.expressible import Inexpressible, pairs, quaternion_pairs
from lockstep.adapter.read import read_adapter
from lockstep.fmi.model_description import Variable
from lockstep.system.unit_table import UNITS

HALF_TURN = "[[1, 0, 0], [0, -1, 0], [0, 0, -1]]"
QUARTER_TURN = "[[1, 0, 0], [0, 0, 1], [0, -1, 0]]"
OBLIQUE = "[[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]"


def variables(*arrays):
    """Return variables by name: (array, number of elements, type, causality, unit)."""
    found = {}
    for array, count, kind, causality, unit in arrays:
        for k in range(1, count + 1):
            name = f"{array}[{k}]" if count > 1 else array
            found[name] = Variable(
                name=name, reference=len(found), type=kind, causality=causality, unit=UNITS[unit] if unit else None
            )
    return found


PORTS = variables(
    ("rate", 3, "Real", "input", "rad/s"),
    ("mrp", 3, "Real", "input", None),
    ("quaternion", 4, "Real", "input", None),
    ("mode", 1, "Integer", "input", None),
    ("valid", 1, "Boolean", "input", None),
    ("torque", 3, "Real", "output", "N.m"),
    ("ready", 1, "Boolean", "output", None),
)
VARIABLES = variables(
    ("w", 3, "Real", "input", None),
    ("q", 4, "Real", "input", None),
    ("s", 3, "Real", "input", None),
    ("number", 1, "Integer", "input", None),
    ("flag", 1, "Boolean", "input", None),
    ("real", 1, "Real", "input", None),
    ("tau", 3, "Real", "output", None),
    ("state", 1, "Integer", "output", None),
    ("done", 1, "Boolean", "output", None),
)


@pytest.fixture
def bound(tmp_path):
    """Return a function that resolves one entry of an adapter."""

    def resolve(direction, text):
        path = Path(tmp_path, "a.toml")
        path.write_text(f"[[{direction}]]\n{text}\n")
        adapter = read_adapter(path)
        (entry,) = adapter.entries
        used = {name.replace("*", str(k)) for name in entry.variables for k in range(1, 5)}
        fmu = {name: v for name, v in VARIABLES.items() if name in used or name in entry.variables}
        binding = bind(adapter, PORTS, fmu)
        return (*binding.inputs, *binding.outputs)[0]

    return resolve


LINEAR = {
    "rate, unit": 'port = "rate"\nvariable = "w[*]"\nunit = "deg/s"',
    "rate, all": 'port = "rate"\nvariable = "w[*]"\nunit = "rpm"\nscale = [2, 3, 4]\nsign = [1, -1, 1]\noffset = 0.3\n'
    "order = [3, 1, 2]",
    "rate, signed permutation": f'port = "rate"\nvariable = "w[*]"\nframe = {QUARTER_TURN}\norder = [2, 1, 3]',
    "quaternion, order": 'port = "quaternion"\nvariable = "q[*]"\nattitude = "quaternion"\nscalar = "first"',
    "quaternion, inverse": 'port = "quaternion"\nvariable = "q[*]"\nattitude = "quaternion"\nscalar = "first"\n'
    'direction = "inertial-from-body"\nsign = -1',
    "quaternion, half turn": 'port = "quaternion"\nvariable = "q[*]"\nattitude = "quaternion"\n'
    f'direction = "inertial-from-body"\nbody_frame = {HALF_TURN}\ninertial_frame = {HALF_TURN}',
    "mode": 'port = "mode"\nvariable = "number"\nscale = 2\noffset = -1',
}


@pytest.mark.parametrize("name", LINEAR)
def test_elements_are_what_the_adapter_computes(bound, name):
    one = bound("input", LINEAR[name])
    values = np.random.default_rng(1).normal(size=len(one.ports))
    found = np.full(len(one.variables), np.nan)
    for pair in pairs(one):
        found[pair.variable] = pair.factor * values[pair.port] + pair.offset

    np.testing.assert_allclose(found, one.conversion.to_fmu(values), rtol=1e-15, atol=0.0)


def test_outputs_are_converted_to_ports(bound):
    text = (
        'port = "torque"\nvariable = "tau[*]"\nunit = "mN.m"\n'
        "sign = [-1, 1, -1]\noffset = [0.5, 0, 1]\norder = [2, 3, 1]"
    )
    one = bound("output", text)
    values = np.random.default_rng(2).normal(size=3)
    found = np.full(3, np.nan)
    for pair in pairs(one):
        found[pair.port] = pair.factor * values[pair.variable] + pair.offset

    few_ulp = 1e-15  # the adapter subtracts and divides
    np.testing.assert_allclose(found, one.conversion.to_port(values), rtol=few_ulp, atol=few_ulp)


def test_mrp_port_is_replaced_by_a_quaternion(bound):
    text = ('port = "mrp"\nvariable = "q[*]"\nattitude = "quaternion"\nscalar = "first"\n'
            f'direction = "inertial-from-body"\nbody_frame = {HALF_TURN}')  # fmt: skip
    one = bound("input", text)
    with pytest.raises(Inexpressible, match="are no linear functions of each other"):
        pairs(one)
    mrp = np.array([0.1, -0.2, 0.3])
    quaternion = np.array([*(2.0 * mrp), 1.0 - mrp @ mrp]) / (1.0 + mrp @ mrp)
    found = np.zeros(4)
    for pair in quaternion_pairs(one):
        found[pair.variable] = pair.factor * quaternion[pair.port] + pair.offset

    np.testing.assert_allclose(found, one.conversion.to_fmu(mrp), rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize(
    "keys",
    ["", 'direction = "inertial-from-body"', f"body_frame = {HALF_TURN}\ninertial_frame = {HALF_TURN}"],
    ids=["as drafted", "other direction", "both frames turned"],
)
def test_mrp_is_written_where_it_is_linear(bound, keys):
    """The same frames turned alike: the rotation's vector is turned, its angle stays."""
    one = bound("input", f'port = "mrp"\nvariable = "s[*]"\nattitude = "mrp"\n{keys}')
    mrp = np.array([0.1, -0.2, 0.3])
    found = np.zeros(3)
    for pair in pairs(one):
        found[pair.variable] = pair.factor * mrp[pair.port] + pair.offset

    np.testing.assert_allclose(found, one.conversion.to_fmu(mrp), rtol=4e-16, atol=1e-16)  # by way of a quaternion


REFUSED = {
    "MRP in another body frame": (
        f'port = "mrp"\nvariable = "s[*]"\nattitude = "mrp"\nbody_frame = {HALF_TURN}',
        "no linear functions",
    ),
    "frame": (
        f'port = "rate"\nvariable = "w[*]"\nframe = {OBLIQUE}',
        "element 1 of the variable is made of 2",
    ),
    "quarter turn": (
        f'port = "quaternion"\nvariable = "q[*]"\nattitude = "quaternion"\nbody_frame = {QUARTER_TURN}',
        "a rotation that mixes axes",
    ),
    "flag of a Real": ('port = "valid"\nvariable = "real"\ntrue = 2', "a flag of a Real is no transformation"),
    "flag of halves": ('port = "valid"\nvariable = "number"\ntrue = 0.5', "are not Integers, as number is"),
    "Integer of halves": ('port = "mode"\nvariable = "number"\nscale = 0.5', "is no whole number"),
    "Real to Integer": ('port = "rate[1]"\nvariable = "number"', "Real and Integer are not connected in SSP: number"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_entry_without_a_connection_is_refused(bound, name):
    text, message = REFUSED[name]
    with pytest.raises(Inexpressible, match=message):
        pairs(bound("input", text))


@pytest.mark.parametrize(
    ("direction", "text", "kind", "entries"),
    [
        ("input", 'port = "valid"\nvariable = "number"\ntrue = 3', "Integer", ((0, 0), (1, 3))),
        ("input", 'port = "valid"\nvariable = "number"\ntrue = 0\nfalse = 1', "Integer", ((0, 1), (1, 0))),
        ("input", 'port = "valid"\nvariable = "flag"\ntrue = 0\nfalse = 1', "Boolean", ((False, True), (True, False))),
        ("output", 'port = "ready"\nvariable = "state"\ntrue = 2', "Integer", ((0, 0),)),
        ("output", 'port = "ready"\nvariable = "state"\ntrue = 2\nfalse = -7', "Integer", ((-7, 0), (0, 1))),
        ("output", 'port = "ready"\nvariable = "done"\ntrue = 0\nfalse = 1', "Boolean", ((False, True), (True, False))),
    ],
)
def test_flags_become_tables(bound, direction, text, kind, entries):
    one = bound(direction, text)
    (pair,) = pairs(one)
    assert (pair.table.kind, pair.table.entries) == (kind, entries)
    table, convert = dict(entries), one.conversion.to_fmu if direction == "input" else one.conversion.to_port
    numbers = (0, 1) if direction == "input" or kind == "Boolean" else (-7, -1, 0, 1, 2, 3)
    for number in numbers:
        mapped = table.get(number, number)  # without an entry it stays as it is
        assert (mapped if direction == "input" else mapped != 0) == convert(np.array([float(number)]))[0]


def test_flag_of_a_boolean_needs_no_table(bound):
    (pair,) = pairs(bound("input", 'port = "valid"\nvariable = "flag"'))
    assert pair.table is None
