"""Static checks of the model description: schema, FMPy's validation, names, variables, experiment."""

from __future__ import annotations

import math
import re
from collections import defaultdict

from lxml import etree  # type: ignore[import-untyped]

from lockstep.check.static.fmu_archive import FmuArchive, unreadable
from lockstep.check.static.model import DEFAULT_INITIAL, NUMBERS, Model, ScalarVariable, duplicates, number
from lockstep.check.static.static_check import CheckOutcome, Notes, check, model_check
from lockstep.errors import InputError, compact
from lockstep.fmi.description_corrections import validation_problems
from lockstep.fmi.model_description import SCHEMAS
from lockstep.system.clock import nanoseconds

_PLAIN = r"[A-Za-z_][A-Za-z0-9_]*"
_QUOTED = r"'(?:[A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+'"
_PART = rf"(?:{_PLAIN}|{_QUOTED})(?:\[\d+(?:,\d+)*\])?"
_PATH = rf"{_PART}(?:\.{_PART})*"
_STRUCTURED = re.compile(rf"{_PATH}|der\({_PATH}(?:,\d+)?\)")  # FMI 2.0.4, 2.2.9


@check("kind", "a co-simulation FMU of FMI 1.0, 2.0 or 3.0 with a readable modelDescription.xml")
def kind(fmu: FmuArchive) -> CheckOutcome:
    """Look at FMI version and interface kinds."""
    reason = unreadable(fmu)
    if reason or fmu.model is None:
        return CheckOutcome(status="error", message=reason)
    model, attributes = fmu.model, fmu.model.attributes
    if model.capabilities is None:
        return CheckOutcome(status="error", message="no CoSimulation element: the FMU is for model exchange only")
    also = ", also for model exchange" if model.root.find("ModelExchange") is not None else ""
    clocks = [clock.get("name", "") for clock in model.root.iterfind("ModelVariables/Clock")]
    if clocks:
        return CheckOutcome(status="error", message=f"has clocks ({compact(clocks)}), which the master cannot drive")
    made_by = attributes.get("generationTool", "an unnamed tool")
    return CheckOutcome(
        status="pass",
        message=f"{attributes.get('modelName', '?')} {attributes.get('version', '')}, made by {made_by}{also}".replace(
            " ,", ","
        ),
        numbers=(("variables", len(model.variables)),),
    )


@model_check("schema", "modelDescription.xml is valid against the schema of its version of FMI")
def schema(model: Model) -> CheckOutcome:
    """Validate against the schema of the standard, with line numbers."""
    rules = etree.XMLSchema(etree.parse(SCHEMAS[model.version]))
    notes = Notes()
    if not rules.validate(model.root):
        for problem in rules.error_log:
            notes.error(f"line {problem.line}: {problem.message}")
    return notes.outcome("valid")


@check("fmpy", "FMPy's validate_fmu has no objection")
def fmpy(fmu: FmuArchive) -> CheckOutcome:
    """Run the validation that most users run."""
    reason = unreadable(fmu)
    if reason:
        return CheckOutcome(status="skipped", message=reason)
    notes = Notes()
    for problem in validation_problems(fmu.path):
        notes.error(" ".join(problem.split()))
    return notes.outcome("no objection")


@model_check("names", "names are unique and follow the declared convention")
def names(model: Model) -> CheckOutcome:
    """Look at the names of the variables."""
    notes = Notes()
    convention = model.attributes.get("variableNamingConvention", "flat")
    given = [variable.name for variable in model.variables]
    for name in duplicates(given):
        notes.error(f"{name}: more than one variable of this name")
    for variable in model.variables:
        if not variable.name.strip() or re.search(r"[\r\n\t]", variable.name):
            notes.error(f"variable {variable.index} (line {variable.line}): {variable.name!r} is not a valid name")
        elif convention == "structured" and not _STRUCTURED.fullmatch(variable.name):
            notes.error(f"{variable.label}: not a structured name, which the file declares")
        elif variable.name != variable.name.strip():
            notes.warning(f"{variable.label}: begins or ends with a blank")
    folded = defaultdict(set)
    for name in given:
        folded[name.casefold()].add(name)
    for alike in folded.values():
        if len(alike) > 1:
            notes.warning(f"{' and '.join(sorted(alike))}: differ in upper and lower case only")
    arrays = [name for name in given if "[" in name]
    if convention == "flat" and arrays:
        notes.info(f"flat names with indices, such as {arrays[0]}: importers will not treat them as arrays")
    return notes.outcome(f"{len(given)} names, {convention}")


@model_check("descriptions", "every port has a description")
def descriptions(model: Model) -> CheckOutcome:
    """Look for ports without a description."""
    ports = [v for v in model.variables if v.causality in ("input", "output", "parameter")]
    without = [v.name for v in ports if not v.description.strip()]
    notes = Notes()
    if without:
        notes.warning(f"{len(without)} of {len(ports)} ports have no description: {compact(without)}")
    if not model.attributes.get("description", "").strip():
        notes.warning("the model has no description")
    return notes.outcome(f"{len(ports)} ports described")


