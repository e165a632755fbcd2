"""Describe one FMU of a system: its step times, parameters and connectors, and its adapter and shadow, if any."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from lockstep.errors import InputError
from lockstep.system.adapter_file import Adapter
from lockstep.system.clock import Time, plain_time, seconds_text
from lockstep.system.sums import Sums
from lockstep.system.units import Unit

Value = float | int | bool | str
Kind = Literal["sampled", "continuous"]
DEFAULT_BLEND = 5_000_000_000  # [ns]


@dataclass(frozen=True, slots=True, kw_only=True)
class Connector:
    """A port that a system file declares. The type is one of Real, Integer, Boolean, String, Enumeration.

    `items` are those of the Enumeration that the file declares.
    """

    name: str
    kind: str
    type: str | None = None
    items: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Component:
    """One FMU and when it is stepped. `parameters` also holds start values of inputs.

    The outputs of a `sampled` component hold from the start of its step on, those of a `continuous` one are
    true at the step's end. `units` are those the system file declares, by variable; the FMU's own come first.
    `connectors` are None when nothing was declared, and then every port of the FMU may be connected.
    """

    name: str
    source: Path  # the FMU; inside `archive`, if there is one
    period: Time  # [ns]
    offset: Time = 0  # [ns]
    kind: Kind = "continuous"  # as FMI defines outputs; nothing in an FMU says otherwise
    parameters: Mapping[str, Value] = field(default_factory=dict)
    units: Mapping[str, Unit] = field(default_factory=dict)
    connectors: tuple[Connector, ...] | None = None
    archive: Path | None = None  # the .ssp that holds the FMU
    isolated: bool | None = None  # in a process of its own; None: `lockstep.processes.isolation_policy` decides
    grouped: bool = False  # if isolated: in the process that several FMUs share, as the policy decided
    adapter: Adapter | None = None  # from the FMU to the ports of `stands_for`
    stands_for: "Component | None" = None
    shadow: "Shadow | None" = None  # runs in shadow of it
    tolerance: float | None = None  # relative, of its integration; None: what the FMU declares, if it does
    sums: Sums | None = None  # computed by the master, without an FMU; `source` is then the file that asks for them

    def __post_init__(self) -> None:
        if not self.name or "." in self.name:
            raise InputError(f"component name {self.name!r}: must not be empty nor hold a dot")
        for key in ("period", "offset"):
            object.__setattr__(self, key, plain_time(getattr(self, key), f"{self.name}: {key} [ns]"))
        if self.period <= 0:
            raise InputError(f"{self.name}: period {seconds_text(self.period)} s must be > 0")
        if not 0 <= self.offset < self.period:
            limits = f"[0, {seconds_text(self.period)}) s, the component's period"
            raise InputError(f"{self.name}: offset {seconds_text(self.offset)} s must be in {limits}")
        if self.kind not in ("sampled", "continuous"):
            raise InputError(f"{self.name}: kind {self.kind!r} must be sampled or continuous")
        if self.tolerance is not None and not 0.0 < self.tolerance < math.inf:
            raise InputError(f"{self.name}: tolerance {self.tolerance!r} must be a number > 0, for example 1e-6")


@dataclass(frozen=True, slots=True, kw_only=True)
class Shadow:
    """Describe the FMU that runs in shadow of the component that holds this. Times in ns.

    `component` has the shadow's own period; the component that holds it is stepped at the common divisor of both.
    `outputs` are those of the original that others read, which is what the shadow has to have too.
    """

    component: Component
    period: Time  # of the original
    outputs: tuple[str, ...]
    switchover: Time | None = None  # None: it stays in shadow to the end
    blend: Time = DEFAULT_BLEND

    def __post_init__(self) -> None:
        if self.switchover is not None and self.switchover < 0:
            raise InputError(f"switchover {seconds_text(self.switchover)} s must be >= 0 s")
        if self.blend < 0:
            raise InputError(f"blend {seconds_text(self.blend)} s must be >= 0 s; 0 switches at once")
