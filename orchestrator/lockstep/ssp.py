"""Read SSP 1.0 system files: a .ssd file, an unpacked SSP folder, or a .ssp archive.

Periods, offsets, kinds, delays, the tick and what to record are no part of SSP. They stand in annotations of
the type `lockstep`, in a namespace of our own; `lockstep.ssp_writer` writes them.
"""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote, urlsplit

from lxml import etree  # type: ignore[import-untyped]

from lockstep.archive import is_inside, open_file
from lockstep.clock import nanoseconds
from lockstep.errors import InputError, compact, siblings, suggestion
from lockstep.ssp_xml import (
    ANNOTATION,
    LOCKSTEP,
    MAIN,
    NS,
    PARAMETERS,
    SSC,
    TYPES,
    parse,
    read_units,
    read_value,
    unit_named,
    validate,
)
from lockstep.system import Component, Connection, Connector, Kind, System, Value
from lockstep.units import Unit


def load_system(path: Path | str) -> System:
    """Read a system file, or raise InputError. Only the FMUs stay unread; `simulate` checks against them."""
    path = Path(path).absolute()
    archive = path if path.suffix.lower() == ".ssp" and path.is_file() else None
    if path.is_dir():
        path = path / MAIN
    document = Path(MAIN) if archive else path
    with open_file(document, archive, str(path)) as stream:
        text = stream.read()
    root = parse(text, str(path), "SystemStructureDescription.xsd")
    with open_file(path, None, str(path)) as stream:
        digest = hashlib.sha256(stream.read()).hexdigest()
    return _Reader(path, document.parent, archive).system(root, digest)


