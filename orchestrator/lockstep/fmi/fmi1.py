"""Running instances of FMI 1.0 co-simulation FMUs."""

from collections.abc import Callable, Mapping
from ctypes import byref, c_char, c_char_p, c_double, c_void_p

import fmpy
import numpy as np
from fmpy import fmi1
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from lockstep.fmi.instance import Hooks, Instance
from lockstep.fmi.library import Library, UnpackedFmu
from lockstep.fmi.log_callbacks import Messages, take_message
from lockstep.fmi.native_call import described
from lockstep.fmi.scalar_calls import Scalars
from lockstep.fmi.slave import ERROR, OK, WARNING, Buffer, Scalar, returned
from lockstep.system.component import Value

_LOGGER = fmi1.fmi1CallbackLoggerTYPE(take_message)
_MIME = "application/x-fmu-sharedlibrary"
_INSTANTIATE = (*(c_char_p,) * 4, c_double, c_char, c_char, fmi1.fmi1CallbackFunctions, c_char)
_NAMES = {"ExitInitializationMode": "InitializeSlave", "Reset": "ResetSlave"}  # of calls that FMI 2.0 names otherwise


class Fmi1Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by calls into the library.

    FMI 1.0 has no initialization mode: inputs and parameters are set, then one call initialises.
    """

    def __init__(self, fmu: UnpackedFmu, hooks: Hooks) -> None:
        self.name = fmu.name
        self._fmu = fmu
        self._span: tuple[float, float | None] = (0.0, 0.0)
        self.instance = Instance(fmu, "fmi", hooks, self._instantiate)
        self._values = Scalars(self.instance)
        step = self.instance.native("DoStep", "step_1")
        self.do_step: Callable[[float, float, int], int] = described(self.instance.bind("DoStep"), step)

    def _instantiate(self, library: Library, _: Messages) -> int | None:
        self._callbacks = callbacks = fmi1.fmi1CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi1.fmi1CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi1.fmi1CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(byref(callbacks))
        function = library.function(f"{library.function_prefix}InstantiateSlave", *_INSTANTIATE, returns=c_void_p)
        texts = (self.name, self._fmu.guid, self._fmu.folder.as_uri(), _MIME)
        timeout, visible, interactive, logging = 0.0, fmi1.fmi1False, fmi1.fmi1False, fmi1.fmi1True
        address: int | None = function(
            *(text.encode() for text in texts), timeout, visible, interactive, callbacks, logging
        )
        return address

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmiGet<scalar> with its arguments bound."""
        return self._values.getter(scalar, references, buffer)

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return fmiSet<scalar> with its arguments bound."""
        return self._values.setter(scalar, references, buffer)

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values of one type by value reference."""
        return self._values.set(values, scalar)

    def setup_experiment(self, start: float, stop: float | None) -> int:
        """Keep the time span for the initialization."""
        self._span = (start, stop)
        return 0

    def enter_initialization(self) -> int:
        """Do nothing: inputs are set before FMI 1.0 initialises."""
        return 0

    def exit_initialization(self) -> int:
        """Call fmiInitializeSlave."""
        start, stop = self._span
        status = self.instance.call("InitializeSlave", start, bytes([stop is not None]), stop or 0.0)
        self.instance.stepping = status < ERROR
        return status

    def reset(self) -> int:
        """Call fmiResetSlave: the instance is as fmiInstantiateSlave left it."""
        status = self.instance.call("ResetSlave")
        if status <= WARNING:
            self.instance.stepping, self.instance.worst = False, OK
        return status

    def forget_calls(self) -> None:
        """Release the memory of the getters and setters that were bound; none of them may be called any more."""
        self._values.forget()

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self.instance.failed(status)

    def outcome(self, call: str, status: int) -> str:
        """Describe a call that failed."""
        return returned("fmi", _NAMES.get(call, call), status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmiOK."""
        return self.instance.messages.last()

    def close(self) -> None:
        """Terminate, free and unload, as far as FMI allows after what happened."""
        self.instance.close()
