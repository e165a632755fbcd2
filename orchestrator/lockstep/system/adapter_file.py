"""Hold the contents of an adapter file as frozen values. `lockstep.adapter.read` reads it, `bind` binds it.

Each entry gives the value of an FMU variable as a function of that of an interface port, for inputs and outputs
alike. The steps, in this order: attitude, frame, order, then

    variable = scale * sign * (port in the unit of the variable) + offset

The other direction is the exact inverse.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from lockstep.system.clock import Time

Number = float | int | bool | str
Matrix = tuple[tuple[float, ...], ...]
Direction = Literal["input", "output"]
ATTITUDES = ("quaternion", "mrp")
SCALARS_AT = ("first", "last")
DIRECTIONS = ("body-from-inertial", "inertial-from-body")


@dataclass(frozen=True, slots=True, kw_only=True)
class AdapterEntry:
    """One array or scalar of the FMU and the interface ports that it stands for."""

    location: str  # for messages: `vendor.toml: input 2 (q_meas[*])`
    direction: Direction  # as seen from the FMU
    ports: tuple[str, ...]  # names of interface ports or whole arrays, or ranges such as gyro.rate[1..3]
    variables: tuple[str, ...]  # names of FMU variables; one with a star is an array
    index_base: int = 1  # the number for which the star of the first element stands
    unit: str | None = None  # of the FMU variable; None: what the FMU declares, or the unit of the port
    scale: tuple[float, ...] = (1.0,)
    offset: tuple[float, ...] = (0.0,)
    sign: tuple[float, ...] = (1.0,)
    order: tuple[int, ...] | None = None  # element k of the variable is element order[k] of the port, from 1
    frame: Matrix | None = None  # the FMU's axes from the port's axes
    attitude: str | None = None  # the FMU's representation of an attitude: quaternion or mrp
    scalar: str = "last"
    rotation: str = "body-from-inertial"
    body_frame: Matrix | None = None  # the FMU's body axes from the port's
    inertial_frame: Matrix | None = None  # the FMU's inertial axes from the port's
    true: float = 1.0  # the FMU's numbers for a flag
    false: float = 0.0
    hold: str | None = None  # a Boolean port: new values only while it is true


@dataclass(frozen=True, slots=True, kw_only=True)
class Adapter:
    """A whole file. `constants` and `parameters` name FMU variables, in their units; `substitutes` name ports."""

    path: Path
    sha256: str
    step: Time | None = None  # [ns]; None: the period of the component that is replaced
    kind: Literal["sampled", "continuous"] | None = None
    entries: tuple[AdapterEntry, ...] = ()
    constants: Mapping[str, Number] = field(default_factory=dict)
    parameters: Mapping[str, Number] = field(default_factory=dict)
    substitutes: Mapping[str, Number] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()  # patterns on outputs of the FMU
