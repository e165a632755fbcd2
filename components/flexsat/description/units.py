"""Read a number with its unit, such as "0.1 arcsec", as a value in the unit of a parameter."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from ..parameters import DEGREE, RPM
from ..ports.units import UNITS

# units that no port has, by that of the parameter: what multiplies its value to give the value in the other unit
_MORE: Mapping[str, Mapping[str, float]] = {
    "N.s2/rad2": {"N/rpm2": RPM**2},
    "N.m.s2/rad2": {"N.m/rpm2": RPM**2},
    "Hz": {"rpm": 60.0},
    "deg": {"rad": DEGREE},
    "rad/s": {"deg/h": 3600.0 / DEGREE},
    "rad/s^1.5": {"deg/h/rth": 60.0 * 3600.0 / DEGREE},  # over the root of an hour
}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")


def units_for(unit: str) -> dict[str, float]:
    """Return the units that a value may have, each with what multiplies a value in `unit` to give one in it."""
    known = UNITS[unit].display if unit in UNITS else {}
    return {unit: 1.0, **known, **_MORE.get(unit, {})}


def number_in(unit: str, value: Any) -> float:
    """Return a value in a unit: a number, which is in it already, or a text with number and unit.

    Raises
    ------
    ValueError
        If it is neither, not finite, or its unit is another quantity's.
    """
    allowed = units_for(unit)
    example = "a number" if unit == "1" else f'a number in {unit}, or a text such as "1.5 {list(allowed)[-1]}"'
    if isinstance(value, str):
        found = _NUMBER.fullmatch(value)
        if found is None:
            raise ValueError(f"must be {example}")
        given = found[2] or unit
        if given not in allowed:
            raise ValueError(f"has the unit {given}; it is measured in {' or '.join(allowed)}")
        return float(found[1]) / allowed[given] if given != unit else float(found[1])
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"must be {example}")
    if not math.isfinite(value):
        raise ValueError(f"must be finite, {example}")
    return float(value)