@model_check("variables", "causality, variability, initial and start values fit together")
def variables(model: Model) -> CheckOutcome:
    """Compare every variable with FMI's table of combinations, and its start value with its range."""
    notes = Notes()
    vague = [v.name for v in model.variables if v.type not in ("Real", "") and not v.variability_given]
    if vague:
        notes.warning(
            f"{compact(vague)}: no variability; the default, continuous, is for a Real only; discrete is assumed"
        )
    for variable in model.variables:
        for problem in _combination(variable) if model.version != "1.0" else ():  # which has no such table
            notes.error(f"{variable.label}: {problem}")
        for problem in _range(variable):
            notes.warning(f"{variable.label}: {problem}")
    return notes.outcome(f"{len(model.variables)} variables")


def _combination(variable: ScalarVariable) -> list[str]:
    v, found = variable, []
    default = DEFAULT_INITIAL.get((v.variability, v.causality))
    if default is None:
        return [f"causality {v.causality} with variability {v.variability} is not allowed"]
    if v.variability == "continuous" and v.type not in ("Real", ""):
        found.append(f"a {v.type} cannot be continuous")
    if v.initial_given:
        allowed = {"": (), "exact": ("exact",), "calculated": ("approx", "calculated")}[default]
        if v.causality in ("output", "local") and v.variability in ("discrete", "continuous"):
            allowed = ("exact", "approx", "calculated")
        if v.initial_given not in allowed:
            accepted = " or ".join(allowed) or "none"
            found.append(f"initial={v.initial_given} for a {v.variability} {v.causality}; FMI allows {accepted}")
    needed = v.causality == "input" or v.initial in ("exact", "approx")
    if needed and v.start is None and v.type:
        found.append("a start value is required")
    if v.start is not None and (v.initial == "calculated" or v.causality == "independent"):
        found.append(f"start={v.start} where the value is calculated")
    return found


def _range(variable: ScalarVariable) -> list[str]:
    if variable.type not in NUMBERS:
        return []
    bounds = {name: number(text) for name, text in variable.bounds.items()}
    low, high = bounds.get("min", -math.inf), bounds.get("max", math.inf)
    found = []
    if not low <= high:
        found.append(f"min={low:g} is above max={high:g}")
    if variable.start is not None:
        start = number(variable.start)
        if not math.isfinite(start):
            found.append(f"start={variable.start} is not finite")
        elif not low <= start <= high and low <= high:
            found.append(f"start={start:g} is outside of {low:g} to {high:g}")
    if not bounds.get("nominal", 1.0) > 0.0:
        found.append(f"nominal={bounds['nominal']:g} is not above zero")
    return found


@model_check("aliases", "variables that share a value reference may do so")
def aliases(model: Model) -> CheckOutcome:
    """List variables of the same type and value reference, and whether they contradict each other."""
    groups = defaultdict(list)
    for v in model.variables:
        # an enumeration is read and written by the functions for integers
        groups["Integer" if v.type == "Enumeration" else v.type, v.reference].append(v)
    notes = Notes()
    for (kind_, reference), group in groups.items():
        if len(group) < 2 or not kind_:
            continue
        who = f"{', '.join(v.name for v in group)} (all {kind_} {reference})"
        set_from_outside = [v for v in group if v.causality in ("input", "parameter")]
        started = [v for v in group if v.start is not None and v.variability != "constant"]
        if len(set_from_outside) > 1:
            notes.error(f"{who}: more than one of them is set from outside")
        elif len(started) > 1:
            notes.error(f"{who}: more than one of them has a start value")
        elif len({v.unit for v in group}) > 1:
            notes.error(f"{who}: their units differ")
        elif len({v.variability == "constant" for v in group}) > 1:
            notes.error(f"{who}: constant and not constant")
        else:
            notes.info(f"aliases: {who}")
    return notes.outcome("no aliases")


def _is_exact(step: str) -> bool:
    """Return whether the master can keep this step."""
    try:
        nanoseconds(step, "stepSize")
    except InputError:
        return False
    return True


@model_check("experiment", "the default experiment is usable, and a fixed step is stated")
def experiment(model: Model) -> CheckOutcome:
    """Look at start, stop and step."""
    fixed = not model.can("canHandleVariableCommunicationStepSize")
    declared = model.experiment or {}
    notes = Notes()
    if model.experiment is None:
        notes.info("no DefaultExperiment: users have to guess step and stop time")
    if "stepSize" not in declared and fixed:
        notes.warning(
            "the step cannot vary (canHandleVariableCommunicationStepSize is false), but stepSize is not declared"
        )
    start, stop, step = (number(declared.get(name, "0")) for name in ("startTime", "stopTime", "stepSize"))
    if "stepSize" in declared:
        if not (step > 0.0 and math.isfinite(step)):
            notes.error(f"stepSize={declared['stepSize']} is not above zero")
        elif not _is_exact(declared["stepSize"]):
            notes.info(
                f"stepSize={declared['stepSize']} s is neither a whole number of nanoseconds nor a fraction such as "
                "0.016666666666666666, 1/60: users have to give another one to this master"
            )
    if "stopTime" in declared:
        if not stop > start:
            notes.error(f"stopTime={stop:g} is not after startTime={start:g}")
        elif "stepSize" in declared and step > stop - start:
            notes.warning(f"stepSize={step:g} is longer than the experiment of {stop - start:g} s")
    if "tolerance" in declared and not number(declared["tolerance"]) > 0.0:
        notes.error(f"tolerance={declared['tolerance']} is not above zero")
    steps = f"step {step:g} s, {'fixed' if fixed else 'may vary'}" if step else "no preferred step"
    return notes.outcome(f"{start:g} to {stop:g} s, {steps}" if stop else steps)
