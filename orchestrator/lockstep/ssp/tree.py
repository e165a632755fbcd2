"""Represent an SSD as a tree of systems and components, before it is flattened."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from lockstep.ssp.annotations import DeclaredSteps
from lockstep.system.clock import Time
from lockstep.system.component import Value
from lockstep.system.transformation import Hop
from lockstep.system.units import Unit

End = tuple[str | None, str]  # element of a system, None for the system itself, and its connector
PortPath = tuple[str, str]  # path of a component or system, and its connector


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """A connector of a component or of a system; its type, unit and items only if they are declared."""

    name: str
    kind: str
    type: str | None = None
    unit: Unit | None = None
    items: Mapping[str, int] = field(default_factory=dict)

    @property
    def gives(self) -> bool | None:
        """Whether values leave an element through it; None: both directions are possible."""
        return None if self.kind == "inout" else self.kind in ("output", "calculatedParameter")


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """A value for a parameter, an input or a connector; `level` is the depth of the element that binds it."""

    name: str
    value: Value
    unit: Unit | None
    hops: tuple[Hop, ...]
    level: int
    origin: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Wire:
    """A connection of a system, in the order of the file: the source follows from the kinds."""

    start: End
    end: End
    hop: Hop
    delay: int | None  # [ticks]
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Leaf:
    """A component that is an FMU."""

    path: str
    source: Path
    archive: Path | None
    ports: Mapping[str, Port]
    steps: DeclaredSteps
    settings: tuple[Setting, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Bus:
    """A reference to a signal dictionary: all with one key share its entries."""

    path: str
    key: str
    ports: Mapping[str, Port]
    entries: Mapping[str, Port]


@dataclass(frozen=True, slots=True, kw_only=True)
class Branch:
    """A system, or a component that refers to one. `tick` is that of a `lockstep` annotation [ns]."""

    path: str
    ports: Mapping[str, Port]
    children: Mapping[str, "Leaf | Bus | Branch"]
    wires: tuple[Wire, ...]
    settings: tuple[Setting, ...] = ()
    tick: Time | None = None

    def leaves(self) -> Iterator[Leaf]:
        """Yield all components below, in the order of the file."""
        for child in self.children.values():
            if isinstance(child, Leaf):
                yield child
            elif isinstance(child, Branch):
                yield from child.leaves()

    def branches(self) -> Iterator["Branch"]:
        """Yield this system and all below."""
        yield self
        for child in self.children.values():
            if isinstance(child, Branch):
                yield from child.branches()


def with_more(branch: Branch, settings: tuple[Setting, ...]) -> Branch:
    """Return a system with the bindings of the component that refers to it after its own."""
    return replace(branch, settings=branch.settings + settings)


def joined(path: str, name: str) -> str:
    """Return the path of an element. A dot in its name becomes a slash: names of components hold no dots."""
    name = name.replace(".", "/")
    return f"{path}/{name}" if path else name
