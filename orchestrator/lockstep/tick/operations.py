"""The operations of a tick, as plain records that both implementations execute.

A step of a component is a *block*: its sets, its doStep and its gets, in order. A tick is a tuple of blocks. Equal
blocks are one object, so that the table stays small however long the cycle of the schedule is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import lcm
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.fmi.slave import Buffer, Scalar
from lockstep.processes.connection import Connection
from lockstep.system.clock import Time

Action = Callable[[float], None]  # called with the simulated time [s] at which the tick began
Judge = Callable[[float, int], None]  # called with that time and a status above OK; it may raise
Row = Sequence[NDArray[Any]]  # of the recorder, in the order of SCALARS
NextRow = Callable[[float], Row]
ALWAYS = 2**62  # a tick after the last one of any run


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gather:
    """Copy values from the bus: buffer[k] = source[index[k]]."""

    source: Buffer
    index: NDArray[np.intp]
    buffer: Buffer


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Convert:
    """Convert Reals in their buffer, gain * value + bias, rounded twice; `refuse` raises if one is not finite then."""

    buffer: Buffer
    gain: NDArray[np.float64]
    bias: NDArray[np.float64]
    refuse: Action


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Transfer:
    """Set or get values of a slave by its bound call, which transfers those of `buffer`."""

    component: str
    function: str  # `SetReal`
    call: Callable[[], int]
    buffer: Buffer
    judge: Judge


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """Step a component by `do_step(time, length, 1)`."""

    component: str
    call: Callable[[float, float, int], int]
    length: float  # [s]
    judge: Judge


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Finite:
    """Check fetched Reals; `report` is called if one is not finite that is not marked in `reported`."""

    buffer: Buffer
    report: Action
    reported: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Capture:
    """Copy values from the bus into the recorder's next row; `index` and `sources` are by type."""

    index: dict[Scalar, NDArray[np.intp]]
    sources: dict[Scalar, Buffer]
    row: NextRow


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Python:
    """Call a function of the time, in the ticks from `first` to `last` (exclusive); elsewhere it would do nothing.

    `following` returns, after a call, the tick before which the next one would do nothing.
    `component` names whose step it begins, executes or completes, if it does.
    """

    call: Action
    component: str = ""
    first: int = 0
    last: int = ALWAYS
    following: Callable[[], int] | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alter:
    """Alter values in a buffer, at the positions `index`, by a fault in the ticks from `first` to `last` (exclusive).

    `call` does it in Python. `kind` says how C does it: `add` and `multiply` with `amounts`, `hold` and `delay` with
    the memory of the effect, which both share. `lockstep.faults.effects` describes `values` and `history`.
    """

    call: Action
    kind: Literal["add", "multiply", "hold", "delay"]
    buffer: Buffer
    index: NDArray[np.intp]
    first: int
    last: int
    amounts: NDArray[np.float64] | None = None
    values: NDArray[Any] | None = None
    history: NDArray[np.int64] | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Begin:
    """Begin a step that a thread may make, or make it; `Finish` comes later in the same tick."""

    step: Step


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Finish:
    """Complete a step that was begun, before anything else of its component happens."""

    step: Step


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pace:
    """Wait until the time of the tick is due on the wall clock; `lockstep/tick/c/pace.h` describes the arrays."""

    call: Action  # waits in Python
    numbers: NDArray[np.float64]
    edges: NDArray[np.float64]
    counts: NDArray[np.int64]


