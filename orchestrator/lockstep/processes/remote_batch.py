"""A batch of steps, in the master: one round trip for FMUs that share a process; `batch.py` is its other side."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from lockstep.fmi.slave import Scalar
from lockstep.processes.connection import Answer, Calls, Connection
from lockstep.processes.last_call import TIME
from lockstep.processes.remote_slave import RemoteSlave


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Inputs of one type that are set before a step, and where their values lie on the bus."""

    scalar: Scalar
    references: tuple[int, ...]
    positions: tuple[int, ...]
    gain: tuple[float, ...] | None = None  # None: the values are not converted
    bias: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """Outputs of one type that are fetched after a step, and where they begin on the bus."""

    scalar: Scalar
    start: int
    references: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchedStep:
    """One step of an FMU: sets, doStep of this length [s], gets; its outputs are true at `end` [s] after its start."""

    name: str
    length: float
    end: float
    inputs: tuple[Inputs, ...]
    outputs: tuple[Outputs, ...]
    fresh: frozenset[str]  # components of which it reads what they compute in the same tick
    read: frozenset[str]  # components of which it reads anything


class Reports(Protocol):
    """What the master makes of a batch that stopped. Times in s, that of the step's start first."""

    def step_failed(self, step: BatchedStep, outcome: str, time: float, *, ended: bool) -> None:
        """Raise RunError, unless the FMU asked for the end with a complete step."""
        ...

    def not_finite(self, step: BatchedStep, outputs: Outputs, time: float) -> None:
        """Raise RunError if outputs are not finite that have to be."""
        ...

    def overflow(self, step: BatchedStep, inputs: Inputs, time: float) -> None:
        """Raise RunError if inputs are not finite after their conversion."""
        ...


class RemoteBatch:
    """Steps in this order, which begin at one time."""

    length = 0.0  # each has its own

    def __init__(
        self,
        connection: Connection,
        bus: Mapping[Scalar, tuple[int, int]],
        steps: Sequence[tuple[RemoteSlave, BatchedStep]],
        reports: Reports,
    ) -> None:
        """Define the batch in the worker. `bus` is where the values of each type begin in its memory, and how many."""
        self.connection, self._reports = connection, reports
        self._reals = connection.last_call.reals
        self._time = 0.0
        self._under_way = False
        self._waves = _waves([step for _, step in steps])
        self._steps: list[BatchedStep | None] = []  # of each call; None: of a wave
        slaves = {step.name: slave for slave, step in steps}
        names, components = [], []
        for wave in self._waves:
            everyone = ", ".join(step.name for step in wave)
            made: list[tuple[str, BatchedStep | None]] = [("", None)]
            for step in wave:
                prefix = slaves[step.name].prefix
                made += [(f"{prefix}Set{part.scalar}", step) for part in step.inputs]
                made += [(f"{prefix}DoStep", step)]
                made += [(f"{prefix}Get{part.scalar}", step) for part in step.outputs]
            if any(part.scalar == "Real" for step in wave for part in step.outputs):
                made.append(("", None))
            self._steps += [step for _, step in made]
            names += [name or "the exchange" for name, _ in made]
            components += [step.name if step else everyone for _, step in made]
        self._calls = Calls(names=tuple(names), components=tuple(components))
        members = [[_member(slaves[step.name].number, step) for step in wave] for wave in self._waves]
        message = json.dumps({"method": "batch", "bus": bus, "waves": members}).encode()
        connection.send(self, self._calls, 0, message, call=0)
        connection.read()
        connection.programs = self.number = connection.programs + 1

    def adopt(self) -> None:
        """Wait for steps that C has requested when `complete` is called."""
        self._under_way = True
        self._time = self.connection.adopt(self, self._calls)

    def start_step(self, time: float) -> None:
        """Begin the steps."""
        connection = self.connection
        connection.settle()
        connection.time = self._time = self._reals[TIME] = time
        self._under_way = True
        connection.send(self, self._calls, self.number)

    def complete(self) -> None:
        """Wait for the end of all steps, or raise RunError."""
        if self._under_way:
            self._finish(self.connection.read())

    def keep(self, answer: Answer) -> None:
        """Finish the steps, as the connection is needed for others."""
        if not self.connection.closing:
            self._finish(answer)

    def _finish(self, answer: Answer) -> None:
        self._under_way = False
        while "stopped" in answer:
            number = int(answer["stopped"])
            self._report(number, answer)
            self.connection.send(self, self._calls, self.number, start=number)
            answer = self.connection.read()

    def _report(self, number: int, answer: Answer) -> None:
        step, time, reports = self._steps[number - 1], self._time, self._reports
        if step is not None:
            reports.step_failed(step, str(answer["failed"]), time, ended=bool(answer["ended"]))
            return
        first = 0
        for wave in self._waves:
            size = 1 + sum(1 + len(step.inputs) + len(step.outputs) for step in wave)
            if number == first + 1:
                for step in wave:
                    for inputs in step.inputs:
                        reports.overflow(step, inputs, time)
            elif number == first + size + 1:
                for step in wave:
                    for outputs in step.outputs:
                        reports.not_finite(step, outputs, time)
            first += size + any(part.scalar == "Real" for step in wave for part in step.outputs)


def _member(slave: int, step: BatchedStep) -> dict[str, object]:
    return {
        "slave": slave,
        "length": step.length,
        "sets": [[part.scalar, part.references, part.positions, part.gain, part.bias] for part in step.inputs],
        "gets": [[part.scalar, part.start, part.references] for part in step.outputs],
    }


def _waves(steps: Sequence[BatchedStep]) -> list[list[BatchedStep]]:
    """Split steps, in their order, so that none reads what another one of the same wave computes."""
    waves: list[list[BatchedStep]] = []
    names: set[str] = set()
    for step in steps:
        if not waves or step.fresh & names:
            waves.append([])
            names = set()
        waves[-1].append(step)
        names.add(step.name)
    return waves
