"""Describe the buffers of the values to the shim, which copies those that Python would only copy.

The shim (`shim/shim.h`) asks for one String by a reference that no variable has, and states the same references, the
same bits and the same order as here. What it refuses itself it writes as a text to another such String.
"""

from __future__ import annotations

import numpy as np

from ...ports.table import Kind
from .call_order import Phase
from .port_values import PortValues

BUFFERS_REFERENCE, REFUSAL_REFERENCE = 0x7FFFFFF0, 0x7FFFFFF1
READ, WRITE, ON_DEMAND, FOLLOWS = 1, 2, 4, 8


class SharedBuffers:
    """Which values a host may read and write without Python, and whether it may now; and the outcome of a call.

    Reals and Booleans may be read, and inputs without declared limits be written, during a run: before it,
    parameters may change, and outputs with them. Values that are not finite, and inputs that feed outputs on demand,
    always go through Python.
    """

    __slots__ = ("_access", "_control", "_values")

    def __init__(self, values: PortValues, feeds_on_demand: bool) -> None:
        self._values = values
        self._access = {kind: self._bits(kind, feeds_on_demand) for kind in ("real", "boolean")}
        # access, outcome, checking, phase, inputs set: `Control` of the shim
        self._control = np.zeros(5, dtype=np.int32)

    def _bits(self, kind: Kind, feeds_on_demand: bool) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
        bits = np.full(len(self._values.arrays[kind]), READ, dtype=np.uint8)
        for port in self._values.table:
            if port.kind != kind:
                continue
            if port.causality == "input" and not port.limited and not feeds_on_demand:
                bits[self._values.table.span(port.name)] |= WRITE
            if port.on_demand:
                bits[self._values.table.span(port.name)] |= ON_DEMAND
            if port.follows_inputs:
                bits[self._values.table.span(port.name)] |= FOLLOWS
        return bits

    def enter(self, phase: Phase) -> None:
        """Allow the shim to access the buffers as the phase does."""
        self._control[0] = {Phase.STEPPING: READ | WRITE, Phase.TERMINATED: READ, Phase.FAILED: READ}.get(phase, 0)
        self._control[3] = phase

    def fail(self, status: int) -> None:
        """Have the shim return a status from the present call: the wrapper cannot."""
        self._control[1] = status

    @property
    def checking(self) -> bool:
        """Whether a state that is set is to be examined only."""
        return bool(self._control[2])

    @property
    def inputs_set(self) -> bool:
        """Whether values were set since the outputs that follow inputs were computed; the shim notes it too."""
        return bool(self._control[4])

    def note_inputs(self, is_set: bool) -> None:
        """Note whether values were set since the outputs that follow inputs were computed."""
        self._control[4] = is_set

    def layout(self, guid: str, present: int) -> str:
        """Return what the shim parses: counts, addresses, first references, the same for the life of the object.

        Parameters
        ----------
        present : address of the present communication point
        """
        parts = ["buffers", guid]
        for kind, access in self._access.items():
            array = self._values.arrays[kind]  # type: ignore[index]
            parts += [str(len(array)), f"{array.ctypes.data:#x}", f"{access.ctypes.data:#x}"]
        parts += [str(len(self._values.arrays["integer"])), str(len(self._values.strings))]
        parts += [str(first) for first in self._values.table.first_reference.values()]
        return " ".join([*parts, f"{self._control.ctypes.data:#x}", f"{present:#x}"])
