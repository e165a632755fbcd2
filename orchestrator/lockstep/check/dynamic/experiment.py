"""What of an FMU the dynamic checks drive, and how: its ports, its step, a mild stimulus."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.model_description import read_model_description
from numpy.typing import NDArray

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description, Variable

KINDS = ("Real", "Integer", "Boolean", "String")
PERIOD = 37  # steps after which the stimulus repeats; no divisor of usual sampling periods
DEFAULT_STEP = 1e-3  # [s] for an FMU that recommends none
GOLDEN = 0.6180339887498949  # turns between the phases of neighbouring inputs, so that no two are alike


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """An input or an output. Enumerations are driven as integers, as FMI does."""

    name: str
    kind: str
    reference: int
    start: float = 0.0
    minimum: float = -math.inf
    maximum: float = math.inf
    nudge: float = 0.0  # a small change of an input, in its unit
    swings: bool = False  # whether the stimulus moves it, by its nudge; else it keeps its start value
    feeds: tuple[str, ...] | None = None  # of an output: inputs it declares to depend on; None for all


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """How one FMU is driven; travels to the processes of the checks as JSON."""

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
    starts: tuple[tuple[str, int, float | str], ...] = ()  # type, value reference, value: set before initialisation
    fmi: str = "2.0"  # the others are driven as the master does, see `slave_instance`

    def as_json(self) -> dict[str, Any]:
        """Return what `from_json` reads."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Experiment:
        """Return the experiment that `as_json` wrote."""
        made = {field.name: data[field.name] for field in fields(cls)}
        for name in ("inputs", "outputs"):
            made[name] = tuple(
                Port(**{**port, "feeds": None if port["feeds"] is None else tuple(port["feeds"])})
                for port in made[name]
            )
        starts = tuple((str(kind), int(reference), value) for kind, reference, value in made["starts"])
        return cls(**{**made, "categories": tuple(made["categories"]), "starts": starts})

    def of_kind(self, side: str, kind: str) -> tuple[Port, ...]:
        """Return the inputs or outputs of one type, in the order of the file."""
        return tuple(port for port in getattr(self, side) if port.kind == kind)

    def stimulus(self, kind: str, phase: int = 0) -> NDArray[Any]:
        """Return the inputs of one type over one period of the stimulus, (PERIOD, inputs).

        Continuous inputs swing about their start value within their range; the others keep it.
        """
        ports = self.of_kind("inputs", kind)
        start = np.array([port.start for port in ports])
        swing = np.array([port.nudge * port.swings for port in ports]) * self.stimulated
        turns = (np.arange(PERIOD)[:, None] + phase) / PERIOD + np.arange(len(ports)) * GOLDEN
        values = start + swing * np.sin(2.0 * np.pi * turns)
        low, high = ([getattr(port, side) for port in ports] for side in ("minimum", "maximum"))
        limited: NDArray[np.float64] = np.clip(values, low, high)
        return limited if kind == "Real" else limited.astype(np.int32)

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


def read_experiment(folder: Path) -> Experiment:
    """Read how to drive an unpacked FMU, or raise InputError."""
    try:
        model = read_model_description(str(folder / "modelDescription.xml"), validate=False)
    except Exception as error:  # fmpy raises bare Exception for whatever is wrong in the XML
        raise InputError(f"bad model description: {' '.join(str(error).split())}") from None
    if model.fmiVersion != "2.0" or model.coSimulation is None:
        raise InputError(f"FMI {model.fmiVersion} {'' if model.coSimulation else 'without co-simulation '}is not FMI "
                         "2.0 co-simulation")  # fmt: skip
    interface = model.coSimulation
    binary = f"{interface.modelIdentifier}{fmpy.sharedLibraryExtension}"
    if Path(binary).name != binary or not (folder / "binaries" / fmpy.platform / binary).is_file():
        raise InputError(f"no binary binaries/{fmpy.platform}/{binary}")
    try:
        return _experiment(model, interface)
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"bad model description: {error}") from None


def read_other_experiment(folder: Path, description: Description) -> Experiment:
    """Read how to drive an unpacked FMU of FMI 1.0 or 3.0; arrays element by element, named as in the description."""
    model = read_model_description(str(folder / "modelDescription.xml"), validate=False)
    names: dict[int, list[str]] = {}  # of the elements, by value reference of their variable
    for variable in description.variables.values():
        names.setdefault(variable.array if description.version == "3.0" else variable.reference, []).append(
            variable.name
        )
    feeds: dict[str, tuple[str, ...] | None] = {}
    for unknown in model.outputs:
        fed = unknown.dependencies
        told = None if fed is None else tuple(n for v in fed for n in names.get(v.valueReference, ()))
        feeds |= dict.fromkeys(names.get(unknown.variable.valueReference, ()), told)
    default = model.defaultExperiment
    step, start = (_number(getattr(default, name, None), math.nan) for name in ("stepSize", "startTime"))
    usable = math.isfinite(step) and step > 0.0
    ports = {
        side: tuple(
            _other_port(v, feeds.get(v.name))
            for v in description.variables.values()
            if v.causality == side and v.scalar
        )
        for side in ("input", "output")
    }
    return Experiment(
        identifier=description.identifier,
        guid=description.guid,
        step=step if usable else DEFAULT_STEP,
        step_source="default experiment" if usable else "no step recommended",
        start_time=start if math.isfinite(start) else 0.0,
        any_step=bool(getattr(model.coSimulation, "canHandleVariableCommunicationStepSize", False)),
        once_per_process=description.once_per_process,
        saves_state=False,  # of no use to those who drive it as the master does
        serialises_state=False,
        categories=(),
        inputs=ports["input"],
        outputs=ports["output"],
        fmi=description.version,
    )


