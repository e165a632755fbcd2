"""Read OspSystemStructure.xml, the system files of the Open Simulation Platform, as libcosim does.

Values are exchanged as they are, without conversion of units. A simulator whose step size is no multiple of the base
step is stepped at the next smaller one. A `LinearTransformation` becomes part of a connection, a sum a component that
has no FMU and adds no delay: it is computed after what it reads, in the tick in which it is read.
"""

import hashlib
from collections.abc import Iterator
from pathlib import Path

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, read_description
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import secure_root
from lockstep.ssp.documents.xml import MAIN, Element, local_name, unique
from lockstep.ssp.osp_functions import OspFunction, read_functions
from lockstep.ssp.osp_groups import group_pairs, group_variables
from lockstep.ssp.step_times import Timing
from lockstep.ssp.typed_values import boolean
from lockstep.system.clock import Time, common_divisor, nanoseconds, seconds_text
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection, System
from lockstep.system.transformation import Hop

NAMESPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
_DEFAULT_STEP = "0.1"  # s, as libcosim has it
_SOURCES = ("output", "calculatedParameter")
_NS = {"osp": NAMESPACE}
_End = tuple[str, str]  # simulator or function, and its variable or signal


def osp_file(path: Path) -> Path | None:
    """Return the file if it is a system of the Open Simulation Platform: an .xml whose root says so, or its folder."""
    if path.is_dir() and not (path / MAIN).exists():
        path /= "OspSystemStructure.xml"
    if path.suffix.lower() != ".xml" or not path.is_file():
        return None
    with path.open("rb") as stream:
        return path if b"OspSystemStructure" in stream.read(4096) else None


def load_osp(path: Path, timing: Timing, within: Path | None = None) -> System:
    """Read a system, or raise InputError; step sizes, kinds and delays of `timing` go before those of the file."""
    location = Location(document=path.absolute(), root=within, home=path.absolute().parent)
    text = location.read(str(path))
    root = secure_root(text, str(path))
    if root.tag != f"{{{NAMESPACE}}}OspSystemStructure":
        raise InputError(f"{path}: its root {local_name(root)} is not OspSystemStructure of {NAMESPACE}")
    return _Structure(location, root, timing).system(hashlib.sha256(text).hexdigest())


