"""A step of an isolated FMU as one program of its worker: its inputs and outputs lie in the memory of both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lockstep.fmi.slave import Buffer, Scalar
from lockstep.processes.remote_slave import RemoteSlave

Group = tuple[Scalar, Sequence[int]]  # type, and references in ascending order


class StepProgram:
    """Sets, a step of this length [s] and gets, in order. `inputs` and `outputs` are where their values lie."""

    def __init__(self, slave: RemoteSlave, sets: Sequence[Group], gets: Sequence[Group], length: float) -> None:
        """Define the program in the worker, after what waits there for a step."""
        slave.flush()
        self._slave, self.connection, self.length = slave, slave.connection, length
        puts = [slave.port("set", scalar, np.array(references, np.uint32)) for scalar, references in sets]
        takes = [slave.port("get", scalar, np.array(references, np.uint32)) for scalar, references in gets]
        self.inputs: list[Buffer] = [region for _, region in puts]
        self.outputs: list[Buffer] = [region for _, region in takes]
        self._program = slave.program((tuple(port for port, _ in puts), True, tuple(port for port, _ in takes)))
        self.number = self._program.number

    def start_step(self, time: float) -> None:
        """Request the step."""
        self._slave.begin_program(self._program, time, self.length)

    def complete(self) -> None:
        """Wait for its end, or raise RunError."""
        self._slave.complete()

    def adopt(self) -> None:
        """Wait for a step that C has requested when `complete` is called."""
        self._slave.adopt(self._program, self.length)
