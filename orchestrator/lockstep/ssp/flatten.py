"""Flatten a tree of systems: the paths from component to component, and the values that reach their variables.

The source of a connection follows from the kinds of its connectors, not from the order in the file: outputs of elements
and inputs of the enclosing system are sources. A connector of a system passes its value on, and an entry of a signal
dictionary passes it to all that refer to it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from lockstep.errors import InputError, compact, suggestion
from lockstep.ssp.tree import Branch, Bus, End, Leaf, Port, PortPath, Setting, Wire
from lockstep.system.transformation import Hop


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """All hops from an output of a component, or from a connector of a system that nothing feeds, to an input.

    The hops lead to the connectors that it passes, the last one to its end.
    """

    start: PortPath
    end: PortPath
    hops: tuple[Hop, ...]
    delay: int | None  # [ticks], summed over the connections that declare one
    passed: tuple[PortPath, ...]  # connectors of systems on the way, the nearest to the start first

    @property
    def via(self) -> tuple[Hop, ...]:
        """All hops but the last, without those that change nothing."""
        return tuple(hop for hop in self.hops[:-1] if hop != Hop())

    def __str__(self) -> str:
        return f"{_text(self.start)} -> {_text(self.end)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Feed:
    source: PortPath
    wire: Wire


def _key(owner: Leaf | Bus | Branch) -> str:
    return owner.key if isinstance(owner, Bus) else owner.path


def _text(path: PortPath) -> str:
    return f"{path[0]}.{path[1]}" if path[0] else path[1]


def ways(tree: Branch) -> tuple[list[Way], list[Way]]:
    """Return the paths that begin at a component, and those that begin at a connector of a system.

    Raises
    ------
    InputError
        If two outputs or two inputs are connected, an input is fed twice, or systems' connectors feed each other.
    """
    feeds: dict[PortPath, _Feed] = {}
    ports: dict[PortPath, Port] = {}
    owners: dict[str, Leaf | Bus | Branch] = {}
    inputs: list[PortPath] = []
    for branch in tree.branches():
        owners[branch.path] = branch
        owners |= {_key(child): child for child in branch.children.values()}
        for wire in branch.wires:
            source, target = _directed(wire, branch)
            first = feeds.setdefault(target, _Feed(source=source, wire=wire))
            if first.wire is not wire:
                raise InputError(
                    f"{wire.what}: the input is already connected to {_text(first.source)}; remove one of them"
                )
            if isinstance(owners[target[0]], Leaf):
                inputs.append(target)
    for key, owner in owners.items():
        found_ports = owner.entries if isinstance(owner, Bus) else owner.ports
        ports |= {(key, name): port for name, port in found_ports.items()}
    found = [_traced(target, feeds, ports) for target in inputs]
    return (
        [way for way in found if isinstance(owners[way.start[0]], Leaf)],
        [way for way in found if not isinstance(owners[way.start[0]], Leaf)],
    )


def _directed(wire: Wire, branch: Branch) -> tuple[PortPath, PortPath]:
    """Return source and target of a connection inside `branch`."""

    def path(end: End) -> tuple[PortPath, bool | None]:
        owner = branch if end[0] is None else branch.children[end[0]]
        gives = owner.ports[end[1]].gives
        return (_key(owner), end[1]), (not gives if end[0] is None and gives is not None else gives)

    (start, start_gives), (end, end_gives) = path(wire.start), path(wire.end)
    if start_gives is None and end_gives is None:
        raise InputError(f"{wire.what}: both ends may be the source; give one of them the kind input or output")
    start_gives = not end_gives if start_gives is None else start_gives
    end_gives = not start_gives if end_gives is None else end_gives
    if start_gives == end_gives:
        side = "sources" if start_gives else "inputs"
        raise InputError(f"{wire.what}: both ends are {side}; connect an output to an input")
    return (start, end) if start_gives else (end, start)


def _traced(target: PortPath, feeds: dict[PortPath, _Feed], ports: dict[PortPath, Port]) -> Way:
    hops: list[Hop] = []
    delays: list[int] = []
    passed: list[PortPath] = []
    here = target
    while here in feeds:
        if here in passed:
            raise InputError(f"{_text(target)}: the connectors {compact(map(_text, passed))} feed each other")
        if here != target:
            passed.insert(0, here)
        feed, port = feeds[here], ports[here]
        hops.insert(0, replace(feed.wire.hop, type=port.type, unit=port.unit, items=port.items))
        if feed.wire.delay is not None:
            delays.append(feed.wire.delay)
        here = feed.source
    return Way(
        start=here,
        end=target,
        hops=tuple(hops),
        delay=sum(delays) if delays else None,
        passed=tuple(passed),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Settled:
    """Hold the valid settings, by variable of a component or connector of a system, and those without a variable."""

    values: dict[PortPath, Setting]
    ignored: tuple[Setting, ...]


def settle(tree: Branch, has: Callable[[Leaf, str], bool]) -> Settled:
    """Apply all bindings: those of enclosing systems override those of the elements inside.

    A name is that of a connector of the system itself, or `element.name` what `name` stands for in that element; if it
    stands for several, all are set. `has` returns whether a component has a variable.
    """
    values: dict[PortPath, Setting] = {}
    ignored: list[Setting] = []
    _settle(tree, values, ignored, has)
    return Settled(values=values, ignored=tuple(ignored))


def _settle(
    node: Leaf | Bus | Branch, values: dict[PortPath, Setting], ignored: list[Setting], has: Callable[[Leaf, str], bool]
) -> None:
    if isinstance(node, Bus):
        return
    if isinstance(node, Branch):
        for child in node.children.values():
            _settle(child, values, ignored, has)
    for setting in node.settings:
        targets = list(_meant(node, setting.name, has))
        values |= dict.fromkeys(targets, setting)
        if not targets:
            ignored.append(setting)


def _meant(node: Leaf | Bus | Branch, name: str, has: Callable[[Leaf, str], bool]) -> Iterator[PortPath]:
    if isinstance(node, Leaf):
        if has(node, name):
            yield node.path, name
        return
    if isinstance(node, Bus):
        return
    if name in node.ports:
        yield node.path, name
    for element, child in node.children.items():
        if name.startswith(f"{element}."):
            yield from _meant(child, name.removeprefix(f"{element}."), has)


def refuse_ignored(settled: Settled, tree: Branch) -> None:
    """Raise InputError for a value without a variable: in a file with `lockstep` annotations that is an error."""
    for setting in settled.ignored:
        element = setting.name.partition(".")[0]
        names = list(tree.children)
        raise InputError(
            f"{setting.name}: no component {element}; there are {compact(names)}{suggestion(element, names)}"
        )
