"""Call an FMU of FMI 3.0 through ctypes alone: every call that C allows, legal or not."""

from __future__ import annotations

import ctypes
import zipfile
from ctypes import byref, c_bool, c_char, c_char_p, c_double, c_int32, c_size_t, c_uint32, c_void_p
from pathlib import Path
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
TYPES = {"Float64": c_double, "Int32": c_int32, "Boolean": c_bool, "String": c_char_p}
_LOGGER = ctypes.CFUNCTYPE(None, c_void_p, ctypes.c_int, c_char_p, c_char_p)


class Library3:
    """An unpacked FMU with its library, and what it logs: (status, category, text)."""

    def __init__(self, archive, folder):
        self.folder = Path(folder)
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(self.folder)
        root = ElementTree.parse(self.folder / "modelDescription.xml").getroot()
        self.token = root.get("instantiationToken").encode()
        self.step = float(root.find("DefaultExperiment").get("stepSize"))
        self.variables = list(root.find("ModelVariables"))
        self.reference = {v.get("name"): int(v.get("valueReference")) for v in self.variables}
        self.size = {v.get("name"): int(v.find("Dimension").get("start")) if len(v.findall("Dimension")) else 1
                     for v in self.variables}  # fmt: skip
        identifier = root.find("CoSimulation").get("modelIdentifier")
        self.path = self.folder / "binaries" / "x86_64-linux" / f"{identifier}.so"
        self.dll = ctypes.CDLL(str(self.path))
        for name in ("CoSimulation", "ModelExchange", "ScheduledExecution"):
            getattr(self.dll, f"fmi3Instantiate{name}").restype = c_void_p
        self.dll.fmi3GetVersion.restype = c_char_p
        self.dll.fmi3FreeInstance.restype = None
        self.logged = []
        self.logger = _LOGGER(lambda _, status, category, text: self.logged.append((status, category, text.decode())))

    def instantiate(
        self,
        name=b"one",
        *,
        token=b"",
        resources=b"",
        logging=True,
        events=False,
        early=False,
        required=(),
        logger=True,
    ):
        """Return an instance, or None; an empty token, and empty resources, stand for the right ones."""
        folder = f"{self.folder / 'resources'}/".encode() if resources == b"" else resources
        made = self.dll.fmi3InstantiateCoSimulation(
            name, self.token if token == b"" else token, folder, c_bool(False), c_bool(logging), c_bool(events),
            c_bool(early), (c_uint32 * len(required))(*required), c_size_t(len(required)), None,
            self.logger if logger else None, None,
        )  # fmt: skip
        return RawFmu3(self, made) if made else None


class RawFmu3:
    """One instance; its calls return the status, whatever it is."""

    def __init__(self, library, address):
        self.library, self.dll = library, library.dll
        self.address = c_void_p(address)
        self.flags = (c_bool * 3)(True, True, True)  # of a step: events, end, early
        self.reached = c_double(-1.0)

    def call(self, name, *arguments):
        """Call a function by its name without prefix."""
        return self.dll[f"fmi3{name}"](self.address, *arguments)

    def free(self):
        """Free the instance."""
        self.dll.fmi3FreeInstance(self.address)
        self.address = c_void_p()

    def enter(self, start=0.0, stop=None, tolerance=None):
        """Call fmi3EnterInitializationMode."""
        values = (c_bool(tolerance is not None), c_double(tolerance or 0.0), c_double(start))
        return self.call("EnterInitializationMode", *values, c_bool(stop is not None), c_double(stop or 0.0))

    def initialise(self):
        """Initialise; every call must succeed."""
        statuses = [self.enter(), self.call("ExitInitializationMode")]
        assert statuses == [OK] * 2, (statuses, self.library.logged)
        return self

    def step(self, time, step=None):
        """Call fmi3DoStep with the step of the default experiment, or another; its answers are `flags`, `reached`."""
        self.flags[:], self.reached.value = (True, True, True), -1.0
        places = [c_void_p(ctypes.addressof(self.flags) + k) for k in range(3)]
        length = c_double(self.library.step if step is None else step)
        return self.call("DoStep", c_double(time), length, c_bool(True), *places, byref(self.reached))

    def set(self, kind, names, values, size=None):
        """Set values of a type, of variables by name or value reference."""
        references = [self.library.reference.get(name, name) for name in names]
        given = (TYPES[kind] * len(values))(*values)
        count = c_size_t(len(values) if size is None else size)
        return self.call(f"Set{kind}", (c_uint32 * len(names))(*references), c_size_t(len(names)), given, count)

    def get(self, kind, names, size=None):
        """Return the status and the values of a type, of variables by name or value reference."""
        references = [self.library.reference.get(name, name) for name in names]
        if size is None:
            size = sum(self.library.size.get(name, 1) for name in names)
        values = (TYPES[kind] * size)()
        given = ((c_uint32 * len(names))(*references), c_size_t(len(names)))
        return self.call(f"Get{kind}", *given, values, c_size_t(size)), list(values)

    def get_state(self):
        """Return the status and the handle of a new state."""
        state = c_void_p()
        return self.call("GetFMUState", byref(state)), state

    def serialise(self, state):
        """Return the status and the bytes of a state."""
        size = c_size_t()
        status = self.call("SerializedFMUStateSize", state, byref(size))
        if status > WARNING:
            return status, b""
        content = (c_char * size.value)()
        return self.call("SerializeFMUState", state, content, size), bytes(content)

    def deserialise(self, content):
        """Return the status and the handle of a state made from bytes."""
        state = c_void_p()
        return self.call("DeserializeFMUState", content, c_size_t(len(content)), byref(state)), state
