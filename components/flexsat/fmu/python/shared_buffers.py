"""Describe the buffers of the values to the shim, which copies those that Python would only copy.

The shim (`shim/shim.c`) asks for one String by a reference that no variable has, and states the same reference, the
same bits and the same order as here.
"""

from __future__ import annotations

import numpy as np

from ...ports.table import Kind
from .port_values import PortValues

BUFFERS_REFERENCE = 0x7FFFFFF0
READ, WRITE, ON_DEMAND = 1, 2, 4


class SharedBuffers:
    """Which values a host may read and write without Python, and whether it may now.

    Reals and Booleans may be read, and inputs without declared limits be written, during a run: before it,
    parameters may change, and outputs with them. Values that are not finite, and inputs that feed outputs on demand,
    always go through Python.
    """

    def __init__(self, values: PortValues, feeds_on_demand: bool) -> None:
        self._values = values
        self._access = {kind: self._bits(kind, feeds_on_demand) for kind in ("real", "boolean")}
        self._running = np.zeros(1, dtype=np.int32)

    def _bits(self, kind: Kind, feeds_on_demand: bool) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
        bits = np.full(len(self._values.arrays[kind]), READ, dtype=np.uint8)
        for port in self._values.table:
            if port.kind != kind:
                continue
            if port.causality == "input" and not port.limited and not feeds_on_demand:
                bits[self._values.table.span(port.name)] |= WRITE
            if port.on_demand:
                bits[self._values.table.span(port.name)] |= ON_DEMAND
        return bits

    def allow(self, running: bool) -> None:
        """Allow the shim to access the buffers from now on, or forbid it."""
        self._running[0] = running

    def layout(self) -> str:
        """Return what the shim parses: counts and addresses, which stay the same for the life of the object."""
        parts = []
        for kind, access in self._access.items():
            array = self._values.arrays[kind]  # type: ignore[index]
            parts += [f"{array.ctypes.data:#x}", str(len(array)), f"{access.ctypes.data:#x}"]
        return " ".join(["buffers", *parts, f"{self._running.ctypes.data:#x}"])