def _other_port(variable: Variable, feeds: tuple[str, ...] | None) -> Port:
    kind = {"Int64": "Integer", "UInt64": "Integer"}.get(str(variable.scalar), str(variable.scalar))
    if kind == "String":
        return Port(name=variable.name, kind=kind, reference=variable.reference, feeds=feeds)
    low, high = (float(limit) for limit in variable.limits) if kind == "Integer" else (-math.inf, math.inf)
    low = low if variable.minimum is None else variable.minimum
    high = high if variable.maximum is None else variable.maximum
    start = min(max(_number(variable.start, 0.0), low), high)
    real = kind == "Real"
    nudge = 0.01 * (high - low) if math.isfinite(high - low) else 1e-3 * max(abs(start), 1.0)
    return Port(
        name=variable.name,
        kind=kind,
        reference=variable.reference,
        start=start,
        minimum=low,
        maximum=high,
        nudge=nudge if real else 1.0,
        swings=real and variable.variability == "continuous",
        feeds=feeds,
    )


def _experiment(model: Any, interface: Any) -> Experiment:
    default = model.defaultExperiment
    recommended = float(default.stepSize) if default is not None and default.stepSize else math.nan
    usable = math.isfinite(recommended) and recommended > 0.0
    start = float(default.startTime) if default is not None and default.startTime else 0.0
    feeds = {
        unknown.variable.name: None if unknown.dependencies is None else tuple(v.name for v in unknown.dependencies)
        for unknown in model.outputs
    }
    inputs = tuple(_port(variable) for variable in model.modelVariables if variable.causality == "input")
    return Experiment(
        identifier=interface.modelIdentifier,
        guid=model.guid or "",
        step=recommended if usable else DEFAULT_STEP,
        step_source="default experiment" if usable else "no step recommended",
        start_time=start if math.isfinite(start) else 0.0,
        any_step=bool(interface.canHandleVariableCommunicationStepSize),
        once_per_process=bool(interface.canBeInstantiatedOnlyOncePerProcess),
        saves_state=bool(interface.canGetAndSetFMUstate),
        serialises_state=bool(interface.canSerializeFMUstate),
        categories=tuple(category.name for category in model.logCategories),
        inputs=inputs,
        outputs=tuple(
            _port(variable, feeds.get(variable.name))
            for variable in model.modelVariables
            if variable.causality == "output"
        ),
    )


def _port(variable: Any, feeds: tuple[str, ...] | None = None) -> Port:
    kind = "Integer" if variable.type == "Enumeration" else variable.type
    if not 0 <= variable.valueReference < 2**32:
        raise ValueError(f"{variable.name}: value reference {variable.valueReference} is not in 0 to 2^32 - 1")
    if kind == "String":
        return Port(name=variable.name, kind=kind, reference=variable.valueReference, feeds=feeds)
    declared = variable.declaredType
    low, high = (
        _number(getattr(variable, name) or (getattr(declared, name) if declared else None), missing)
        for name, missing in (("min", -math.inf), ("max", math.inf))
    )
    if not low <= high:
        raise ValueError(f"{variable.name}: min {low} is above max {high}")
    start = min(max(_number(variable.start, 0.0), low), high)
    nominal = _number(variable.nominal, 1.0)
    span = high - low
    # a thousandth of the usual size: visible in 64 bits, and small against any range of validity
    nudge = 0.01 * span if math.isfinite(span) else 1e-3 * max(abs(start), abs(nominal))
    return Port(
        name=variable.name,
        kind=kind,
        reference=variable.valueReference,
        start=start,
        minimum=low,
        maximum=high,
        nudge=nudge if kind == "Real" else 1.0,
        swings=kind == "Real" and variable.variability in (None, "continuous"),
        feeds=feeds,
    )


def _number(text: Any, missing: float) -> float:
    if text in (None, ""):
        return missing
    if isinstance(text, str) and text.strip() in ("true", "false"):
        return float(text.strip() == "true")
    value = float(text)
    return value if math.isfinite(value) else missing
