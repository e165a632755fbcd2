"""Make one FMU of the three components with FMPy's `container_fmu`."""

from __future__ import annotations

from copy import copy
from pathlib import Path
from typing import Any

import fmpy
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration, Connection
from fmpy.model_description import (
    CoSimulation,
    DefaultExperiment,
    ModelDescription,
    ModelVariable,
    Unknown,
)

from lockstep import System

# Order in which FMPy's container transfers values: once before initialisation ends, then after every step.
# The plant's initial outputs come first: the sensors start from them, and the controller from those of the sensors.
ORDER = (("plant", "sensors"), ("sensors", "controller"), ("sensors", "plant"), ("controller", "plant"))
TYPES = {"Real": "Float64", "Boolean": "Boolean"}  # the container's own names, for connections too


class _Mappings(dict[Any, Any]):
    """Container variables to what they stand for; FMPy only walks through the pairs, and its variables do not hash."""

    def __init__(self, pairs: list[tuple[Any, Any]]) -> None:
        super().__init__()
        self.pairs = pairs

    def items(self) -> Any:
        return self.pairs


def build_container(system: System, step: float, folder: Path) -> Path:
    """Return the container of a system's FMUs, its outputs and start values named `component.variable`.

    Parameters
    ----------
    system : of sensors, controller and plant
    step : [s] of all of them, and of the container: it knows one rate
    folder : to make it in
    """
    start_values = {c.name: dict(c.parameters) for c in system.components}
    start_values["sensors"]["step_size"] = step
    components, variables = {}, {}
    for c in system.components:
        description = fmpy.read_model_description(str(c.source))
        components[c.name] = Component(name=c.name, filename=c.source, modelDescription=description)
        variables[c.name] = {v.name: v for v in description.modelVariables}

    # The container counts its variables from 1 and gives the time as 0, whatever `create_container_fmu` writes into the
    # model description, which counts from 0. With the time as its first variable both are right.
    exposed = [
        ModelVariable(
            name="time",
            valueReference=0,
            type="Real",
            causality="independent",
            variability="continuous",
            description="simulation time",
        )
    ]
    # The container reads an output when it is asked for it, after it has set the inputs of the next step, and the
    # plant's accelerations change at once with the torque: what is connected is shown as it arrives.
    arrives = {(w.from_component, w.output): (w.to_component, w.input) for w in system.connections}
    pairs = []
    for name, known in variables.items():
        for variable in known.values():
            if variable.causality != "output" and variable.name not in start_values[name]:
                continue
            own = ModelVariable(name=f"{name}.{variable.name}", valueReference=0)
            own.type, own.description, own.causality = variable.type, variable.description, variable.causality
            own.variability = variable.variability
            if variable.causality == "output":
                own.initial = "calculated"
            else:
                own.causality, own.variability, own.initial = "parameter", "fixed", "exact"
                own.start = _text(start_values[name][variable.name])
            exposed.append(own)
            owner, shown = arrives.get((name, variable.name), (name, variable.name))
            pairs.append((own, [(components[owner], variables[owner][shown])]))

    groups: dict[tuple[str, str, str], tuple[list[Any], list[Any]]] = {}
    for wire in system.connections:
        source = copy(variables[wire.from_component][wire.output])
        key = (wire.from_component, wire.to_component, source.type)
        source.type = TYPES[source.type]
        sources, targets = groups.setdefault(key, ([], []))
        sources.append(source)
        targets.append(variables[wire.to_component][wire.input])
    connections = [
        Connection(components[key[0]], sources, components[key[1]], targets)
        for key, (sources, targets) in sorted(groups.items(), key=lambda group: ORDER.index(group[0][:2]))
    ]

    description = ModelDescription()
    description.fmiVersion, description.modelName = "2.0", "closed_loop"
    description.guid = description.instantiationToken = "{closed-loop}"
    description.variableNamingConvention = "structured"
    description.defaultExperiment = DefaultExperiment(startTime=0.0, stopTime=0.5, stepSize=step)
    description.coSimulation = CoSimulation()
    description.coSimulation.modelIdentifier = "container_fmu"
    description.coSimulation.fixedInternalStepSize = step
    description.coSimulation.canHandleVariableCommunicationStepSize = False
    description.modelVariables = exposed
    description.outputs = [Unknown(variable=v) for v in exposed if v.causality == "output"]
    description.initialUnknowns = list(description.outputs)
    configuration = Configuration(
        parallelDoStep=False,
        modelDescription=description,
        components=list(components.values()),
        connections=connections,
        variableMappings=_Mappings(pairs),
    )
    (folder / "unpacked").mkdir(parents=True)
    create_container_fmu(configuration, folder / "unpacked", folder / "closed_loop.fmu")
    return folder / "closed_loop.fmu"


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(float(value))
