"""Read system files: a .ssd file, an unpacked SSP folder, a .ssp archive, an OspSystemStructure.xml, or one FMU.

Periods, offsets, kinds, delays, the tick and what to record are no part of SSP. They stand in annotations of the type
`lockstep`, in a namespace of its own; `lockstep.ssp.write` writes them, and `lockstep.ssp.step_times` resolves them in
files without. Systems in systems are flattened; a component of one has its path as its name: `aocs/controller`.

In a file whose system has no such annotation, a value without a variable is left out, as SSP defines, and listed in
`System.ignored`, and small offences are amended, with `System.warnings`; in one with annotations both are refused.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lockstep.errors import InputError
from lockstep.fmi.model_description import Description, read_description
from lockstep.fmi.safe_zip import open_file
from lockstep.ssp.annotations import SYSTEM_ATTRIBUTES, DeclaredSteps, annotation, flag, master_step
from lockstep.ssp.documents.location import Location, location_of
from lockstep.ssp.documents.xml import ANNOTATION, MAIN, NS, Element, unique
from lockstep.ssp.flatten import Settled, Way, refuse_ignored, settle, ways
from lockstep.ssp.lone_fmu import lone_fmu
from lockstep.ssp.osp_structure import load_osp, osp_file
from lockstep.ssp.read_tree import open_description, read_tree
from lockstep.ssp.step_times import Timing
from lockstep.ssp.tree import Branch, Leaf, PortPath, Setting
from lockstep.system.clock import Time, nanoseconds
from lockstep.system.component import Component, Connector, Kind, Value
from lockstep.system.system import Connection, Feed, System, SystemInput, SystemPort
from lockstep.system.transformation import Hop, transferred
from lockstep.system.units import Unit, known_unit


def load_system(path: Path | str, timing: Timing | None = None, within: Path | None = None) -> System:
    """Read a system file, or raise InputError.

    Parameters
    ----------
    path : a .ssd, the folder of an unpacked package, a .ssp, one variant in it: `package.ssp#Variant.ssd`, an
        OspSystemStructure.xml of the Open Simulation Platform, or one .fmu
    timing : periods, kinds and delays of the command line; for the rest see `lockstep.ssp.step_times`
    within : the folder in which all files have to lie; None: sources outside the folder of a .ssd are warnings

    FMUs are read only where their steps, variables or units are needed; `simulate` checks against all.
    """
    path = Path(path)
    if not path.exists() and "#" not in path.name:
        raise InputError(f"{path}: no such file; give a system (.ssd, .ssp, the folder of one) or one FMU")
    osp = osp_file(path)
    if osp is not None:
        return load_osp(osp, timing or Timing(), within)
    if path.suffix.lower() == ".fmu" and path.is_file():
        return lone_fmu(path, timing or Timing())
    location = location_of(path, within)
    document = open_description(location)
    tree = read_tree(document)
    file = location.archive or location.document
    with open_file(file, None, str(file)) as stream:
        digest = hashlib.sha256(stream.read()).hexdigest()
    named = file if location.archive is None or location.document == Path(MAIN) else Path(f"{file}#{location.document}")
    return _Assembly(named, document.root, tree, timing or Timing(), location).system(digest)


class _Assembly:
    """Assemble a system from a tree, and read the descriptions of its FMUs where they are needed."""

    def __init__(self, path: Path, root: Element, tree: Branch, timing: Timing, location: Location) -> None:
        self.path, self.root, self.tree, self.timing, self.location = path, root, tree, timing, location
        unique((child.path for branch in tree.branches() for child in branch.children.values()), f"{path}: element ")
        self.leaves = {leaf.path: leaf for leaf in tree.leaves()}
        self.own = annotation(root.find("ssd:System", NS), "System", "the system", SYSTEM_ATTRIBUTES)
        self.step = master_step(root)
        self.descriptions: dict[str, Description] = {}

    def system(self, digest: str) -> System:
        name = str(self.root.get("name"))
        if not self.leaves:
            raise InputError(f"system {name}: no components; without an FMU there is nothing to simulate")
        settled = settle(self.tree, self._has)
        if self.own is not None:
            refuse_ignored(settled, self.tree)
        found, free = ways(self.tree)
        values = self._values(settled, [*found, *free])
        steps = {path: self._steps(leaf) for path, leaf in self.leaves.items()}
        periods = self.timing.periods_of(steps, self.location.warnings)
        components = tuple(
            self._component(leaf, values.get(path, {}), periods[path]) for path, leaf in self.leaves.items()
        )
        kinds: dict[str, Kind] = {component.name: component.kind for component in components}
        period = None if self.own is None else self.own.get("recordPeriod")
        record = () if self.own is None else (str(e.get("pattern")) for e in self.own.iterfind("lockstep:Record", NS))
        system = System(
            name=name,
            tick=self._tick(components),
            components=components,
            connections=tuple(self._connection(way, kinds) for way in found),
            stop_time=self._experiment("stopTime"),
            start_time=self._experiment("startTime") or 0,
            record=tuple(record) or ("all",),
            record_period=None if period is None else nanoseconds(period, "recordPeriod"),
            path=self.path,
            sha256=digest,
            inputs=self._inputs(free, values),
            ignored=tuple(f"{setting.name} ({setting.origin})" for setting in settled.ignored),
            start_values=() if self.own is not None else self._start_values(found, values),
            strict_inputs=self.own is not None and bool(flag(self.own, "strictInputs", "the system")),
            warnings=self.location.all_warnings,
            ports=() if self.own is None else self._ports(),
        )
        if self.own is not None and system.warnings:
            raise InputError(f"{system.warnings[0]}; in a file with {ANNOTATION} annotations this is an error")
        self.timing.check_names(system)
        return system

    def _start_values(self, found: list[Way], values: Mapping[str, Mapping[str, object]]) -> tuple[str, ...]:
        """Return the connected inputs that have a value: in SSP it serves at initialization."""
        return tuple(f"{way.end[0]}.{way.end[1]}" for way in found if way.end[1] in values.get(way.end[0], {}))

    def describe(self, leaf: Leaf) -> Description:
        """Read the FMU of a component, once."""
        if leaf.path not in self.descriptions:
            component = Component(name=leaf.path, source=leaf.source, archive=leaf.archive, period=1)
            self.descriptions[leaf.path] = read_description(component)
        return self.descriptions[leaf.path]

    def _has(self, leaf: Leaf, name: str) -> bool:
        """Return whether a value is for this component; in an annotated file a wrong name is found by `simulate`."""
        if self.own is not None:
            return True
        variable = self.describe(leaf).variables.get(name)
        if variable is not None and variable.causality == "structuralParameter":
            text = "a structural parameter keeps the value of the FMU, and arrays their sizes"
            self.location.warnings.append(f"{leaf.path}.{name}: {text}")
        return variable is not None and variable.settable

    def _tick(self, components: tuple[Component, ...]) -> Time:
        tick = self.timing.tick_of(self.tree.tick, (t for c in components for t in (c.period, c.offset)))
        for branch in self.tree.branches():
            if branch.tick not in (None, tick):
                raise InputError(
                    f"{branch.path}: its tick is not that of the whole system, in which delays count; make them equal"
                )
        return tick

    def _experiment(self, attribute: str) -> Time | None:
        """Return a time of the default experiment [ns], or None."""
        experiment = self.root.find("ssd:DefaultExperiment", NS)
        text = None if experiment is None else experiment.get(attribute)
        return None if text is None else nanoseconds(text, f"{self.path}: {attribute}")

    def _steps(self, leaf: Leaf) -> tuple[DeclaredSteps, Description | None]:
        """Return what the file, and the FMU where it is needed, declare of the steps of a component."""
        steps = leaf.steps if leaf.steps.hint is not None else replace(leaf.steps, hint=self.step)
        return steps, self.describe(leaf) if self.timing.needs_description(leaf.path, steps) else None

    def _component(self, leaf: Leaf, values: Mapping[str, tuple[Value, Unit | None]], period: Time) -> Component:
        name = leaf.path
        steps, _ = self._steps(leaf)
        declared = {port.name: port.unit for port in leaf.ports.values() if port.unit is not None}
        return Component(
            name=name,
            source=leaf.source,
            period=period,
            offset=steps.offset,
            kind=self.timing.kind_of(name, steps),
            parameters={key: value for key, (value, _) in values.items()},
            units=declared | {key: unit for key, (_, unit) in values.items() if unit is not None},
            connectors=tuple(
                Connector(name=port.name, kind=port.kind, type=port.type, items=port.items)
                for port in leaf.ports.values()
                if port.type != "Binary"  # one that is connected has been refused
            ),
            archive=leaf.archive,
            isolated=steps.isolated,
            tolerance=steps.tolerance,
        )

    def _connection(self, way: Way, kinds: Mapping[str, Kind]) -> Connection:
        last = way.hops[-1]
        return Connection(
            from_component=way.start[0],
            output=way.start[1],
            to_component=way.end[0],
            input=way.end[1],
            delay=self.timing.delay_of(way.delay, kinds[way.start[0]]),
            factor=last.factor,
            offset=last.offset,
            table=last.table,
            convert_units=last.convert_units,
            via=way.via,
        )

    def _values(self, settled: Settled, found: list[Way]) -> dict[str, dict[str, tuple[Value, Unit | None]]]:
        """Return the values of the components' variables, with those of connectors converted along their paths."""
        chosen: dict[PortPath, tuple[Setting, tuple[Hop, ...]]] = {
            port: (setting, setting.hops) for port, setting in settled.values.items() if port[0] in self.leaves
        }
        for way in found:
            for number, port in enumerate((way.start, *way.passed)):
                setting = settled.values.get(port)
                if setting is None or port[0] in self.leaves:
                    continue
                other = chosen.get(way.end)
                if other is not None and _same_value(setting, other[0]) and not any(map(_changes, way.hops)):
                    continue  # stated twice, for hosts that know no values of connectors of systems
                if other is None or setting.level < other[0].level:  # a higher binding wins
                    chosen[way.end] = (setting, (*self._into(port, setting), *way.hops[number:]))
        values: dict[str, dict[str, tuple[Value, Unit | None]]] = {}
        for (path, name), (setting, hops) in chosen.items():
            values.setdefault(path, {})[name] = self._sent(self.leaves[path], name, setting, hops)
        return values

    def _into(self, connector: PortPath, setting: Setting) -> tuple[Hop, ...]:
        """Return the hops of a value into a connector of a system."""
        path, name = connector
        port = next(branch for branch in self.tree.branches() if branch.path == path).ports[name]
        hops = setting.hops or (Hop(),)
        return (*hops[:-1], replace(hops[-1], type=port.type, unit=port.unit, items=port.items))

    def _sent(self, leaf: Leaf, name: str, setting: Setting, hops: tuple[Hop, ...]) -> tuple[Value, Unit | None]:
        what = f"{leaf.path}.{name}"
        port = leaf.ports.get(name)
        declared = None if port is None else port.unit
        if not hops:
            value, unit = setting.value, setting.unit
            if unit is None or port is None or not isinstance(value, float):
                return value, unit
            if declared == unit:
                return value, unit
            hops = (Hop(),)  # in `Component.units` it would be the unit of the connector
        variable = self.describe(leaf).variables.get(name)
        if variable is None:
            raise InputError(self.describe(leaf).lacks(leaf.path, name, "parameter"))
        end = variable.end(known_unit(variable.unit, declared))
        return transferred(setting.value, setting.unit, hops, end, what)[0], None

    def _ports(self) -> tuple[SystemPort, ...]:
        """Return the connectors of the whole system that are connected to a component at once, and unchanged."""
        found = []
        for wire in self.tree.wires:
            for outer, inner in ((wire.start, wire.end), (wire.end, wire.start)):
                leaf = self.tree.children[inner[0]] if outer[0] is None and inner[0] is not None else None
                kind = self.tree.ports[outer[1]].kind if isinstance(leaf, Leaf) else ""
                if isinstance(leaf, Leaf) and kind in ("input", "output") and not _changes(wire.hop):
                    found.append(SystemPort(name=outer[1], kind=kind, component=leaf.path, variable=inner[1]))
        return tuple(found)

    def _inputs(self, free: list[Way], values: Mapping[str, Mapping[str, object]]) -> tuple[SystemInput, ...]:
        """Return the connectors of the whole system that feed inputs and have no value."""
        feeds: dict[str, list[Feed]] = {}
        for way in free:
            path, name = way.start
            if path == "" and self.tree.ports[name].kind == "input" and way.end[1] not in values.get(way.end[0], {}):
                feeds.setdefault(name, []).append(Feed(component=way.end[0], input=way.end[1], hops=way.hops))
        return tuple(
            SystemInput(name=name, unit=self.tree.ports[name].unit, feeds=tuple(found)) for name, found in feeds.items()
        )


def _changes(hop: Hop) -> bool:
    return (hop.factor, hop.offset, hop.table) != (1.0, 0.0, None)


def _same_value(one: Setting, other: Setting) -> bool:
    return (type(one.value), one.value, one.unit) == (type(other.value), other.value, other.unit)
