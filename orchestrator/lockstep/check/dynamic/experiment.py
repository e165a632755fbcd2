"""How the dynamic checks drive an FMU: its ports, its step size, and a mild stimulus of its inputs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import InputError
from lockstep.fmi.model_description import (
    Description,
    Variable,
    bound_text,
    declared_tolerance,
    parse_description,
    read_description,
)
from lockstep.fmi.platforms import library_path
from lockstep.fmi.slave import DTYPES, SCALARS, Scalar
from lockstep.system.component import Component

PREFIXES = {"1.0": "fmi", "2.0": "fmi2", "3.0": "fmi3"}
SIDES = ("inputs", "outputs")
PERIOD = 37  # steps after which the stimulus repeats; no divisor of usual sampling periods
DEFAULT_STEP = 1e-3  # [s] for an FMU that recommends none
GOLDEN = 0.6180339887498949  # turns between the phases of neighbouring inputs, so that no two are alike


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """An input or an output. Enumerations are driven as integers, as FMI does."""

    name: str
    kind: str  # Real, Integer, Boolean or String
    reference: int
    start: float = 0.0
    minimum: float = -math.inf
    maximum: float = math.inf
    nudge: float = 0.0  # a small change of an input, in its unit
    swings: bool = False  # whether the stimulus moves it, by its nudge; else it keeps its start value
    feeds: tuple[str, ...] | None = None  # of an output: inputs it declares to depend on; None for all
    type: str = ""  # in which its values travel: an Integer of FMI 3.0 may be Int64; empty: the kind

    @property
    def scalar(self) -> Scalar:
        """The type in which its values travel."""
        return self.type or self.kind  # type: ignore[return-value]


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """How one FMU is driven; travels to the processes of the checks as JSON.

    Its groups of ports are made once: each step of a check asks for them, and an FMU may have hundreds of ports.
    """

    identifier: str
    guid: str
    step: float  # [s]
    step_source: str
    start_time: float  # [s]
    any_step: bool
    once_per_process: bool
    saves_state: bool
    serialises_state: bool
    categories: tuple[str, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    stimulated: bool = True  # false leaves every input at its start value
    directory: str = "elsewhere"  # or "unpacked": the only working directory in which it runs
    starts: tuple[tuple[Scalar, int, float | str], ...] = ()  # type, value reference, value: set before initialisation
    fmi: str = "2.0"  # version
    tolerance: float | None = None  # that the FMU declares
    parameters: tuple[Port, ...] = ()  # numbers, Enumerations aside
    most_steps: int | None = None  # after which it asks for the end of the simulation; None: not seen

    @property
    def prefix(self) -> str:
        """The prefix of the functions of its version."""
        return PREFIXES[self.fmi]

    def as_json(self) -> dict[str, Any]:
        """Return what `from_json` reads; it is kept, as each process of a check gets it."""
        return self._fields

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Experiment:
        """Return the experiment that `as_json` wrote."""
        made = {field.name: data[field.name] for field in fields(cls)}
        for name in ("inputs", "outputs", "parameters"):
            made[name] = tuple(
                Port(**{**port, "feeds": None if port["feeds"] is None else tuple(port["feeds"])})
                for port in made[name]
            )
        starts = tuple((kind, int(reference), value) for kind, reference, value in made["starts"])
        return cls(**{**made, "categories": tuple(made["categories"]), "starts": starts})

    def of_kind(self, side: str, kind: str) -> tuple[Port, ...]:
        """Return the inputs or outputs of one type, in the order of the file."""
        return self._kinds.get((side, kind), ())

    def by_type(self, side: str) -> Mapping[Scalar, tuple[Port, ...]]:
        """Return the inputs or outputs that are numbers, by the type in which they travel; each type has some."""
        return self._types[side]

    @cached_property
    def _fields(self) -> dict[str, Any]:
        """All fields, ports as dictionaries."""
        return asdict(self)

    @cached_property
    def _kinds(self) -> dict[tuple[str, str], tuple[Port, ...]]:
        """The inputs and the outputs of each type that there is."""
        kinds: dict[tuple[str, str], list[Port]] = {}
        for side in SIDES:
            for port in getattr(self, side):
                kinds.setdefault((side, port.kind), []).append(port)
        return {key: tuple(ports) for key, ports in kinds.items()}

    @cached_property
    def _types(self) -> dict[str, dict[Scalar, tuple[Port, ...]]]:
        """The inputs and the outputs that are numbers, by the type in which they travel, in the order of the types."""
        found: dict[str, dict[Scalar, tuple[Port, ...]]] = {}
        for side in SIDES:
            numeric = [port for port in getattr(self, side) if port.kind != "String"]
            groups = {scalar: tuple(port for port in numeric if port.scalar == scalar) for scalar in SCALARS}
            found[side] = {scalar: ports for scalar, ports in groups.items() if ports}
        return found

    def stimulus(self, scalar: Scalar, phase: int = 0) -> NDArray[Any]:
        """Return the inputs of one type over one period of the stimulus, (PERIOD, inputs).

        Continuous inputs swing about their start value within their range; the others keep it.
        """
        ports = self.by_type("inputs").get(scalar, ())
        start = np.array([port.start for port in ports])
        swing = np.array([port.nudge * port.swings for port in ports]) * self.stimulated
        turns = (np.arange(PERIOD)[:, None] + phase) / PERIOD + np.arange(len(ports)) * GOLDEN
        values = start + swing * np.sin(2.0 * np.pi * turns)
        low, high = ([getattr(port, side) for port in ports] for side in ("minimum", "maximum"))
        limited: NDArray[Any] = np.clip(values, low, high).astype(DTYPES[scalar])
        return limited

    def time(self, k: int) -> float:
        """Return when step k (from 0) begins [s]."""
        return self.start_time + k * self.step

    def times(self, how: str, steps: int) -> list[tuple[float, float]]:
        """Return time and length of each step [s], as hosts compute them: they differ in their last digits.

        how : "accumulated" by adding the step; "subtracted" when each step is the difference of two times
        """
        if how == "accumulated":
            at = [self.start_time]
            for _ in range(steps - 1):
                at.append(at[-1] + self.step)
            return [(time, self.step) for time in at]
        return [(now, then - now) for now, then in pairwise(self.time(k) for k in range(steps + 1))]


def experiment_of(archive: Path, folder: Path) -> Experiment:
    """Read how to drive an FMU of any version that is unpacked to a folder, or raise InputError."""
    try:
        version = parse_description(str(folder / "modelDescription.xml"), validate=False).fmiVersion[:3]
    except ValueError as error:
        raise InputError(f"bad model description: {error}") from None
    if version not in ("1.0", "3.0"):
        return read_experiment(folder)
    name = "checked"
    try:
        return read_other_experiment(folder, read_description(Component(name=name, source=archive, period=1)))
    except InputError as error:
        raise InputError(str(error).removeprefix(f"{name}: ")) from None


def read_experiment(folder: Path) -> Experiment:
    """Read how to drive an unpacked FMU of FMI 2.0, or raise InputError. A description that is not valid will do."""
    try:
        model = parse_description(str(folder / "modelDescription.xml"), validate=False)
    except ValueError as error:
        raise InputError(f"bad model description: {error}") from None
    interface = model.coSimulation
    if model.fmiVersion != "2.0" or interface is None:
        without = "" if interface else "without co-simulation "
        raise InputError(f"FMI {model.fmiVersion} {without}is not FMI 2.0 co-simulation")
    library = library_path(interface.modelIdentifier, "2.0", lambda inside: (folder / inside).is_file())
    if "/" in interface.modelIdentifier or not (folder / library).is_file():
        raise InputError(f"no binary {library}")
    feeds = {
        unknown.variable.name: None if unknown.dependencies is None else tuple(v.name for v in unknown.dependencies)
        for unknown in model.outputs
    }
    try:
        step, step_source, start = _default_experiment(model.defaultExperiment)
        ports = {
            side: tuple(_port(v, feeds.get(v.name)) for v in model.modelVariables if v.causality == side)
            for side in ("input", "output")
        }
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"bad model description: {error}") from None
    return Experiment(
        identifier=interface.modelIdentifier,
        guid=model.guid or "",
        step=step,
        step_source=step_source,
        start_time=start,
        any_step=bool(interface.canHandleVariableCommunicationStepSize),
        once_per_process=bool(interface.canBeInstantiatedOnlyOncePerProcess),
        saves_state=bool(interface.canGetAndSetFMUstate),
        serialises_state=bool(interface.canSerializeFMUstate),
        categories=tuple(category.name for category in model.logCategories),
        inputs=ports["input"],
        outputs=ports["output"],
        tolerance=declared_tolerance(model),
        parameters=tuple(_parameters(model)),
    )


def read_other_experiment(folder: Path, description: Description) -> Experiment:
    """Read how to drive an unpacked FMU of FMI 1.0 or 3.0; arrays element by element, named as in the description."""
    model = parse_description(str(folder / "modelDescription.xml"), validate=False)
    newer = description.version == "3.0"  # where a value reference is of one variable, whatever its type
    names: dict[tuple[str, int], list[str]] = {}  # of the elements, by type and value reference of their variable
    for variable in description.variables.values():
        key = ("", variable.array) if newer else (variable.type, variable.reference)
        names.setdefault(key, []).append(variable.name)

    def elements(variable: Any) -> list[str]:
        return names.get(("" if newer else variable.type, variable.valueReference), [])

    feeds: dict[str, tuple[str, ...] | None] = {}
    for unknown in model.outputs:
        fed = unknown.dependencies
        declared = None if fed is None else tuple(name for source in fed for name in elements(source))
        feeds |= dict.fromkeys(elements(unknown.variable), declared)
    step, step_source, start = _default_experiment(model.defaultExperiment)
    ports = {
        side: tuple(
            _element_port(v, feeds.get(v.name))
            for v in description.variables.values()
            if v.causality == side and v.scalar
        )
        for side in ("input", "output")
    }
    return Experiment(
        identifier=description.identifier,
        guid=description.guid,
        step=step,
        step_source=step_source,
        start_time=start,
        any_step=bool(getattr(model.coSimulation, "canHandleVariableCommunicationStepSize", False)),
        once_per_process=description.once_per_process,
        saves_state=newer and bool(model.coSimulation.canGetAndSetFMUstate),
        serialises_state=newer and bool(model.coSimulation.canSerializeFMUstate),
        categories=tuple(category.name for category in model.logCategories),
        inputs=ports["input"],
        outputs=ports["output"],
        fmi=description.version,
        tolerance=description.tolerance,
    )


def _default_experiment(default: Any) -> tuple[float, str, float]:
    """Return step size [s], where it is from, and start time [s]."""
    step, start = (_number(getattr(default, name, None), math.nan) for name in ("stepSize", "startTime"))
    usable = math.isfinite(step) and step > 0.0
    source = "default experiment" if usable else "no step recommended"
    return step if usable else DEFAULT_STEP, source, start if math.isfinite(start) else 0.0


def _parameters(model: Any) -> Iterator[Port]:
    """Yield the parameters that can be set to a value nearby; those whose declaration is not valid are left out."""
    for variable in model.modelVariables:
        if variable.causality == "parameter" and variable.type in ("Real", "Integer", "Boolean"):
            with suppress(ValueError, TypeError, OverflowError):
                yield _port(variable)


def _port(variable: Any, feeds: tuple[str, ...] | None = None) -> Port:
    """Make a port of one of fmpy's variables."""
    kind = "Integer" if variable.type == "Enumeration" else variable.type
    if not 0 <= variable.valueReference < 2**32:
        raise ValueError(f"{variable.name}: value reference {variable.valueReference} is not in 0 to 2^32 - 1")
    port = Port(name=variable.name, kind=kind, reference=variable.valueReference, feeds=feeds)
    if kind == "String":
        return port
    low, high = (
        _number(bound_text(variable, name), missing) for name, missing in (("min", -math.inf), ("max", math.inf))
    )
    if not low <= high:
        raise ValueError(f"{variable.name}: min {low} is above max {high}")
    nominal = _number(variable.nominal, 1.0)
    return _numeric(port, variable.start, (low, high), nominal, variable.variability in (None, "continuous"))


