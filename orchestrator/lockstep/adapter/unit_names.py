"""Units that an adapter file may name, by the exponents of their base units."""

from __future__ import annotations

import math

from lockstep.system.units import BASES, Unit, conversion

_DEGREE = math.pi / 180.0
# name: factor to base units, then exponents
_TABLE: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}),
    "%": (0.01, {}),
    "rad": (1.0, {"rad": 1}),
    "mrad": (1e-3, {"rad": 1}),
    "urad": (1e-6, {"rad": 1}),
    "deg": (_DEGREE, {"rad": 1}),
    "arcmin": (_DEGREE / 60.0, {"rad": 1}),
    "arcsec": (_DEGREE / 3600.0, {"rad": 1}),
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
    "m/s2": (1.0, {"m": 1, "s": -2}),
    "mm/s2": (1e-3, {"m": 1, "s": -2}),
    "g": (9.80665, {"m": 1, "s": -2}),  # standard gravity, by definition
    "m/s": (1.0, {"m": 1, "s": -1}),
    "km/s": (1e3, {"m": 1, "s": -1}),
    "m": (1.0, {"m": 1}),
    "mm": (1e-3, {"m": 1}),
    "um": (1e-6, {"m": 1}),
    "km": (1e3, {"m": 1}),
    "s": (1.0, {"s": 1}),
    "ms": (1e-3, {"s": 1}),
    "us": (1e-6, {"s": 1}),
    "A": (1.0, {"A": 1}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "K": (1.0, {"K": 1}),
}
UNITS = {
    name: Unit(name=name, exponents=tuple(powers.get(base, 0) for base in BASES), factor=factor)
    for name, (factor, powers) in _TABLE.items()
}
_RADIAN = BASES.index("rad")


def gain_between(ours: Unit | None, theirs: Unit | None) -> tuple[float, float]:
    """Return (gain, bias) of our value in their unit; the radian need not be among the base units.

    Raises
    ------
    ValueError
        If the units measure different things.
    """
    if ours is None or theirs is None:
        return 1.0, 0.0
    return conversion(_without_radian(_told(ours)), _without_radian(_told(theirs)))


def _told(unit: Unit) -> Unit:
    """Return a unit with exponents, of its name if its definition has none."""
    return UNITS.get(unit.name, unit) if unit.exponents is None else unit


def _without_radian(unit: Unit) -> Unit:
    if unit.exponents is None:
        return unit
    exponents = tuple(0 if i == _RADIAN else e for i, e in enumerate(unit.exponents))
    return Unit(name=unit.name, exponents=exponents, factor=unit.factor, offset=unit.offset)
