"""Numbers between doubles and other types in an adapter: rounded to the nearest, and refused where they do not fit."""

from dataclasses import replace

import numpy as np
import pytest

from lockstep import Component, InputError, RunError, read_signals, simulate
from lockstep.adapter.bind import bind
from lockstep.adapter.component import replace_component
from lockstep.adapter.read import read_adapter
from lockstep.adapter.slave import AdaptedSlave
from lockstep.fmi.model_description import Variable, read_description
from lockstep.fmi.slave import DTYPES, ERROR, OK
from lockstep.system.unit_table import UNITS


def variable(name, kind, causality, reference=0):
    native, kind = (kind, "Integer") if kind in ("Int64", "UInt64") else ("", kind)
    return Variable(name=name, reference=reference, type=kind, causality=causality, native=native)


class Constant:
    """A slave with one input and one output, which holds what it is given."""

    def __init__(self, output=0):
        self.input, self.output, self.worst = None, output, OK

    def do_step(self, *_):
        return OK

    def getter(self, _scalar, _references, buffer):
        def get():
            buffer[:] = self.output
            return OK

        return get

    def setter(self, _scalar, _references, buffer):
        def put():
            self.input = buffer.tolist()[0]
            return OK

        return put

    def exit_initialization(self):
        return OK

    def failed(self, status):
        self.worst = status

    def last_messages(self):
        return "a message of the FMU about something else"


def adapted(folder, port, foreign, direction, slave, more=""):
    path = folder / "vendor.toml"
    path.write_text(f'[[{direction}]]\nport = "port"\nvariable = "foreign"\n{more}')
    ports = {"port": variable("port", port, direction)}
    return AdaptedSlave(slave, bind(read_adapter(path), ports, {"foreign": variable("foreign", foreign, direction)}))


def call(slave, way, scalar, value=0):
    buffer = np.array([value], DTYPES[scalar])
    status = getattr(slave, way)(scalar, np.array([0], np.uint32), buffer)()
    return status, buffer.tolist()[0]


BAD = [np.nan, np.inf, -np.inf, 1e300, 3e9, -3e9]


@pytest.mark.parametrize("foreign", ["Integer", "Boolean"])
@pytest.mark.parametrize("value", BAD)
def test_a_real_that_does_not_fit_the_input_of_an_fmu_is_refused_by_name(tmp_path, foreign, value):
    inner = Constant()
    slave = adapted(tmp_path, "Real", foreign, "input", inner)
    assert slave.exit_initialization() == OK
    assert call(slave, "setter", "Real", value)[0] == OK

    if foreign == "Boolean" and np.isfinite(value):  # any number but 0 is true
        assert slave.do_step(0.0, 0.1, 1) == OK
        assert inner.input == 1
        return
    assert slave.do_step(0.0, 0.1, 1) == ERROR

    assert slave.outcome("DoStep", ERROR) == f"foreign: {value:.9g} does not fit into {foreign}"
    assert slave.last_messages() == ""
    slave.failed(ERROR)
    assert (inner.input, inner.worst) == (0, OK)  # nothing was set, and the FMU may be terminated


@pytest.mark.parametrize("value", BAD)
def test_an_output_that_does_not_fit_a_port_is_refused_by_name(tmp_path, value):
    flag = adapted(tmp_path, "Boolean", "Real", "output", Constant(value))
    whole = adapted(tmp_path, "Integer", "Real", "output", Constant(value))
    if np.isfinite(value):
        assert flag.do_step(0.0, 0.1, 1) == OK
        assert call(flag, "getter", "Boolean") == (OK, 1)  # any number but 0 is true
        assert whole.do_step(0.0, 0.1, 1) == OK
        assert call(whole, "getter", "Integer")[0] == ERROR
        assert whole.outcome("GetInteger", ERROR) == f"port: {value:.9g} does not fit into Integer"
    else:
        assert flag.do_step(0.0, 0.1, 1) == ERROR
        assert flag.outcome("DoStep", ERROR) == f"foreign: is {value}, of which no Boolean can be made for port"
        assert whole.exit_initialization() == ERROR
        assert whole.outcome("ExitInitializationMode", ERROR).startswith(f"foreign: is {value}, of which no Integer")


@pytest.mark.parametrize(
    ("value", "integer"), [(2.5, 2), (3.5, 4), (-1.6, -2), (2.0**31 - 1.25, 2**31 - 1), (-(2.0**31) - 0.4, -(2**31))]
)
def test_a_number_becomes_the_nearest_integer(tmp_path, value, integer):
    inner = Constant()
    slave = adapted(tmp_path, "Real", "Integer", "input", inner)
    call(slave, "setter", "Real", value)
    assert slave.exit_initialization() == OK
    assert inner.input == integer
    whole = adapted(tmp_path, "Integer", "Real", "output", Constant(value))
    assert whole.do_step(0.0, 0.1, 1) == OK
    assert call(whole, "getter", "Integer") == (OK, integer)


