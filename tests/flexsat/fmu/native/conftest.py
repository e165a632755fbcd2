"""The C twins of the components, compiled once for all workers; tests skip where there is no compiler."""

import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from flexsat.ports.table import Port
from fmus.native.twin import compile_twin

Compiled = Callable[[str, str, Sequence[Port], Mapping[str, Any]], Path]


@pytest.fixture(scope="session")
def compiled(once: Callable[[str, Callable[[Path], None]], Path]) -> Compiled:
    """Return a function that compiles a component, under a name for its matrices, and returns the library's path."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: `cc` is not on the path")

    def library(name: str, component: str, ports: Sequence[Port], variants: Mapping[str, Any]) -> Path:
        def make(folder: Path) -> None:
            compile_twin(component, ports, variants, folder)

        return once(f"native-{name}-{component}", make) / f"{component}.so"

    return library
