"""Licences of an FMU's content: the sources of flexsat, and of one in Python the wrapper with its Python module."""

from __future__ import annotations

from importlib.metadata import distribution
from pathlib import Path

from ...errors import BuildError
from .render import fill

ENTRY = "license.txt"  # FMI 2.0, section 2.3: where a reader begins
OWN, WRAPPER = "flexsat-BSD-3-Clause.txt", "pythonfmu-MIT.txt"


def licence_files(native: bool = False) -> dict[str, bytes]:
    """Return the files below documentation/licenses/.

    Raises
    ------
    BuildError
        If an installed package came without its licence.
    """
    if native:
        return {ENTRY: fill("license_native.txt", own=OWN), OWN: _own_licence()}
    entry = fill("license.txt", own=OWN, wrapper=WRAPPER, wrapper_version=distribution("pythonfmu").version)
    return {ENTRY: entry, OWN: _own_licence(), WRAPPER: _installed_licence("pythonfmu")}


def _own_licence() -> bytes:
    """Return the licence of flexsat: next to the sources in a checkout, else as installed."""
    path = Path(__file__).parents[4] / "LICENSE"
    return path.read_bytes() if path.is_file() else _installed_licence("flexsat")


def _installed_licence(package: str) -> bytes:
    for file in distribution(package).files or ():
        if file.name == "LICENSE" and ".dist-info" in file.parts[0]:
            return Path(str(file.locate())).read_bytes()
    raise BuildError(f"package {package}: no LICENSE in its installation; install it again, from a wheel")