class _Reader:
    """Holds where the document stands, so that every message and every relative path can refer to it."""

    def __init__(self, path: Path, folder: Path, archive: Path | None) -> None:
        self.path, self.folder, self.archive = path, folder, archive

    def system(self, root: etree._Element, digest: str) -> System:
        system = root.find("ssd:System", NS)
        assert system is not None  # the schema demands it
        units = read_units(root)
        own = self.annotation(system, "System", "the system")
        if own is None or "tick" not in own.attrib:
            raise InputError(f"{self.path}: no base tick; {_remedy('System', 'tick')} to ssd:System")
        _known(own, ("tick", "recordPeriod"), "system annotation")
        elements = list(system.iterfind("ssd:Elements/*", NS))
        for element in elements:
            if etree.QName(element).localname != "Component":
                kind = etree.QName(element).localname
                raise InputError(f"{element.get('name')}: a nested {kind} is not supported; flatten the system")
        shared = self.shared_parameters(system, units, [str(e.get("name")) for e in elements])
        components = tuple(self.component(element, units, shared) for element in elements)
        ports = {c.name: {port.name: port for port in c.connectors or ()} for c in components}
        experiment = root.find("ssd:DefaultExperiment", NS)
        start, stop = (experiment.get(name) if experiment is not None else None for name in ("startTime", "stopTime"))
        if start is not None and float(start) != 0.0:
            raise InputError(f"{self.path}: startTime {start} must be 0")
        period = own.get("recordPeriod")
        record = tuple(str(e.get("pattern")) for e in own.iterfind("lockstep:Record", NS))
        return System(
            name=str(root.get("name")),
            tick=nanoseconds(own.attrib["tick"], "tick"),
            components=components,
            connections=tuple(self.connection(e, ports) for e in system.iterfind("ssd:Connections/*", NS)),
            stop_time=None if stop is None else nanoseconds(stop, "stopTime"),
            record=record or ("all",),
            record_period=None if period is None else nanoseconds(period, "recordPeriod"),
            path=self.path,
            sha256=digest,
        )

    def component(
        self,
        element: etree._Element,
        units: Mapping[str, Unit],
        shared: Mapping[str, dict[str, tuple[Value, Unit | None]]],
    ) -> Component:
        name = str(element.get("name"))
        if element.get("type", "application/x-fmu-sharedlibrary") != "application/x-fmu-sharedlibrary":
            raise InputError(f"{name}: type {element.get('type')} is not supported; only FMUs are")
        if element.get("implementation") == "ModelExchange":
            raise InputError(f"{name}: implementation ModelExchange is not supported; use CoSimulation")
        timing = self.annotation(element, "Component", name)
        if timing is None or "period" not in timing.attrib:
            raise InputError(f"{name}: no period; {_remedy('Component', 'period')} to the component")
        _known(timing, ("period", "offset", "kind", "isolated"), f"{name}: annotation")
        kind: Kind = "continuous" if timing.get("kind") == "continuous" else "sampled"
        if timing.get("kind", kind) != kind:
            raise InputError(f"{name}: kind {timing.get('kind')!r} must be sampled or continuous")
        values: dict[str, tuple[Value, Unit | None]] = dict(shared.get(name, {}))
        values |= self.bindings(element, units, name)
        connectors, declared = self.connectors(element, units, name)
        return Component(
            name=name,
            source=self.resolve(str(element.get("source")), name),
            period=nanoseconds(timing.attrib["period"], f"{name}: period"),
            offset=nanoseconds(timing.get("offset", "0"), f"{name}: offset"),
            kind=kind,
            parameters={key: value for key, (value, _) in values.items()},
            units=declared | {key: unit for key, (_, unit) in values.items() if unit is not None},
            connectors=connectors,
            archive=self.archive,
            isolated=_flag(timing, "isolated", name),
        )

    def connectors(
        self, element: etree._Element, units: Mapping[str, Unit], name: str
    ) -> tuple[tuple[Connector, ...], dict[str, Unit]]:
        ports: dict[str, Connector] = {}
        declared: dict[str, Unit] = {}
        for port in element.iterfind("ssd:Connectors/ssd:Connector", NS):
            key = str(port.get("name"))
            if key in ports:
                raise InputError(f"{name}.{key}: connector declared twice")
            kind = next((child for child in port if etree.QName(child).namespace == SSC), None)
            type_name = etree.QName(kind).localname if kind is not None else None
            if type_name is not None and type_name not in TYPES:
                raise InputError(f"{name}.{key}: type {type_name} is not supported; use one of {', '.join(TYPES)}")
            if kind is not None and kind.get("unit") is not None:
                declared[key] = unit_named(str(kind.get("unit")), units, f"{name}.{key}")
            ports[key] = Connector(name=key, kind=str(port.get("kind")), type=type_name)
        return tuple(ports.values()), declared

    def connection(self, element: etree._Element, ports: Mapping[str, Mapping[str, Connector]]) -> Connection:
        start, end = element.get("startElement"), element.get("endElement")
        output, target = str(element.get("startConnector")), str(element.get("endConnector"))
        if start is None or end is None:
            raise InputError(
                f"{output} -> {target}: connectors of the system itself are not supported; name both elements"
            )
        factor, offset = 1.0, 0.0
        for child in element:
            kind = etree.QName(child).localname
            if kind == "LinearTransformation":
                factor, offset = float(child.get("factor", "1")), float(child.get("offset", "0"))
            elif kind.endswith("Transformation"):
                raise InputError(f"{start}.{output} -> {end}.{target}: {kind} is not supported")
        own = self.annotation(element, "Connection", f"{start}.{output}")
        if own is not None:
            _known(own, ("delay",), f"{start}.{output} -> {end}.{target}: annotation")
        text = "0" if own is None else own.get("delay", "0")
        if not text.isdecimal():
            raise InputError(f"{start}.{output} -> {end}.{target}: delay {text!r} must be a whole number of ticks >= 0")
        connection = Connection(
            from_component=start,
            output=output,
            to_component=end,
            input=target,
            delay=int(text),
            factor=factor,
            offset=offset,
            convert_units=element.get("suppressUnitConversion", "false") not in ("true", "1"),
        )
        # backwards is checked against the FMUs, with a message that knows their ports
        for component, port, kind in ((start, output, "output"), (end, target, "input")):
            there = ports.get(component)
            if there is not None and port not in there:
                near = compact(siblings(port, there)) + suggestion(port, there)
                raise InputError(f"{component}.{port}: no such {kind} connector; {component} declares {near}")
        return connection

    def shared_parameters(
        self, system: etree._Element, units: Mapping[str, Unit], names: list[str]
    ) -> dict[str, dict[str, tuple[Value, Unit | None]]]:
        """Split the system's own parameters, named `component.parameter`, by component."""
        split: dict[str, dict[str, tuple[Value, Unit | None]]] = {}
        for key, value in self.bindings(system, units, "the system").items():
            component, _, parameter = key.partition(".")
            if component not in names:
                raise InputError(
                    f"{key}: no component {component}; there are {compact(names)}{suggestion(component, names)}"
                )
            split.setdefault(component, {})[parameter] = value
        return split

    def bindings(
        self, element: etree._Element, units: Mapping[str, Unit], name: str
    ) -> dict[str, tuple[Value, Unit | None]]:
        found: dict[str, tuple[Value, Unit | None]] = {}
        for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NS):
            if binding.find("ssd:ParameterMapping", NS) is not None:
                raise InputError(f"{name}: a ParameterMapping is not supported; name the parameters as the FMU does")
            if binding.get("type", "application/x-ssp-parameter-set") != "application/x-ssp-parameter-set":
                raise InputError(f"{name}: parameter binding of type {binding.get('type')} is not supported")
            for key, value in self.parameter_set(binding, units, name):
                key = binding.get("prefix", "") + key
                if key in found:
                    raise InputError(f"{name}.{key}: parameter given twice")
                found[key] = value
        return found

    def parameter_set(
        self, binding: etree._Element, units: Mapping[str, Unit], name: str
    ) -> Iterator[tuple[str, tuple[Value, Unit | None]]]:
        source = binding.get("source")
        if source is None:
            sets = binding.findall("ssd:ParameterValues/ssv:ParameterSet", NS)
            for values in sets:  # the schema of the system lets anything pass here
                validate(values, str(self.path), PARAMETERS)
        else:
            if binding.get("sourceBase", "SSD") != "SSD":
                raise InputError(
                    f"{name}: {source}: sourceBase component is not supported; put the file beside the system"
                )
            path = self.resolve(source, name)
            with open_file(path, self.archive, name) as stream:
                sets = [parse(stream.read(), str(path), PARAMETERS)]
        for values in sets:
            known = {**units, **read_units(values)}
            for parameter in values.iterfind("ssv:Parameters/ssv:Parameter", NS):
                key = str(parameter.get("name"))
                yield key, read_value(parameter[0], known, f"{name}.{key}")

    def resolve(self, source: str, name: str) -> Path:
        parts = urlsplit(source)
        if parts.scheme not in ("", "file") or parts.netloc:
            raise InputError(f"{name}: source {source} is not a file; copy it beside the system file")
        path = Path(unquote(parts.path))
        if self.archive is not None and not is_inside(path.as_posix()):
            raise InputError(f"{name}: source {source} lies outside {self.archive.name}; put the file into the archive")
        return path if self.archive else Path(self.folder, path).resolve()

    def annotation(self, element: etree._Element, tag: str, name: str) -> etree._Element | None:
        """Return our own element in the annotations of `element`, or None."""
        found = element.findall(f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']/*", NS)
        if not found:
            return None
        if len(found) > 1 or found[0].tag != f"{{{LOCKSTEP}}}{tag}":
            raise InputError(f"{name}: the {ANNOTATION} annotation must hold one {tag} element in namespace {LOCKSTEP}")
        return found[0]


def _known(element: etree._Element, names: tuple[str, ...], what: str) -> None:
    for name in element.attrib:
        if name not in names:
            raise InputError(f"{what} {name}: no such attribute; there are {', '.join(names)}")


def _flag(element: etree._Element, attribute: str, name: str) -> bool | None:
    text = element.get(attribute)
    if text not in (None, "true", "false", "1", "0"):
        raise InputError(f"{name}: {attribute} {text!r} must be true or false")
    return None if text is None else text in ("true", "1")


def _remedy(tag: str, attribute: str) -> str:
    return f'add <lockstep:{tag} {attribute}="0.001"/> in an annotation of type {ANNOTATION}'
