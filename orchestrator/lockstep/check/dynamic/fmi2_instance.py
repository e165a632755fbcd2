"""One instance of an FMU, driven call by call: every call is noted, and every bad status an exception."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.logging import addLoggerProxy

from lockstep.check.dynamic.experiment import PERIOD, Experiment
from lockstep.check.dynamic.trajectory import Trajectory
from lockstep.processes.last_call import LastCall

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
STATUS_NAMES = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")

Row = tuple[Any, Any, list[bytes]]  # real outputs, integer and boolean outputs, strings

# fmpy's proxy knows one logger for the whole process, so there is one here too, which finds the instance by its
# environment
_instances: WeakValueDictionary[int, Instance] = WeakValueDictionary()
_environments = count(1)


def status_name(status: int) -> str:
    """Return the name of a status."""
    return STATUS_NAMES[status] if 0 <= status < len(STATUS_NAMES) else f"the unknown status {status}"


def location(folder: Path, form: str) -> str:
    """Return a folder's URI: "encoded" as RFC 3986 wants, "raw" with letters as they are, or "bare" of an authority.

    FMI 2.0 (2.1.5) obliges FMUs to understand the scheme `file` with and without the authority.
    """
    uri = folder.as_uri()
    return {"encoded": uri, "raw": f"file://{folder}", "bare": uri.replace("file:///", "file:/", 1)}[form]


class Failed(Exception):
    """The FMU did not do what every FMU must; one line."""


class CallFailed(Failed):
    """A call was answered with a status from fmi2Discard on; names the call, the time and what was logged."""

    def __init__(self, call: str, status: int, logged: str) -> None:
        super().__init__(
            f"{call} returned {status_name(status)}" + (f": {logged}" if logged else ", and logged nothing")
        )
        self.status = status


class Instance:
    """An instantiated FMU. `close` terminates, frees and unloads as far as FMI allows after what happened."""

    def __init__(
        self, experiment: Experiment, folder: Path, last_call: LastCall, name: str = "checked", form: str = "encoded"
    ) -> None:
        self.experiment, self.name, self._last_call = experiment, name, last_call
        self.messages: deque[tuple[int, str, str, str]] = deque(maxlen=20)  # status, category, instance, text
        self.worst, self._alive, self._stepping = OK, False, False
        self._at: float | None = None  # [s] where the instance stands
        self._kept: list[object] = []
        self._load(folder)
        self._instantiate(location(folder / "resources", form))
        self.write, self.read = self._exchanges()

    def _load(self, folder: Path) -> None:
        self._enter("loading the library")
        try:
            self._fmu = fmi2.FMU2Slave(
                guid=self.experiment.guid,
                modelIdentifier=self.experiment.identifier,
                unzipDirectory=str(folder),
                instanceName=self.name,
                requireFunctions=False,
            )
        except Exception as error:  # fmpy raises bare Exception, ctypes AttributeError for a missing function
            raise Failed(f"cannot load the library: {' '.join(str(error).split())}") from None
        self._leave()

    def _instantiate(self, resources: str) -> None:
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        callbacks.componentEnvironment = next(_environments)
        _instances[callbacks.componentEnvironment] = self
        addLoggerProxy(byref(callbacks))
        self._callbacks = callbacks  # the library keeps their address
        function = self._fmu.dll["fmi2Instantiate"]
        function.restype = c_void_p
        function.argtypes = (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int)
        self._enter("fmi2Instantiate")
        self.component = function(
            self.name.encode(),
            fmi2.fmi2CoSimulation,
            self.experiment.guid.encode(),
            resources.encode(),
            byref(callbacks),
            0,  # not visible
            1,  # logging on
        )
        self._leave()
        if not self.component:
            with suppress(OSError):
                self._fmu.freeLibrary()
            raise Failed(f"fmi2Instantiate returned no instance: {self.logged() or 'it logged no reason'}")
        self._alive = True

    # Calls.

    def function(self, name: str, *types: type) -> Callable[..., int]:
        """Return a function of the library; its first argument is always the instance."""
        try:
            found = self._fmu.dll[name]  # an object of our own, unlike the attribute
        except AttributeError:
            raise Failed(f"the library does not export {name}") from None
        found.argtypes, found.restype = (c_void_p, *types), c_int
        return partial(found, c_void_p(self.component))

    def ask(self, name: str, *arguments: Any, types: tuple[type, ...] = (), time: float | None = None) -> int:
        """Call a function and return its status, whatever it is."""
        function = self.function(name, *types)
        self._enter(name, time)
        status = function(*arguments)
        self._leave()
        self._note(status)
        return status

    def demand(self, name: str, *arguments: Any, types: tuple[type, ...] = (), time: float | None = None) -> None:
        """Call a function, or raise CallFailed."""
        self._must(self.ask(name, *arguments, types=types, time=time), name, time)

    @property
    def library(self) -> Any:
        """The loaded library; an index gives a function object of one's own."""
        return self._fmu.dll

    def logged(self) -> str:
        """Return the last messages of a status above fmi2OK."""
        texts = [text for status, _, _, text in self.messages if status != OK]
        return " | ".join(texts[-2:])[:400]

    def _must(self, status: int, name: str, time: float | None = None) -> None:
        if status not in (OK, WARNING):
            self._note(status)
            at = self._at if time is None else time
            raise CallFailed(f"{name} at t = {at:.9g} s" if at is not None else name, status, self.logged())

    def _note(self, status: int) -> None:
        self.worst = max(self.worst, status if status in range(PENDING) else FATAL)

    def _enter(self, name: str, time: float | None = None) -> None:
        at = self._at if time is None else time
        self._last_call.enter(name, at)

    def _leave(self) -> None:
        self._last_call.leave()

    # Life cycle.

    def initialise(self) -> None:
        """Set start values, set up the experiment without an end, and initialise."""
        for kind, reference, value in self.experiment.starts:
            kept: Any = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}[kind]
            text = str(value).encode() if kind == "String" else value if kind == "Real" else int(value)
            where = byref(c_uint32(reference)), 1, byref(kept(text))
            self.demand(f"fmi2Set{kind}", *where, types=(c_void_p, c_size_t, c_void_p))
        start = self.experiment.start_time
        types = (c_int, c_double, c_double, c_int, c_double)
        self.demand("fmi2SetupExperiment", 0, 0.0, start, 0, 0.0, types=types)
        self.demand("fmi2EnterInitializationMode")
        self.demand("fmi2ExitInitializationMode")
        self._stepping, self._at = True, start

    def reset(self) -> None:
        """Go back to where fmi2Instantiate left."""
        self.demand("fmi2Reset")
        self._stepping, self._at, self.worst = False, None, OK

    def try_step(self, time: float, step: float) -> int:
        """Call fmi2DoStep and return its status."""
        status = self.ask("fmi2DoStep", time, step, 1, types=(c_double, c_double, c_int), time=time)
        self._at = time + step
        return status

    def close(self) -> None:
        """End the instance."""
        if not self._alive or self.worst >= FATAL:
            return
        self._alive = False
        status = self.ask("fmi2Terminate") if self._stepping and self.worst < ERROR else OK
        if self.worst < FATAL:
            self._enter("fmi2FreeInstance")
            self.function("fmi2FreeInstance")()  # returns nothing; what ctypes makes of it is not looked at
            self._enter("unloading the library")
            self._fmu.freeLibrary()
            self._leave()
        self._must(status, "fmi2Terminate")

    # Values.

    def _exchanges(self) -> tuple[list[Any], list[Any]]:
        """Bind setters and getters to buffers of their own: (function, name, buffer) for each type that has ports."""
        bound: dict[str, list[Any]] = {"inputs": [], "outputs": []}
        for side, verb in (("inputs", "Set"), ("outputs", "Get")):
            for kind, dtype in (("Real", np.float64), ("Integer", np.int32), ("Boolean", np.int32)):
                ports = self.experiment.of_kind(side, kind)
                references = np.array([port.reference for port in ports], np.uint32)
                buffer = np.zeros(len(ports), dtype)
                self._kept += [references, buffer]
                if ports:
                    name = f"fmi2{verb}{kind}"
                    function = self.function(name, c_void_p, c_size_t, c_void_p)
                    where = c_void_p(references.ctypes.data), c_size_t(len(ports)), c_void_p(buffer.ctypes.data)
                    bound[side].append((partial(function, *where), name, buffer, kind))
        return bound["inputs"], bound["outputs"]

    def stimuli(self, phase: int = 0) -> list[Any]:
        """Return the stimulus of each bound setter, (PERIOD, inputs) each."""
        return [self.experiment.stimulus(kind, phase) for _, _, _, kind in self.write]

    def put(self, values: list[Any]) -> None:
        """Set the inputs, one array for each bound setter."""
        for (function, name, buffer, _), row in zip(self.write, values, strict=True):
            buffer[:] = row
            self._enter(name)
            status = function()
            if status:
                self._must(status, name)
        self._leave()

    def step(self, time: float, length: float) -> None:
        """Make one step, or raise CallFailed."""
        self._must(self.try_step(time, length), "fmi2DoStep", time)

    def row(self) -> Row:
        """Read all outputs."""
        for function, name, _, _ in self.read:
            self._enter(name)
            status = function()
            if status:
                self._must(status, name)
        self._leave()
        buffers = {kind: buffer for _, _, buffer, kind in self.read}
        nothing = np.zeros(0, np.int32)
        integers = np.concatenate([buffers.get("Integer", nothing), buffers.get("Boolean", nothing)])
        return buffers.get("Real", np.zeros(0)).copy(), integers, self._texts()

    def _texts(self) -> list[bytes]:
        ports = self.experiment.of_kind("outputs", "String")
        if not ports:
            return []
        references = np.array([port.reference for port in ports], np.uint32)
        texts = (c_char_p * len(ports))()
        where = c_void_p(references.ctypes.data), len(ports), byref(texts)
        self.demand("fmi2GetString", *where, types=(c_void_p, c_size_t, c_void_p))
        return [text or b"" for text in texts]

    def run(
        self,
        first: int,
        last: int,
        *,
        phase: int = 0,
        tables: Sequence[Any] | None = None,
        times: Sequence[tuple[float, float]] | None = None,
    ) -> Trajectory:
        """Make steps `first` to `last` - 1 under the stimulus, or under `tables`; return the outputs after each."""
        tables = self.stimuli(phase) if tables is None else tables
        rows = []
        for k in range(first, last):
            self.put([table[k % PERIOD] for table in tables])
            self.step(*(times[k] if times else (self.experiment.time(k), self.experiment.step)))
            rows.append(self.row())
        return Trajectory.of_rows(rows, self.experiment)


def _logged(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    with suppress(Exception):  # nothing may be raised into C
        instance = _instances.get(environment or 0)
        if instance is None:  # an FMU that does not hand the environment through
            instance = next(i for i in _instances.values() if i.name.encode() == name)
        words = [(part or b"").decode("utf-8", "replace") for part in (category, name, message)]
        instance.messages.append((status, words[0], words[1], " ".join(words[2].split())[:400]))


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_logged)
