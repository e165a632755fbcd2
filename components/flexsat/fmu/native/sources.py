"""Collect the C files of a native FMU: those of the FMI layer and of its component, and those generated for it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...ports.table import FmiVersion, PortTable
from .matrix_source import matrix_sources
from .port_source import port_places, port_table

NATIVE = "native"  # folder of the FMUs; their models have the names of the Python FMUs, being the same models
FMI3 = "fmi3"  # folder in that, of the FMUs of FMI 3.0
FOLDER = Path(__file__).with_name("c")
LAYERS: dict[FmiVersion, tuple[str, ...]] = {"2.0": ("fmi", "fmi2"), "3.0": ("fmi", "fmi3")}  # folders of the FMI layer
IN_C: dict[FmiVersion, str] = {"2.0": "native", "3.0": "FMI 3.0"}  # what a build's manifest calls the FMUs
IDENTITY = "identity.c"
INCLUDE = re.compile(r'^#include "(\w+\.h)"', re.MULTILINE)


def native_folder(layout: Path, fmi: FmiVersion = "2.0") -> Path:
    """Return the folder of the native FMUs of a version of FMI, in the folder of a layout."""
    return layout / NATIVE if fmi == "2.0" else layout / NATIVE / FMI3


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """What the FMI layer knows of the FMU that it is in, apart from its ports.

    Attributes
    ----------
    equal_steps : whether all steps have to be as long as the first
    step_parameter : parameter that sets the only step accepted, if one does
    """

    guid: str
    equal_steps: bool
    step_parameter: str | None


def c_files() -> dict[str, Path]:
    """Return the C files and headers of all folders by their names; an FMU has those that it needs in one folder."""
    return {path.name: path for path in sorted(FOLDER.rglob("*.[ch]"))}


def component_sources(main: Path, fmi: FmiVersion = "2.0") -> dict[str, bytes]:
    """Return the C files of the FMI layer and of a component, by name.

    Parameters
    ----------
    main : the component's own file, such as plant.c; with it come the headers that it includes, and the C files
        of the same names as those, from its folder or from those of flexsat
    """
    there = c_files() | {path.name: path for path in main.parent.glob("*.[ch]")}
    found: dict[str, bytes] = {}
    todo = [path.name for layer in LAYERS[fmi] for path in (FOLDER / layer).glob("*.c")] + [main.name]
    while todo:
        name = todo.pop()
        if name in found or name not in there:  # a generated header is none of these files
            continue
        found[name] = there[name].read_bytes()
        for header in INCLUDE.findall(found[name].decode("ascii")):
            todo += [header, header.removesuffix(".h") + ".c"]
    return dict(sorted(found.items()))


def generated_sources(component: str, table: PortTable, variants: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the generated files, but for the identity: the ports, and the matrices of each variant if it has any."""
    texts = {"ports.h": port_places(table), "ports.c": port_table(table)}
    texts |= matrix_sources(component, variants) if variants else {}
    return {name: text.encode("ascii") for name, text in texts.items()}


def identity_source(identity: Identity) -> bytes:
    """Return the source identity.c."""
    set_by = "NULL" if identity.step_parameter is None else f'"parameter {identity.step_parameter}"'
    lines = [
        "/* Generated; see identity.h. */",
        '#include "identity.h"',
        "",
        "#include <stddef.h>",
        "",
        f'const Identity this_fmu = {{"{identity.guid}", {int(identity.equal_steps)}, {set_by}}};',
    ]
    return ("\n".join(lines) + "\n").encode("ascii")
