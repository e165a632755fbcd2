"""Running instances of FMI 3.0 co-simulation FMUs, without event mode, early return and intermediate update."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import c_bool, c_char_p, c_size_t, c_void_p
from pathlib import Path

import numpy as np
from fmpy import fmi3
from numpy.typing import NDArray

from lockstep.arrays import refill
from lockstep.fmi.fmi3_arrays import Arrays
from lockstep.fmi.instance import Hooks, Instance
from lockstep.fmi.library import Library, UnpackedFmu
from lockstep.fmi.log_callbacks import Messages, take_message
from lockstep.fmi.model_description import Variable
from lockstep.fmi.native_call import described
from lockstep.fmi.saved_state import restore_state, save_state
from lockstep.fmi.slave import DISCARD, ERROR, OK, WARNING, Buffer, Scalar, asked_for_end, returned
from lockstep.system.component import Value

_INSTANTIATE = (
    *(c_char_p,) * 3,
    *(c_bool,) * 4,
    *(c_void_p, c_size_t, c_void_p),  # intermediate variables, their number, environment
    *(fmi3.fmi3LogMessageCallback, c_void_p),
)
_EVENT, _END, _EARLY = range(3)  # flags of a step, in the order of fmi3DoStep's arguments
_SETS = "present.npz"


class Fmi3Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by calls into the library."""

    def __init__(self, fmu: UnpackedFmu, variables: Iterable[Variable], hooks: Hooks) -> None:
        self.name = fmu.name
        self._fmu = fmu
        self._span: tuple[float, float | None] = (0.0, 0.0)
        self._tolerance = fmu.tolerance
        self._problem = ""  # of a step that returned OK
        self.instance = Instance(fmu, "fmi3", hooks, self._instantiate)
        self._values = Arrays(self.instance, variables)
        self.do_step: Callable[[float, float, int], int] = self._stepper()

    def _instantiate(self, library: Library, messages: Messages) -> int | None:
        environment = messages.environment

        def message(_: int | None, status: int, category: bytes, text: bytes) -> None:
            take_message(environment, None, status, category, text)

        self._callback = fmi3.fmi3LogMessageCallback(message)  # the library keeps its address
        function = library.function("fmi3InstantiateCoSimulation", *_INSTANTIATE, returns=c_void_p)
        texts = (self.name, self._fmu.guid, f"{self._fmu.folder / 'resources'}{os.sep}")
        visible, logging, events, early = False, True, False, False
        address: int | None = function(
            *(text.encode() for text in texts), visible, logging, events, early, None, 0, None, self._callback, None
        )
        return address

    def _stepper(self) -> Callable[[float, float, int], int]:
        function = self.instance.bind("DoStep")
        flags, reached = bytearray(3), np.zeros(1)
        marks = np.frombuffer(flags, np.uint8)
        addresses = [c_void_p(marks.ctypes.data + k) for k in range(3)]
        last = c_void_p(reached.ctypes.data)

        def do_step(time: float, step: float, no_set_state: int) -> int:
            status = function(time, step, no_set_state, *addresses, last)
            if any(flags) and status <= WARNING:
                return self._unsupported(flags, float(reached[0]))
            return status

        def note(status: int) -> None:
            if status == DISCARD and any(flags):
                self._unsupported(flags, float(reached[0]))

        return described(do_step, self.instance.native("DoStep", "step_3", buffer=reached, flags=marks, note=note))

    def _unsupported(self, flags: Sequence[int], reached: float) -> int:
        """Note what the master does not support in a step, or that it ends the run; return DISCARD."""
        if flags[_EARLY]:
            self._problem = f"fmi3DoStep returned early, having reached {reached:.9g} s, which is not allowed,"
        elif flags[_END]:
            self._problem = f"fmi3DoStep {asked_for_end(reached)}"
        else:
            self._problem = "fmi3DoStep asked for event mode, which is not used,"
        return DISCARD

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:  # noqa: ARG002
        """Return a call that gets elements."""
        return self._values.getter(references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:  # noqa: ARG002
        """Return a call that sets elements."""
        return self._values.setter(references, buffer)

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by reference."""
        return self._values.set(values, scalar)

    def setup_experiment(self, start: float, stop: float | None) -> int:
        """Keep the time span, which FMI 3.0 announces with initialization."""
        self._span = (start, stop)
        return 0

    def enter_initialization(self) -> int:
        """Call fmi3EnterInitializationMode, with the tolerance, if there is one."""
        start, stop = self._span
        tolerance, span = self._tolerance, (start, stop is not None, stop or 0.0)
        return self.instance.call("EnterInitializationMode", tolerance is not None, tolerance or 0.0, *span)

    def exit_initialization(self) -> int:
        """Call fmi3ExitInitializationMode."""
        status = self.instance.call("ExitInitializationMode")
        self.instance.stepping = status < ERROR
        return status

    def reset(self) -> int:
        """Call fmi3Reset: the instance is as fmi3InstantiateCoSimulation left it."""
        status = self.instance.call("Reset")
        if status <= WARNING:
            self.instance.stepping, self.instance.worst, self._problem = False, OK, ""
        return status

    def save_state(self, folder: str) -> int:
        """Serialise the state into a folder, with what the arrays hold that can be set."""
        present = self._values.present.items()
        arrays = {str(handle): v.astype(str) if v.dtype == object else v for handle, v in present}
        np.savez(Path(folder, _SETS), allow_pickle=False, **arrays)
        return save_state(self.instance, folder)

    def restore_state(self, folder: str) -> int:
        """Set the state that a folder holds."""
        with np.load(Path(folder, _SETS), allow_pickle=False) as saved:
            for handle in saved.files:
                refill(self._values.present[int(handle)], saved[handle])
        return restore_state(self.instance, folder)

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self.instance.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a call that failed, or a problem found before or after it."""
        if self._values.problem:
            return self._values.problem
        if self._problem and call == "DoStep":
            return self._problem
        if call.endswith("FMUstate"):
            call = call.replace("FMUstate", "FMUState")  # as FMI 3.0 writes it
        elif call.startswith(("Get", "Set")) and self._values.last.startswith(call[:3]):
            call = self._values.last
        return returned("fmi3", call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi3OK."""
        return self.instance.messages.last()

    def close(self) -> None:
        """Terminate, free and unload, as far as FMI allows after what happened."""
        self.instance.close()
