"""Collect the source files that a shell imports, so that exactly these travel in its FMU."""

from __future__ import annotations

import ast
import importlib.util
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

ALLOWED = frozenset({"numpy", "pythonfmu"})  # with the standard library, all that a built FMU may need
_MOST_MODULES = 1000  # whose imports are kept: more than all FMUs have


def module_sources(module: str) -> dict[str, bytes]:
    """Return the sources of a module and of all it imports, by path below the parent of its top package.

    Raises
    ------
    ValueError
        For an absolute import of anything but the standard library, numpy and pythonfmu, and for an import of the
        package inside a function: by then the folder that an FMU was unpacked to may be gone.
    """
    found: dict[str, bytes] = {}
    todo = [module]
    seen: set[str] = set()
    while todo:
        name = todo.pop()
        if name in seen:
            continue
        seen.add(name)
        path, is_package = _locate(name)
        source = path.read_bytes()
        found["/".join(name.split(".")) + ("/__init__.py" if is_package else ".py")] = source
        if "." in name:
            todo.append(name.rpartition(".")[0])  # importing a module runs the packages above it
        todo += _imports(source, name, is_package, path)
    return dict(sorted(found.items()))


def _locate(name: str) -> tuple[Path, bool]:
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        raise ValueError(f"{name}: no such module")
    return Path(spec.origin), spec.submodule_search_locations is not None


@lru_cache(_MOST_MODULES)  # several FMUs have the same
def _imports(source: bytes, name: str, is_package: bool, path: Path) -> tuple[str, ...]:
    """Return the modules of the package that a module imports when it is loaded."""
    return tuple(_imported(ast.parse(source, filename=str(path)), name, is_package, path))


def _imported(tree: ast.Module, name: str, is_package: bool, path: Path) -> Iterator[str]:
    for node, inside in _statements(tree, False):
        if isinstance(node, ast.ImportFrom) and node.level > 0:
            if inside:
                raise ValueError(
                    f"{path.name}:{node.lineno}: import of the package inside a function; move it to the top"
                )
            yield from _relative(node, name, is_package, path)
            continue
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [str(node.module)]
        for imported in names:
            top = imported.partition(".")[0]
            if top not in sys.stdlib_module_names and top not in ALLOWED:
                remedy = " (use a relative import)" if top == name.partition(".")[0] else ""
                raise ValueError(
                    f"{path.name}:{node.lineno}: {name} imports {imported}; an FMU has the standard library, "
                    f"{' and '.join(sorted(ALLOWED))}{remedy}"
                )


def _relative(node: ast.ImportFrom, name: str, is_package: bool, path: Path) -> Iterator[str]:
    parts = name.split(".")
    kept = len(parts) - node.level + (1 if is_package else 0)
    if kept < 1:
        raise ValueError(f"{path.name}:{node.lineno}: relative import beyond the top package")
    base = ".".join(parts[:kept] + ([node.module] if node.module else []))
    yield base
    if _locate(base)[1]:
        for alias in node.names:
            if importlib.util.find_spec(f"{base}.{alias.name}") is not None:
                yield f"{base}.{alias.name}"


def _statements(node: ast.AST, inside: bool) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Yield every import that runs, and whether it stands in a function."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.Import, ast.ImportFrom)):
            yield child, inside
        elif isinstance(child, ast.If) and ast.unparse(child.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
            for other in child.orelse:
                yield from _statements(other, inside)
        else:
            yield from _statements(
                child, inside or isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))
            )
