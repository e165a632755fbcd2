"""Compute sums of signals in the master, as a slave without an FMU."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import RunError
from lockstep.fmi.slave import OK, Buffer, Scalar, returned
from lockstep.system.component import Value
from lockstep.system.sums import Sums

_STATE = "sums.npy"


class SumsSlave:
    """Outputs are computed whenever they are fetched, of the inputs as they were set last."""

    def __init__(self, name: str, sums: Sums) -> None:
        self._name = name
        self._outputs = len(sums.inputs)
        self._values = np.zeros((self._outputs, sums.terms))

    def do_step(self, _time: float, _step: float, _complete: int) -> int:
        """Do nothing: there is no state."""
        return OK

    def getter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that computes the outputs, or fetches inputs."""
        self._only_reals(scalar)

        def get() -> int:
            # one after the other, in the order of the file: np.sum would add pairs first
            sums = np.add.accumulate(self._values, axis=1)[:, -1]
            buffer[:] = np.concatenate((sums, self._values.ravel()))[references]
            return OK

        return get

    def setter(self, scalar: Scalar, references: NDArray[np.uint32], buffer: Buffer) -> Callable[[], int]:
        """Return a call that sets inputs."""
        self._only_reals(scalar)
        inputs, positions = self._values.reshape(-1), references.astype(np.intp) - self._outputs

        def set_() -> int:
            inputs[positions] = buffer
            return OK

        return set_

    def set_start(self, values: Mapping[int, Value], scalar: Scalar) -> int:
        """Set start values of inputs."""
        self._only_reals(scalar)
        for reference, value in values.items():
            self._values.reshape(-1)[reference - self._outputs] = float(value)
        return OK

    def setup_experiment(self, _start: float, _stop: float) -> int:
        """Do nothing."""
        return OK

    def enter_initialization(self) -> int:
        """Do nothing."""
        return OK

    def exit_initialization(self) -> int:
        """Do nothing."""
        return OK

    def save_state(self, folder: str) -> int:
        """Save the inputs."""
        np.save(Path(folder, _STATE), self._values)
        return OK

    def restore_state(self, folder: str) -> int:
        """Restore the inputs, in their place: bound calls refer to it."""
        self._values[:] = np.load(Path(folder, _STATE))
        return OK

    def failed(self, _status: int) -> None:
        """Do nothing: no call fails."""

    def outcome(self, call: str, status: int) -> str:
        """Describe a call."""
        return returned("fmi2", call, status)

    def last_messages(self) -> str:
        """Return nothing: it logs nothing."""
        return ""

    def close(self) -> None:
        """Do nothing."""

    def _only_reals(self, scalar: Scalar) -> None:
        if scalar != "Real":
            raise RunError(f"{self._name}: a sum has Reals only, not {scalar}")
