"""Running instances of FMI 1.0 co-simulation FMUs."""

from collections.abc import Callable, Mapping
from ctypes import byref, c_char, c_double, c_void_p
from functools import partial
from pathlib import Path

import fmpy
import numpy as np
from fmpy import fmi1
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from lockstep.fmi.library import Library, not_instantiated
from lockstep.fmi.log_callbacks import Log, Messages, take_message
from lockstep.fmi.model_description import Description
from lockstep.fmi.scalar_calls import Scalars
from lockstep.fmi.slave import ERROR, FATAL, Buffer, Scalar, returned
from lockstep.system.component import Component, Value

_LOGGER = fmi1.fmi1CallbackLoggerTYPE(take_message)
_NAMES = {"ExitInitializationMode": "InitializeSlave"}  # of what FMI 2.0 calls otherwise


class Fmi1Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by direct calls into the library.

    FMI 1.0 has no initialization mode: inputs and parameters are set, then one call initialises.
    """

    def __init__(self, component: Component, description: Description, folder: Path, log: Log) -> None:
        self.name = component.name
        self._status = 0
        self._alive = self._stepping = False
        self._span = (0.0, 0.0)
        self._messages = Messages(component.name, log)
        self._library = Library(component, description, folder, fmi1.FMU1Slave)
        self._fmu = self._library.fmu
        self._begin = f"{description.identifier}_"  # of the names of all functions
        self._instantiate()
        self._values = Scalars(self._function, "fmi", self._fmu.component)
        self.do_step: Callable[[float, float, int], int] = partial(
            self._function("fmiDoStep", c_void_p, c_double, c_double, c_char), self._fmu.component
        )

    def _function(self, name: str, *argument_types: type) -> Callable[..., int]:
        return self._library.function(self._begin + name, *argument_types)

    def _instantiate(self) -> None:
        callbacks = fmi1.fmi1CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi1.fmi1CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi1.fmi1CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(byref(callbacks))
        self._fmu.instantiate(functions=callbacks, loggingOn=True)
        if not self._fmu.component:
            self._library.free()
            raise not_instantiated(self.name, self._messages.last())
        self._alive = True

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmiGet<scalar> with its arguments bound."""
        return self._values.getter(scalar, references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmiSet<scalar> with its arguments bound."""
        return self._values.setter(scalar, references, buffer)

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by value reference."""
        return self._values.set(values, scalar)

    def setup_experiment(self, start: float, stop: float) -> int:
        """Keep the time span for the initialization."""
        self._span = (start, stop)
        return 0

    def enter_initialization(self) -> int:
        """Do nothing: inputs are set before FMI 1.0 initialises."""
        return 0

    def exit_initialization(self) -> int:
        """Call fmiInitializeSlave."""
        function = self._function("fmiInitializeSlave", c_void_p, c_double, c_char, c_double)
        status = function(self._fmu.component, self._span[0], b"\1", self._span[1])
        self._stepping = status < ERROR
        return status

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._status = max(self._status, status)

    def outcome(self, call: str, status: int) -> str:
        """Say what a call came to that failed."""
        return returned("fmi", _NAMES.get(call, call), status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmiOK."""
        return self._messages.last()

    def close(self) -> None:
        """Terminate unless the instance failed or never began, free it unless the failure was fatal, unload."""
        if not self._alive:
            return
        self._alive = False
        if self._status >= FATAL:
            return  # no call is allowed any more; not even unloading is safe
        if self._stepping and self._status < ERROR:
            self._status = max(self._status, self._function("fmiTerminateSlave", c_void_p)(self._fmu.component))
        if self._status < FATAL:
            self._fmu.freeInstance()
