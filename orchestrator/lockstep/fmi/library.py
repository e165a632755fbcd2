"""The library of an FMU: unpacked, loaded, and its functions as ctypes call them."""

import os
from collections.abc import Callable
from ctypes import c_int
from pathlib import Path
from typing import Any

from lockstep.errors import RunError
from lockstep.fmi.model_description import Description
from lockstep.fmi.safe_zip import open_file, open_zip
from lockstep.system.component import Component


class Library:
    """One loaded library. `fmu` is fmpy's object for it, which knows how to instantiate."""

    def __init__(self, component: Component, description: Description, folder: Path, kind: Callable[..., Any]) -> None:
        """Unpack the FMU into a folder and load it, or raise RunError."""
        with (
            open_file(component.source, component.archive, component.name) as stream,
            open_zip(stream, f"{component.name}: {component.source}") as archive,
        ):
            archive.extractall(folder)
        directory = Path.cwd()  # fmpy changes it while loading, and does not change it back on failure
        try:
            self.fmu = kind(
                guid=description.guid,
                modelIdentifier=description.identifier,
                unzipDirectory=str(folder),
                instanceName=component.name,
            )
        except Exception as error:  # fmpy raises bare Exception, ctypes AttributeError for a missing function
            raise RunError(f"{component.name}: cannot load the FMU: {' '.join(str(error).split())}") from None
        finally:
            os.chdir(directory)

    def function(self, name: str, *argument_types: type) -> Callable[..., int]:
        """Return a function that returns a status."""
        # indexing makes a function object of our own: fmpy's keeps its argument types, which copy buffers
        function = self.fmu.dll[name]
        function.argtypes, function.restype = argument_types, c_int
        return function  # type: ignore[no-any-return]

    def free(self) -> None:
        """Unload it."""
        self.fmu.freeLibrary()


def not_instantiated(name: str, said: str) -> RunError:
    """Return the error of an instance that was refused, with what it logged."""
    reason = said or "it logged no reason (a GUID mismatch is one)"
    return RunError(f"{name}: cannot be instantiated: {reason}")
