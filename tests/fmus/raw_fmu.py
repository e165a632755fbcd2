"""Call an FMU of FMI 2.0 through ctypes alone: every call that C allows, legal or not."""

from __future__ import annotations

import ctypes
import zipfile
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
CO_SIMULATION = 1
KINDS = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
# the first of the variadic arguments, which is there if the format is "%s"
_LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", _LOGGER),
        ("allocate_memory", c_void_p),
        ("free_memory", c_void_p),
        ("step_finished", c_void_p),
        ("environment", c_void_p),
    )


class Library:
    """An unpacked FMU with its library, and what it logs: (name, status, category, text)."""

    def __init__(self, archive, folder):
        self.folder = Path(folder)
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(self.folder)
        root = ElementTree.parse(self.folder / "modelDescription.xml").getroot()
        self.guid = root.get("guid").encode()
        self.fixed_step = root.find("CoSimulation").get("canHandleVariableCommunicationStepSize") != "true"
        self.step = float(root.find("DefaultExperiment").get("stepSize"))
        self.variables = [(v, v[0].tag, int(v.get("valueReference"))) for v in root.iter("ScalarVariable")]
        self.reference = {v.get("name"): reference for v, _, reference in self.variables}
        identifier = root.find("CoSimulation").get("modelIdentifier")
        self.location = (self.folder / "resources").as_uri().encode()
        self.dll = ctypes.CDLL(str(self.folder / "binaries" / "linux64" / f"{identifier}.so"))
        self.dll.fmi2Instantiate.restype = c_void_p
        self.dll.fmi2FreeInstance.restype = None
        self.logged = []
        self._logger = _LOGGER(self._log)
        self.callbacks = Callbacks(logger=self._logger)

    def _log(self, _environment, name, status, category, text, detail):
        # what printf makes of the formats of flexsat
        filled = ctypes.string_at(detail) if text == b"%s" else text.replace(b"%%", b"%")
        self.logged.append((name, status, category.decode(), filled.decode()))

    def references(self, kind, causality=None):
        """Return the value references of a type, such as "Real", with a causality or with any."""
        return [r for v, tag, r in self.variables if tag == kind and causality in (None, v.get("causality"))]

    def instantiate(self, name=b"one", *, kind=CO_SIMULATION, guid=b"", location=b"", callbacks=True, logging=0):
        """Return an instance, or None; empty texts stand for the right ones."""
        made = self.dll.fmi2Instantiate(
            name,
            kind,
            self.guid if guid == b"" else guid,
            self.location if location == b"" else location,
            byref(self.callbacks) if callbacks else None,
            0,
            logging,
        )
        return RawFmu(self, made) if made else None


class RawFmu:
    """One instance; its calls return the status, whatever it is."""

    def __init__(self, library, address):
        self.library, self.dll = library, library.dll
        self.address = c_void_p(address)

    def call(self, name, *arguments):
        """Call a function by its name without prefix."""
        return self.dll[f"fmi2{name}"](self.address, *arguments)

    def free(self):
        """Free the instance."""
        self.dll.fmi2FreeInstance(self.address)
        self.address = c_void_p()

    def setup(self, start=0.0, stop=None, tolerance=None):
        """Call fmi2SetupExperiment."""
        values = (c_int(tolerance is not None), c_double(tolerance or 0.0), c_double(start))
        return self.call("SetupExperiment", *values, c_int(stop is not None), c_double(stop or 0.0))

    def initialise(self):
        """Set up the experiment and initialise; every call must succeed."""
        statuses = [self.setup(), self.call("EnterInitializationMode"), self.call("ExitInitializationMode")]
        assert statuses == [OK] * 3, (statuses, self.library.logged)
        return self

    def step(self, time, step=None):
        """Call fmi2DoStep with the step of the default experiment, or another."""
        return self.call("DoStep", c_double(time), c_double(self.library.step if step is None else step), c_int(1))

    def set(self, kind, references, values):
        """Set values of a type."""
        n = len(references)
        return self.call(f"Set{kind}", (c_uint * n)(*references), c_size_t(n), (KINDS[kind] * n)(*values))

    def get(self, kind, references):
        """Return the status and the values of a type."""
        n = len(references)
        values = (KINDS[kind] * n)()
        return self.call(f"Get{kind}", (c_uint * n)(*references), c_size_t(n), values), list(values)

    def get_state(self, state=None):
        """Return the status and a handle: the given one, or a new one."""
        state = c_void_p() if state is None else state
        return self.call("GetFMUstate", byref(state)), state

    def set_state(self, state):
        """Call fmi2SetFMUstate."""
        return self.call("SetFMUstate", state)

    def free_state(self, state):
        """Call fmi2FreeFMUstate."""
        return self.call("FreeFMUstate", byref(state))

    def serialise(self, state):
        """Return the status and the bytes of a state."""
        size = c_size_t()
        status = self.call("SerializedFMUstateSize", state, byref(size))
        if status > WARNING:
            return status, b""
        content = (ctypes.c_char * size.value)()
        return self.call("SerializeFMUstate", state, content, size), bytes(content)

    def deserialise(self, content):
        """Return the status and the handle of a state made from bytes."""
        state = c_void_p()
        return self.call("DeSerializeFMUstate", content, c_size_t(len(content)), byref(state)), state


__all__ = ["CO_SIMULATION", "DISCARD", "ERROR", "FATAL", "KINDS", "OK", "POINTER", "WARNING", "Library", "RawFmu"]
