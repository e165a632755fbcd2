"""The requests of a packed program to worker processes: what C leaves to Python."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from ctypes import addressof, c_void_p
from time import monotonic
from typing import Any

from lockstep.errors import RunError
from lockstep.processes.cpu_affinity import core_assignment
from lockstep.tick.operations import Requested
from lockstep.tick.program_table import Packed
from lockstep.tick.structures import Kind, TickState


class Requests:
    """What a program requests, by number, and the links to its workers."""

    def __init__(self, requests: Sequence[Requested], state: TickState) -> None:
        """Set the links in the state of the tick."""
        self._requests = tuple(requests)
        connections = list(dict.fromkeys(one.connection for one in requests))
        self._connections = connections
        self._links = [connection.link for connection in connections]
        for connection in connections:
            connection.adopt_from_c = self.adopt
        self._addresses: Any = (c_void_p * max(1, len(self._links)))(*(addressof(link) for link in self._links))
        state.links, state.link_count = addressof(self._addresses), len(self._links)

    def look(self) -> None:
        """Judge which workers belong on the master's core."""
        if self._links:
            core_assignment().look(monotonic())

    def act(self, entry: Packed, number: int, time: float) -> None:
        """Do in Python what C left at an operation: begin, or wait for an answer that says something."""
        assert entry.requested is not None
        assert entry.act is not None
        made = entry.requested.connection.link.asking == number + 1
        self.adopt()
        if entry.kind == Kind.ANSWER or not made:  # else the worker has closed its pipe, which its answer shows
            entry.act(time)

    def adopt(self) -> None:
        """Have Python wait for the answers to all requests that C has made."""
        for number, requested in enumerate(self._requests):
            if requested.connection.link.asking == number + 1:
                requested.adopt()

    def stop(self) -> None:
        """Wait for the answers to all requests, after an error: what is closed next must not be at work."""
        self.adopt()
        for connection in self._connections:
            with suppress(RunError, KeyboardInterrupt):  # the error that is raised came first
                connection.settle()
