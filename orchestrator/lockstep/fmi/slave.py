"""The interface of a slave as the master uses it: an FMU in this process or another, or a toy in a test."""

from collections.abc import Callable, Mapping
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import EndOfSimulation
from lockstep.system.component import Value

# The types in which values travel. An Integer has 32 bits: all of FMI 1.0 and 2.0, and those of FMI 3.0 that fit.
Scalar = Literal["Real", "Integer", "Boolean", "Int64", "UInt64", "String"]
SCALARS: tuple[Scalar, ...] = ("Real", "Integer", "Boolean", "Int64", "UInt64", "String")
DTYPES: Mapping[str, type] = {
    "Real": np.float64,
    "Integer": np.int32,
    "Boolean": np.int32,
    "Int64": np.int64,
    "UInt64": np.uint64,
    "String": np.object_,  # of str
}
Buffer = NDArray[np.float64] | NDArray[np.int32] | NDArray[np.int64] | NDArray[np.uint64] | NDArray[np.object_]

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
ASKED_FOR_END, _REACHED = "asked for the end of the simulation", ", having reached "
_STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")  # FMI 3.0 has no fmi3Pending


class Slave(Protocol):
    """One instance. Every call returns an FMI status, which is never below 0; above WARNING the run is over."""

    @property
    def do_step(self) -> Callable[[float, float, int], int]:
        """Call as do_step(time, step, 1)."""
        ...

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that fills the buffer, whose memory must not move."""
        ...

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that sets the values of the buffer, whose memory must not move."""
        ...

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set parameters and start values by reference, after `setup_experiment`, which may reset what was set."""
        ...

    def setup_experiment(self, start: float, stop: float) -> int:
        """Announce the time span [s], and the tolerance: the first call of all."""
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

    def outcome(self, call: str, status: int) -> str:
        """Describe a call that failed: `fmi2DoStep returned fmi2Error`. `call` has no prefix: `DoStep`."""
        ...

    def last_messages(self) -> str:
        """Return what the slave logged last, or nothing."""
        ...

    def close(self) -> None:
        """Terminate and free; never raises, may be called twice."""
        ...


@runtime_checkable
class Stateful(Protocol):
    """A slave that can save its state and continue from it in another process. A wrapper of a slave saves both."""

    def save_state(self, folder: str) -> int:
        """Write the whole state to files in an empty folder; each layer of wrappers uses file names of its own."""
        ...

    def restore_state(self, folder: str) -> int:
        """Restore the state in a folder; the instance has been initialized with the same parameters."""
        ...


def status_name(prefix: str, status: int) -> str:
    """Return the name of a status in a version of FMI, such as `fmi2Error`; prefix is `fmi2`."""
    if 0 <= status < (PENDING if prefix == "fmi3" else len(_STATUS)):
        return f"{prefix}{_STATUS[status]}"
    return f"the unknown status {status - 2**32 if status >= 2**31 else status}"  # as the FMU meant it: an int of C


def asked_for_end(reached: float | None) -> str:
    """Describe that an FMU asked for a regular end in a step; `reached` is the last time that it has computed [s]."""
    return ASKED_FOR_END if reached is None else f"{ASKED_FOR_END}{_REACHED}{reached!r} s"


def regular_end(outcome: str, name: str, time: float, step: float) -> EndOfSimulation | None:
    """Return the end of a run if the outcome of a step [s] is what `asked_for_end` describes; None for a failure."""
    if ASKED_FOR_END not in outcome:
        return None
    _, found, reached = outcome.rpartition(_REACHED)
    end = time + step
    complete = bool(found) and float(reached.removesuffix(" s")) >= end - 1e-9 * max(1.0, abs(end))
    return EndOfSimulation(f"{name}: {outcome}, in the step from {time:.9g} s", name, complete)


def returned(prefix: str, call: str, status: int) -> str:
    """Describe a call with this prefix (`fmi2`) that returned a status."""
    return f"{prefix}{call} returned {status_name(prefix, status)}"
