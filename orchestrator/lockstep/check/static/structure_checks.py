"""Static check of the model structure: outputs, derivatives, initial unknowns and what they depend on."""

from __future__ import annotations

from collections.abc import Sequence

from lockstep.check.static.model import Model, ScalarVariable, Unknown, duplicates
from lockstep.check.static.static_check import CheckOutcome, Notes, model_check
from lockstep.errors import compact

_KINDS = ("dependent", "constant", "fixed", "tunable", "discrete")
_INITIAL_KINDS = ("dependent", "constant")  # the others concern the time after initialisation


@model_check("unknowns", "ModelStructure lists every output and every initial unknown, with valid dependencies")
def unknowns(model: Model) -> CheckOutcome:
    """Compare the lists of ModelStructure with the variables (FMI 2.0.4, 2.2.8)."""
    notes = Notes()
    if model.version == "1.0":
        return CheckOutcome(status="skipped", message="FMI 1.0 has no ModelStructure")
    _entries("Outputs", model.outputs, model, notes)
    _entries("Derivatives", model.derivatives, model, notes)
    _entries("InitialUnknowns", model.initial_unknowns, model, notes)
    _listed("Outputs", model.outputs, [v for v in model.variables if v.causality == "output"], model, notes)
    _listed("InitialUnknowns", model.initial_unknowns, _initial_unknowns(model), model, notes)
    for variable in _variables(model.derivatives, model):
        if not variable.derivative:
            notes.error(f"{variable.label} is listed as a derivative but has no attribute derivative")
    order = [int(entry.index) for entry in model.initial_unknowns if entry.index.isdecimal()]
    if order != sorted(order) and model.version == "2.0":
        notes.error("InitialUnknowns are not in the order of their index")
    _undeclared_dependencies(model, notes)
    message = f"{len(model.outputs)} outputs, {len(model.initial_unknowns)} initial unknowns"
    return notes.outcome(message, (("outputs", len(model.outputs)), ("initial_unknowns", len(model.initial_unknowns))))


def _variable(index: str, model: Model) -> ScalarVariable | None:
    position = int(index) if index.isdecimal() else 0
    return model.variables[position - 1] if 1 <= position <= len(model.variables) else None


def _variables(entries: Sequence[Unknown], model: Model) -> list[ScalarVariable]:
    return [variable for entry in entries if (variable := _variable(entry.index, model)) is not None]


def _initial_unknowns(model: Model) -> list[ScalarVariable]:
    derivatives = _variables(model.derivatives, model)
    states = [state for d in derivatives if (state := _variable(d.derivative, model)) is not None]
    indices = {v.index for v in (*derivatives, *states)}
    return [
        v
        for v in model.variables
        if v.causality == "calculatedParameter"
        or (v.initial in ("approx", "calculated") and (v.causality == "output" or v.index in indices))
    ]


def _listed(tag: str, entries: Sequence[Unknown], wanted: list[ScalarVariable], model: Model, notes: Notes) -> None:
    """Compare a list with what it must hold, no more and no less."""
    listed = {v.index for v in _variables(entries, model)}
    missing = [v.name for v in wanted if v.index not in listed]
    if missing:
        notes.error(f"{tag} lacks {len(missing)} of {len(wanted)}: {compact(missing)}")
    expected = {v.index for v in wanted}
    extra = [v.name for v in model.variables if v.index in listed - expected]
    if extra:
        why = (
            "they are not outputs"
            if tag == "Outputs"
            else "they are known at initialisation, or not unknowns in the sense of FMI"
        )
        notes.error(f"{tag} lists {compact(extra)}, but {why}")
    for index in duplicates([entry.index for entry in entries]):
        variable = _variable(index, model)
        notes.error(f"{tag} lists {variable.name if variable else index} more than once")


def _entries(tag: str, entries: Sequence[Unknown], model: Model, notes: Notes) -> None:
    """Check each entry by itself: indices in range, kinds of equal number, knowns that are known."""
    accepted = _INITIAL_KINDS if tag == "InitialUnknowns" else _KINDS
    size = len(model.variables)
    for entry in entries:
        variable = _variable(entry.index, model)
        if variable is None:
            notes.error(f"{tag} (line {entry.line}): index {entry.index!r} is not in 1 to {size}")
            continue
        who = f"{tag}: {variable.name} (line {entry.line})"
        if entry.kinds is not None and len(entry.kinds) != len(entry.dependencies or ()):
            notes.error(f"{who}: {len(entry.dependencies or ())} dependencies, but {len(entry.kinds)} dependenciesKind")
        strange = sorted(set(entry.kinds or ()) - set(accepted))
        if strange:
            notes.error(f"{who}: dependenciesKind {', '.join(strange)} is not allowed here")
        dependencies = entry.dependencies or ()
        outside = [index for index in dependencies if _variable(index, model) is None]
        if outside:
            notes.error(f"{who}: depends on {', '.join(outside[:4])}, not in 1 to {size}")
        if len(set(dependencies)) < len(dependencies):
            notes.error(f"{who}: a dependency is listed twice")
        knowns = [v for index in dependencies if (v := _variable(index, model)) is not None]
        unknown = [v.name for v in knowns if not _known(v, tag, model)]
        if unknown:
            notes.warning(f"{who}: depends on {compact(unknown, 4)}, which is not a known here according to FMI")


def _known(variable: ScalarVariable, tag: str, model: Model) -> bool:
    if variable.causality in ("input", "independent"):
        return True
    if tag == "InitialUnknowns":
        return variable.initial == "exact"
    states = {entry.derivative for entry in _variables(model.derivatives, model)}
    # without Derivatives a co-simulation FMU has no continuous states to name
    return str(variable.index) in states


def _undeclared_dependencies(model: Model, notes: Notes) -> None:
    undeclared = [
        v.name for e in model.outputs if e.dependencies is None and (v := _variable(e.index, model)) is not None
    ]
    inputs = any(v.causality == "input" for v in model.variables)
    if undeclared and inputs:
        notes.info(
            f"no dependencies declared for {compact(undeclared, 4)}: importers must assume feedthrough from every input"
        )
