"""Adapters bound to ports and variables, and adapted slaves around toy slaves."""

import random

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from lockstep.adapter.bind import bind
from lockstep.adapter.read import read_adapter
from lockstep.adapter.slave import AdaptedSlave
from lockstep.errors import InputError
from lockstep.fmi.model_description import Variable
from lockstep.fmi.slave import DTYPES, ERROR, OK
from lockstep.system.unit_table import UNITS


def variables(*rows):
    """Make variables of (name, type, causality, unit), with value references from 10 on."""
    made = [
        Variable(name=name, reference=k, type=kind, causality=causality, unit=UNITS.get(unit))
        for k, (name, kind, causality, unit) in enumerate(rows, start=10)
    ]
    return {variable.name: variable for variable in made}


PORTS = variables(
    *((f"rate[{k}]", "Real", "input", "rad/s") for k in (1, 2, 3)),
    ("valid", "Boolean", "input", ""),
    ("unused", "Real", "input", "m"),
    *((f"torque[{k}]", "Real", "output", "N.m") for k in (1, 2)),
    ("healthy", "Boolean", "output", ""),
    ("reference", "Real", "output", "rad"),
)
FMU = variables(
    *((f"w{k}", "Real", "input", "") for k in (0, 1, 2)),
    ("ok", "Integer", "input", ""),
    ("mode", "Integer", "input", ""),
    ("t_1", "Real", "output", "mN.m"),
    ("t_2", "Real", "output", "mN.m"),
    ("status", "Integer", "output", ""),
    ("noise", "Real", "output", ""),
    ("kp", "Real", "parameter", ""),
)
RATE = '[[input]]\nport = "rate"\nvariable = "w*"\nindex_base = 0\nunit = "deg/s"\n'
VALID = '[[input]]\nport = "valid"\nvariable = "ok"\ntrue = 5\n'
TORQUE = '[[output]]\nport = "torque"\nvariable = "t_*"\nsign = -1\n'
HEALTHY = '[[output]]\nport = "healthy"\nvariable = "status"\nfalse = 9\n'
REST = '[constants]\nmode = 2\n[parameters]\nkp = 0.5\n[substitutes]\n"ref*" = 0.25\n'
GOOD = 'ignore = ["noi*"]\n' + RATE + VALID + TORQUE + HEALTHY + REST


class Toy:
    """Give at each step the sum of the Real inputs, times 1000, and remember what was set."""

    def __init__(self):
        self.store = {kind: {} for kind in ("Real", "Integer", "Boolean", "String")}
        self.step_status = OK

    def do_step(self, _time, _step, _new):
        total = sum(self.store["Real"].get(r, 0.0) for r in (10, 11, 12))
        self.store["Real"] |= {15: 1000.0 * total, 16: 2000.0}
        self.store["Integer"][17] = self.store["Integer"].get(13, 0)
        return self.step_status

    def getter(self, scalar, references, buffer):
        def get():
            buffer[:] = [self.store[scalar].get(int(r), 0) for r in references]
            return OK

        return get

    def setter(self, scalar, references, buffer):
        def put():
            self.store[scalar] |= dict(zip(references.tolist(), buffer.tolist(), strict=True))
            return OK

        return put

    def set_start(self, values, scalar):
        self.store[scalar] |= values
        return OK

    def setup_experiment(self, _start, _stop):
        self.store = {kind: {} for kind in self.store}  # what was set before is lost
        return OK

    def exit_initialization(self):
        return OK


@pytest.fixture
def resolve(tmp_path):
    def resolve(text):
        path = tmp_path / "vendor.toml"
        path.write_text(text)
        return bind(read_adapter(path), PORTS, FMU)

    return resolve


def ports(slave, binding, names, scalar, values=None):
    references = np.array([binding.shown[name].reference for name in names], np.uint32)
    buffer = np.array(values if values is not None else np.zeros(len(names)), DTYPES[scalar])
    call = (slave.getter if values is None else slave.setter)(scalar, references, buffer)
    assert call() == OK
    return buffer


