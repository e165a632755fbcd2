"""Static check of the units: defined, used, and with the base units that their names mean."""

from __future__ import annotations

import math
from collections import defaultdict

from lockstep.check.static.model import Model, UnitDefinition, duplicates, number
from lockstep.check.static.static_check import CheckOutcome, Notes, model_check
from lockstep.errors import compact
from lockstep.system.unit_table import meanings
from lockstep.system.units import BASES, Unit, without_radian

_PORTS = ("input", "output", "parameter")
_TOLERANCE = 1e-3  # relative: factors are often written with a few digits


@model_check("units", "every real port has a unit, and units are defined once, used, and as their names say")
def units(model: Model) -> CheckOutcome:
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
    return notes.outcome(f"{len(definitions)} units: {', '.join(definitions) or 'none needed'}")


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
            notes.error(f"{variable.label}: displayUnit={variable.display_unit!r} without a unit")
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
            notes.warning(f"unit {name!r} (line {definitions[name].line}) is defined but not used")
    wrong = {(v.unit, v.display_unit) for v in model.variables if v.unit in definitions and v.display_unit}
    for unit, shown in sorted(wrong):
        if shown != unit and shown not in {name for name, _, _ in definitions[unit].display}:
            names = [v.name for v in model.variables if (v.unit, v.display_unit) == (unit, shown)]
            notes.error(f"display unit {shown!r} of {compact(names, 4)} is not defined for unit {unit!r}")


def _definition(definition: UnitDefinition, notes: Notes) -> None:
    unit, line = definition.unit, definition.line
    if unit.exponents is None:
        notes.info(f"unit {unit.name!r} (line {line}) has no BaseUnit: tools can compare only its name")
        return
    if not (unit.factor > 0.0 and math.isfinite(unit.factor) and math.isfinite(unit.offset)):
        notes.error(f"unit {unit.name!r} (line {line}): factor {unit.factor:g}, offset {unit.offset:g} are not valid")
        return
    known = _known(unit.name)
    # the radian is a base unit of FMI's own, and many files leave it out
    if known and not any(_same_dimension(one, unit) and _near(unit.factor, one.factor) for one in known):
        powers = " ".join(f"{base}={e}" for base, e in zip(BASES, unit.exponents, strict=True) if e) or "no base unit"
        notes.warning(
            f"unit {unit.name!r} (line {line}) is defined as {unit.factor:g} x ({powers}), not what its name says"
        )


def _known(name: str) -> tuple[Unit, ...]:
    return meanings(name.replace("*", ".").replace("^", ""))


def _same_dimension(one: Unit, other: Unit) -> bool:
    return without_radian(one).exponents == without_radian(other).exponents


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
                notes.error(f"{where}: factor {factor_text}, offset {offset_text} are not valid")
                continue
            base = definition.unit
            known = [one for one in _known(name) if base.exponents is not None and _same_dimension(one, base)]
            expected = [base.factor / one.factor for one in known]
            if expected and not any(_near(factor, one) for one in expected):
                inverse = ", the inverse" if any(_near(factor, 1.0 / one) for one in expected) else ""
                notes.warning(f"{where}: factor {factor:g}, expected {expected[0]:g}{inverse}")
