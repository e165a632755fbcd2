"""What the master needs of a slave, whatever stands behind it: an FMU, or a toy in a test."""

from collections.abc import Callable, Mapping
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.system import Value

Scalar = Literal["Real", "Integer", "Boolean"]
SCALARS: tuple[Scalar, ...] = ("Real", "Integer", "Boolean")
DTYPES: Mapping[str, type] = {"Real": np.float64, "Integer": np.int32, "Boolean": np.int32}
Buffer = NDArray[np.float64] | NDArray[np.int32]

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")


class Slave(Protocol):
    """One instance. Every call returns an FMI status; above WARNING the run is over."""

    @property
    def do_step(self) -> Callable[[float, float, int], int]:
        """Call as do_step(time, step, 1)."""
        ...

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer; the buffer must stay where it is."""
        ...

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that hands the buffer over; the buffer must stay where it is."""
        ...

    def set_start(self, values: Mapping[int, Value], scalar: str) -> int:
        """Set parameters and start values by value reference, before initialization."""
        ...

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span [s]."""
        ...

    def enter_initialization(self) -> int:
        """Enter initialization mode."""
        ...

    def exit_initialization(self) -> int:
        """Leave initialization mode."""
        ...

    def failed(self, status: int) -> None:
        """Note the status that ended the run; after FATAL the instance is never called again."""
        ...

    def last_messages(self) -> str:
        """Return what the slave logged last, or nothing."""
        ...

    def close(self) -> None:
        """Terminate and free; never raises, may be called twice."""
        ...
