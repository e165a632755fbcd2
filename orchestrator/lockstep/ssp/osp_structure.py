"""Read OspSystemStructure.xml, the system files of the Open Simulation Platform, as libcosim does.

Values are exchanged as they are, without conversion of units. A simulator whose step size is no multiple of the base
step is stepped at the nearest one. `LinearTransformation` becomes part of a connection; other functions are refused.
"""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from lockstep.errors import InputError, compact, suggestion
from lockstep.fmi.model_description import Description, read_description
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import secure_root
from lockstep.ssp.documents.xml import Element, local_name, unique
from lockstep.ssp.osp_groups import group_pairs
from lockstep.ssp.step_times import Timing
from lockstep.ssp.typed_values import boolean
from lockstep.system.clock import nanoseconds, seconds_text
from lockstep.system.component import Component, Value
from lockstep.system.system import Connection, System
from lockstep.system.transformation import Hop

NAMESPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
_DEFAULT_STEP = "0.1"  # s, as libcosim has it
_SOURCES = ("output", "calculatedParameter")
_NS = {"osp": NAMESPACE}
_End = tuple[str, str]  # simulator or function, and its variable or signal


def is_osp(path: Path) -> bool:
    """Return whether a file is a system of the Open Simulation Platform: an .xml whose root says so."""
    if path.suffix.lower() != ".xml" or not path.is_file():
        return False
    with path.open("rb") as stream:
        return b"OspSystemStructure" in stream.read(4096)


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

    def system(self, digest: str) -> System:
        simulators = self.root.findall("osp:Simulators/osp:Simulator", _NS)
        unique((str(s.get("name")) for s in simulators), f"{self.location}: simulator ")
        for simulator in simulators:
            component = self._component(simulator)
            self.components[component.name] = component
        if self._text("Algorithm", "fixedStep").lower() != "fixedstep":
            self._warn(f"Algorithm {self._text('Algorithm', '')} is not supported: steps are fixed")
        start = self._text("StartTime", "0")
        if float(start) != 0.0:
            raise InputError(f"{self.location}: StartTime {start} must be 0; a simulation begins there")
        stop = self._text("EndTime", "")
        components = tuple(self.components.values())
        connections = tuple(self._connections())
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
            path=self.location.document,
            sha256=digest,
            warnings=self.location.all_warnings,
        )
        for named in self.timing.names():
            system.component(named)
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

    def _period(self, name: str, given: str | None) -> int:
        """Return the period of a simulator [ns]: the multiple of the base step nearest to its step size."""
        period = self.timing.periods.get(name) or self.timing.period
        if period is not None:
            return period
        wanted = nanoseconds(given, f"{name}: stepSize") if given is not None else self.base
        steps = max(1, round(wanted / self.base))
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
        functions = {
            str(f.get("name")): f
            for f in self.root.findall("osp:Functions/*", _NS)
            if local_name(f) == "LinearTransformation"
        }
        inputs: dict[str, _End] = {}  # of the functions
        outputs: list[tuple[str, _End]] = []
        for connection in self.root.findall("osp:Connections/*", _NS):
            match local_name(connection):
                case "VariableConnection":
                    first, second = (_end(v, "simulator") for v in connection)
                    yield self._connection(first, second)
                case "VariableGroupConnection":
                    first, second = (_end(v, "simulator") for v in connection)
                    for pair in group_pairs(self._owner(first), self._owner(second), first, second, self.location):
                        yield self._connection((first[0], pair[0]), (second[0], pair[1]))
                case "SignalConnection":
                    variable = _end(next(c for c in connection if local_name(c) == "Variable"), "simulator")
                    function, signal = _end(next(c for c in connection if local_name(c) == "Signal"), "function")
                    if function not in functions:
                        raise InputError(self._no_function(function, functions))
                    if signal == "in":
                        inputs[function] = variable
                    else:
                        outputs.append((function, variable))
                case kind:
                    raise InputError(f"{self.location}: {kind} is not supported; connect the variables one by one")
        for function, target in outputs:
            if function not in inputs:
                raise InputError(f"{self.location}: function {function}: nothing is connected to its signal in")
            element = functions[function]
            hop = Hop(
                factor=float(element.get("factor", "1")), offset=float(element.get("offset", "0")), convert_units=False
            )
            yield self._connection(inputs[function], target, hop)

    def _no_function(self, name: str, known: Mapping[str, Element]) -> str:
        for element in self.root.findall("osp:Functions/*", _NS):
            if element.get("name") == name:
                return f"{self.location}: function {name}: {local_name(element)} is not supported; put it into an FMU"
        return f"{self.location}: function {name}: no such function; there are {compact(known)}"

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
        kind = self.components[source[0]].kind
        return Connection(
            from_component=source[0],
            output=source[1],
            to_component=target[0],
            input=target[1],
            delay=self.timing.delay_of(None, kind),
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
            case "Integer":
                return int(text)
            case "Boolean":
                return boolean(text)
            case "String":
                return text
    except ValueError:
        raise InputError(f"{what}: {text!r} is no value of type {kind}") from None
    raise InputError(f"{what}: type {kind} is not supported; use Real, Integer, Boolean or String")
