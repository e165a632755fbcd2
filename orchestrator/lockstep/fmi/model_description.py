"""Read what co-simulation FMUs of FMI 1.0, 2.0 and 3.0 declare. Instances are made by `lockstep.fmi.instantiate`."""

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import IO, Any

import fmpy

from lockstep.array_names import element_name
from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.fmi.declared_units import DeclaredUnits, declared_units
from lockstep.fmi.description_corrections import correct, negated_aliases, read_root, read_with_fmpy, text_starts
from lockstep.fmi.platforms import PLATFORMS, library_path
from lockstep.fmi.safe_zip import open_file, open_zip, sha256_of
from lockstep.fmi.slave import Scalar
from lockstep.system.component import Component
from lockstep.system.sums import Sums
from lockstep.system.transformation import End
from lockstep.system.units import Unit

SSP_SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
SCHEMAS = {  # of model descriptions, by version of FMI
    "1.0": Path(fmpy.__file__).parent / "schema" / "fmi1" / "fmiModelDescription.xsd",
    "2.0": Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd",
    "3.0": Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3ModelDescription.xsd",
}
VERSION = str(fmpy.__version__)

INTEGERS = {  # smallest and largest value, by FMI's name of the type
    "Integer": (-(2**31), 2**31 - 1),
    **{f"Int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
_SCALARS: Mapping[str, Scalar] = {
    "Real": "Real",
    "Float32": "Real",
    "Float64": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Int8": "Integer",
    "Int16": "Integer",
    "Int32": "Integer",
    "UInt8": "Integer",
    "UInt16": "Integer",
    "UInt32": "Int64",
    "Int64": "Int64",
    "UInt64": "UInt64",
    "Boolean": "Boolean",
    "String": "String",
}
_BOUNDS = ("min", "max")
_MOST_READ = 100  # descriptions that are kept
_read: dict[str, "Description"] = {}  # by digest: loading, planning and starting a system read each FMU several times
_NUMBERS: Mapping[str, Callable[[str], float]] = {"Real": float, "Integer": int, "Enumeration": int}


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """The declaration of one variable, or of one element of an array of FMI 3.0.

    `reference` identifies it among those that travel in the same way: the value reference, or, with FMI 3.0, a
    number given here, since there all elements of an array share the value reference `array`.
    """

    name: str
    reference: int
    type: str  # Real, Integer, Boolean, String, Enumeration; Binary and Clock, which do not travel
    causality: str
    unit: Unit | None = None
    relative: bool = False  # a difference: the unit's offset does not apply
    minimum: float | None = None
    maximum: float | None = None
    nominal: float = 1.0  # usual size of a Real
    description: str = ""
    variability: str = "continuous"
    initial: str = ""  # exact, approx or calculated
    items: Mapping[str, int] = field(default_factory=dict, hash=False)  # of an Enumeration, value by name
    native: str = ""  # the type as FMI 3.0 names it: Float32, UInt8, ...
    array: int = 0
    element: int = 0  # its position in the array from 0, the last index running fastest
    start: str | None = None  # as written in the model description
    display_unit: str = ""  # that tools show its values in
    declared_units: DeclaredUnits = field(default_factory=DeclaredUnits, compare=False, repr=False)  # of its FMU

    @property
    def settable(self) -> bool:
        """Whether a value may be given before initialization."""
        if self.variability == "constant":
            return False
        if self.causality in ("output", "local"):
            return self.initial in ("exact", "approx")
        return self.causality in ("parameter", "input")

    @property
    def scalar(self) -> Scalar | None:
        """The type in which its values travel; None: not at all."""
        if self.native == "Enumeration":
            return "Int64"  # as FMI 3.0 passes them
        return _SCALARS.get(self.native or self.type)

    def end(self, unit: Unit | None) -> End:
        """Return the variable as the end of a connection, in a unit."""
        return End(type=self.type, unit=unit, relative=self.relative, items=self.items)

    @property
    def limits(self) -> tuple[int, int]:
        """The smallest and largest value of an Integer or Enumeration."""
        kind = self.native or self.type
        return INTEGERS[("Int64" if self.native else "Integer") if kind == "Enumeration" else kind]


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """What the master uses of a model description, and the digest of the file it came from."""

    model: str
    guid: str
    identifier: str
    once_per_process: bool
    saves_state: bool  # and restores it in another process
    sha256: str
    variables: Mapping[str, Variable]
    keeps_state: bool = False  # and restores it in this process
    step_size: str | None = None  # of the default experiment [s], as the two below
    start_time: str | None = None
    stop_time: str | None = None
    version: str = "2.0"  # of FMI: 1.0, 2.0 or 3.0
    tolerance: float | None = None  # of the default experiment, if it can be passed
    negated: Mapping[str, str] = field(default_factory=dict)  # of FMI 1.0, not among the variables: alias by name
    needs_tool: bool = False  # runs what it does not contain
    problems: tuple[str, ...] = ()  # offences of the file that the master can do without, each beginning with its name

    @property
    def prefix(self) -> str:
        """How the names of its functions begin."""
        return {"1.0": "fmi", "2.0": "fmi2", "3.0": "fmi3"}[self.version]

    def tolerance_of(self, component: Component) -> float | None:
        """Return the tolerance to pass to the FMU: that of its component, else its own; None if there is none."""
        return self.tolerance if component.tolerance is None else component.tolerance

    def names(self, *causalities: str) -> list[str]:
        """Return the names of the variables of these causalities, in the order of the file."""
        return [v.name for v in self.variables.values() if v.causality in causalities]

    def lacks(self, component: str, name: str, kind: str) -> str:
        """Return the message that there is no such variable, with those that there are."""
        if name in self.negated:
            remedy = f"use {self.negated[name]}, whose sign is the other one"
            return f"{component}.{name}: is a negated alias of FMI 1.0, which is not converted; {remedy}"
        # an input may be given a start value like a parameter, so both are offered
        kinds = ("parameter", "input") if kind == "parameter" else (kind,)
        names = [found for each in kinds for found in self.names(each)]
        there = compact(siblings(name, names)) + suggestion(name, names)
        return f"{component}.{name}: no such {kind}; {component} has {there}"


def read_description(component: Component) -> Description:
    """Read the FMU of a component, or raise InputError."""
    if component.sums is not None:
        return _describe_sums(component.sums)
    with open_file(component.source, component.archive, component.name) as stream:
        digest = sha256_of(stream, on_disk=component.archive is None)
        if digest in _read:
            return _located(_read[digest], component)
        stream.seek(0)
        with open_zip(stream, f"{component.name}: {component.source}") as archive:
            if "modelDescription.xml" not in archive.namelist():
                raise InputError(f"{component.name}: {component.source} is no FMU: it has no modelDescription.xml")
            members = set(archive.namelist())
        stream.seek(0)
        where = f"{component.name}: {component.source}"
        try:
            model, problems = _tolerant_description(stream)
            stream.seek(0)
            root = read_root(stream)
        except ValueError as error:
            raise InputError(f"{where} has a bad model description: {error}") from None
    version = str(model.fmiVersion)[:3]
    if version not in PLATFORMS or model.coSimulation is None:
        kind = f"FMI {model.fmiVersion}" + ("" if model.coSimulation else " without co-simulation")
        raise InputError(f"{where} is {kind}; a co-simulation FMU of FMI {', '.join(PLATFORMS)} is needed")
    clocks = [v.name for v in model.modelVariables if v.type == "Clock"]
    if clocks:
        raise InputError(f"{where} has clocks ({compact(clocks)}), which the master cannot drive; use one without")
    identifier, platform = model.coSimulation.modelIdentifier, PLATFORMS[version]
    if library_path(identifier, version, members.__contains__) not in members:
        there = sorted({m.split("/")[1] for m in members if m.startswith("binaries/") and m.count("/") > 1})
        raise InputError(f"{where} has no binary for {platform}; it has {', '.join(there) or 'none'}")
    negated = negated_aliases(root)
    try:
        units = declared_units(model.unitDefinitions, root)
        if version == "3.0":
            variables = list(_elements(model.modelVariables, units, text_starts(root)))
        else:
            variables = [v for v in _scalars(model, units) if v.name not in negated]
    except (ValueError, OverflowError) as error:  # numbers that are none: the problem found before says where
        raise InputError(f"{where} has a bad model description: {problems[0] if problems else error}") from None
    twice = [name for name, count in Counter(v.name for v in variables).items() if count > 1]
    ports = sorted({v.name for v in variables if v.causality != "local"} & set(twice), key=twice.index)
    if ports:
        raise InputError(f"{where} has {compact(ports)} twice; names must be unique")
    if twice:
        problems += (f"{compact(twice)}: there twice; the last one of a name is used",)
    keeps_state = bool(getattr(model.coSimulation, "canGetAndSetFMUstate", False))
    if len(_read) >= _MOST_READ:
        del _read[next(iter(_read))]
    _read[digest] = Description(
        model=model.modelName,
        guid=model.guid,
        identifier=identifier,
        once_per_process=bool(model.coSimulation.canBeInstantiatedOnlyOncePerProcess),
        saves_state=keeps_state and bool(getattr(model.coSimulation, "canSerializeFMUstate", False)),
        keeps_state=keeps_state,
        sha256=digest,
        variables={v.name: v for v in variables},
        version=version,
        step_size=getattr(model.defaultExperiment, "stepSize", None),
        start_time=getattr(model.defaultExperiment, "startTime", None),
        stop_time=getattr(model.defaultExperiment, "stopTime", None),
        tolerance=declared_tolerance(model),
        negated=negated,
        needs_tool=bool(getattr(model.coSimulation, "needsExecutionTool", False)),
        problems=problems,
    )
    return _located(_read[digest], component)


def _located(description: Description, component: Component) -> Description:
    """Return a description whose problems begin with the component and its file."""
    where = f"{component.name}: {component.source.name}"
    return replace(description, problems=tuple(f"{where}: {problem}" for problem in description.problems))


def _describe_sums(sums: Sums) -> Description:
    """Return what the description of an FMU with these sums would be."""
    inputs = (name for names in sums.inputs.values() for name in names)
    ports = [*((name, "output") for name in sums.inputs), *((name, "input") for name in inputs)]
    variables = {n: Variable(name=n, reference=k, type="Real", causality=c) for k, (n, c) in enumerate(ports)}
    digest = hashlib.sha256(repr(dict(sums.inputs)).encode()).hexdigest()
    return Description(
        model="Sums",
        guid="",
        identifier="",
        once_per_process=False,
        saves_state=True,
        sha256=digest,
        variables=variables,
    )


def _tolerant_description(stream: IO[bytes]) -> tuple[Any, tuple[str, ...]]:
    """Return a model description, and what its validation objects to, if it can be read nevertheless.

    Raises
    ------
    ValueError
        If it cannot, with what the validation said.
    """
    try:
        return parse_description(stream), ()
    except ValueError as error:
        stream.seek(0)
        try:
            model = parse_description(stream, validate=False)
        except ValueError:
            raise error from None
        problems = error.args[1:] or (str(error),)
        more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        return model, (f"modelDescription.xml: {problems[0]}{more}",)


class _BadDescription(ValueError):
    """Its arguments are all problems in one line, then each problem."""

    def __str__(self) -> str:
        return str(self.args[0])


def parse_description(source: Any, *, validate: bool = True) -> Any:
    """Return a model description from an FMU as a stream or from an XML file; raise ValueError with one line.

    It is fmpy's, corrected where fmpy reads it wrongly.
    """
    try:
        model, root = read_with_fmpy(source, validate=validate)
    except Exception as error:  # fmpy raises bare Exception for whatever is wrong in the XML
        problems = (" ".join(str(problem).split()) for problem in getattr(error, "problems", ()))
        raise _BadDescription(" ".join(str(error).split()), *problems) from None
    correct(model, root)
    return model


def declared_tolerance(model: Any) -> float | None:
    """Return the tolerance of the default experiment; None if it is no number > 0, or cannot be passed: FMI 1.0."""
    text = getattr(model.defaultExperiment, "tolerance", None)
    try:
        tolerance = math.nan if text is None or model.fmiVersion == "1.0" else float(text)
    except ValueError:
        return None  # the description need not be valid where it is only checked
    return tolerance if 0.0 < tolerance < math.inf else None


def _scalars(model: Any, units: DeclaredUnits) -> Iterator[Variable]:
    for variable in model.modelVariables:
        yield Variable(
            name=variable.name,
            reference=variable.valueReference,
            type=variable.type,
            start=variable.start,
            **_shared(variable, variable.type, units),
        )


def _elements(variables: Any, units: DeclaredUnits, texts: Mapping[str, list[str]]) -> Iterator[Variable]:
    """Yield the variables of FMI 3.0, arrays element by element, with references counted from 0."""
    reference = 0
    for variable in variables:
        kind = "Real" if variable.type.startswith("Float") else "Integer" if "Int" in variable.type else variable.type
        shared = _shared(variable, kind, units)
        # a String's start is one text, blanks and all; one number is that of all elements
        text = kind == "String" or variable.start is None
        starts = texts.get(variable.name, [variable.start]) if text else variable.start.split()
        size = math.prod(variable.shape)
        if len(starts) not in (1, size):
            raise ValueError(f"{variable.name}: {len(starts)} start values for {size} elements")
        if kind in _NUMBERS and variable.start is not None:
            list(map(_NUMBERS[kind], starts))  # ValueError for what is no number
        for position, index in enumerate(product(*(range(1, size + 1) for size in variable.shape))):
            yield Variable(
                name=element_name(variable.name, index),
                reference=reference,
                type=kind,
                native=variable.type,
                array=variable.valueReference,
                element=position,
                start=starts[0] if len(starts) == 1 else starts[position],
                **shared,
            )
            reference += 1


def _shared(variable: Any, kind: str, units: DeclaredUnits) -> dict[str, Any]:
    if not 0 <= variable.valueReference < 2**32:
        raise ValueError(f"{variable.name}: value reference {variable.valueReference} is not in 0 to 2^32 - 1")
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared else None)
    minimum, maximum = (_bound(variable, bound) if kind in ("Real", "Integer") else None for bound in _BOUNDS)
    return {
        "causality": variable.causality or "local",
        "unit": units.units.get(unit, Unit(name=unit)) if unit else None,
        "display_unit": variable.displayUnit or (declared.displayUnit if declared else None) or "",
        "declared_units": units,
        "relative": _is_relative(variable),
        "minimum": minimum,
        "maximum": maximum,
        "nominal": float(variable.nominal) if kind == "Real" and variable.nominal else 1.0,
        "description": variable.description or "",
        "variability": variable.variability or ("continuous" if kind == "Real" else "discrete"),
        "initial": variable.initial or "",
        "items": {item.name: int(item.value) for item in declared.items} if declared else {},
    }


def _is_relative(variable: Any) -> bool:
    """Return whether a variable is a difference: as it says itself, else as its declared type says."""
    own = variable.relativeQuantity
    return bool(variable.declaredType and variable.declaredType.relativeQuantity) if own is None else bool(own)


def bound_text(variable: Any, name: str) -> str | None:
    """Return `min` or `max` of one of fmpy's variables as written: its own, else that of its declared type."""
    declared = variable.declaredType
    return getattr(variable, name) or (getattr(declared, name) if declared else None)


def _bound(variable: Any, name: str) -> float | None:
    text = bound_text(variable, name)
    return float(text) if text else None