class _Structure:
    def __init__(self, location: Location, root: Element, timing: Timing) -> None:
        self.location, self.root, self.timing = location, root, timing
        self.base = nanoseconds(self._text("BaseStepSize", _DEFAULT_STEP), f"{location}: BaseStepSize")
        if self.base <= 0:
            raise InputError(f"{location}: BaseStepSize {seconds_text(self.base)} s must be > 0")
        self.descriptions: dict[str, Description] = {}
        self.components: dict[str, Component] = {}
        self.functions = read_functions(root.findall("osp:Functions/*", _NS), str(location))

    def system(self, digest: str) -> System:
        simulators = self.root.findall("osp:Simulators/osp:Simulator", _NS)
        unique((str(s.get("name")) for s in simulators), f"{self.location}: simulator ")
        for simulator in simulators:
            component = self._component(simulator)
            self.components[component.name] = component
        if self._text("Algorithm", "fixedStep").lower() != "fixedstep":
            self._warn(f"Algorithm {self._text('Algorithm', '')} is not supported: steps are fixed")
        start = nanoseconds(self._text("StartTime", "0"), f"{self.location}: StartTime")
        stop = self._text("EndTime", "")
        connections = tuple(self._connections())
        components = tuple(self.components.values())
        system = System(
            name=self.location.document.stem,
            tick=self.timing.tick_of(None, (c.period for c in components)),
            components=components,
            connections=connections,
            start_values=tuple(
                f"{c.to_component}.{c.input}"
                for c in connections
                if c.input in self.components[c.to_component].parameters
            ),
            stop_time=nanoseconds(stop, f"{self.location}: EndTime") if stop else None,
            start_time=start,
            path=self.location.document,
            sha256=digest,
            warnings=self.location.all_warnings,
        )
        self.timing.check_names(system)
        return system

    def _text(self, tag: str, default: str) -> str:
        found = self.root.find(f"osp:{tag}", _NS)
        return default if found is None or not found.text else str(found.text).strip()

    def _warn(self, text: str) -> None:
        self.location.warnings.append(f"{self.location}: {text}")

    def _component(self, simulator: Element) -> Component:
        name = str(simulator.get("name")).replace(".", "/")
        found, _ = self.location.resolve(str(simulator.get("source", "")), name)
        component = Component(name=name, source=found.document, archive=found.archive, period=self.base)
        description = self.descriptions[name] = read_description(component)
        return Component(
            name=name,
            source=found.document,
            archive=found.archive,
            period=self._period(name, simulator.get("stepSize")),
            kind=self.timing.kinds.get(name, "continuous"),
            parameters=dict(self._values(simulator, name, description)),
        )

    def _period(self, name: str, given: str | None) -> Time:
        """Return the period of a simulator [ns]: the greatest multiple of the base step within its step size."""
        period = self.timing.given_period(name)
        if period is not None:
            return period
        wanted = nanoseconds(given, f"{name}: stepSize") if given is not None else self.base
        steps = max(1, int(wanted / self.base + 1e-6))
        if wanted not in (0, steps * self.base):
            text = f"{name}: stepSize {given} is no multiple of the base step"
            self._warn(f"{text}; it is stepped every {seconds_text(steps * self.base)} s")
        return steps * self.base

    def _values(self, simulator: Element, name: str, description: Description) -> Iterator[tuple[str, Value]]:
        for one in simulator.findall("osp:InitialValues/osp:InitialValue", _NS):
            variable, kind = str(one.get("variable")), one[0]
            if variable not in description.variables:
                raise InputError(description.lacks(name, variable, "parameter"))
            yield variable, _value(kind, f"{name}.{variable}")

    def _connections(self) -> Iterator[Connection]:
        """Yield all connections; those of the sums join `components` once all their inputs are known."""
        inputs: dict[str, _End] = {}  # of the linear transformations
        outputs: list[tuple[OspFunction, _End]] = []
        of_sums: list[tuple[OspFunction, str, _End]] = []
        for connection in self.root.findall("osp:Connections/*", _NS):
            kind = local_name(connection)
            match kind:
                case "VariableConnection":
                    first, second = (_end(v, "simulator") for v in connection)
                    yield self._connection(first, second)
                case "VariableGroupConnection":
                    first, second = (_end(v, "simulator") for v in connection)
                    for pair in group_pairs(self._owner(first), self._owner(second), first, second, self.location):
                        yield self._connection((first[0], pair[0]), (second[0], pair[1]))
                case "SignalConnection" | "SignalGroupConnection":
                    for function, signal, variable in self._signals(connection, kind):
                        if function.hop is None:
                            of_sums.append((function, signal, variable))
                        elif not function.gives(signal):
                            inputs[function.name] = variable
                        else:
                            outputs.append((function, variable))
                case _:
                    raise InputError(f"{self.location}: {kind} is not supported; connect the variables one by one")
        for function, target in outputs:
            if function.name not in inputs:
                text = "nothing is connected to its signal in"
                raise InputError(f"{self.location}: function {function.name}: {text}")
            yield self._connection(inputs[function.name], target, function.hop)
        self._add_sums(of_sums)
        for function, signal, variable in of_sums:
            yield self._connection((function.name, signal), variable)

    def _signals(self, connection: Element, kind: str) -> Iterator[tuple[OspFunction, str, _End]]:
        """Yield the pairs of a connection of one signal or of a group: function, signal, and variable."""
        group = "Group" if kind == "SignalGroupConnection" else ""
        ends = {local_name(child): child for child in connection}
        missing = [tag for tag in (f"Signal{group}", f"Variable{group}") if tag not in ends]
        if missing:
            raise InputError(f"{self.location}, line {connection.sourceline}: {kind} without {missing[0]}")
        name, signal = _end(ends[f"Signal{group}"], "function")
        variable = _end(ends[f"Variable{group}"], "simulator")
        if name not in self.functions:
            near = compact(self.functions) + suggestion(name, self.functions)
            raise InputError(f"{self.location}: function {name}: no such function; there are {near}")
        function = self.functions[name]
        if not group:
            function.check_signal(signal)
            yield function, signal, variable
            return
        signals, names = function.group(signal), group_variables(self._owner(variable), variable[1], self.location)
        if len(signals) != len(names):
            what = f"{name}.{signal} -> {variable[0]}.{variable[1]}"
            raise InputError(f"{what}: {len(signals)} signals and {len(names)} variables; they must be as many")
        for one, other in zip(signals, names, strict=True):
            yield function, one, (variable[0], other)

    def _add_sums(self, connected: list[tuple[OspFunction, str, _End]]) -> None:
        """Add the sums to the components, computed whenever one of their readers is stepped."""
        for function in {f.name: f for f, _, _ in connected}.values():
            if function.name in self.components:
                raise InputError(f"{self.location}: function {function.name}: a simulator has this name; change one")
            readers = (variable[0] for f, signal, variable in connected if f is function and function.gives(signal))
            periods = [self._owner((name, ""))[0].period for name in readers]
            period = common_divisor(*periods) if periods else self.base
            component = function.component(self.location.document, period)
            self.components[function.name] = component
            self.descriptions[function.name] = read_description(component)

    def _owner(self, end: _End) -> tuple[Component, Description]:
        name = end[0]
        if name not in self.components:
            names = self.components
            raise InputError(f"{name}: no such simulator; there are {compact(names)}{suggestion(name, names)}")
        return self.components[name], self.descriptions[name]

    def _connection(self, first: _End, second: _End, hop: Hop | None = None) -> Connection:
        """Return the connection of two variables; the FMUs decide which of them is the source."""
        gives = []
        for end in (first, second):
            _, description = self._owner(end)
            variable = description.variables.get(end[1])
            if variable is None:
                raise InputError(description.lacks(end[0], end[1], "output"))
            gives.append(variable.causality in _SOURCES)
        source, target = (first, second) if gives[0] else (second, first)
        producer = self.components[source[0]]
        return Connection(
            from_component=source[0],
            output=source[1],
            to_component=target[0],
            input=target[1],
            delay=0 if producer.sums is not None else self.timing.delay_of(None, producer.kind),
            factor=hop.factor if hop else 1.0,
            offset=hop.offset if hop else 0.0,
            convert_units=False,
        )


def _end(element: Element, owner: str) -> _End:
    return str(element.get(owner)).replace(".", "/"), str(element.get("name"))


def _value(element: Element, what: str) -> Value:
    kind, text = local_name(element), str(element.get("value"))
    try:
        match kind:
            case "Real":
                return float(text)
            case "Integer" | "Enumeration":
                return int(text)
            case "Boolean":
                return boolean(text)
            case "String":
                return text
    except ValueError:
        raise InputError(f"{what}: {text!r} is no value of type {kind}") from None
    raise InputError(f"{what}: type {kind} is not supported; use Real, Integer, Boolean or String")
