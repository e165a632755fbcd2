"""The toy component as an FMU, built once for all workers."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fmus.native.native_toy import build_native_toy, compiler_is_missing
from fmus.toys.builds import build


@pytest.fixture(scope="session")
def toy(once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the FMU of the toy component, for reading only."""

    def make(folder: Path) -> None:
        build(folder / "toy.fmu")

    return once("toy", make) / "toy.fmu"


@pytest.fixture(scope="session")
def native_toy(once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the native FMU of the toy component, for reading only."""
    reason = compiler_is_missing()
    if reason:
        pytest.skip(reason)

    def make(folder: Path) -> None:
        build_native_toy(folder / "toy.fmu")

    return once("native-toy", make) / "toy.fmu"


@pytest.fixture(scope="session")
def native_toy_fmi3(once: Callable[[str, Callable[[Path], None]], Path]) -> Path:
    """Return the native FMU of the toy component in FMI 3.0, for reading only."""
    reason = compiler_is_missing()
    if reason:
        pytest.skip(reason)

    def make(folder: Path) -> None:
        build_native_toy(folder / "toy.fmu", fmi="3.0")

    return once("native-toy-fmi3", make) / "toy.fmu"


@pytest.fixture(params=["toy", "native_toy"])
def either_toy(request: pytest.FixtureRequest) -> Path:
    """Return the FMU of the toy component in Python, then the native one: they answer the same calls the same way."""
    path: Path = request.getfixturevalue(request.param)
    return path
