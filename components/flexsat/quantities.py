"""Read units and ranges of parameters from the annotations of their fields: `Annotated[float, "N.m", POSITIVE]`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any, get_type_hints


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Limits of a parameter: `minimum` and `maximum` may be reached, `above` and `below` may not."""

    minimum: float | None = None
    above: float | None = None
    maximum: float | None = None
    below: float | None = None

    def __contains__(self, value: float) -> bool:
        """Return whether a value lies within the limits; not-a-number does not."""
        return (
            (self.minimum is None or value >= self.minimum)
            and (self.above is None or value > self.above)
            and (self.maximum is None or value <= self.maximum)
            and (self.below is None or value < self.below)
            and not math.isnan(value)
        )

    def __str__(self) -> str:
        limits = ((">=", self.minimum), (">", self.above), ("<=", self.maximum), ("<", self.below))
        return " and ".join(f"{sign} {limit:g}" for sign, limit in limits if limit is not None) or "a number"

    @property
    def least(self) -> float | None:
        """The lower limit, reached or not."""
        return self.above if self.minimum is None else self.minimum

    @property
    def most(self) -> float | None:
        """The upper limit, reached or not."""
        return self.below if self.maximum is None else self.maximum


NOT_NEGATIVE = Range(minimum=0.0)
POSITIVE = Range(above=0.0)
PERIOD = Range(minimum=1e-6, maximum=3600.0)
FULL_TURN = 2.0 * math.pi  # rad
TURN = Range(minimum=-FULL_TURN, maximum=FULL_TURN)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What a parameter is measured in, and its range: the annotation of its field."""

    unit: str
    range: Range


def quantity(owner: type, name: str) -> Quantity:
    """Return unit and range of a field that is annotated with a unit; raise ValueError for any other."""
    known = _quantities(owner).get(name)
    if known is None:
        raise ValueError(f"{owner.__name__}.{name}: no such parameter with a unit")
    return known


@cache  # reading annotations compiles each of them
def _quantities(owner: type) -> dict[str, Quantity]:
    """Return unit and range of the fields that are annotated with a unit."""
    found = {}
    for name, hint in get_type_hints(owner, include_extras=True).items():
        unit, *limits = getattr(hint, "__metadata__", (None,))
        if unit is not None:
            found[name] = Quantity(unit=unit, range=limits[0] if limits else Range())
    return found


def check_ranges(parameters: Any) -> None:
    """Refuse a value outside the range of its field, by name; called from `__post_init__`."""
    owner: type = type(parameters)
    for name, known in _quantities(owner).items():
        value = getattr(parameters, name)
        for number in value if isinstance(value, tuple) else (value,):
            if number not in known.range:
                raise ValueError(f"{owner.__name__}.{name} [{known.unit}] must be {known.range}, got {number!r}")
