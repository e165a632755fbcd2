"""Give a compiled twin its matrices in memory, in place of megabytes of C: quicker to compile, and easily changed."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from flexsat.fmu.native.matrix_source import matrix_header
from flexsat.fmu.native.port_source import port_places
from flexsat.ports.table import Port, PortTable
from fmus.native.twin import compile_library, sources_of

_kept: list[Any] = []  # arrays that libraries point to, as long as the process lives


def compile_with_places(
    component: str, ports: Sequence[Port], variants: Mapping[str, Any], folder: Path, options: Sequence[str] = ()
) -> Path:
    """Compile the twin of a component with places for its matrices, which `give_matrices` fills; arguments as those of
    `compile_twin`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    kind = f"{component.capitalize()}Data"
    places = "".join(f"{kind} {component}_{name};\n" for name in variants)
    (folder / "data.h").write_text(matrix_header(component, variants), encoding="utf-8")
    (folder / "ports.h").write_text(port_places(PortTable(ports)), encoding="utf-8")
    (folder / "data.c").write_text(f'#define const\n#include "data.h"\n{places}', encoding="utf-8")
    return compile_library([*sources_of(component), folder / "data.c"], folder / f"{component}.so", options, [folder])


def give_matrices(library: Path, component: str, variants: Mapping[str, Any]) -> None:
    """Fill the places of a library, in this process; instances that start later use them."""
    loaded = ctypes.CDLL(str(library))
    for name, matrices in variants.items():
        place = _structure(matrices).in_dll(loaded, f"{component}_{name}")
        for field in fields(matrices):
            value = getattr(matrices, field.name)
            if not isinstance(value, np.ndarray):
                setattr(place, field.name, value)
                continue
            array = np.ascontiguousarray(value, np.intc if value.dtype.kind in "iub" else np.float64)
            _kept.append(array)
            rows = array.shape[0] if array.ndim else 1
            setattr(place, field.name, array.ctypes.data)
            setattr(place, f"{field.name}_rows", rows)
            setattr(place, f"{field.name}_columns", array.size // rows if rows else 0)


def _structure(matrices: Any) -> type[ctypes.Structure]:
    """Return the structure of data.h."""
    entries: list[tuple[str, Any]] = []
    for field in fields(matrices):
        value = getattr(matrices, field.name)
        if isinstance(value, np.ndarray):
            sizes = ((f"{field.name}_{side}", ctypes.c_int) for side in ("rows", "columns"))
            entries += [(field.name, ctypes.c_void_p), *sizes]
        else:
            whole = isinstance(value, (bool, int, np.integer))
            entries.append((field.name, ctypes.c_int if whole else ctypes.c_double))
    return type("Data", (ctypes.Structure,), {"_fields_": entries})
