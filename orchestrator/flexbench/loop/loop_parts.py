"""Find plant and controller in a system that has flexsat's plant, and the values of their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import ConfigurationName
from flexsat.variants import VARIANT_PORT
from lockstep.fmi.model_description import read_description
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection, System

Parameters = Mapping[str, Mapping[str, Value]]  # that are set, by component and variable
_COUPLED = "wheel.torque"


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopParts:
    """Plant and controller of a system. A controller of others has what it stands for as `ports`."""

    configuration: ConfigurationName
    plant: Component
    controller: Component | None  # what commands the torque, if one component does
    ports: Component | None  # flexsat's controller: itself, or the one that it replaces
    torques: tuple[Connection, ...]  # to the wheels, in their order
    flat: bool  # names without structure

    def name(self, port: str, element: int = 0) -> str:
        """Return the variable of a port, or of its element from 1."""
        return spelled(port, element, self.flat)


def spelled(port: str, element: int, flat: bool) -> str:
    """Return the name of a port's variable, or of an element from 1, in FMUs with structured and flat names."""
    if flat:
        return port.replace(".", "_") + (f"_{element}" if element else "")
    return port + (f"[{element}]" if element else "")


def loop_parts(system: System) -> LoopParts | None:
    """Return the parts of the loop around flexsat's plant; None for a system without it, or with several."""
    models = [(component, _model(component, "plant")) for component in system.components]
    found = [(c, model.removeprefix("plant_")) for c, model in models if model and _is_plant(c, model)]
    if len(found) != 1:
        return None
    ((plant, name),) = found
    description = read_description(plant)
    flat = description.model.endswith("_flat")
    count = 1
    while spelled(_COUPLED, count, flat) in description.variables:
        count += 1
    into = {c.input: c for c in system.connections if c.to_component == plant.name}
    names = [spelled(_COUPLED, k, flat) for k in range(1, count)]
    torques = tuple(into[one] for one in names if one in into)
    sources = {one.from_component for one in torques}
    controller = system.component(sources.pop()) if len(torques) == len(names) and len(sources) == 1 else None
    ports = None if controller is None else controller.stands_for or controller
    if ports is not None and _model(ports, "controller") != f"controller_{name}":
        ports = None
    return LoopParts(configuration=name, plant=plant, controller=controller, ports=ports, torques=torques, flat=flat)


def _is_plant(component: Component, model: str) -> bool:
    """Return whether a model called plant_<name> is flexsat's: a built-in one, or one with the parameters of these."""
    return model.removeprefix("plant_") in CONFIGURATIONS or VARIANT_PORT in read_description(component).variables


def _model(component: Component, part: str) -> str:
    """Return the model of a component's FMU if its name may be that of a part of the loop."""
    model = read_description(component).model.removesuffix("_flat")
    return model if component.sums is None and model.startswith(f"{part}_") else ""


def values_of(component: Component, names: Sequence[str], parameters: Parameters) -> list[str | Value | None]:
    """Return the values of parameters in a run: what is set, else the FMU's own; None for one that there is not."""
    variables, given = read_description(component).variables, parameters.get(component.name, {})
    return [given.get(name, variables[name].start) if name in variables else None for name in names]


def numbers_of(component: Component, names: Sequence[str], parameters: Parameters) -> list[float | None]:
    """Return the values of Reals in a run, None for one that there is not."""
    return [None if value is None else float(value) for value in values_of(component, names, parameters)]


def number_of(component: Component, name: str, parameters: Parameters) -> float | None:
    """Return the value of a Real in a run, None if there is none."""
    return numbers_of(component, [name], parameters)[0]


def flag_of(component: Component, name: str, parameters: Parameters) -> bool:
    """Return the value of a Boolean in a run; one that the component lacks is false."""
    (value,) = values_of(component, [name], parameters)
    return value.strip().lower() in ("true", "1") if isinstance(value, str) else bool(value)
