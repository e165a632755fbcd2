"""Express periods as whole numbers of steps. Travels in the FMUs."""

from __future__ import annotations


def whole_multiple(name: str, period: float, step: float, step_name: str = "the step of") -> int:
    """Return period / step as a whole number from 1; raise ValueError by name if it is none.

    Decimal periods are not exact in binary: a difference of a millionth of a step is accepted.
    """
    count = round(period / step)
    if count < 1 or abs(count * step - period) > 1e-6 * step:
        raise ValueError(f"{name} = {period:g} s must be a whole multiple of {step_name} {step:g} s")
    return count
