"""Read the commanded attitude of a run, for controllers that output no reference of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.arrays import Array
from flexsat.runtime.controller_parameters import CAPTURE_ANGLE
from flexsat.runtime.rotations import rotate_mrp
from lockstep import InputError, load_system
from lockstep.results.run_record import RUN
from lockstep.system.clock import SAME_TIME

ROTATION = tuple(f"command.rotation[{axis}]" for axis in (1, 2, 3))
START_TIME = "command.start_time"


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A rotation vector from where the run begins [rad], commanded from `time` [s] on."""

    time: float
    rotation: tuple[float, float, float]


def command_of(record: Mapping[str, Any], controller: str) -> Command | None:
    """Return what a run commanded its controller, None if it turns by nothing or cannot be known.

    An adapter without a port for the command leaves it out of the record; the system file still has it.
    """
    found = next((c for c in record.get("component", []) if c["name"] == controller), None)
    values = dict(found.get("parameters", {})) if found is not None else {}
    if not any(name in values for name in ROTATION):
        values = _of_system_file(record, controller) | values
    x, y, z = (number_of(values, name) for name in ROTATION)
    if (x, y, z) == (0.0, 0.0, 0.0):
        return None
    return Command(time=number_of(values, START_TIME), rotation=(x, y, z))


def _of_system_file(record: Mapping[str, Any], controller: str) -> dict[str, Any]:
    """Return the values that the system file gives the controller; none if it has changed since the run."""
    about = record.get("system", {})
    path = Path(about.get("path", ""))
    if not path.is_file():
        return {}
    try:
        system = load_system(path)
        if system.sha256 != about.get("sha256"):
            return {}
        return dict(system.component(controller).parameters)
    except InputError:
        return {}


def number_of(parameters: Mapping[str, Any], name: str) -> float:
    """Return a parameter of a record as a number, 0 if it is absent; raise InputError if it is none."""
    value = parameters.get(name, 0.0)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{RUN}: the parameter {name} = {value!r} must be a number; run again, or restore the file")
    return float(value)


def commanded_attitude(time: Array, command: Command | None, initial: Array) -> Array:
    """Return the commanded attitude at times (n,) [s] as MRPs, (n, 3).

    Before the command it is where the run begins: the attitude `initial`, (3,), if that is far from zero, else zero. A
    nearer one is an error to regulate.
    """
    far = 4.0 * float(np.arctan(np.linalg.norm(initial))) > CAPTURE_ANGLE
    base = initial if far else np.zeros(3)
    attitude = np.tile(base, (len(time), 1))
    if command is not None:
        attitude[time >= command.time - SAME_TIME] = rotate_mrp(base.tolist(), command.rotation)
    return attitude
