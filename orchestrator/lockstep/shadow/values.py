"""Hold the outputs of one type that may be switched over: the original's, the shadow's, the residual, what acts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Scalar
from lockstep.shadow.blend import remaining, short
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW, Joined, Match
from lockstep.system.clock import Time, common_divisor
from lockstep.system.component import Shadow

Convert = Callable[[Buffer], Buffer]


class OutputValues:
    """Hold one row for each kind and one column for each output. Only Reals have a residual and are blended."""

    def __init__(self, scalar: Scalar, joined: Joined, plan: Shadow) -> None:
        self.scalar, self._plan = scalar, plan
        step = common_divisor(plan.period, plan.component.period)
        self._weight = min(1.0, 2.0 * step / max(step, plan.blend))
        self.matches = [match for match in joined.acting if match.shown.scalar == scalar]
        count = len(self.matches)
        bank: Buffer = np.zeros((4, count), DTYPES[scalar])
        self.acting, self.original, self.shadow, self.residual = bank
        self.raw: Buffer = np.zeros(count, DTYPES[scalar])  # the shadow's, in its own unit
        self.offset: Buffer = np.zeros(count, DTYPES[scalar])  # original less shadow at the switchover
        self.mean, self._count = np.zeros(count), np.zeros(1)  # of original less shadow until then, of how many
        self.applied: Buffer = np.zeros(count, DTYPES[scalar])  # what acted in the shadow's last step
        self._acted, self._times = np.zeros(count), np.zeros(1)  # sum and number since that began
        self._convert = conversion(self.matches)
        self.flat = bank.reshape(-1)
        self.positions: dict[int, int] = {}  # in `flat`, by the reference that is shown
        number = {name: variable.reference for name, variable in joined.variables.items()}
        for row, prefix in enumerate(("", ORIGINAL, SHADOW, RESIDUAL)):
            for column, match in enumerate(self.matches):
                name = f"{prefix}{match.shown.name}"
                if name in number:
                    self.positions[number[name]] = row * count + column

    def pulled(self) -> None:
        """Convert the values got from the shadow."""
        self.shadow[:] = self._convert(self.raw)

    def update_applied(self) -> None:
        """Set `applied` to the mean of the Reals that acted since the last update; of other types to the last value."""
        if self.scalar != "Real" or not self._times[0]:
            self.applied[:] = self.acting
            return
        self.applied[:] = self._acted / self._times
        self._acted[:] = self._times[:] = 0.0

    def memory(self) -> list[Buffer]:
        """Return the arrays that a restarted run needs."""
        own = [self.flat, self.raw, self.offset, self.mean, self._count, self.applied, self._acted, self._times]
        return own if self.matches else []

    def keep_offset(self) -> None:
        """Keep the difference of Reals at the switchover."""
        np.subtract(self.original, self.shadow, self.offset)

    def decide(self, now: Time) -> None:
        """Select the values that act at this time [ns]; after the switchover the difference is blended out."""
        plan, real = self._plan, self.scalar == "Real"
        over = plan.switchover
        if real:
            np.subtract(self.shadow, self.original, self.residual)
        # at the switchover itself shadow + difference is the original, up to rounding
        if over is None or now < over or (real and now == over and plan.blend > 0):
            self.acting[:] = self.original
        elif real and now < over + plan.blend:
            slow, fast = remaining(now - over, plan.blend), remaining(now - over, short(plan))
            self.acting[:] = self.shadow + (slow * self.mean + fast * (self.offset - self.mean))
        else:
            self.acting[:] = self.shadow
        if real:
            if over is not None and now < over:
                self._follow()
            self._acted += self.acting
            self._times += 1.0

    def _follow(self) -> None:
        """Include the present difference in the mean; the first ones have equal weights."""
        self._count += 1.0
        self.mean -= max(self._weight, 1.0 / self._count[0]) * (self.residual + self.mean)


def conversion(matches: Sequence[Match]) -> Convert:
    """Return the conversion of values from one side to the other."""
    gain, bias = np.array([m.gain for m in matches]), np.array([m.bias for m in matches])
    if np.all(gain == 1.0) and not np.any(bias):
        return lambda values: values
    return lambda values: gain * values + bias
