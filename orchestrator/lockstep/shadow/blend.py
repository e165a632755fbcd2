"""Which FMU rides along beside a component, what it may take over, and how: frozen values and one law.

At the hand-over T the difference d = original(T) - shadow(T) is kept, and m, the mean difference of late: what is left,
d - m, is mostly noise of that one sample. From then on

    acting(t) = shadow(t) + w((t - T) / blend) m + w((t - T) / short) (d - m)
    w(x) = 1 - 10 x^3 + 15 x^4 - 6 x^5 for 0 <= x <= 1, then 0;    short = 10 steps of the slower one, at most blend

so that acting(T) = original(T). What the two differ by for long, such as an integral that has drifted, passes in the
time told, and one sample's noise does not act as a torque for seconds. Both begin and end with zero slope and
curvature, which excites a flexible structure least. After T the original is in no loop: stability is that of the
shadow's loop alone, with a disturbance that passes. m forgets with half of blend as its time constant.
"""

from lockstep.system.component import Shadow


def short(plan: Shadow) -> int:
    """Return how long the difference of one sample takes to pass [ns]."""
    return min(plan.blend, 10 * max(plan.period, plan.component.period))


def remaining(elapsed: int, blend: int) -> float:
    """Return the share of the offset that is left `elapsed` after the hand-over [ns both]."""
    if elapsed >= blend:
        return 0.0
    x = elapsed / blend
    return 1.0 - x**3 * (10.0 - x * (15.0 - 6.0 * x))
