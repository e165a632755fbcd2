"""What the scripts of the hosts from PyPI share: the loop to close, its first inputs, and how rows are saved.

Runs in the environment of each host, so it needs FMPy and numpy alone.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

START_ORDER = ("plant", "sensors", "controller")  # each starts from outputs of those before it


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """Three FMUs, what they are set to, and how they are connected."""

    fmus: dict[str, str]  # paths by component, in the order of a tick
    values: dict[str, dict[str, Any]]  # parameters and unconnected inputs, by component and name
    connections: list[tuple[str, str, str, str]]  # component, output, component, input
    outputs: dict[str, list[str]]  # real outputs to save, by component
    step: float  # [s] of the host
    ticks: int
    options: dict[str, Any]  # of one host

    @property
    def columns(self) -> list[str]:
        """Return the names of what is saved."""
        return [f"{component}.{output}" for component, outputs in self.outputs.items() for output in outputs]


def read(given: str) -> ClosedLoop:
    """Return the loop that a test describes."""
    return ClosedLoop(**json.loads(Path(given).read_text(encoding="utf-8")))


def run_each(main: Callable[[str, str], None]) -> None:
    """Run each loop that the arguments name, with where to save it: a host takes longer to import than to run it."""
    for given, saved in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        main(given, saved)


def save(saved: str, loop: ClosedLoop, rows: Any) -> None:
    """Save the rows as `hosting.load` reads them."""
    values = np.array(rows, np.float64)
    assert values.shape == (loop.ticks, len(loop.columns)), values.shape
    with Path(saved).open("wb") as stream:
        np.savez(stream, names=np.array(loop.columns), values=values)


class Component:
    """One FMU through FMPy, with its variables by name and of their own types."""

    def __init__(self, path: str) -> None:
        description = read_model_description(path)
        self.variables = {v.name: v for v in description.modelVariables}
        self._folder = extract(path)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)

    def initialize(self, values: dict[str, Any]) -> None:
        """Initialize with these parameters and inputs."""
        self.fmu.enterInitializationMode()
        self.set(values)
        self.fmu.exitInitializationMode()

    def set(self, values: dict[str, Any]) -> None:
        """Set variables by name."""
        setters = {"Real": self.fmu.setReal, "Integer": self.fmu.setInteger, "Boolean": self.fmu.setBoolean}
        for kind, setter in setters.items():
            names = [name for name in values if self.variables[name].type == kind]
            if names:
                setter([self.variables[name].valueReference for name in names], [values[name] for name in names])

    def get(self, names: list[str]) -> dict[str, Any]:
        """Return variables by name."""
        getters = {"Real": self.fmu.getReal, "Integer": self.fmu.getInteger, "Boolean": self.fmu.getBoolean}
        found: dict[str, Any] = {}
        for kind, getter in getters.items():
            chosen = [name for name in names if self.variables[name].type == kind]
            if chosen:
                values = getter([self.variables[name].valueReference for name in chosen])
                found |= zip(chosen, map(bool, values) if kind == "Boolean" else values, strict=True)
        return {name: found[name] for name in names}

    def close(self) -> None:
        """End the instance and remove its files."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)


def first_inputs(loop: ClosedLoop) -> dict[str, dict[str, Any]]:
    """Return the connected inputs at the start, by component and name: the outputs of the others once initialized.

    A host that propagates nothing before its first step needs them as start values.
    """
    inputs: dict[str, dict[str, Any]] = {name: {} for name in loop.fmus}
    for name in START_ORDER:
        component = Component(loop.fmus[name])
        component.initialize(loop.values[name] | inputs[name])
        wires = [wire for wire in loop.connections if wire[0] == name]
        outputs = component.get(list(dict.fromkeys(output for _, output, _, _ in wires)))
        for _, output, to, target in wires:
            inputs[to][target] = outputs[output]
        component.close()
    return inputs
