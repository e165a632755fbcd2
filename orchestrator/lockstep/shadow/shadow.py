"""Which FMU rides along beside a component, what it may take over, and how: frozen values and one law.

At the hand-over T the difference between the two is kept, d = original(T) - shadow(T), and from then on

    acting(t) = shadow(t) + w((t - T) / blend) d,    w(x) = 1 - 10 x^3 + 15 x^4 - 6 x^5 for 0 <= x <= 1, then 0

so that acting(T) = original(T), and the offset begins and ends with zero slope and curvature, which excites a flexible
structure least. After T the original is in no loop: stability is that of the shadow's loop alone, with w d as a
disturbance that passes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lockstep.clock import seconds_text
from lockstep.errors import InputError

if TYPE_CHECKING:
    from lockstep.system import Component

DEFAULT_BLEND = 5_000_000_000  # [ns]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shadow:
    """What rides along beside the component that holds this. Times in ns.

    `component` has the shadow's own period; the component that holds it is stepped at the common divisor of both.
    `outputs` are those of the original that others read, which is what the shadow has to have too.
    """

    component: Component
    period: int  # of the original
    outputs: tuple[str, ...]
    hand_over: int | None = None  # None: it rides along to the end
    blend: int = DEFAULT_BLEND

    def __post_init__(self) -> None:
        if self.hand_over is not None and self.hand_over < 0:
            raise InputError(f"hand-over {seconds_text(self.hand_over)} s must be >= 0 s")
        if self.blend < 0:
            raise InputError(f"blend {seconds_text(self.blend)} s must be >= 0 s; 0 switches at once")


def remaining(elapsed: int, blend: int) -> float:
    """Return the share of the offset that is left `elapsed` after the hand-over [ns both]."""
    if elapsed >= blend:
        return 0.0
    x = elapsed / blend
    return 1.0 - x**3 * (10.0 - x * (15.0 - 6.0 * x))
