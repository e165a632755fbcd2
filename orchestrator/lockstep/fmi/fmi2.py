"""Running instances of FMI 2.0 co-simulation FMUs."""

from collections.abc import Callable, Mapping
from ctypes import byref, c_double, c_int, c_void_p
from functools import partial
from pathlib import Path

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from lockstep.fmi.library import Library, not_instantiated
from lockstep.fmi.log_callbacks import Log, Messages, take_message
from lockstep.fmi.model_description import Description
from lockstep.fmi.saved_state import restore_state, save_state
from lockstep.fmi.scalar_calls import Scalars
from lockstep.fmi.slave import DISCARD, ERROR, FATAL, WARNING, Buffer, Scalar, returned
from lockstep.system.component import Component, Value

_LOGGER = fmi2.fmi2CallbackLoggerTYPE(take_message)
_TERMINATED = 3  # fmi2StatusKind: fmi2Terminated


class Fmi2Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by direct calls into the library."""

    def __init__(self, component: Component, description: Description, folder: Path, log: Log) -> None:
        self.name = component.name
        self._status = 0
        self._alive = self._stepping = False
        self._messages = Messages(component.name, log)
        self._library = Library(component, description, folder, fmi2.FMU2Slave)
        self._fmu, self._function = self._library.fmu, self._library.function
        self._instantiate()
        self._values = Scalars(self._function, "fmi2", self._fmu.component)
        self.do_step: Callable[[float, float, int], int] = partial(
            self._function("fmi2DoStep", c_void_p, c_double, c_double, c_int), self._fmu.component
        )

    def _instantiate(self) -> None:
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        callbacks.componentEnvironment = self._messages.environment
        addLoggerProxy(byref(callbacks))
        try:
            self._fmu.instantiate(callbacks=callbacks, loggingOn=True)
        except Exception:  # a bare Exception; the reason is what the FMU logged
            self._library.free()
            raise not_instantiated(self.name, self._messages.last()) from None
        self._alive = True

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Get<scalar> with its arguments bound."""
        return self._values.getter(scalar, references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmi2Set<scalar> with its arguments bound."""
        return self._values.setter(scalar, references, buffer)

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by value reference."""
        return self._values.set(values, scalar)

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span, without a tolerance."""
        return self._call(
            "fmi2SetupExperiment", (c_int, 0), (c_double, 0), (c_double, start), (c_int, 1), (c_double, stop)
        )

    def enter_initialization(self) -> int:
        """Call fmi2EnterInitializationMode."""
        return self._call("fmi2EnterInitializationMode")

    def exit_initialization(self) -> int:
        """Call fmi2ExitInitializationMode."""
        status = self._call("fmi2ExitInitializationMode")
        self._stepping = status < ERROR
        return status

    def _call(self, name: str, *arguments: tuple[type, float]) -> int:
        function = self._function(name, c_void_p, *(kind for kind, _ in arguments))
        return function(self._fmu.component, *(value for _, value in arguments))

    def save_state(self, folder: str) -> int:
        """Serialise the state into a folder."""
        return save_state(self._function, "fmi2", self._fmu.component, folder)

    def restore_state(self, folder: str) -> int:
        """Set the state that a folder holds."""
        return restore_state(self._function, "fmi2", self._fmu.component, folder)

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._status = max(self._status, status)

    def outcome(self, call: str, status: int) -> str:
        """Say what a call came to; a step may have been discarded because the FMU asks for the end."""
        if call == "DoStep" and status == DISCARD and self._alive:
            ended = c_int(0)
            ask = self._function("fmi2GetBooleanStatus", c_void_p, c_int, c_void_p)
            if ask(self._fmu.component, _TERMINATED, byref(ended)) <= WARNING and ended.value:
                return "fmi2DoStep returned fmi2Discard, asking for the end,"
        return returned("fmi2", call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi2OK."""
        return self._messages.last()

    def close(self) -> None:
        """Terminate unless the instance failed or never began, free it unless the failure was fatal, unload."""
        if not self._alive:
            return
        self._alive = False
        if self._status >= FATAL:
            return  # no call is allowed any more; not even unloading is safe
        if self._stepping and self._status < ERROR:
            self._status = max(self._status, self._call("fmi2Terminate"))
        if self._status < FATAL:
            self._fmu.freeInstance()
