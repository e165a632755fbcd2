"""Running instances of FMI 2.0 co-simulation FMUs."""

from collections.abc import Callable, Mapping
from ctypes import byref, c_char_p, c_double, c_int, c_void_p

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from lockstep.fmi.instance import Hooks, Instance
from lockstep.fmi.library import Library, UnpackedFmu
from lockstep.fmi.log_callbacks import Messages, take_message
from lockstep.fmi.native_call import described
from lockstep.fmi.saved_state import restore_bytes, restore_state, save_state, state_bytes
from lockstep.fmi.scalar_calls import Scalars
from lockstep.fmi.slave import DISCARD, ERROR, OK, WARNING, Buffer, Scalar, asked_for_end, returned
from lockstep.system.component import Value

_LOGGER = fmi2.fmi2CallbackLoggerTYPE(take_message)
_INSTANTIATE = (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int)
_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3  # fmi2StatusKind


class Fmi2Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by calls into the library."""

    def __init__(self, fmu: UnpackedFmu, hooks: Hooks) -> None:
        self.name = fmu.name
        self._fmu = fmu
        self.instance = Instance(fmu, "fmi2", hooks, self._instantiate)
        self._values = Scalars(self.instance)
        step = self.instance.native("DoStep", "step_2")
        self.do_step: Callable[[float, float, int], int] = described(self.instance.bind("DoStep"), step)

    def _instantiate(self, library: Library, messages: Messages) -> int | None:
        self._callbacks = callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        callbacks.componentEnvironment = messages.environment
        addLoggerProxy(byref(callbacks))
        function = library.function("fmi2Instantiate", *_INSTANTIATE, returns=c_void_p)
        resources = self._fmu.resources or (self._fmu.folder / "resources").as_uri()
        visible, logging = 0, 1
        identity = (self.name.encode(), int(fmi2.fmi2CoSimulation), self._fmu.guid.encode(), resources.encode())
        address: int | None = function(*identity, byref(callbacks), visible, logging)
        return address

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Get<scalar> with its arguments bound."""
        return self._values.getter(scalar, references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Set<scalar> with its arguments bound."""
        return self._values.setter(scalar, references, buffer)

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by value reference."""
        return self._values.set(values, scalar)

    def setup_experiment(self, start: float, stop: float | None) -> int:
        """Pass the tolerance, if there is one, and the time span, which may have no end."""
        tolerance = self._fmu.tolerance
        span = start, stop is not None, stop or 0.0
        return self.instance.call("SetupExperiment", tolerance is not None, tolerance or 0.0, *span)

    def enter_initialization(self) -> int:
        """Call fmi2EnterInitializationMode."""
        return self.instance.call("EnterInitializationMode")

    def exit_initialization(self) -> int:
        """Call fmi2ExitInitializationMode."""
        status = self.instance.call("ExitInitializationMode")
        self.instance.stepping = status < ERROR
        return status

    def reset(self) -> int:
        """Call fmi2Reset: the instance is as fmi2Instantiate left it."""
        status = self.instance.call("Reset")
        if status <= WARNING:
            self.instance.stepping, self.instance.worst = False, OK
        return status

    def save_state(self, folder: str) -> int:
        """Serialise the state into a folder."""
        return save_state(self.instance, folder)

    def restore_state(self, folder: str) -> int:
        """Set the state that a folder holds."""
        return restore_state(self.instance, folder)

    def state_bytes(self) -> tuple[int, bytes]:
        """Return a status and the state that `save_state` would write to its file."""
        return state_bytes(self.instance)

    def restore_bytes(self, content: bytes) -> int:
        """Set the state that `state_bytes` returned."""
        return restore_bytes(self.instance, content)

    def forget_calls(self) -> None:
        """Release the memory of the getters and setters that were bound; none of them may be called any more."""
        self._values.forget()

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self.instance.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a call that failed; a step may have been discarded because the FMU asks for the end.

        One that logged an error has failed: pythonfmu's wrapper answers so for a step that was refused.
        """
        if call == "DoStep" and status == DISCARD and self.instance.alive:
            ended = c_int(0)
            answer = self.instance.call("GetBooleanStatus", _TERMINATED, byref(ended))
            if answer <= WARNING and ended.value and self.instance.messages.last_status < ERROR:
                return f"fmi2DoStep returned fmi2Discard and {asked_for_end(self._reached())}"
        return returned("fmi2", call, status)

    def _reached(self) -> float | None:
        """Return the last time that the FMU has computed [s]; None if it does not know."""
        reached = c_double(0.0)
        answer = self.instance.call("GetRealStatus", _LAST_SUCCESSFUL_TIME, byref(reached))
        return reached.value if answer <= WARNING else None

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi2OK."""
        return self.instance.messages.last()

    def close(self) -> None:
        """Terminate, free and unload, as far as FMI allows after what happened."""
        self.instance.close()
