"""Collect the files of the exported controller: the C files that native FMUs have, without those of FMI."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from ...controller_weights import ControllerDesign
from ...ports.controller import ports
from ...ports.table import PortTable
from ...runtime.controller_parameters import ControllerMatrices
from ...variants import VARIANTS
from ..native.matrix_source import matrix_sources
from ..native.port_source import port_places
from ..native.sources import INCLUDE, c_files
from .header import Precision, controller_header
from .memory_size import memory_size, sizes_of, state_size
from .parameter_source import parameter_source
from .readme import makefile, readme

MAIN = "flexsat_controller.c"
HEADER = "flexsat_controller.h"
EXAMPLE = ("example.c", "rigid_spacecraft.c", "rigid_spacecraft.h")  # run on a host, not in the target
NAMES = "flexsat_names.h"
# sources of the FMUs in whose place the export has others: those take memory of the caller, and need no stdio
REPLACED = {"memory.c": "caller_memory.c", "component.c": "plain_messages.c", "number_text.c": "plain_messages.c"}
BYTES = {"double": 8, "float": 4}
_FUNCTION = re.compile(r"^(?!typedef|static|extern)[A-Za-z_][\w ]*[ *](\w+)\(", re.MULTILINE)
_DATA = re.compile(r"^extern const [\w *]*?(\w+)(?:\[\])?;", re.MULTILINE)


def controller_files(
    matrices: ControllerMatrices, configuration: str, design: ControllerDesign, precision: Precision
) -> dict[str, bytes]:
    """Return the files of the export by name.

    Parameters
    ----------
    matrices : of the design
    configuration : name of the layout, for comments
    precision : of the numbers of a step
    """
    table = PortTable(ports(matrices))
    names = [variant.name for variant in VARIANTS]  # one set of arrays, whichever is chosen
    data = matrix_sources("controller", dict.fromkeys(names, matrices))
    about = f"The flight controller of the {configuration} layout, {design} design, in {precision}s."
    sizes = sizes_of(matrices, BYTES[precision])
    identity = hashlib.sha256("".join([precision, configuration, design, data["data.c"]]).encode()).digest()[:8]
    memory, saved = memory_size(sizes), state_size(sizes)
    number = int.from_bytes(identity, "little")
    files = {path.name: path.read_text(encoding="ascii") for path in _sources()}
    files |= data | {
        "ports.h": port_places(table),
        HEADER: controller_header(table, precision, matrices.period, number, memory, saved, about),
        "parameter_table.c": parameter_source(table, design),
    }
    files[NAMES] = _names(files, precision)
    for name in files:
        if name.endswith(".c"):
            files[name] = f'#include "{NAMES}"\n{files[name]}'
    targets = sorted(name for name in files if name.endswith(".c") and name not in EXAMPLE)
    files["Makefile"] = makefile(targets, EXAMPLE)
    files["README.md"] = readme(table, matrices, about, precision, memory, saved)
    return {name: text.encode("ascii") for name, text in sorted(files.items())}


def _sources() -> Iterator[Path]:
    """Yield the files that the main one and the example need."""
    there = c_files()
    found: set[str] = set()
    todo = [MAIN, *EXAMPLE]
    while todo:
        name = todo.pop()
        name = REPLACED.get(name, name)
        if name in found or name not in there:
            continue
        found.add(name)
        yield there[name]
        for header in INCLUDE.findall(there[name].read_text(encoding="ascii")):
            todo += [header, header.removesuffix(".h") + ".c"]


def _names(files: Mapping[str, str], precision: Precision) -> str:
    """Return a header that gives all functions and constants of several files a name of their own.

    Flight software is linked in one piece: a function `solve` would stand in the way of another one.
    """
    texts = [text for name, text in files.items() if name.endswith(".h")]
    names = {name for text in texts for pattern in (_FUNCTION, _DATA) for name in pattern.findall(text)}
    lines = [
        "/* Generated: names that meet no others where flight software is linked, and the numbers of a step. */",
        "#ifndef FLEXSAT_NAMES_H",
        "#define FLEXSAT_NAMES_H",
        "",
        *(["#define FLEXSAT_FLOATS", ""] if precision == "float" else []),
        *(f"#define {name} flexsat_{name}" for name in sorted(names) if not name.startswith("flexsat_")),
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"
