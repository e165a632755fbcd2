"""The units that files may name, and what their names mean. The only table of units of lockstep and flexbench."""

from __future__ import annotations

import math

from lockstep.system.units import BASES, Unit, conversion, without_radian

_DEGREE = math.pi / 180.0
# name: factor to the base units, then their exponents
_TABLE: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}),
    "%": (0.01, {}),
    "rad": (1.0, {"rad": 1}),
    "mrad": (1e-3, {"rad": 1}),
    "urad": (1e-6, {"rad": 1}),
    "nrad": (1e-9, {"rad": 1}),
    "deg": (_DEGREE, {"rad": 1}),
    "arcmin": (_DEGREE / 60.0, {"rad": 1}),
    "arcsec": (_DEGREE / 3600.0, {"rad": 1}),
    "mas": (1e-3 * (_DEGREE / 3600.0), {"rad": 1}),
    "rev": (2.0 * math.pi, {"rad": 1}),
    "rad/s": (1.0, {"rad": 1, "s": -1}),
    "mrad/s": (1e-3, {"rad": 1, "s": -1}),
    "deg/s": (_DEGREE, {"rad": 1, "s": -1}),
    "deg/h": (_DEGREE / 3600.0, {"rad": 1, "s": -1}),
    "arcsec/s": (_DEGREE / 3600.0, {"rad": 1, "s": -1}),
    "rpm": (math.pi / 30.0, {"rad": 1, "s": -1}),
    "Hz": (2.0 * math.pi, {"rad": 1, "s": -1}),
    "rad/s2": (1.0, {"rad": 1, "s": -2}),
    "deg/s2": (_DEGREE, {"rad": 1, "s": -2}),
    "N.m": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "mN.m": (1e-3, {"kg": 1, "m": 2, "s": -2}),
    "uN.m": (1e-6, {"kg": 1, "m": 2, "s": -2}),
    "N.m.s": (1.0, {"kg": 1, "m": 2, "s": -1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "mN": (1e-3, {"kg": 1, "m": 1, "s": -2}),
    "N.s": (1.0, {"kg": 1, "m": 1, "s": -1}),
    "N.s2/rad2": (1.0, {"kg": 1, "m": 1, "rad": -2}),  # force of an imbalance over speed squared
    "N.m.s2/rad2": (1.0, {"kg": 1, "m": 2, "rad": -2}),
    "m/s2": (1.0, {"m": 1, "s": -2}),
    "mm/s2": (1e-3, {"m": 1, "s": -2}),
    "g": (9.80665, {"m": 1, "s": -2}),  # standard gravity, by definition
    "m/s": (1.0, {"m": 1, "s": -1}),
    "um/s": (1e-6, {"m": 1, "s": -1}),
    "km/s": (1e3, {"m": 1, "s": -1}),
    "m": (1.0, {"m": 1}),
    "mm": (1e-3, {"m": 1}),
    "um": (1e-6, {"m": 1}),
    "km": (1e3, {"m": 1}),
    "s": (1.0, {"s": 1}),
    "ms": (1e-3, {"s": 1}),
    "us": (1e-6, {"s": 1}),
    "min": (60.0, {"s": 1}),
    "h": (3600.0, {"s": 1}),
    "1/s": (1.0, {"s": -1}),
    "1/s2": (1.0, {"s": -2}),
    "kg": (1.0, {"kg": 1}),
    "kg/m2": (1.0, {"kg": 1, "m": -2}),
    "kg.m": (1.0, {"kg": 1, "m": 1}),
    "kg.m2": (1.0, {"kg": 1, "m": 2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "A": (1.0, {"A": 1}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "K": (1.0, {"K": 1}),
    "m2": (1.0, {"m": 2}),
    "N/m2": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "T": (1.0, {"kg": 1, "s": -2, "A": -1}),
    "A.m2": (1.0, {"m": 2, "A": 1}),
}
# names that an FMU may also use for another unit; an adapter or a fault means the one above
_ALSO: dict[str, tuple[float, dict[str, int]]] = {
    "g": (1e-3, {"kg": 1}),
    "Hz": (1.0, {"s": -1}),
}


def _unit(name: str, factor: float, powers: dict[str, int]) -> Unit:
    return Unit(name=name, exponents=tuple(powers.get(base, 0) for base in BASES), factor=factor)


UNITS = {name: _unit(name, *meaning) for name, meaning in _TABLE.items()}


def meanings(name: str) -> tuple[Unit, ...]:
    """Return the units that a name stands for, the usual one first; none if it is unknown."""
    return tuple(_unit(name, *table[name]) for table in (_TABLE, _ALSO) if name in table)


def gain_between(source: Unit | None, target: Unit | None, relative: bool = False) -> tuple[float, float]:
    """Return (gain, bias) with which target value = gain * source value + bias; a difference (`relative`) has no bias.

    A unit without exponents is looked up by its name, and the radian need not be among the base units.

    Raises
    ------
    ValueError
        If the units measure different things.
    """
    if source is None or target is None:
        return 1.0, 0.0
    return conversion(without_radian(_with_exponents(source)), without_radian(_with_exponents(target)), relative)


def _with_exponents(unit: Unit) -> Unit:
    return UNITS.get(unit.name, unit) if unit.exponents is None else unit
