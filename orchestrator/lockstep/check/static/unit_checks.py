"""Static check of the units: defined, used, and telling the same thing by the same name."""

from __future__ import annotations

import math
from collections import defaultdict

from lockstep.check.static.model import Model, UnitDefinition, duplicates, number
from lockstep.check.static.subject import Notes, Verdict, model_check
from lockstep.errors import compact
from lockstep.system.units import BASES

_PORTS = ("input", "output", "parameter")
# What these names say everywhere: factor to the base units, and exponents of kg, m, s, A, K, mol, cd, rad
_KNOWN: dict[str, tuple[float, tuple[int, ...]]] = {
    "kg": (1.0, (1, 0, 0, 0, 0, 0, 0, 0)),
    "g": (1e-3, (1, 0, 0, 0, 0, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0, 0, 0, 0, 0)),
    "mm": (1e-3, (0, 1, 0, 0, 0, 0, 0, 0)),
    "km": (1e3, (0, 1, 0, 0, 0, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0, 0, 0, 0)),
    "ms": (1e-3, (0, 0, 1, 0, 0, 0, 0, 0)),
    "min": (60.0, (0, 0, 1, 0, 0, 0, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0, 0, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0, 0, 0, 0)),
    "K": (1.0, (0, 0, 0, 0, 1, 0, 0, 0)),
    "rad": (1.0, (0, 0, 0, 0, 0, 0, 0, 1)),
    "deg": (math.pi / 180.0, (0, 0, 0, 0, 0, 0, 0, 1)),
    "rad/s": (1.0, (0, 0, -1, 0, 0, 0, 0, 1)),
    "deg/s": (math.pi / 180.0, (0, 0, -1, 0, 0, 0, 0, 1)),
    "rpm": (math.pi / 30.0, (0, 0, -1, 0, 0, 0, 0, 1)),
    "m/s": (1.0, (0, 1, -1, 0, 0, 0, 0, 0)),
    "m/s2": (1.0, (0, 1, -2, 0, 0, 0, 0, 0)),
    "N": (1.0, (1, 1, -2, 0, 0, 0, 0, 0)),
    "N.m": (1.0, (1, 2, -2, 0, 0, 0, 0, 0)),
    "J": (1.0, (1, 2, -2, 0, 0, 0, 0, 0)),
    "W": (1.0, (1, 2, -3, 0, 0, 0, 0, 0)),
    "Pa": (1.0, (1, -1, -2, 0, 0, 0, 0, 0)),
    "V": (1.0, (1, 2, -3, -1, 0, 0, 0, 0)),
}
_TOLERANCE = 1e-3  # relative: factors are often written with a few digits
_RADIAN = BASES.index("rad")


@model_check("units", "every real port has a unit, defined once, used, and meaning what its name says")
def units(model: Model) -> Verdict:
    """Compare the units that are used with those that are defined."""
    notes = Notes()
    definitions = {definition.unit.name: definition for definition in model.units}
    _ports_without(model, notes)
    _use(model, definitions, notes)
    for name in duplicates([definition.unit.name for definition in model.units]):
        twice = [d for d in model.units if d.unit.name == name]
        contradictory = len({(d.unit.exponents, d.unit.factor, d.unit.offset) for d in twice}) > 1
        lines = " and ".join(str(d.line) for d in twice)
        notes.error(f"unit {name!r} is defined twice (lines {lines}){', differently' if contradictory else ''}")
    for definition in model.units:
        _definition(definition, notes)
    _display_units(model, notes)
    return notes.verdict(f"{len(definitions)} units: {', '.join(definitions) or 'none needed'}")


def _ports_without(model: Model, notes: Notes) -> None:
    real = [v for v in model.variables if v.type == "Real" and v.causality in _PORTS]
    bare = [v.name for v in real if not v.unit]
    if bare:
        notes.warning(f"{len(bare)} of {len(real)} real ports have no unit: {compact(bare)}")


def _use(model: Model, definitions: dict[str, UnitDefinition], notes: Notes) -> None:
    users = defaultdict(list)
    for variable in model.variables:
        if variable.unit:
            users[variable.unit].append(variable.name)
        elif variable.display_unit:
            notes.error(f"{variable.place}: displayUnit={variable.display_unit!r} without a unit")
    for name, (unit, _) in model.type_units.items():
        if unit:
            users[unit].append(f"type {name}")
    for unit, names in users.items():
        if unit not in definitions:
            notes.error(f"unit {unit!r} is used by {compact(names, 4)} but not defined")
    for name in definitions:
        if not name:
            notes.warning(f"line {definitions[name].line} defines a unit without a name")
        elif name not in users:
            notes.warning(f"unit {name!r} (line {definitions[name].line}) is defined but nothing uses it: stale")
    wrong = {(v.unit, v.display_unit) for v in model.variables if v.unit in definitions and v.display_unit}
    for unit, shown in sorted(wrong):
        if shown != unit and shown not in {name for name, _, _ in definitions[unit].display}:
            names = [v.name for v in model.variables if (v.unit, v.display_unit) == (unit, shown)]
            notes.error(f"display unit {shown!r} of {compact(names, 4)} is not defined for unit {unit!r}")


def _definition(definition: UnitDefinition, notes: Notes) -> None:
    unit, line = definition.unit, definition.line
    if unit.exponents is None:
        notes.info(f"unit {unit.name!r} (line {line}) has no BaseUnit: tools can compare it by name only")
        return
    if not (unit.factor > 0.0 and math.isfinite(unit.factor) and math.isfinite(unit.offset)):
        notes.error(f"unit {unit.name!r} (line {line}): factor {unit.factor:g}, offset {unit.offset:g} make no unit")
        return
    known = _known(unit.name)
    if known is None:
        return
    factor, exponents = known
    # the radian is a base unit of FMI's own, and many files leave it out
    if _without_angle(exponents) != _without_angle(unit.exponents) or not _near(unit.factor, factor):
        powers = " ".join(f"{base}={e}" for base, e in zip(BASES, unit.exponents, strict=True) if e) or "no base unit"
        notes.warning(
            f"unit {unit.name!r} (line {line}) is defined as {unit.factor:g} x ({powers}), not what its name says"
        )


def _known(name: str) -> tuple[float, tuple[int, ...]] | None:
    return _KNOWN.get(name.replace("*", ".").replace("^", ""))


def _without_angle(exponents: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(e for i, e in enumerate(exponents) if i != _RADIAN)


def _near(value: float, expected: float) -> bool:
    return abs(value - expected) <= _TOLERANCE * abs(expected)


def _display_units(model: Model, notes: Notes) -> None:
    """A display unit's factor times the value in the unit gives the displayed value."""
    for definition in model.units:
        names = [name for name, _, _ in definition.display]
        for name in duplicates(names):
            notes.error(f"display unit {name!r} of {definition.unit.name!r} is defined twice")
        for name, factor_text, offset_text in definition.display:
            factor, offset = number(factor_text), number(offset_text)
            where = f"display unit {name!r} of {definition.unit.name!r} (line {definition.line})"
            if not (factor > 0.0 and math.isfinite(factor) and math.isfinite(offset)):
                notes.error(f"{where}: factor {factor_text}, offset {offset_text} make no unit")
                continue
            known, base = _known(name), definition.unit
            if known is None or base.exponents is None:
                continue
            expected = base.factor / known[0]
            if _without_angle(known[1]) == _without_angle(base.exponents) and not _near(factor, expected):
                inverse = ", the inverse" if _near(factor, 1.0 / expected) else ""
                notes.warning(f"{where}: factor {factor:g}, expected {expected:g}{inverse}")
