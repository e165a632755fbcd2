"""What of an adapter SSP can say is what the adapter does, element by element; what it cannot say is refused."""

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


OURS = variables(
    ("rate", 3, "Real", "input", "rad/s"),
    ("mrp", 3, "Real", "input", None),
    ("quaternion", 4, "Real", "input", None),
    ("mode", 1, "Integer", "input", None),
    ("valid", 1, "Boolean", "input", None),
    ("torque", 3, "Real", "output", "N.m"),
    ("ready", 1, "Boolean", "output", None),
)
THEIRS = variables(
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
        used = {name.replace("*", str(k)) for name in entry.theirs for k in range(1, 5)}
        theirs = {name: v for name, v in THEIRS.items() if name in used or name in entry.theirs}
        binding = bind(adapter, OURS, theirs)
        return (*binding.inputs, *binding.outputs)[0]

    return resolve


LINEAR = {
    "rate, unit": 'ours = "rate"\ntheirs = "w[*]"\nunit = "deg/s"',
    "rate, all": 'ours = "rate"\ntheirs = "w[*]"\nunit = "rpm"\nscale = [2, 3, 4]\nsign = [1, -1, 1]\noffset = 0.3\n'
    "order = [3, 1, 2]",
    "rate, signed permutation": f'ours = "rate"\ntheirs = "w[*]"\nframe = {QUARTER_TURN}\norder = [2, 1, 3]',
    "quaternion, order": 'ours = "quaternion"\ntheirs = "q[*]"\nattitude = "quaternion"\nscalar = "first"',
    "quaternion, inverse": 'ours = "quaternion"\ntheirs = "q[*]"\nattitude = "quaternion"\nscalar = "first"\n'
    'direction = "inertial-from-body"\nsign = -1',
    "quaternion, half turn": 'ours = "quaternion"\ntheirs = "q[*]"\nattitude = "quaternion"\n'
    f'direction = "inertial-from-body"\nbody_frame = {HALF_TURN}\ninertial_frame = {HALF_TURN}',
    "mode": 'ours = "mode"\ntheirs = "number"\nscale = 2\noffset = -1',
}


@pytest.mark.parametrize("name", LINEAR)
def test_the_elements_are_what_the_adapter_computes(bound, name):
    one = bound("input", LINEAR[name])
    values = np.random.default_rng(1).normal(size=len(one.ours))
    theirs = np.full(len(one.theirs), np.nan)
    for pair in pairs(one):
        theirs[pair.theirs] = pair.factor * values[pair.ours] + pair.offset

    np.testing.assert_allclose(theirs, one.conversion.to_theirs(values), rtol=1e-15, atol=0.0)


def test_outputs_go_the_other_way(bound):
    text = (
        'ours = "torque"\ntheirs = "tau[*]"\nunit = "mN.m"\nsign = [-1, 1, -1]\noffset = [0.5, 0, 1]\norder = [2, 3, 1]'
    )
    one = bound("output", text)
    values = np.random.default_rng(2).normal(size=3)
    ours = np.full(3, np.nan)
    for pair in pairs(one):
        ours[pair.ours] = pair.factor * values[pair.theirs] + pair.offset

    few_ulp = 1e-15  # the adapter subtracts and divides
    np.testing.assert_allclose(ours, one.conversion.to_ours(values), rtol=few_ulp, atol=few_ulp)


def test_an_mrp_of_ours_is_replaced_by_a_quaternion(bound):
    text = ('ours = "mrp"\ntheirs = "q[*]"\nattitude = "quaternion"\nscalar = "first"\n'
            f'direction = "inertial-from-body"\nbody_frame = {HALF_TURN}')  # fmt: skip
    one = bound("input", text)
    with pytest.raises(Inexpressible, match="are no linear functions of each other"):
        pairs(one)
    mrp = np.array([0.1, -0.2, 0.3])
    quaternion = np.array([*(2.0 * mrp), 1.0 - mrp @ mrp]) / (1.0 + mrp @ mrp)
    theirs = np.zeros(4)
    for pair in quaternion_pairs(one):
        theirs[pair.theirs] = pair.factor * quaternion[pair.ours] + pair.offset

    np.testing.assert_allclose(theirs, one.conversion.to_theirs(mrp), rtol=1e-15, atol=1e-16)


REFUSED = {
    "MRP of theirs": ('ours = "mrp"\ntheirs = "s[*]"\nattitude = "mrp"', "no linear functions"),
    "frame": (f'ours = "rate"\ntheirs = "w[*]"\nframe = {OBLIQUE}', "mixes axes: element 1 of theirs is made of 2"),
    "quarter turn": (
        f'ours = "quaternion"\ntheirs = "q[*]"\nattitude = "quaternion"\nbody_frame = {QUARTER_TURN}',
        "a rotation that mixes axes",
    ),
    "flag of a Real": ('ours = "valid"\ntheirs = "real"\ntrue = 2', "a flag of a Real is no transformation"),
    "flag of halves": ('ours = "valid"\ntheirs = "number"\ntrue = 0.5', "are not Integers, as number is"),
    "Integer of halves": ('ours = "mode"\ntheirs = "number"\nscale = 0.5', "is no whole number"),
    "Real to Integer": ('ours = "rate[1]"\ntheirs = "number"', "Real and Integer are not connected in SSP: number"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_connection_can_do_is_refused(bound, name):
    text, says = REFUSED[name]
    with pytest.raises(Inexpressible, match=says):
        pairs(bound("input", text))


@pytest.mark.parametrize(
    ("direction", "text", "kind", "entries"),
    [
        ("input", 'ours = "valid"\ntheirs = "number"\ntrue = 3', "Integer", ((0, 0), (1, 3))),
        ("input", 'ours = "valid"\ntheirs = "number"\ntrue = 0\nfalse = 1', "Integer", ((0, 1), (1, 0))),
        ("input", 'ours = "valid"\ntheirs = "flag"\ntrue = 0\nfalse = 1', "Boolean", ((False, True), (True, False))),
        ("output", 'ours = "ready"\ntheirs = "state"\ntrue = 2', "Integer", ((0, 0),)),
        ("output", 'ours = "ready"\ntheirs = "state"\ntrue = 2\nfalse = -7', "Integer", ((-7, 0), (0, 1))),
        ("output", 'ours = "ready"\ntheirs = "done"\ntrue = 0\nfalse = 1', "Boolean", ((False, True), (True, False))),
    ],
)
def test_flags_are_tables(bound, direction, text, kind, entries):
    one = bound(direction, text)
    (pair,) = pairs(one)
    assert (pair.table.kind, pair.table.entries) == (kind, entries)
    table, convert = dict(entries), one.conversion.to_theirs if direction == "input" else one.conversion.to_ours
    numbers = (0, 1) if direction == "input" or kind == "Boolean" else (-7, -1, 0, 1, 2, 3)
    for number in numbers:
        told = table.get(number, number)  # no entry: it stays as it is
        assert (told if direction == "input" else told != 0) == convert(np.array([float(number)]))[0]


def test_a_flag_of_a_boolean_needs_no_table(bound):
    (pair,) = pairs(bound("input", 'ours = "valid"\ntheirs = "flag"'))
    assert pair.table is None
