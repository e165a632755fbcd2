"""Drive one FMU through FMPy's low-level calls, in the fresh process of a test."""

from __future__ import annotations

import ctypes
import shutil
import sys
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

__all__ = ["FMICallException", "Session"]


described = cache(fmpy.read_model_description)  # of a path; an FMU does not change while a script runs


class Session:
    """One instance of an FMU, unpacked on its own, with everything it logs."""

    def __init__(self, path, name="one", folder=None, formatted=True, raw_location=False):
        self.description = described(str(path))
        self.folder = Path(folder or tempfile.mkdtemp())
        fmpy.extract(str(path), str(self.folder))
        self.messages = []
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _, __, status, category, text: self.messages.append((status, category, text.decode()))
        )
        if formatted:  # C's printf, as most hosts do
            addLoggerProxy(ctypes.byref(callbacks))
        self.references = {v.name: (v.type, v.valueReference) for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        if raw_location:
            location = f"file://{self.folder}/resources".encode()
            self.fmu.callbacks = callbacks
            self.fmu.component = self.fmu.fmi2Instantiate(
                name.encode(), 1, self.description.guid.encode(), location, ctypes.byref(callbacks), 0, 1
            )
            assert self.fmu.component
        else:
            self.fmu.instantiate(callbacks=callbacks, loggingOn=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with suppress(FMICallException):  # where a call was refused, or initialisation did not end
            self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    def initialize(self, **parameters):
        self.fmu.setupExperiment()
        for name, value in parameters.items():
            self.set(name, value)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, name, *values):
        kind, first = self.references[name if name in self.references else f"{name}[1]"]
        getattr(self.fmu, f"set{kind}")(list(range(first, first + len(values))), list(values))

    def get(self, name, size=1):
        kind, first = self.references[name if name in self.references else f"{name}[1]"]
        values = getattr(self.fmu, f"get{kind}")(list(range(first, first + size)))
        return values[0] if size == 1 else values

    def run(self, first, last, step=0.01):
        """Step with a torque that depends on the step, and return the outputs in hexadecimal: bitwise."""
        trace = []
        for k in range(first, last):
            self.set("wheel.torque", 0.1 * k, -0.2, 0.3 / (k + 1))
            self.fmu.doStep(k * step, step)
            outputs = [*self.get("level", 3), self.get("angle"), self.get("energy")]
            trace.append([value.hex() for value in outputs] + [self.get("greeting").decode()])
        return trace


def argument(i):
    """Return an argument of the script."""
    return sys.argv[1 + i]
