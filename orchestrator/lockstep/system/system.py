"""Describe a system: components and the connections between them, as frozen values."""

from dataclasses import dataclass, replace
from pathlib import Path

from lockstep.errors import InputError, compact, suggestion
from lockstep.plain_values import plain_number, plain_whole
from lockstep.system.clock import Time, plain_time, seconds_text
from lockstep.system.component import Component
from lockstep.system.transformation import Hop, Table
from lockstep.system.units import Unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """One scalar from an output to an input; the consumer sees the value of `delay` ticks ago (0: this tick).

    The consumer receives factor * value + offset, or the value of the table, after the conversion of units. `via` are
    the transformations before that, along connectors of systems.
    """

    from_component: str
    output: str
    to_component: str
    input: str
    delay: int = 0  # [ticks]
    factor: float = 1.0
    offset: float = 0.0
    convert_units: bool = True
    table: Table | None = None
    via: tuple[Hop, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "delay", plain_whole(self.delay, f"{self}: delay [ticks]"))
        for key in ("factor", "offset"):
            object.__setattr__(self, key, plain_number(getattr(self, key), f"{self}: {key}"))
        if self.delay < 0:
            raise InputError(f"{self}: delay {self.delay} must be >= 0 ticks")

    @property
    def hops(self) -> tuple[Hop, ...]:
        """All transformations in order, for `lockstep.system.transformation.convert`."""
        last = Hop(factor=self.factor, offset=self.offset, table=self.table, convert_units=self.convert_units)
        return (*self.via, last)

    def __str__(self) -> str:
        return f"{self.from_component}.{self.output} -> {self.to_component}.{self.input}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Feed:
    """An input fed by a connector of the whole system, and the transformations between them."""

    component: str
    input: str
    hops: tuple[Hop, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemInput:
    """An unconnected connector of the whole system, which needs a value; `unit` if one is declared."""

    name: str
    unit: Unit | None
    feeds: tuple[Feed, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemPort:
    """A connector of the whole system and the variable that it leads to, or comes from; of kind input or output.

    It is for hosts that connect the system to others: this master keeps the value of the component for such an input.
    Several of one name are one input that feeds several components.
    """

    name: str
    kind: str
    component: str
    variable: str


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class System:
    """A whole system. Times are exact nanoseconds; `record` holds patterns on `component.variable`.

    `ignored` are the values of a system file that have no variable, for display; `start_values` the connected inputs to
    which one gives a value that counts at initialization only, where the producer comes later. `warnings` are
    what was amended in the file, `ports` its connectors to the outside. With `strict_inputs` every input has to be
    connected or have a value; without, an input keeps its FMU's start value.
    """

    name: str
    tick: Time  # [ns]
    components: tuple[Component, ...]
    connections: tuple[Connection, ...] = ()
    stop_time: Time | None = None  # [ns]
    record: tuple[str, ...] = ("all",)
    record_period: Time | None = None  # [ns]; None: the tick
    path: Path | None = None  # where it was read from
    sha256: str | None = None  # of that file
    inputs: tuple[SystemInput, ...] = ()
    ignored: tuple[str, ...] = ()
    start_values: tuple[str, ...] = ()  # `component.input`
    strict_inputs: bool = False
    warnings: tuple[str, ...] = ()
    ports: tuple[SystemPort, ...] = ()
    start_time: Time = 0  # [ns]; simulated time begins there, and the stop time counts from 0

    def __post_init__(self) -> None:
        for key in ("tick", "stop_time", "record_period", "start_time"):
            if (value := getattr(self, key)) is not None:
                object.__setattr__(self, key, plain_time(value, f"system {self.name}: {key} [ns]"))
        if self.tick <= 0:
            raise InputError(f"system {self.name}: tick {seconds_text(self.tick)} s must be > 0")
        if not self.components:
            raise InputError(f"system {self.name}: no components")
        names = [component.name for component in self.components]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise InputError(f"system {self.name}: component {twice[0]} is there twice; names must be unique")
        for port in self.ports:
            if port.component not in names:
                raise InputError(f"connector {port.name} of the system: {_no_component(port.component, names)}")
            if port.kind not in ("input", "output"):
                raise InputError(f"connector {port.name} of the system: kind {port.kind!r} must be input or output")
        fed: dict[tuple[str, str], Connection] = {}
        known = set(names)
        for connection in self.connections:
            for end in (connection.from_component, connection.to_component):
                if end not in known:
                    raise InputError(f"{connection}: {_no_component(end, names)}")
            first = fed.setdefault((connection.to_component, connection.input), connection)
            if first is not connection:
                source = f"{first.from_component}.{first.output}"
                raise InputError(f"{connection}: the input is already connected to {source}; remove one of them")

    def __repr__(self) -> str:
        """Describe the system in one line."""
        names = compact([component.name for component in self.components], 4)
        return f"<System {self.name}: {names}; {len(self.connections)} connections, tick {seconds_text(self.tick)} s>"

    def component(self, name: str) -> Component:
        """Return the component of that name, or raise InputError."""
        for component in self.components:
            if component.name == name:
                return component
        raise InputError(_no_component(name, [component.name for component in self.components]))

    def without(self, component: str) -> "System":
        """Return the system without a component and its connections: the inputs that it fed can be set then."""
        self.component(component)
        start = f"{component}."
        return replace(
            self,
            components=tuple(c for c in self.components if c.name != component),
            connections=tuple(c for c in self.connections if component not in (c.from_component, c.to_component)),
            record=tuple(p for p in self.record if not p.rpartition(":")[2].startswith(start)) or ("all",),
            inputs=tuple(one for one in self.inputs if all(feed.component != component for feed in one.feeds)),
            start_values=tuple(name for name in self.start_values if not name.startswith(start)),
            ports=tuple(port for port in self.ports if port.component != component),
            strict_inputs=False,  # those that it fed have no value yet
        )

    def with_delay(self, from_component: str, to_component: str, ticks: int) -> "System":
        """Return the system with this delay on every connection between two components."""
        self.component(from_component), self.component(to_component)
        ends = (from_component, to_component)
        if not any((c.from_component, c.to_component) == ends for c in self.connections):
            raise InputError(f"{from_component} -> {to_component}: no such connection, so it cannot have a delay")
        changed = (
            replace(c, delay=ticks) if (c.from_component, c.to_component) == ends else c for c in self.connections
        )
        return replace(self, connections=tuple(changed))

    def with_every_delay(self, ticks: int) -> "System":
        """Return the system with this delay on all connections."""
        return replace(self, connections=tuple(replace(c, delay=ticks) for c in self.connections))

    def with_start_time(self, start_time: Time) -> "System":
        """Return the system with another start time [ns]."""
        return replace(self, start_time=start_time)

    def with_period(self, component: str, period: Time) -> "System":
        """Return the system with another period [ns] of one component."""
        self.component(component)
        changed = (replace(c, period=period) if c.name == component else c for c in self.components)
        return replace(self, components=tuple(changed))

    def with_isolation(self, component: str, isolated: bool | None) -> "System":
        """Return the system with one component in a process of its own, or in the master's."""
        self.component(component)
        changed = (replace(c, isolated=isolated) if c.name == component else c for c in self.components)
        return replace(self, components=tuple(changed))


def _no_component(name: str, names: list[str]) -> str:
    return f"{name}: no such component; there are {compact(names)}{suggestion(name, names)}"
