"""What the wall time of ticks is charged to: steps by component, exchange of values, recording, waiting, the rest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockstep.tick.operations import Answer, Begin, Capture, Finish, Operation, Pace, Program, Python, Request, Step

REST, EXCHANGE, RECORDING, WAITING = range(4)
KINDS = ("rest", "exchange", "recording", "waiting")  # the rest: checkpoints, progress, and the master itself


class Accounts:
    """The accounts of a program: the four kinds, then the components."""

    def __init__(self, program: Program) -> None:
        blocks = {id(block): block for blocks in program.ticks for block in blocks}
        found = (_component(operation) for block in blocks.values() for operation in block)
        self.components = list(dict.fromkeys(name for name in found if name))
        self._numbers = {name: number for number, name in enumerate(self.components, len(KINDS))}

    def __len__(self) -> int:
        return len(KINDS) + len(self.components)

    def of(self, operations: Sequence[Operation]) -> int:
        """Return the number of the account of operations that are executed as one."""
        for operation in operations:
            if name := _component(operation):
                return self._numbers[name]
        for operation in operations:
            if isinstance(operation, Capture | Pace):
                return RECORDING if isinstance(operation, Capture) else WAITING
        return EXCHANGE

    def named(self, times: Iterable[float]) -> dict[str, float]:
        """Return times by account under their names; a component has its name behind a slash."""
        names = (*KINDS, *(f"/{name}" for name in self.components))
        return dict(zip(names, times, strict=True))


def _component(operation: Operation) -> str:
    if isinstance(operation, Begin | Finish):
        operation = operation.step
    return operation.component if isinstance(operation, Step | Python | Request | Answer) else ""