def test_only_served_ports_and_parameters_of_the_fmu_are_shown(resolve):
    shown = resolve(GOOD).shown

    assert list(shown) == ["rate[1]", "rate[2]", "rate[3]", "valid", "torque[1]", "torque[2]", "healthy", "reference",
                           "kp"]  # fmt: skip
    assert [v.reference for v in shown.values()] == list(range(9))
    assert shown["torque[1]"].unit == UNITS["N.m"]


def test_values_are_converted_in_both_directions(resolve):
    binding, toy = resolve(GOOD), Toy()
    slave = AdaptedSlave(toy, binding)
    assert slave.setup_experiment(0.0, 1.0) == OK
    ports(slave, binding, ["rate[1]", "rate[3]"], "Real", np.radians([1.0, 2.0]))
    ports(slave, binding, ["valid"], "Boolean", [True])

    assert slave.exit_initialization() == OK
    assert (toy.store["Integer"][13], toy.store["Integer"][14], toy.store["Real"][19]) == (5, 2, 0.5)
    assert slave.do_step(0.0, 0.1, 1) == OK
    torque = ports(slave, binding, ["torque[1]", "torque[2]", "reference"], "Real")
    np.testing.assert_allclose(torque, [-3.0, -2.0, 0.25], rtol=1e-15)  # rounding of the degrees
    assert ports(slave, binding, ["healthy"], "Boolean")[0] == 1


def test_held_input_changes_only_while_its_flag_is_true(resolve):
    binding, toy = resolve(GOOD.replace('"w*"\n', '"w*"\nhold = "valid"\n', 1)), Toy()
    slave = AdaptedSlave(toy, binding)
    slave.exit_initialization()
    seen = []
    for valid, rate in ((0, 1.0), (1, 2.0), (0, 3.0)):
        ports(slave, binding, ["valid"], "Boolean", [valid])
        ports(slave, binding, ["rate[1]"], "Real", [np.radians(rate)])
        slave.do_step(0.0, 0.1, 1)
        seen.append(toy.store["Real"][10])

    assert_array_equal(np.round(seen, 12), [0.0, 2.0, 2.0])


def test_failed_step_is_reported_and_no_output_is_read(resolve):
    binding, toy = resolve(GOOD), Toy()
    slave = AdaptedSlave(toy, binding)
    slave.exit_initialization()
    toy.step_status = ERROR

    assert slave.do_step(0.0, 0.1, 1) == ERROR
    assert ports(slave, binding, ["torque[2]"], "Real")[0] == 0.0


