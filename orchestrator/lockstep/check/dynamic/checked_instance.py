"""One instance of an FMU under check: each call is recorded before it is made, and each bad status raises RunError."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from ctypes import byref, c_char, c_char_p, c_size_t, c_uint32, c_void_p
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.experiment import PERIOD, Experiment, Port
from lockstep.check.dynamic.trajectory import Trajectory
from lockstep.errors import RunError
from lockstep.fmi.fmi2 import Fmi2Slave
from lockstep.fmi.instance import Hooks
from lockstep.fmi.instantiate import instantiate_unpacked
from lockstep.fmi.library import UnpackedFmu
from lockstep.fmi.model_description import Variable
from lockstep.fmi.saved_state import spelled
from lockstep.fmi.slave import DTYPES, FATAL, OK, PENDING, WARNING, Scalar, regular_end
from lockstep.processes.last_call import LastCall
from lockstep.system.component import Value

NAME = "checked"  # of the instance that most checks make

OutputRow = tuple[Any, Any, list[bytes]]  # real outputs, integer and boolean outputs, strings


class PortCall(NamedTuple):
    """A bound setter or getter of all ports of one type, and the buffer that it works on."""

    call: Callable[[], int]
    name: str  # without the prefix of the version
    buffer: NDArray[Any]
    ports: tuple[Port, ...]
    scalar: Scalar


def location(folder: Path, form: str) -> str:
    """Return a folder's URI: "encoded" as RFC 3986 wants, "raw" with letters as they are, or "bare" of an authority.

    FMI 2.0 (2.1.5) obliges FMUs to understand the scheme `file` with and without the authority.
    """
    uri = folder.as_uri()
    return {"encoded": uri, "raw": f"file://{folder}", "bare": uri.replace("file:///", "file:/", 1)}[form]


class CheckedInstance:
    """An instance of any version of FMI; `close` ends it as far as FMI allows after what happened."""

    def __init__(
        self,
        experiment: Experiment,
        folder: Path,
        last_call: LastCall,
        name: str = NAME,
        form: str = "encoded",
        variables: Iterable[Variable] = (),
    ) -> None:
        self.experiment, self.name, self._last_call = experiment, name, last_call
        self.messages: deque[tuple[int, str, str, str]] = deque(maxlen=20)  # status, category, instance, text
        self._at: float | None = None  # [s] simulated time that the instance has reached
        self._prefix = experiment.prefix
        fmu = UnpackedFmu(
            name=name,
            folder=folder,
            identifier=experiment.identifier,
            guid=experiment.guid,
            alone=True,
            resources=location(folder / "resources", form),
            tolerance=experiment.tolerance,
        )
        hooks = Hooks(log=lambda *_: None, message=self._take_message, call=self._record_call)
        self._slave = instantiate_unpacked(fmu, experiment.fmi, variables, hooks)
        self.do_step = self._slave.do_step
        self._text_call: PortCall | None = None
        self._stimuli: dict[int, list[NDArray[Any]]] = {}  # by phase
        self.write = [self._port_call("Set", ports, scalar) for scalar, ports in experiment.by_type("inputs").items()]
        self._read = {
            scalar: self._port_call("Get", ports, scalar) for scalar, ports in experiment.by_type("outputs").items()
        }

    @property
    def read(self) -> list[PortCall]:
        """The getters of numbers."""
        return list(self._read.values())

    @property
    def worst(self) -> int:
        """The worst status of all calls since it was instantiated or reset."""
        return self._slave.instance.worst

    # Calls.

    def call(self, name: str, *arguments: object) -> int:
        """Call a function by its name without prefix, and return its status, whatever it is."""
        status = self._slave.instance.call(name, *arguments)
        self._note(status)
        return status

    def demand(self, name: str, *arguments: object) -> None:
        """Call a function, or raise RunError."""
        self._must(self.call(name, *arguments), name)

    def library_text(self, name: str) -> bytes:
        """Return what a function without arguments answers, such as GetVersion."""
        library = self._slave.instance.library
        text: bytes = library.function(f"{library.function_prefix}{name}", returns=c_char_p)()
        return text

    def logged(self) -> str:
        """Return the last messages of a status above OK."""
        texts = [text for status, _, _, text in self.messages if status != OK]
        return " | ".join(texts[-2:])[:400]

    def _take_message(self, status: int, category: str, name: str, text: str) -> None:
        self.messages.append((status, category, name, " ".join(text.split())[:400]))

    def _record_call(self, name: str) -> None:
        if name:
            self._last_call.enter(name, self._at)
        else:
            self._last_call.leave()

    def _must(self, status: int, name: str, time: float | None = None) -> None:
        if status in (OK, WARNING):
            return
        self._note(status)
        at = self._at if time is None else time
        moment = f" at t = {at:.9g} s" if at is not None else ""
        logged = self.logged()
        reason = f": {logged}" if logged else ", and logged nothing"
        raise RunError(f"{self._slave.outcome(name, status)}{moment}{reason}")

    def _note(self, status: int) -> None:
        self._slave.failed(status if status in range(PENDING) else FATAL)

    # Life cycle.

    def initialise(self) -> None:
        """Set up the experiment without an end, set start values, and initialise."""
        self.set_up()
        self._set_start(self.experiment.starts)
        self._make("EnterInitializationMode", self._slave.enter_initialization)
        self._make("ExitInitializationMode", self._slave.exit_initialization)
        self._at = self.experiment.start_time

    def set_up(self) -> None:
        """Announce an experiment without an end."""
        start = self.experiment.start_time
        self._make("SetupExperiment", lambda: self._slave.setup_experiment(start, None))

    def set_values(self, values: Iterable[tuple[Port, float]]) -> None:
        """Set ports and parameters that are numbers."""
        self._set_start([(p.scalar, p.reference, v if p.kind == "Real" else int(v)) for p, v in values])

    def values(self, ports: Sequence[Port]) -> dict[str, float]:
        """Return the present values of ports and parameters that are numbers, by name."""
        found: dict[str, float] = {}
        for scalar in dict.fromkeys(port.scalar for port in ports):
            group = tuple(port for port in ports if port.scalar == scalar)
            get = self._port_call("Get", group, scalar)
            self._make(get.name, get.call)
            found |= {port.name: float(value) for port, value in zip(group, get.buffer, strict=True)}
        return found

    def _set_start(self, starts: Iterable[tuple[Scalar, int, Value]]) -> None:
        by_type: dict[Scalar, dict[int, Value]] = {}
        for scalar, reference, value in starts:
            by_type.setdefault(scalar, {})[reference] = value
        for scalar, values in by_type.items():
            self._make(f"Set{scalar}", partial(self._slave.set_start, values, scalar))

    def _make(self, name: str, call: Callable[[], int]) -> None:
        """Make a call that the driver reports, or does not because it is bound."""
        self._last_call.enter(f"{self._prefix}{name}", self._at)
        status = call()
        self._last_call.leave()
        self._must(status, name)

    def reset(self) -> None:
        """Return to the state after instantiation."""
        self._must(self._slave.reset(), "Reset")
        self._at = None

    def try_step(self, time: float, step: float) -> int:
        """Make a step and return its status."""
        self._last_call.enter(f"{self._prefix}DoStep", time)
        status = self.do_step(time, step, 1)
        self._last_call.leave()
        if status:
            self._note(status)
        self._at = time + step
        return status

    def close(self) -> None:
        """End the instance; raise RunError if it refuses to terminate."""
        if not self._slave.instance.alive or self.worst >= FATAL:
            return
        before = max(WARNING, self.worst)
        self._slave.close()
        if self.worst > before:
            self._must(self.worst, "TerminateSlave" if self._prefix == "fmi" else "Terminate")

    # Values.

    def _port_call(self, verb: str, ports: tuple[Port, ...], scalar: Scalar) -> PortCall:
        references = np.array([port.reference for port in ports], np.uint32)
        buffer: NDArray[Any] = np.zeros(len(ports), DTYPES[scalar])
        bind = self._slave.setter if verb == "Set" else self._slave.getter
        return PortCall(bind(scalar, references, buffer), f"{verb}{scalar}", buffer, ports, scalar)

    def stimuli(self, phase: int = 0) -> list[NDArray[Any]]:
        """Return the stimulus of each bound setter, (PERIOD, inputs) each; for reading only, as it is kept."""
        if phase not in self._stimuli:
            self._stimuli[phase] = [self.experiment.stimulus(port_call.scalar, phase) for port_call in self.write]
            for table in self._stimuli[phase]:
                table.flags.writeable = False
        return self._stimuli[phase]

    def put(self, values: Sequence[Any]) -> None:
        """Set the inputs, one array for each bound setter."""
        for (call, name, buffer, _, _), row in zip(self.write, values, strict=True):
            buffer[:] = row
            self._last_call.enter(f"{self._prefix}{name}", self._at)
            status = call()
            if status:
                self._must(status, name)
        self._last_call.leave()

    def step(self, time: float, length: float) -> None:
        """Make one step, or raise RunError: EndOfSimulation, if the FMU asks for a regular end."""
        status = self.try_step(time, length)
        if status in (OK, WARNING):
            return
        end = regular_end(self._slave.outcome("DoStep", status), self.name, time, length)
        if end is not None:
            raise end
        self._must(status, "DoStep", time)

    def row(self) -> OutputRow:
        """Read all outputs."""
        for call, name, _, _, _ in self._read.values():
            self._last_call.enter(f"{self._prefix}{name}", self._at)
            status = call()
            if status:
                self._must(status, name)
        self._last_call.leave()
        real = self._read.get("Real")
        whole = [port_call.buffer for scalar, port_call in self._read.items() if scalar != "Real"]
        integers = np.concatenate(whole, dtype=np.int64, casting="unsafe") if whole else np.zeros(0, np.int64)
        return np.zeros(0) if real is None else real.buffer.copy(), integers, self._texts()

    def _texts(self) -> list[bytes]:
        """Return the String outputs as bytes, which need not be UTF-8."""
        ports = self.experiment.of_kind("outputs", "String")
        if not ports:
            return []
        if isinstance(self._slave, Fmi2Slave):
            references = (c_uint32 * len(ports))(*(port.reference for port in ports))
            texts = (c_char_p * len(ports))()
            self.demand("GetString", byref(references), len(ports), byref(texts))
            return [text or b"" for text in texts]
        if self._text_call is None:  # bound once: each binding keeps its buffers
            self._text_call = self._port_call("Get", ports, "String")
        found = self._text_call
        self._make(found.name, found.call)
        return [str(text).encode() for text in found.buffer]

    # State, from FMI 2.0 on.

    def _state(self, text: str) -> str:
        """Return the name of a function as the version spells it."""
        name, deserialise = spelled(self._slave.instance)
        return text.format(name, deserialise)

    def get_state(self) -> c_void_p:
        """Return the handle of a new state."""
        state = c_void_p()
        self.demand(self._state("Get{}"), byref(state))
        return state

    def set_state(self, state: c_void_p) -> None:
        """Set a state."""
        self.demand(self._state("Set{}"), state)

    def free_state(self, state: c_void_p) -> None:
        """Free a state."""
        self.demand(self._state("Free{}"), byref(state))

    def serialised(self, state: c_void_p) -> bytes:
        """Return a state as bytes."""
        size = c_size_t()
        self.demand(self._state("Serialized{}Size"), state, byref(size))
        buffer = (c_char * size.value)()
        self.demand(self._state("Serialize{}"), state, buffer, size)
        return bytes(buffer)

    def deserialised(self, content: bytes) -> c_void_p:
        """Return the handle of a state that the FMU makes of bytes."""
        state = c_void_p()
        buffer = (c_char * len(content)).from_buffer_copy(content)
        self.demand(self._state("{1}{0}"), buffer, len(content), byref(state))
        return state

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
