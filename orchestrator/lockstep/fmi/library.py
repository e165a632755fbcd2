"""Unpack an FMU, load its library, and look up its functions."""

import os
from collections.abc import Callable
from ctypes import c_uint
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lockstep.errors import RunError
from lockstep.fmi.safe_zip import extract, open_file, open_zip
from lockstep.system.component import Component


@dataclass(frozen=True, slots=True, kw_only=True)
class UnpackedFmu:
    """An FMU in a folder, and the names that loading and instantiating it take."""

    name: str  # of the instance
    folder: Path
    identifier: str  # names the library
    guid: str
    resources: str | None = None  # URI of its resources, for FMI 2.0; None: as RFC 3986 writes it
    tolerance: float | None = None  # relative, passed before initialization by FMI 2.0 and 3.0; None: none


def unpack_fmu(component: Component, folder: Path) -> None:
    """Unpack the FMU of a component into a folder, or raise InputError."""
    with (
        open_file(component.source, component.archive, component.name) as stream,
        open_zip(stream, f"{component.name}: {component.source}") as archive,
    ):
        extract(archive, folder, f"{component.name}: {component.source}")


class Library:
    """One loaded library. `fmu` is fmpy's object for it."""

    def __init__(self, fmu: UnpackedFmu, kind: Callable[..., Any]) -> None:
        """Load it, or raise RunError, also if a function of the standard is missing."""
        directory = Path.cwd()  # fmpy changes it while loading, and does not change it back on failure
        try:
            self.fmu = kind(
                guid=fmu.guid,
                modelIdentifier=fmu.identifier,
                unzipDirectory=str(fmu.folder),
                instanceName=fmu.name,
            )
        except Exception as error:  # fmpy raises bare Exception, ctypes AttributeError for a missing function
            raise RunError(f"{fmu.name}: cannot load the FMU: {' '.join(str(error).split())}") from None
        finally:
            os.chdir(directory)

    def function(self, name: str, *argument_types: type, returns: type = c_uint) -> Callable[..., Any]:
        """Return a function, which returns a status unless another type is given.

        A status is unsigned: one below 0, which FMI does not know, becomes a large number, worse than all others.
        """
        # indexing makes a new function object: fmpy's keeps its argument types, which copy buffers
        function = self.fmu.dll[name]
        function.argtypes, function.restype = argument_types, returns
        return function  # type: ignore[no-any-return]

    def free(self) -> None:
        """Unload it."""
        self.fmu.freeLibrary()
