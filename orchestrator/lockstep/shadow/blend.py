"""Compute how the difference between a component and its shadow decays after the switchover.

At the switchover T, d = original(T) - shadow(T) is the present difference and m the mean difference of the time before;
the rest, d - m, is mostly noise of one sample. From then on

    acting(t) = shadow(t) + w((t - T) / blend) m + w((t - T) / short) (d - m)
    w(x) = 1 - 10 x^3 + 15 x^4 - 6 x^5 for 0 <= x <= 1, then 0;    short = 10 steps of the slower one, at most blend

so that acting(T) = original(T). A lasting difference, such as a drifted integral, decays over `blend`, and the noise of
one sample acts for a few steps only. w begins and ends with zero slope and curvature, which excites a flexible
structure least. After T the original is in no loop: stability is that of the shadow's loop alone, with a decaying
disturbance. The mean m forgets with half of `blend` as its time constant.
"""

from lockstep.system.clock import Time
from lockstep.system.component import Shadow


def short(plan: Shadow) -> Time:
    """Return the time over which the difference of one sample decays [ns]."""
    return min(plan.blend, 10 * max(plan.period, plan.component.period))


def remaining(elapsed: Time, blend: Time) -> float:
    """Return the share of a difference that remains `elapsed` after the switchover [ns both]."""
    if elapsed >= blend:
        return 0.0
    x = float(elapsed / blend)
    return 1.0 - x**3 * (10.0 - x * (15.0 - 6.0 * x))
