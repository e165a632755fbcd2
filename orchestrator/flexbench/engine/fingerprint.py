"""What a result depends on, as one hash: the same inputs, files and code give the same bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from lockstep.plain_values import plain_value
from lockstep.system.component import Component
from lockstep.system.system import System
from lockstep.whole_file import file_digest

_PACKAGES = ("flexsat", "lockstep", "flexbench")
_NUMERICAL = ("numpy", "scipy", "pyarrow")
_SOURCES = (".py", ".c", ".h")


def fingerprint(*parts: Any) -> str:
    """Return the hash of plain values, with the code."""
    text = json.dumps([code(), *parts], sort_keys=True, default=lambda value: _plain(value))
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    return repr(value) if not hasattr(value, "tolist") else plain_value(value, "a value")


def of_system(system: System) -> list[Any]:
    """Return a system as plain values, with the content of its files in place of their paths."""
    text = repr(system)
    for path in sorted(files_of(system), key=lambda path: len(str(path)), reverse=True):
        text = text.replace(repr(path), f"<{file_digest(path)}>")
    return [system.name, text]


def files_of(system: System) -> set[Path]:
    """Return the files that a system is simulated from: its FMUs, or the packages that hold them."""
    return {path for component in system.components for path in _files(component)}


def _files(component: Component) -> Iterator[Path]:
    if component.sums is None:
        yield component.archive or component.source
    if component.stands_for is not None:
        yield from _files(component.stands_for)
    if component.shadow is not None:
        yield from _files(component.shadow.component)


@cache
def code() -> str:
    """Return the hash of the code and the versions of the numerical libraries."""
    digest = hashlib.sha256(" ".join(f"{name} {version(name)}" for name in _NUMERICAL).encode())
    for package in _PACKAGES:
        found = find_spec(package)
        assert found is not None
        root = Path(str(found.origin)).parent
        for path in sorted(path for path in root.rglob("*") if path.suffix in _SOURCES):
            digest.update(f"{package}/{path.relative_to(root).as_posix()}".encode() + path.read_bytes())
    return digest.hexdigest()


def code_changed() -> bool:
    """Return whether the code was changed since `code` was called first; what is imported then may not fit the rest."""
    return code.cache_info().currsize > 0 and code.__wrapped__() != code()
