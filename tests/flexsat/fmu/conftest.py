"""The toy component as an FMU, built once for all workers."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fmus.toys.builds import build


@pytest.fixture(scope="session")
def toy(once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the FMU of the toy component, for reading only."""

    def make(folder: Path) -> None:
        build(folder / "toy.fmu")

    return once("toy", make) / "toy.fmu"