@pytest.mark.parametrize(("value", "flag"), [(0.0, 0), (0.4, 0), (1.0, 1), (3.0, 1), (-7.0, 1)])
def test_a_boolean_is_0_or_1(tmp_path, value, flag):
    inner = Constant()
    slave = adapted(tmp_path, "Real", "Boolean", "input", inner)
    call(slave, "setter", "Real", value)
    assert slave.exit_initialization() == OK
    assert inner.input == flag


@pytest.mark.parametrize(("kind", "value"), [("Int64", 2**53 + 1), ("Int64", -(2**60) - 1), ("UInt64", 2**64 - 1)])
def test_integers_of_64_bits_between_two_doubles_are_refused(tmp_path, kind, value):
    inner = Constant()
    slave = adapted(tmp_path, kind, kind, "input", inner)
    assert call(slave, "setter", kind, value)[0] == ERROR
    assert slave.outcome("SetInt64", ERROR) == f"port: {value} has more digits than the 53 bits that an adapter keeps"
    assert slave.set_start({0: value}, kind) == ERROR
    out = adapted(tmp_path, kind, kind, "output", Constant(value))
    assert out.do_step(0.0, 0.1, 1) == ERROR
    assert call(slave, "setter", kind, 2**53)[0] == OK
    assert slave.exit_initialization() == OK
    assert inner.input == 2**53


def test_a_number_that_overflows_in_the_conversion_is_refused_and_an_injected_nan_is_passed_on(tmp_path):
    inner = Constant()
    slave = adapted(tmp_path, "Real", "Real", "input", inner, "scale = 1000.0\n")
    call(slave, "setter", "Real", 1e307)
    assert slave.exit_initialization() == ERROR
    assert slave.outcome("", ERROR) == "foreign: is inf after the conversion of [1e+307]"
    slave = adapted(tmp_path, "Real", "Real", "input", inner, "scale = 1000.0\n")
    call(slave, "setter", "Real", np.nan)  # a fault of kind nan: the reaction of the FMU decides
    assert slave.do_step(0.0, 0.1, 1) == OK
    assert np.isnan(inner.input)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_output_that_is_not_finite_reaches_a_real_port_as_it_is(tmp_path, value):
    slave = adapted(tmp_path, "Real", "Real", "output", Constant(value), "scale = 2.0\noffset = 1.0\n")
    assert slave.do_step(0.0, 0.1, 1) == OK
    np.testing.assert_equal(call(slave, "getter", "Real"), (OK, value))  # the master finds it, and names the FMU


@pytest.mark.parametrize(
    ("of_port", "of_fmu", "unit", "bias"),
    [
        (True, True, "", 0.0),
        (True, False, "", -273.15),
        (False, True, "", -273.15),
        (True, False, 'unit = "K"', 0.0),  # the entry says what the FMU's number is: that difference in this unit
        (False, False, 'unit = "K"', 273.15),
    ],
)
def test_offsets_of_units_count_unless_both_ends_are_differences(tmp_path, of_port, of_fmu, unit, bias):
    kelvin, celsius = UNITS["K"], replace(UNITS["K"], name="degC", offset=273.15)
    path = tmp_path / "vendor.toml"
    path.write_text(f'[[input]]\nport = "port"\nvariable = "foreign"\n{unit}')
    port = replace(variable("port", "Real", "input"), unit=celsius if unit else kelvin, relative=of_port)
    foreign = replace(variable("foreign", "Real", "input"), unit=celsius, relative=of_fmu)
    (bound,) = bind(read_adapter(path), {"port": port}, {"foreign": foreign}).inputs

    assert bound.conversion.to_fmu(np.array([300.0])).tolist() == [300.0 + bias]


@pytest.mark.parametrize("version", ["1.0", "2.0", "3.0"])
def test_a_run_ends_with_the_variable_and_the_time(loop, reference_fmu, tmp_path, version):
    """The count times 1e9 fits two times into an Integer; the third value has to end the run, not to be bent."""
    fmu = reference_fmu("feedthrough", version)
    inputs = read_description(Component(name="x", source=fmu, period=1)).variables.values()
    name = "Int32_in" if version == "3.0" else "Integer_in"
    others = [v for v in inputs if v.causality == "input" and v.name != name]
    constants = "".join(f'"{v.name}" = {_constant(v)}\n' for v in others)
    path = tmp_path / "vendor.toml"
    path.write_text(f'ignore = ["*"]\n[[input]]\nport = "u[1]"\nvariable = "{name}"\n[constants]\n{constants}')
    system = replace_component(loop, "echo", fmu, replace(read_adapter(path), step=1_000_000))
    message = rf"^echo: {name}: 3e\+09 does not fit into {name.removesuffix('_in')} at 0\.002 s$"
    system, out = system.with_isolation("echo", version == "2.0"), tmp_path / "out"
    with pytest.raises(InputError, match=r"^echo\.u\[1\]: is connected to counter\.count, so that a value"):
        simulate(system, out, overrides={"echo.u[1]": 5.0})  # also behind an adapter
    with pytest.raises(RunError, match=message):
        simulate(system, out, overrides={"counter.gain": 1e9}, record=["counter.count"])
    assert read_signals(out)["counter.count"].tolist() == [1e9, 2e9]


def _constant(variable):
    return {"String": '""', "Boolean": "false"}.get(variable.type, variable.start or 0)