def _element_port(variable: Variable, feeds: tuple[str, ...] | None) -> Port:
    """Make a port of a variable, or of an element of an array of FMI 3.0."""
    scalar = str(variable.scalar)
    kind = "Integer" if "Int" in scalar else scalar
    port = Port(name=variable.name, kind=kind, reference=variable.reference, feeds=feeds, type=scalar)
    if kind == "String":
        return port
    low, high = (float(limit) for limit in variable.limits) if kind == "Integer" else (-math.inf, math.inf)
    low = low if variable.minimum is None else variable.minimum
    high = high if variable.maximum is None else variable.maximum
    nominal = _number(variable.nominal, 1.0)
    return _numeric(port, variable.start, (low, high), nominal, variable.variability == "continuous")


def _numeric(port: Port, start_text: Any, limits: tuple[float, float], nominal: float, continuous: bool) -> Port:
    """Return a port with its start value, its range, and the change that the stimulus makes."""
    low, high = limits
    start = min(max(_number(start_text, 0.0), low), high)
    span = high - low
    # a thousandth of the usual size: visible in 64 bits, and small against any range of validity
    nudge = 0.01 * span if math.isfinite(span) else 1e-3 * max(abs(start), abs(nominal))
    real = port.kind == "Real"
    return replace(
        port,
        start=start,
        minimum=low,
        maximum=high,
        nudge=nudge if real else 1.0,
        swings=real and continuous,
    )


def _number(text: Any, missing: float) -> float:
    if text in (None, ""):
        return missing
    if isinstance(text, str) and text.strip() in ("true", "false"):
        return float(text.strip() == "true")
    value = float(text)
    return value if math.isfinite(value) else missing
