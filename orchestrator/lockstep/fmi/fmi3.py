"""Running instances of FMI 3.0 co-simulation FMUs, without event mode, early return and intermediate update."""

from collections.abc import Callable, Mapping
from ctypes import addressof, byref, c_bool, c_double, c_void_p
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import fmi3
from numpy.typing import NDArray

from lockstep.fmi.fmi3_arrays import Arrays
from lockstep.fmi.library import Library, not_instantiated
from lockstep.fmi.log_callbacks import Log, Messages, take_message
from lockstep.fmi.model_description import Description
from lockstep.fmi.saved_state import restore_state, save_state
from lockstep.fmi.slave import DISCARD, ERROR, FATAL, WARNING, Buffer, Scalar, returned
from lockstep.system.component import Component, Value

_EVENT, _END, _EARLY = range(3)  # what a step may ask for or do, in the order of fmi3DoStep's arguments
_SETS = "present.npz"


class Fmi3Slave:
    """One running instance. Implements `lockstep.fmi.slave.Slave` by direct calls into the library."""

    def __init__(self, component: Component, description: Description, folder: Path, log: Log) -> None:
        self.name = component.name
        self._status = 0
        self._alive = self._stepping = False
        self._span = (0.0, 0.0)
        self._problem = ""  # what a step that returned OK did nevertheless
        self._messages = Messages(component.name, log)
        self._library = Library(component, description, folder, fmi3.FMU3Slave)
        self._fmu, self._function = self._library.fmu, self._library.function
        self._instantiate()
        self._values = Arrays(self._function, self._fmu.component, description.variables.values())
        self.do_step: Callable[[float, float, int], int] = self._stepper()

    def _instantiate(self) -> None:
        environment = self._messages.environment

        def message(_: int | None, status: int, category: bytes, text: bytes) -> None:
            take_message(environment, None, status, category, text)

        try:
            self._fmu.instantiate(loggingOn=True, logMessage=message)
        except Exception:  # a bare Exception; the reason is what the FMU logged
            self._library.free()
            raise not_instantiated(self.name, self._messages.last()) from None
        self._alive = True

    def _stepper(self) -> Callable[[float, float, int], int]:
        kinds = (c_void_p, c_double, c_double, c_bool, c_void_p, c_void_p, c_void_p, c_void_p)
        function, instance = self._function("fmi3DoStep", *kinds), c_void_p(self._fmu.component)
        marks = bytearray(3)
        flags, reached = (c_bool * 3).from_buffer(marks), c_double()
        places = [c_void_p(addressof(flags) + k) for k in range(3)]
        last = byref(reached)

        def do_step(time: float, step: float, no_set_state: int) -> int:
            status = function(instance, time, step, no_set_state, *places, last)
            if any(marks) and status <= WARNING:
                return self._asked_for(flags, reached.value)
            return status

        return do_step

    def _asked_for(self, flags: Any, reached: float) -> int:
        """Note what a step did that the master has not allowed, or that ends the run; return DISCARD."""
        if flags[_EARLY]:
            self._problem = f"fmi3DoStep returned early, having reached {reached:.9g} s, which is not allowed,"
        elif flags[_END]:
            self._problem = "fmi3DoStep asked for the end"
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

    def setup_experiment(self, start: float, stop: float) -> int:
        """Keep the time span, which FMI 3.0 announces with initialization."""
        self._span = (start, stop)
        return 0

    def enter_initialization(self) -> int:
        """Call fmi3EnterInitializationMode, without a tolerance."""
        kinds = (c_void_p, c_bool, c_double, c_double, c_bool, c_double)
        function = self._function("fmi3EnterInitializationMode", *kinds)
        return function(self._fmu.component, False, 0.0, self._span[0], True, self._span[1])

    def exit_initialization(self) -> int:
        """Call fmi3ExitInitializationMode."""
        status = self._call("fmi3ExitInitializationMode")
        self._stepping = status < ERROR
        return status

    def _call(self, name: str) -> int:
        return self._function(name, c_void_p)(self._fmu.component)

    def save_state(self, folder: str) -> int:
        """Serialise the state into a folder, with what the arrays hold that can be set."""
        present = self._values.present.items()
        arrays = {str(handle): v.astype(str) if v.dtype == object else v for handle, v in present}
        np.savez(Path(folder, _SETS), allow_pickle=False, **arrays)
        return save_state(self._function, "fmi3", self._fmu.component, folder)

    def restore_state(self, folder: str) -> int:
        """Set the state that a folder holds."""
        with np.load(Path(folder, _SETS), allow_pickle=False) as saved:
            for handle in saved.files:
                self._values.present[int(handle)][:] = saved[handle]
        return restore_state(self._function, "fmi3", self._fmu.component, folder)

    def failed(self, status: int) -> None:
        """Note the status that ended the run."""
        self._status = max(self._status, status)

    def outcome(self, call: str, status: int) -> str:
        """Say what a call came to: its own failure, or what was found before or after it."""
        if self._values.problem:
            return self._values.problem
        if self._problem and call == "DoStep":
            return self._problem
        if call.endswith("FMUstate"):
            call = call.replace("FMUstate", "FMUState")  # as FMI 3.0 writes it
        elif call.startswith(("Get", "Set")) and self._values.last.startswith(f"fmi3{call[:3]}"):
            call = self._values.last.removeprefix("fmi3")
        return returned("fmi3", call, status)

    def last_messages(self) -> str:
        """Return what the FMU logged last above fmi3OK."""
        return self._messages.last()

    def close(self) -> None:
        """Terminate unless the instance failed or never began, free it unless the failure was fatal, unload."""
        if not self._alive:
            return
        self._alive = False
        if self._status >= FATAL:
            return  # no call is allowed any more; not even unloading is safe
        if self._stepping and self._status < ERROR:
            self._status = max(self._status, self._call("fmi3Terminate"))
        if self._status < FATAL:
            self._fmu.freeInstance()
