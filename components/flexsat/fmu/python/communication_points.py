"""Check the times that a host gives: each step begins where the one before ended, and none passes the stop time."""

from __future__ import annotations

import sys
from collections.abc import Callable
from math import isfinite

import numpy as np

from .port_values import Refused

STEP_TOLERANCE = 1e-6  # relative; a host that subtracts times at t = 1e5 s errs by 1e-11 s in its step
ROUNDING = 16.0 * sys.float_info.epsilon  # relative to the time; a time of ns made by division errs by 1


class CommunicationPoints:
    """The present communication point of an instance, and its stop time. All times in [s].

    The next point is compared with the last one that the host gave, plus its step: what a host errs by in adding steps
    up does not accumulate here.
    """

    __slots__ = ("_present", "defined", "length", "stop")

    def __init__(self) -> None:
        self._present = np.zeros(1)  # the shim reads it
        self.defined = False  # whether the experiment is set up
        self.stop: float | None = None
        self.length = 0.0  # of all steps, where the first one sets it

    @property
    def present(self) -> float:
        """The point that the model has reached."""
        return float(self._present[0])

    @property
    def address(self) -> int:
        """Where the shim reads the present point."""
        return int(self._present.ctypes.data)

    def set_up(self, start: float, stop: float | None, tolerance: float | None) -> None:
        """Accept an experiment."""
        if not isfinite(start):
            raise Refused(f"the start time must be finite, got {start!r} s")
        if stop is not None and not (isfinite(stop) and stop >= start):
            raise Refused(f"the stop time must be finite and not before the start time {start!r} s, got {stop!r} s")
        if tolerance is not None and not (isfinite(tolerance) and tolerance >= 0.0):
            raise Refused(f"the tolerance must be finite and >= 0, got {tolerance!r}")
        self._present[0], self.stop, self.defined = start, stop, True

    def check_defined(self) -> None:
        """Refuse to initialise before the experiment is set up."""
        if not self.defined:
            raise Refused("not allowed before fmi2SetupExperiment")

    def restore(self, present: float, defined: bool, length: float = 0.0) -> None:
        """Return to the point of a saved state; the stop time is that of the last experiment."""
        self._present[0], self.defined, self.length = present, defined, length

    def admit(
        self, time: float, step: float, fixed: float | None, set_by: str | None, first: Callable[[float], None] | None
    ) -> float:
        """Check a step, and return its length: the exact one where only one is accepted.

        Parameters
        ----------
        fixed, set_by : as of `check_step`
        first : called with the length of the first step, which all others have to have; None: they may differ
        """
        if fixed is not None or first is None:
            self.check_step(time, step, fixed, set_by)
            return step if fixed is None else fixed
        self.check_step(time, step, self.length or None, "the first step")
        if not self.length:
            length = round(step, 9)  # a host that subtracts times errs in the last digits
            if not length > 0.0:
                raise Refused(f"a step of {step!r} s is not accepted; the shortest is 1e-9 s")
            try:
                first(length)
            except ValueError as error:
                raise Refused(str(error)) from None
            self.length = length
        return self.length

    def check_step(self, time: float, step: float, fixed: float | None, set_by: str | None) -> None:
        """Refuse a step of another length than the fixed one, at another time than the present, or past the stop time.

        Parameters
        ----------
        fixed : the only length accepted [s]; None accepts any
        set_by : what sets it
        """
        if fixed is not None:
            if step != fixed and not abs(step - fixed) <= STEP_TOLERANCE * fixed:
                remedy = f", set by {set_by}" if set_by else ""
                raise Refused(f"a step of {step!r} s is not accepted; the step is {fixed!r} s{remedy}")
        elif not 0.0 < step < sys.float_info.max:
            raise Refused(f"a step of {step!r} s is not accepted; a step is > 0 s and finite")
        present = float(self._present[0])
        tolerance = STEP_TOLERANCE * step + ROUNDING * abs(present)
        if not abs(time - present) <= tolerance:
            raise Refused(f"a step begins at the present communication point, {present!r} s")
        if self.stop is not None and time + step > self.stop + tolerance:
            raise Refused(f"a step to {time + step!r} s passes the stop time {self.stop!r} s")

    def advance(self, time: float, step: float) -> None:
        """Note that a step was made."""
        self._present[0] = time + step
