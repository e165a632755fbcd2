"""Unpack an FMU, load its library, and look up its functions."""

from collections.abc import Callable
from contextlib import nullcontext
from ctypes import c_uint, cdll
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy

from lockstep.errors import RunError
from lockstep.fmi.platforms import library_path
from lockstep.fmi.safe_zip import extract, open_file, open_zip
from lockstep.fmi.signatures import SIGNATURES
from lockstep.operating_system import working_directory
from lockstep.system.component import Component

_VERSIONS = {"fmi": "1.0", "fmi2": "2.0", "fmi3": "3.0"}  # by the prefix of the functions


@dataclass(frozen=True, slots=True, kw_only=True)
class UnpackedFmu:
    """An FMU in a folder, and the names that loading and instantiating it take."""

    name: str  # of the instance
    folder: Path
    identifier: str  # names the library
    guid: str
    alone: bool = False  # in its process: loaded from the folder of its library, where some look for others
    resources: str | None = None  # URI of its resources, for FMI 2.0; None: as RFC 3986 writes it
    tolerance: float | None = None  # relative, passed before initialization by FMI 2.0 and 3.0; None: none
    native: bool = False  # no Python runs in it, nor a tool beside it: a thread may make its steps


def unpack_fmu(component: Component, folder: Path) -> None:
    """Unpack the FMU of a component into a folder, or raise InputError."""
    with (
        open_file(component.source, component.archive, component.name) as stream,
        open_zip(stream, f"{component.name}: {component.source}") as archive,
    ):
        extract(archive, folder, f"{component.name}: {component.source}")


class Library:
    """One loaded library of an FMU; FMPy's own loader changes the working directory of the whole process."""

    def __init__(self, fmu: UnpackedFmu, prefix: str) -> None:
        """Load it, or raise RunError, also if a function of the standard is missing. `prefix` is that of the version.

        The functions of FMI 1.0 carry the name of their FMU before the prefix.
        """
        self.function_prefix = f"{fmu.identifier}_{prefix}" if prefix == "fmi" else prefix
        path = fmu.folder / library_path(
            fmu.identifier, _VERSIONS[prefix], lambda inside: (fmu.folder / inside).is_file()
        )
        try:
            with working_directory(path.parent) if fmu.alone else nullcontext():
                self._library = cdll.LoadLibrary(str(path))
        except OSError as error:
            reason = " ".join(str(error).split())
            raise RunError(f"{fmu.name}: cannot load the FMU: Failed to load shared library {path}. {reason}") from None
        missing = [name for name in SIGNATURES[prefix] if not hasattr(self._library, f"{self.function_prefix}{name}")]
        if missing:
            raise RunError(
                f"{fmu.name}: cannot load the FMU: {path}: undefined symbol: {self.function_prefix}{missing[0]}"
            )

    def function(self, name: str, *argument_types: type, returns: type = c_uint) -> Callable[..., Any]:
        """Return a function by its whole name, which returns a status unless another type is given.

        A status is unsigned: one below 0, which FMI does not know, becomes a large number, worse than all others.
        """
        try:
            function = self._library[name]  # indexing makes a new object at each call
        except AttributeError:
            raise RunError(f"the library does not export {name}") from None
        function.argtypes, function.restype = argument_types, returns
        return function

    def free(self) -> None:
        """Unload it."""
        fmpy.freeLibrary(self._library._handle)
