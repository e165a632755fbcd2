"""Set inputs at the start of each step to what files of signals give for its time."""

from bisect import bisect_right
from collections.abc import Callable, Sequence

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Slave
from lockstep.plan.input_files import InputPart

Check = Callable[[str, str, float, int], None]  # component, call of FMI, time [s] and status
Action = Callable[[float], None]  # called with the simulated time [s]


class InputSignals:
    """The inputs that files give. They are functions of time alone, so that there is no state to save."""

    def __init__(self, parts: Sequence[InputPart], start_time: float) -> None:
        self._parts = parts
        self.start_time = start_time  # [s], of the run: the time of the values during initialization

    def feed(self, component: str) -> bool:
        """Return whether a component has such inputs."""
        return any(part.component == component for part in self._parts)

    def on_step(self, component: str, slave: Slave, check: Check) -> list[Action]:
        """Return what sets the inputs of a component at the start of a step."""
        return [_bound(part, slave, check) for part in self._parts if part.component == component]


def _bound(part: InputPart, slave: Slave, check: Check) -> Action:
    buffer: Buffer = np.zeros(len(part.references), DTYPES[part.scalar])
    call = slave.setter(part.scalar, np.array(part.references, np.uint32), buffer)
    times, values, linear, function = part.times, part.values, part.linear, f"Set{part.scalar}"
    last = len(times) - 1

    def act(time: float) -> None:
        row = bisect_right(times, time + part.tolerance) - 1
        if row < 0:
            buffer[:] = values[0]
        elif not linear or row == last:
            buffer[:] = values[row]
        else:
            share = (time - times[row]) / (times[row + 1] - times[row])
            buffer[:] = values[row] + max(share, 0.0) * (values[row + 1] - values[row])
        status = call()
        if status:
            check(part.component, function, time, status)

    return act
