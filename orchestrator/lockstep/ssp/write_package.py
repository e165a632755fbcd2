"""Write a system as a .ssp with values of components in separate files: `.ssv`, and `.ssm` where names differ."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from lockstep.fmi.safe_zip import open_file
from lockstep.ssp.documents.parse import parse
from lockstep.ssp.documents.xml import DESCRIPTION, NS, SSC, SSD, SSM, SSV, Element, add, document_bytes, new_root
from lockstep.ssp.package_members import package_entries
from lockstep.ssp.typed_values import literal, write_transformation, write_units
from lockstep.ssp.write import PARAMETER_SET, write_ssd
from lockstep.system.component import Value
from lockstep.system.system import System
from lockstep.system.transformation import Table
from lockstep.system.units import Unit


@dataclass(frozen=True, slots=True, kw_only=True)
class MappingEntry:
    """Map a value to a parameter of another name, with a transformation."""

    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0
    table: Table | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterFile:
    """Values of a component, by name with their units; with a mapping if the names are not those of its parameters."""

    component: str
    name: str  # of the files, without suffix
    values: dict[str, tuple[Value, Unit | None]]
    mapping: tuple[MappingEntry, ...] = ()
    set_name: str = PARAMETER_SET


def package(system: System, files: Sequence[ParameterFile]) -> bytes:
    """Return a .ssp with the system, its FMUs, and the values.

    Raises
    ------
    InputError
        If an FMU cannot be read or lacks what is set.
    """
    with tempfile.TemporaryDirectory(prefix="lockstep-ssp-") as name:
        folder = Path(name)
        document = folder / f"{system.name}.ssd"
        write_ssd(_unpacked(system, folder / "fmus"), document)
        root = parse(document.read_bytes(), str(document), DESCRIPTION)
        for file in files:
            if not file.values:
                continue
            (folder / f"{file.name}.ssv").write_bytes(_values(file))
            if file.mapping:
                (folder / f"{file.name}.ssm").write_bytes(_mapping(file))
            component = root.xpath("//ssd:Component[@name=$name]", namespaces=NS, name=file.component)[0]
            _bind(component, file)
        document.write_bytes(document_bytes(root))
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
            for member, data in package_entries(document).items():
                # a fixed time stamp: the same system gives the same bytes
                archive.writestr(zipfile.ZipInfo(member, (1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
        return content.getvalue()


def _unpacked(system: System, folder: Path) -> System:
    """Return the system with the FMUs of an archive extracted to files."""
    components = []
    for number, component in enumerate(system.components):
        if component.archive is not None:
            file = folder / str(number) / component.source.name
            file.parent.mkdir(parents=True)
            with open_file(component.source, component.archive, component.name) as stream:
                file.write_bytes(stream.read())
            component = replace(component, source=file, archive=None)
        components.append(component)
    return replace(system, components=tuple(components))


def _bind(component: Element, file: ParameterFile) -> None:
    bindings = component.find("ssd:ParameterBindings", NS)
    if bindings is None:
        bindings = new_root(SSD, "ParameterBindings", {})
        connectors = component.find("ssd:Connectors", NS)
        component.insert(0 if connectors is None else 1, bindings)
    binding = add(bindings, SSD, "ParameterBinding", type="application/x-ssp-parameter-set", source=f"{file.name}.ssv")
    if file.mapping:
        kind = "application/x-ssp-parameter-mapping"
        add(binding, SSD, "ParameterMapping", type=kind, source=f"{file.name}.ssm")


def _values(file: ParameterFile) -> bytes:
    root = new_root(SSV, "ParameterSet", {"ssv": SSV, "ssc": SSC}, version="1.0", name=file.set_name)
    parameters = add(root, SSV, "Parameters")
    for name, (value, unit) in file.values.items():
        kind, text = literal(value, {})
        attributes = {"unit": unit.name} if kind == "Real" and unit is not None else {}
        add(add(parameters, SSV, "Parameter", name=name), SSV, kind, value=text, **attributes)
    reals = (unit for value, unit in file.values.values() if isinstance(value, float) and unit is not None)
    write_units(root, SSV, {unit.name: unit for unit in reals})
    return document_bytes(root)


def _mapping(file: ParameterFile) -> bytes:
    root = new_root(SSM, "ParameterMapping", {"ssm": SSM, "ssc": SSC}, version="1.0")
    for entry in file.mapping:
        # the factor includes the conversion of units, so that the reader needs none
        element = add(root, SSM, "MappingEntry", source=entry.source, target=entry.target,
                      suppressUnitConversion="true")  # fmt: skip
        write_transformation(element, entry.factor, entry.offset, entry.table)
    return document_bytes(root)
