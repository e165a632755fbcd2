"""Make the content of a native FMU: its description, its libraries, and the sources that build them."""

from __future__ import annotations

import hashlib
import json
import re
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from ...ports.table import FmiVersion, PortTable
from ..documentation.xml_text import xml_bytes
from ..python.model_description import About, model_description
from ..python.resources import BUILD_FILE
from .compile import binaries
from .compilers import compiler_for
from .fmi3_description import build_description, fmi3_model_description
from .platforms import folders
from .port_source import differentiable
from .sources import IDENTITY, Identity, component_sources, generated_sources, identity_source

_TOKEN: dict[FmiVersion, str] = {"2.0": "guid", "3.0": "instantiationToken"}  # attribute that has the GUID


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeComponent:
    """What a native FMU is made from.

    Attributes
    ----------
    main : the C file that implements `component.h`, such as plant.c
    variants : matrices by variant, as of `generated_sources`; none for a component without any
    about : what its model description contains; the GUID is replaced
    equal_steps, step_parameter : as of `Identity`
    resources : files below resources/ for tools that evaluate a run; the library reads none
    """

    main: Path
    table: PortTable
    variants: Mapping[str, Any]
    about: About
    equal_steps: bool
    step_parameter: str | None
    resources: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeContent:
    """Files of an FMU by their path in the archive, and its GUID."""

    guid: str
    entries: dict[str, bytes]


def native_content(component: NativeComponent, fmi: FmiVersion = "2.0", platforms: Sequence[str] = ()) -> NativeContent:
    """Generate and compile what a native FMU contains, but for its documentation.

    The GUID follows from the sources and the description, so that the same input gives the same GUID.

    Parameters
    ----------
    component : what it is made from
    fmi : version
    platforms : that it has libraries for, as of `binaries`

    Raises
    ------
    ValueError
        For a model name that is no C identifier.
    BuildError
        If a library cannot be compiled here.
    """
    name = component.about.model_name
    if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
        raise ValueError(f"model_name must be a C identifier, got {name!r}")
    sources = component_sources(component.main, fmi)
    sources |= generated_sources(component.main.stem, component.table, component.variants)
    identity = Identity(guid="", equal_steps=component.equal_steps, step_parameter=component.step_parameter)
    units = sorted(file for file in (*sources, IDENTITY) if file.endswith(".c"))
    about = replace(component.about, source_files=tuple(units), derivatives=differentiable(component.table))
    content = {**component.resources, **sources, IDENTITY: identity_source(identity)}
    description = _described(component.table, about, fmi)
    guid = _guid(content, xml_bytes(description))
    description.set(_TOKEN[fmi], guid)
    sources[IDENTITY] = identity_source(replace(identity, guid=guid))
    compilers = {
        folder: compiler_for(targets[0] if platforms else None).version
        for folder, targets in folders(platforms, fmi).items()
    }
    facts = {"model_name": name, "guid": guid, "version": about.version, "native": True, "compilers": compilers}
    resources = {**component.resources, BUILD_FILE: (json.dumps(facts, indent=2) + "\n").encode()}
    entries = {f"sources/{file}": source for file, source in sources.items()}
    entries |= {f"resources/{file}": resource for file, resource in resources.items()}
    entries["modelDescription.xml"] = xml_bytes(description)
    if fmi == "3.0":
        entries["sources/buildDescription.xml"] = xml_bytes(build_description(about))
    libraries = binaries(sources, name, platforms, fmi)
    entries |= {f"binaries/{path}": library for path, library in libraries.items()}
    return NativeContent(guid=guid, entries=entries)


def _described(table: PortTable, about: About, fmi: FmiVersion) -> Element:
    return fmi3_model_description(table, about) if fmi == "3.0" else model_description(table, about)


def _guid(files: Mapping[str, bytes], description: bytes) -> str:
    digest = hashlib.sha256(json.dumps(sorted(files)).encode())
    for part in (*(files[file] for file in sorted(files)), description):
        digest.update(len(part).to_bytes(8, "little") + part)
    return f"{{{uuid.uuid5(uuid.NAMESPACE_OID, digest.hexdigest())}}}"
