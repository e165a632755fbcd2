"""Read the units that an FMU defines, and in which units a value of one of its variables may be written."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from lockstep.errors import suggestion
from lockstep.system.unit_table import UNITS, meanings
from lockstep.system.units import BASES, Unit, conversion, without_radian

_TRUE = ("true", "1")


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayUnit:
    """A unit to show values in: a value in the unit it belongs to is gain * shown + bias."""

    gain: float
    bias: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredUnits:
    """The units that an FMU defines, by name, and the display units of each, by both names."""

    units: Mapping[str, Unit] = field(default_factory=dict)
    display: Mapping[str, Mapping[str, DisplayUnit]] = field(default_factory=dict)


def declared_units(definitions: Any, root: Any) -> DeclaredUnits:
    """Return the units of a model description: fmpy's definitions, and the root of its XML.

    A display unit with a factor of 0, or with the inverse of FMI 3.0, which is not linear, is left out.
    """
    inverse = {
        (d.getparent().get("name"), d.get("name")) for d in root.iter("DisplayUnit") if d.get("inverse") in _TRUE
    }
    display: dict[str, dict[str, DisplayUnit]] = {}
    for unit in definitions:
        for shown in unit.displayUnits:
            factor, offset = float(shown.factor), float(shown.offset)
            linear = factor != 0.0 and math.isfinite(factor) and math.isfinite(offset)
            if linear and (unit.name, shown.name) not in inverse:
                known = display.setdefault(unit.name, {})
                known[shown.name] = DisplayUnit(gain=1.0 / factor, bias=-offset / factor)
    return DeclaredUnits(units={unit.name: _unit(unit) for unit in definitions}, display=display)


def _unit(unit: Any) -> Unit:
    base = unit.baseUnit
    if base is None:
        return Unit(name=unit.name)
    exponents = tuple(int(getattr(base, name)) for name in BASES)
    factor, offset = float(base.factor), float(base.offset)
    if not (math.isfinite(factor) and factor and math.isfinite(offset)):
        return Unit(name=unit.name)  # it converts nothing: it is known by its name alone
    return Unit(name=unit.name, exponents=exponents, factor=factor, offset=offset)


def conversion_from(name: str, unit: Unit, relative: bool, declared: DeclaredUnits) -> tuple[float, float]:
    """Return (gain, bias) with which a value in `unit` = gain * value in the unit of this name + bias.

    The name is that of the unit itself, of one of its display units, of another unit of the FMU, or one of the table.
    A radian counts: an angle is not a number.

    Raises
    ------
    ValueError
        If the name is unknown, or its unit measures something else; with what is accepted.
    """
    if name == unit.name:
        return 1.0, 0.0
    shown = declared.display.get(unit.name, {}).get(name)
    if shown is not None:
        return shown.gain, 0.0 if relative else shown.bias
    target, found = _with_exponents(unit), list(_meanings(name, declared))
    for source in found:
        try:
            return conversion(source, target, relative)
        except ValueError:
            continue
    names = accepted(unit, declared)
    others = f" or in {', '.join(names[1:])}" if len(names) > 1 else ""
    reason = f"does not convert to {unit.name}" if found else "is no unit that is known"
    raise ValueError(f"{name!r} {reason}; give it in {names[0]}{others}{suggestion(name, names)}")


def accepted(unit: Unit, declared: DeclaredUnits) -> list[str]:
    """Return the names of units that values in a unit may be given in, its own first."""
    names = {unit.name: None, **dict.fromkeys(declared.display.get(unit.name, ()))}
    target = _with_exponents(unit)
    if target.exponents is not None:
        known = [*declared.units.values(), *UNITS.values()]
        names |= {other.name: None for other in known if other.exponents == target.exponents}
    return list(names)


def _meanings(name: str, declared: DeclaredUnits) -> Iterator[Unit]:
    own = declared.units.get(name)
    if own is not None and own.exponents is not None:
        yield own
    yield from meanings(name)


def _with_exponents(unit: Unit) -> Unit:
    """Return a unit as the table has it where the file gives none of its base units, or leaves the radian out."""
    for known in meanings(unit.name):
        if unit.exponents is None or (
            without_radian(unit).exponents == without_radian(known).exponents
            and (unit.factor, unit.offset) == (known.factor, known.offset)
        ):
            return known
    return unit
