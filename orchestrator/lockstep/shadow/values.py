"""The values that are handed over, of one type: the original's, the shadow's, the residual, and what acts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import gcd

import numpy as np

from lockstep.fmi.slave import DTYPES, Buffer, Scalar
from lockstep.shadow.blend import remaining, short
from lockstep.shadow.ports import ORIGINAL, RESIDUAL, SHADOW, Joined, Match
from lockstep.system.component import Shadow

Convert = Callable[[Buffer], Buffer]


class Values:
    """One row a kind, one column a variable. Only Reals have a residual and are blended; others switch at once."""

    def __init__(self, scalar: Scalar, joined: Joined, plan: Shadow) -> None:
        self.scalar, self._plan = scalar, plan
        step = gcd(plan.period, plan.component.period)
        self._weight = min(1.0, 2.0 * step / max(step, plan.blend))
        self.matches = [match for match in joined.handed if match.shown.scalar == scalar]
        count = len(self.matches)
        bank: Buffer = np.zeros((4, count), DTYPES[scalar])
        self.acting, self.original, self.shadow, self.residual = bank
        self.raw: Buffer = np.zeros(count, DTYPES[scalar])  # the shadow's, in its own unit
        self.offset: Buffer = np.zeros(count, DTYPES[scalar])  # original less shadow at the hand-over
        self.mean, self._count = np.zeros(count), np.zeros(1)  # of original less shadow until then, of how many
        self.applied: Buffer = np.zeros(count, DTYPES[scalar])  # what acted in the shadow's last step
        self._acted, self._times = np.zeros(count), np.zeros(1)  # sum and number since that began
        self._convert = conversion(self.matches)
        self.flat = bank.reshape(-1)
        self.places: dict[int, int] = {}  # in `flat`, by the reference that is shown
        number = {name: variable.reference for name, variable in joined.variables.items()}
        for row, prefix in enumerate(("", ORIGINAL, SHADOW, RESIDUAL)):
            for column, match in enumerate(self.matches):
                name = f"{prefix}{match.shown.name}"
                if name in number:
                    self.places[number[name]] = row * count + column

    def pulled(self) -> None:
        """Take over what the shadow gave."""
        self.shadow[:] = self._convert(self.raw)

    def tell_applied(self) -> None:
        """Make `applied` anew: the mean since it was made last, or of other types the last."""
        if self.scalar != "Real" or not self._times[0]:
            self.applied[:] = self.acting
            return
        self.applied[:] = self._acted / self._times
        self._acted[:] = self._times[:] = 0.0

    def memory(self) -> list[Buffer]:
        """Return all that has to be the same where a run goes on."""
        own = [self.flat, self.raw, self.offset, self.mean, self._count, self.applied, self._acted, self._times]
        return own if self.matches else []

    def keep_offset(self) -> None:
        """Keep what the two differ by at the hand-over; of Reals."""
        np.subtract(self.original, self.shadow, self.offset)

    def decide(self, now: int) -> None:
        """Let one of them act, or at first after the hand-over the shadow with what is left of the difference [ns]."""
        plan, real = self._plan, self.scalar == "Real"
        over = plan.hand_over
        if real:
            np.subtract(self.shadow, self.original, self.residual)
        # at the hand-over itself shadow + difference is the original, but for rounding
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
        """Take the present difference into the mean; the first ones count alike."""
        self._count += 1.0
        self.mean -= max(self._weight, 1.0 / self._count[0]) * (self.residual + self.mean)


def conversion(matches: Sequence[Match]) -> Convert:
    """Return what turns values on one side into those on the other."""
    gain, bias = np.array([m.gain for m in matches]), np.array([m.bias for m in matches])
    if np.all(gain == 1.0) and not np.any(bias):
        return lambda values: values
    return lambda values: gain * values + bias