class Requested(Protocol):
    """A step, or several, of FMUs in a worker process, which C can request too."""

    number: int  # of the program that the worker runs
    length: float  # [s] of the step

    connection: Connection

    def adopt(self) -> None:
        """Have Python wait for the answer to a request that C has made."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Request:
    """Begin what is requested; `call` does it in Python."""

    requested: Requested
    call: Action
    component: str  # or several, which the time is charged to


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Answer:
    """Complete what was requested; `call` does it in Python."""

    requested: Requested
    call: Action
    component: str  # or several, which the time is charged to


Operation = (
    Gather | Convert | Alter | Transfer | Step | Begin | Finish | Request | Answer | Finite | Capture | Python | Pace
)
Block = tuple[Operation, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartedStep:
    """A step in two blocks: one begins it, the other completes it and fetches the outputs.

    Or several steps, which take their inputs after they have begun: `reads` are the components that those are of.
    """

    begin: Block
    finish: Block
    reads: frozenset[str] = field(default_factory=frozenset)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Program:
    """The blocks of every tick of the cycle, which begins at tick 0 of the run."""

    ticks: Sequence[tuple[Block, ...]]

    def with_first(self, block: Block) -> Program:
        """Return the program with a block at the start of each tick."""
        return Program(ticks=[(block, *blocks) for blocks in self.ticks])


class RowBlock(Protocol):
    """The memory of rows."""

    @property
    def times(self) -> NDArray[np.float64]:
        """(size,) [s]."""
        ...

    @property
    def parts(self) -> Row:
        """(size, k) of each type, in the order of SCALARS; the values of a row are neighbours."""
        ...


class Rows(Protocol):
    """A recorder whose rows the C tick fills in without a call for each."""

    count: int  # rows in the block

    @property
    def block(self) -> RowBlock:
        """The block that is filled."""
        ...

    def next_block(self) -> None:
        """Have the block written, and begin with another one."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Times:
    """The time of tick k is (origin + k * length) / second, in seconds: the nearest double, never a sum of steps."""

    origin: int
    length: int
    second: float | int  # a float where the numerator is exact in one

    @classmethod
    def of(cls, tick: Time, start: Time) -> Times:
        """Return those of ticks of a length from a start [ns], which need not be whole."""
        parts = lcm(tick.denominator, start.denominator)  # of a nanosecond, in which all times are whole
        second = 1e9 if parts == 1 else parts * 10**9
        return cls(origin=int(start * parts), length=int(tick * parts), second=second)

    def exact_until(self, tick: int) -> bool:
        """Return whether all numerators to this tick, and the denominator, are whole doubles."""
        largest = max(abs(self.origin), abs(self.origin + tick * self.length), self.second)
        return largest < 2**53 and tick < 2**53


class Clock(Protocol):
    """What others read the present simulated time from."""

    time: float  # [s]

    def follow(self, source: Callable[[], float] | None) -> None:
        """Read the present time from elsewhere while ticks run; None: from `time` again."""
        ...


class Ticking(Protocol):
    """One of the two implementations, with a program."""

    @property
    def done(self) -> int:
        """The first tick that is not complete."""
        ...

    def run(self, until: int, look: Action) -> None:
        """Execute the ticks from `done` to another (exclusive), or to where it ends.

        `look` is called about ten times in a second of wall time with the time at which the present tick began [s].
        """
        ...

    def stepper(self, last: int) -> Callable[[], int]:
        """Return a quick function that executes one tick, unless `last` of them are complete: it returns a Reason.

        After another one than DONE and AT_LAST, `go_on` has to be called; before anything else, `settle`.
        """
        ...

    def go_on(self, reason: int, look: Action) -> None:
        """Complete the tick at which the function of `stepper` returned this."""
        ...

    def settle(self) -> None:
        """Count the rows of the ticks that the function of `stepper` has executed."""
        ...

    @property
    def in_tick(self) -> bool:
        """Whether a tick has begun and is not complete."""
        ...

    @property
    def threads(self) -> int:
        """How many threads have stepped components."""
        ...

    def go_back(self, tick: int) -> None:
        """Continue at a tick, as if no later one had been executed, and none had ended the run."""
        ...

    def end_after_tick(self) -> None:
        """End the run when the present tick is complete."""
        ...

    def measured(self) -> float:
        """Return the sum of what `spent` returns [s]."""
        ...

    def spent(self) -> dict[str, float]:
        """Return the wall time of its ticks by account [s], see `lockstep.tick.accounts`; empty if not measured."""
        ...

    def close(self) -> None:
        """Stop what looks at the clock."""
        ...
