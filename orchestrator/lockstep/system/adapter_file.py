"""What an adapter file says, as frozen values. `lockstep.adapter.read` reads it, `lockstep.adapter.bind` resolves it.

Every entry describes their values as seen from ours, for inputs and outputs alike, in this order: attitude, frame,
order, then

    theirs = scale * sign * (our value in their unit) + offset

The other direction inverts exactly that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

Number = float | int | bool | str
Matrix = tuple[tuple[float, ...], ...]
Direction = Literal["input", "output"]
ATTITUDES = ("quaternion", "mrp")
SCALARS_AT = ("first", "last")
DIRECTIONS = ("body-from-inertial", "inertial-from-body")


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One array or scalar of theirs and the ports of ours that it stands for."""

    place: str  # for messages: `vendor.toml: input 2 (q_meas[*])`
    direction: Direction  # as seen from the FMU
    ours: tuple[str, ...]  # names of ports or whole arrays, or ranges such as gyro.rate[1..3]
    theirs: tuple[str, ...]  # names; one with a star is an array
    index_base: int = 1  # the number that the star of their first element is
    unit: str | None = None  # theirs; None: what the FMU declares, or ours
    scale: tuple[float, ...] = (1.0,)
    offset: tuple[float, ...] = (0.0,)
    sign: tuple[float, ...] = (1.0,)
    order: tuple[int, ...] | None = None  # theirs[k] is ours[order[k]], counted from 1
    frame: Matrix | None = None  # their axes from our axes
    attitude: str | None = None  # how they represent an attitude: quaternion or mrp
    scalar: str = "last"
    rotation: str = "body-from-inertial"
    body_frame: Matrix | None = None  # their body axes from ours
    inertial_frame: Matrix | None = None  # their inertial axes from ours
    true: float = 1.0  # their numbers for a flag
    false: float = 0.0
    hold: str | None = None  # a Boolean port of ours: new values only while it is true


@dataclass(frozen=True, slots=True, kw_only=True)
class Adapter:
    """A whole file. `constants` and `parameters` name theirs, in their units; patterns in `substitutes` mean ours."""

    path: Path
    sha256: str
    step: int | None = None  # [ns]; None: the period of the component that is replaced
    kind: Literal["sampled", "continuous"] | None = None
    entries: tuple[Entry, ...] = ()
    constants: Mapping[str, Number] = field(default_factory=dict)
    parameters: Mapping[str, Number] = field(default_factory=dict)
    substitutes: Mapping[str, Number] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()  # patterns on their outputs