def test_start_values_reach_ports_and_parameters_of_the_fmu(resolve):
    binding, toy = resolve(GOOD), Toy()
    slave = AdaptedSlave(toy, binding)
    number = {name: v.reference for name, v in binding.shown.items()}
    assert slave.set_start({number["rate[2]"]: np.radians(4.0), number["kp"]: 7.0}, "Real") == OK
    slave.exit_initialization()

    assert toy.store["Real"][11] == pytest.approx(4.0)
    assert toy.store["Real"][19] == 7.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('port = "rate"', 'port = "rates"', "port = 'rates': no such input; there are rate[1..3], valid, unused; did"),
        ('port = "rate"', 'port = "rate[1..4]"', "port = 'rate[1..4]': no such input; there are rate[1..3]"),
        ('port = "rate"', 'port = "torque"', "port = 'torque': no such input"),
        ('port = "rate"', 'port = "rate[1..2]"', "the FMU also has w2, and the port makes 2 elements only"),
        ("index_base = 0\n", "", "variable = 'w3': no such input of the FMU; there are w0, w1, w2, ok, mode; is"),
        ('variable = "w*"\nindex_base = 0', 'variable = ["w0", "w1"]', "variable has 2 elements, and the port makes"),
        ('unit = "deg/s"', 'unit = "mN.m"', "rate[1]: unit 'rad/s' [s-1] does not convert to 'mN.m'"),
        ('unit = "deg/s"', "scale = [1, 2]", "scale = [1.0, 2.0] must be one number or 3, one for each element"),
        ('unit = "deg/s"', "order = [2, 1]", "order = [2, 1] must have 3 elements"),
        ('unit = "deg/s"', 'hold = "rate[1]"', "hold = 'rate[1]' must be a Boolean input of the interface: valid"),
        (VALID, "", "vendor.toml: nothing feeds ok of the FMU; add an [[input]], or a constant"),
        ('ignore = ["noi*"]', "", "vendor.toml: nothing takes noise of the FMU; add an [[output]], or ignore it"),
        ("mode = 2", "mode = 2.5", "constants: mode: 2.5 is not of its type Integer"),
        ("mode = 2", "mode = 2\nok = 1", "constants: ok = 1: an [[input]] feeds it already; remove one of them"),
        ("mode = 2", "modus = 2", "constants: modus = 2: no such input of the FMU; there are w0, w1, w2, ok, mode"),
        ("kp = 0.5", "ki = 0.5", "parameters: ki = 0.5: no such parameter of the FMU; there are kp"),
        ('"ref*" = 0.25', "torque = 0.0", "substitutes: torque = 0.0: an [[output]] makes it already"),
        ('"ref*" = 0.25', "ref = 0.0", "substitutes: ref = 0.0: no such output port; there are torque[1..2]"),
        ('ignore = ["noi*"]', 'ignore = ["noise", "nosie"]', "ignore: 'nosie': no such output of the FMU; there"),
        ('"ref*" = 0.25', '"ref*" = 0.25\nreference = 1.0', "reference = 1.0: reference has one already; remove one"),
        ("true = 5", "sign = -1", "input 2 (ok): sign = -1: has no effect on Booleans; true and false give"),
        ("true = 5", "order = [1]", "order = 1: has no effect on Booleans"),
        ("true = 5", "index_base = 0", "index_base = 0: has no effect here; it is the first number of an array"),
        ("sign = -1", "true = 3", "output 1 (t_*): true = 3: has no effect on numbers; scale, sign and offset"),
        (VALID, VALID + VALID.replace("true = 5", ""), "ok is fed twice, also by vendor.toml: input 2 (ok); remove"),
    ],
)  # fmt: skip
def test_adapter_that_does_not_fit_is_refused_in_one_line(resolve, old, new, message):
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        resolve(GOOD.replace(old, new, 1))

    assert message in str(caught.value)
    assert "vendor.toml" in str(caught.value)


GRID = [f"{row},{column}" for row in (1, 2) for column in range(1, 11)]


@pytest.mark.parametrize(
    ("ports", "foreign", "entry"),
    [
        ([f"p[{k}]" for k in range(1, 13)], [f"q[{k}]" for k in range(12)], 'variable = "q[*]"\nindex_base = 0\n'),
        (
            [f"p[{k}]" for k in range(1, 21)],
            [f"a[{i},{k}]" for i in (1, 2) for k in range(1, 11)],
            'variable = "a[*]"\n',
        ),
        ([f"p[{i},{k}]" for i in (1, 2) for k in range(1, 11)], [f"q_{k}" for k in range(1, 21)], 'variable = "q_*"\n'),
    ],
)
def test_elements_of_arrays_are_paired_by_number(tmp_path, ports, foreign, entry):
    def shuffled(names):
        return variables(*((name, "Real", "input", "") for name in random.Random(5).sample(names, len(names))))

    path = tmp_path / "vendor.toml"
    path.write_text('[[input]]\nport = "p"\n' + entry)

    (bound,) = bind(read_adapter(path), shuffled(ports), shuffled(foreign)).inputs

    assert [v.name for v in bound.ports] == ports
    assert [v.name for v in bound.variables] == foreign
