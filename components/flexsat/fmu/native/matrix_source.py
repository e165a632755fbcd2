"""Write the matrices of a component as C: a structure with a field for each, and a constant for each variant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ...variants import AS_PUBLISHED, CORRECTED
from .c_text import wrapped, wrapped_doubles


def matrix_sources(component: str, variants: Mapping[str, Any]) -> dict[str, str]:
    """Return the files data.h and data.c of a component.

    Parameters
    ----------
    component : "plant", "sensors", "controller"
    variants : the matrices of each variant by its name, all of the same frozen class

    An array `x` becomes `const double *x`, row after row, with `x_rows` and `x_columns`, the product of all further
    dimensions; indices become `const int *x`; numbers are `int` or `double`. Doubles are written in hexadecimal,
    so that they are exact.
    """
    kind = f"{component.capitalize()}Data"
    source = ["/* Generated; see data.h. */", '#include "data.h"', ""]
    written: dict[bytes, str] = {}  # equal arrays of several variants are written once
    for name, matrices in variants.items():
        entries: list[str] = []
        for field in fields(matrices):
            entries += _entries(field.name, getattr(matrices, field.name), f"{name}_{field.name}", source, written)
        source += [f"const {kind} {component}_{name} = {{", *(f"    {entry}," for entry in entries), "};", ""]
    return {"data.h": matrix_header(component, variants), "data.c": "\n".join(source).rstrip() + "\n"}


def matrix_header(component: str, variants: Mapping[str, Any]) -> str:
    """Return the file data.h of a component; arguments as of `matrix_sources`."""
    kind = f"{component.capitalize()}Data"
    some = next(iter(variants.values()))
    lines = [
        f"/* Generated: matrices of the {component}, as flexsat.runtime describes them in {type(some).__name__}. */",
        "#ifndef FLEXSAT_DATA_H",
        "#define FLEXSAT_DATA_H",
        "",
        f"typedef struct {kind} {{",
        *(f"    {line}" for field in fields(some) for line in _declaration(field.name, getattr(some, field.name))),
        f"}} {kind};",
        "",
        *(f"extern const {kind} {component}_{name};" for name in variants),
        *_release(component, variants),
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _release(component: str, variants: Mapping[str, Any]) -> list[str]:
    """Return whether there are matrices of a release; the others stand for them, and no run may choose them."""
    has = AS_PUBLISHED.name in variants
    return [
        f"enum {{ HAS_AS_PUBLISHED = {int(has)} }};",
        *([] if has else [f"#define {component}_{AS_PUBLISHED.name} {component}_{CORRECTED.name}"]),
    ]


def _declaration(name: str, value: Any) -> list[str]:
    if isinstance(value, np.ndarray):
        kind = "int" if value.dtype.kind in "iub" else "double"
        return [f"const {kind} *{name};", f"int {name}_rows;", f"int {name}_columns;"]
    return [f"{'int' if isinstance(value, (bool, int, np.integer)) else 'double'} {name};"]


def _entries(name: str, value: Any, label: str, source: list[str], written: dict[bytes, str]) -> list[str]:
    """Return the initialisers of a field; an array that has not been written yet is added to `source`."""
    if not isinstance(value, np.ndarray):
        number = str(int(value)) if isinstance(value, (bool, int, np.integer)) else float(value).hex()
        return [f".{name} = {number}"]
    kind = "int" if value.dtype.kind in "iub" else "double"
    content = kind.encode() + np.ascontiguousarray(value).tobytes()
    known = written.setdefault(content, label)
    if known == label:
        whole = kind == "int" or not value.size  # C has no empty arrays
        lines = wrapped([str(int(v)) for v in value.ravel()] or ["0"]) if whole else wrapped_doubles(value)
        source += [f"static const {kind} {label}[{value.size or 1}] = {{", *lines, "};", ""]
    rows = value.shape[0] if value.ndim else 1
    columns = value.size // rows if rows else 0
    return [f".{name} = {known}", f".{name}_rows = {rows}", f".{name}_columns = {columns}"]
