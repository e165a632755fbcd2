"""Steps of isolated FMUs that one request makes: their inputs and outputs go through memory that the worker sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from lockstep.errors import EndOfSimulation
from lockstep.fmi.slave import Scalar
from lockstep.plan.transfer import SetValue
from lockstep.processes.remote_slave import RemoteSlave
from lockstep.processes.step_program import StepProgram
from lockstep.run.step_operations import Gets, StepOperations
from lockstep.tick.operations import Answer, Gather, Operation, Request, StartedStep


def requested_step(
    operations: StepOperations,
    slave: RemoteSlave,
    sets: Mapping[Scalar, list[SetValue]],
    gets: Gets,
    length: float,
    end: float,
    ended: Callable[[EndOfSimulation], None],
) -> StartedStep:
    """Return a step of this length [s] in two blocks; its outputs are true at `end` [s] after its start.

    `ended` takes the end that the FMU asks for.
    """
    name = slave.name
    references = {scalar: found for scalar, (_, found) in gets.items()}
    targets = {scalar: [entry.target for entry in entries] for scalar, entries in sets.items()}
    program = StepProgram(slave, list(targets.items()), list(references.items()), length)
    begin: list[Operation] = []
    for (scalar, entries), region in zip(sets.items(), program.inputs, strict=True):
        begin += operations.fill(name, scalar, entries, region)
    finish: list[Operation] = []
    for (scalar, (start, found)), region in zip(gets.items(), program.outputs, strict=True):
        part = operations.bus[scalar][start : start + len(found)]
        finish.append(Gather(source=region, index=np.arange(len(found)), buffer=part))
        finish += operations.finite(name, scalar, found, part, end)

    def complete(_time: float) -> None:
        try:
            program.complete()
        except EndOfSimulation as asked:
            ended(asked)

    return StartedStep(
        begin=(*begin, Request(requested=program, call=program.start_step, component=name)),
        finish=(Answer(requested=program, call=complete, component=name), *finish),
    )
