"""Units: conversion between two of them, the table of names, and when a unit's offset applies."""

import math

import pytest

from lockstep.system.transformation import End, Hop, convert
from lockstep.system.unit_table import UNITS, gain_between, meanings
from lockstep.system.units import Unit, conversion, known_unit, without_radian

KELVIN = Unit(name="K", exponents=(0, 0, 0, 0, 1, 0, 0, 0))
CELSIUS = Unit(name="degC", exponents=(0, 0, 0, 0, 1, 0, 0, 0), offset=273.15)
NAMED = Unit(name="rad/s")  # an FMU that gives a name without base units


@pytest.mark.parametrize(
    ("source_relative", "target_relative", "bias"),
    [(False, False, 273.15), (True, False, 273.15), (False, True, 273.15), (True, True, 0.0)],
)
def test_offset_is_left_out_between_two_differences_only(source_relative, target_relative, bias):
    source = End(type="Real", unit=CELSIUS, relative=source_relative)
    target = End(type="Real", unit=KELVIN, relative=target_relative)

    found = convert(source, target, [Hop()], "a -> b")

    assert (found.gain, found.bias) == (1.0, bias)


def test_gain_and_bias_follow_from_factor_and_offset():
    fahrenheit = Unit(name="degF", exponents=KELVIN.exponents, factor=5.0 / 9.0, offset=459.67 * 5.0 / 9.0)

    gain, bias = conversion(fahrenheit, CELSIUS)

    assert gain * 212.0 + bias == pytest.approx(100.0, abs=1e-12)  # rounding of numbers near 400


def test_units_of_other_dimensions_are_refused_by_name():
    with pytest.raises(ValueError, match=r"unit 'N\.m' \[kg\.m2\.s-2\] does not convert to 'rad' \[rad\]"):
        conversion(UNITS["N.m"], UNITS["rad"])


def test_rad_may_be_left_out_between_units_of_one_name_only():
    assert conversion(UNITS["rad/s"], without_radian(UNITS["rad/s"])) == (1.0, 0.0)
    with pytest.raises(ValueError, match="does not convert"):
        conversion(UNITS["rad/s"], Unit(name="1/s", exponents=(0, 0, -1, 0, 0, 0, 0, 0)))


def test_system_file_defines_a_unit_that_the_fmu_only_names():
    assert known_unit(NAMED, UNITS["rad/s"]) == UNITS["rad/s"]
    assert known_unit(None, KELVIN) == KELVIN
    assert known_unit(CELSIUS, KELVIN) == CELSIUS


@pytest.mark.parametrize(
    ("source", "target", "gain"),
    [
        ("deg", "rad", math.pi / 180.0),
        ("rpm", "rad/s", math.pi / 30.0),
        ("rev", "deg", 360.0),
        ("g", "m/s2", 9.80665),
        ("Hz", "rad/s", 2.0 * math.pi),
        ("h", "min", 60.0),
    ],
)
def test_table_converts_by_definition(source, target, gain):
    assert gain_between(UNITS[source], UNITS[target]) == (pytest.approx(gain, rel=1e-15), 0.0)


def test_unit_without_base_units_is_looked_up_by_name():
    assert gain_between(NAMED, UNITS["deg/s"]) == (pytest.approx(180.0 / math.pi, rel=1e-15), 0.0)


def test_names_with_two_meanings_have_the_usual_one_first():
    gravity, gram = meanings("g")
    assert gravity == UNITS["g"]
    assert (gram.factor, gram.exponents) == (1e-3, (1, 0, 0, 0, 0, 0, 0, 0))
    assert [unit.exponents[-1] for unit in meanings("Hz")] == [1, 0]  # radians or periods in a second
    assert meanings("furlong") == ()
