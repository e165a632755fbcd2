"""Define every unit of the ports in base units, and the units to display."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # in the order of FMI 2.0, section 2.2.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """An SI unit: exponents of the base units (its factor is one) and display units by name.

    Exponents are None where FMI cannot express them: they are whole numbers there, and modal coordinates are m kg^0.5.
    A display unit's factor multiplies an SI value to give the displayed one.
    """

    exponents: Mapping[str, int] | None = field(default_factory=dict)
    display: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for base in self.exponents or ():
            if base not in BASE_UNITS:
                raise ValueError(f"Unit: no base unit {base!r}; base units are {', '.join(BASE_UNITS)}")


_DEGREE = 180.0 / math.pi

UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        "1": Unit(),
        "rad": Unit(exponents={"rad": 1}, display={"deg": _DEGREE, "arcsec": 3600.0 * _DEGREE}),
        "rad/s": Unit(exponents={"rad": 1, "s": -1}, display={"deg/s": _DEGREE, "rpm": 30.0 / math.pi}),
        "rad/s2": Unit(exponents={"rad": 1, "s": -2}, display={"deg/s2": _DEGREE}),
        "rad/s^1.5": Unit(exponents=None),  # random walk of a rate
        "m": Unit(exponents={"m": 1}, display={"mm": 1e3, "um": 1e6}),
        "m/s": Unit(exponents={"m": 1, "s": -1}, display={"um/s": 1e6}),
        "m/s2": Unit(exponents={"m": 1, "s": -2}),
        "m.kg^0.5": Unit(exponents=None),
        "m.kg^0.5/s": Unit(exponents=None),
        "s": Unit(exponents={"s": 1}, display={"ms": 1e3}),
        "1/s": Unit(exponents={"s": -1}),
        "1/s2": Unit(exponents={"s": -2}),
        "Hz": Unit(exponents={"s": -1}),
        "kg": Unit(exponents={"kg": 1}),
        "kg.m": Unit(exponents={"kg": 1, "m": 1}),
        "kg/m2": Unit(exponents={"kg": 1, "m": -2}),
        "kg.m2": Unit(exponents={"kg": 1, "m": 2}),
        "N": Unit(exponents={"kg": 1, "m": 1, "s": -2}, display={"mN": 1e3}),
        "N.s": Unit(exponents={"kg": 1, "m": 1, "s": -1}),
        "N.m": Unit(exponents={"kg": 1, "m": 2, "s": -2}, display={"mN.m": 1e3}),
        "N.m.s": Unit(exponents={"kg": 1, "m": 2, "s": -1}),
        "m2": Unit(exponents={"m": 2}),
        "N/m2": Unit(exponents={"kg": 1, "m": -1, "s": -2}),
        "T": Unit(exponents={"kg": 1, "s": -2, "A": -1}),
        "A.m2": Unit(exponents={"A": 1, "m": 2}),
        "J": Unit(exponents={"kg": 1, "m": 2, "s": -2}),
        "N.s2/rad2": Unit(exponents={"kg": 1, "m": 1, "rad": -2}),  # force of an imbalance over speed squared
        "N.m.s2/rad2": Unit(exponents={"kg": 1, "m": 2, "rad": -2}),  # torque of an imbalance over speed squared
    }
)


def unit_of(name: str) -> Unit:
    """Return a unit by name; raise ValueError for an unknown one."""
    try:
        return UNITS[name]
    except KeyError:
        raise ValueError(f"unit {name!r} is unknown; known units are {', '.join(UNITS)}") from None
