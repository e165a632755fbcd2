"""One instance of an FMU of any version: its calls by name, the worst status so far, and its end."""

from collections.abc import Callable
from contextlib import suppress
from ctypes import c_void_p, cast
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import RunError
from lockstep.fmi.library import Library, UnpackedFmu
from lockstep.fmi.log_callbacks import Listener, Log, Messages
from lockstep.fmi.native_call import Apart, Kind, NativeCall
from lockstep.fmi.signatures import ENDINGS, OPTIONAL, SIGNATURES
from lockstep.fmi.slave import ERROR, FATAL, OK, WARNING, returned

BoundCall = Callable[..., int]  # an FMI function with its instance, and perhaps more arguments, filled in
Instantiate = Callable[[Library, Messages], int | None]  # returns the instance's address; None: there is none


def ignore_call(_: str) -> None:
    """Do nothing at a call."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hooks:
    """What an instance reports to. `call` gets the name of each call that begins, and "" when it has returned.

    Calls that are bound once and made at every step are not reported: setters, getters and DoStep.
    """

    log: Log  # of messages above OK
    message: Listener | None = None  # of every message
    call: Callable[[str], None] = ignore_call


class Instance:
    """One instance. `call` makes a call by the name that FMI gives it, without the prefix."""

    def __init__(self, fmu: UnpackedFmu, prefix: str, hooks: Hooks, instantiate: Instantiate) -> None:
        """Load the library and instantiate the FMU, or raise RunError."""
        self.prefix, self.worst, self.stepping = prefix, OK, False
        self._name, self._native = fmu.name, fmu.native
        self.messages = Messages(fmu.name, hooks.log, hooks.message)
        self._hooks = hooks
        hooks.call("loading the library")
        self.library = Library(fmu, prefix)
        hooks.call(f"{prefix}Instantiate{'Slave' if prefix == 'fmi' else ''}")
        handle = instantiate(self.library, self.messages)
        hooks.call("")
        self._alive = bool(handle)
        if not handle:
            with suppress(OSError):
                self.library.free()
            reason = self.messages.last() or "it logged no reason (a GUID mismatch is one)"
            raise RunError(f"{fmu.name}: cannot be instantiated: {reason}")
        self._handle = c_void_p(handle)

    @property
    def alive(self) -> bool:
        """Whether it has not been ended."""
        return self._alive

    def bind(self, name: str, *arguments: object) -> BoundCall:
        """Return a function with the instance, and the first arguments behind it, filled in; or raise RunError."""
        signature = (SIGNATURES[self.prefix] | OPTIONAL[self.prefix])[name]
        function = self.library.function(f"{self.library.function_prefix}{name}", c_void_p, *signature)
        return partial(function, self._handle, *arguments)

    def native(
        self,
        name: str,
        kind: Kind,
        references: NDArray[np.uint32] | None = None,
        buffer: NDArray[Any] | None = None,
        flags: NDArray[np.uint8] | None = None,
        note: Callable[[int], None] = lambda _: None,
    ) -> NativeCall:
        """Describe a call of a function with the instance, for C; the arguments are those of `NativeCall`."""
        function = cast(self.bind(name).func, c_void_p).value  # type: ignore[attr-defined]
        assert function is not None
        assert self._handle.value is not None
        return NativeCall(
            kind=kind,
            function=function,
            instance=self._handle.value,
            references=references,
            buffer=buffer,
            flags=flags,
            note=note,
            apart=Apart(messages=self.messages, failed=self.failed) if self._native and name == "DoStep" else None,
        )

    def call(self, name: str, *arguments: object) -> int:
        """Call a function and return its status."""
        function = self.bind(name)
        self._hooks.call(f"{self.prefix}{name}")
        status = function(*arguments)
        self._hooks.call("")
        return status

    def failed(self, status: int) -> None:
        """Note a status; after FATAL the FMU is not called any more."""
        self.worst = max(self.worst, status)

    def close(self) -> None:
        """Terminate unless the instance failed or never began, free it unless the failure was fatal, unload."""
        if not self._alive:
            return
        self._alive = False
        if self.worst >= FATAL:
            return  # no call is allowed any more; not even unloading is safe
        terminate, free = ENDINGS[self.prefix]
        if self.stepping and self.worst < ERROR:
            status = self.call(terminate)
            self.failed(status)
            if status > WARNING:
                self._hooks.log(self._name, status, "", returned(self.prefix, terminate, status))
        if self.worst < FATAL:
            self.call(free)  # returns nothing; what ctypes makes of that is not looked at
            self._hooks.call("unloading the library")
            self.library.free()
            self._hooks.call("")
