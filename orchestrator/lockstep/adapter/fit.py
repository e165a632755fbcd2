"""Convert numbers between doubles and the other types of FMI: what does not fit is refused, never changed to fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.arrays import Array
from lockstep.fmi.model_description import Variable

_EXACT = 2**53  # the largest integer up to which every one is a double
_LIMITS = {  # the outermost doubles that fit, by the type of a buffer
    np.dtype(np.int32): (-(2.0**31), 2.0**31 - 1.0),
    np.dtype(np.int64): (-(2.0**63), 2.0**63 - 1024.0),
    np.dtype(np.uint64): (0.0, 2.0**64 - 2048.0),
}


class Unfit(Exception):
    """Report a value that its destination cannot hold; the text names both."""


def whole(values: Array, variables: Sequence[Variable], dtype: np.dtype[Any]) -> Array:
    """Return doubles rounded to the nearest whole number for these variables; of a Boolean, any but 0 is 1.

    Raises
    ------
    Unfit
        If one is not finite, or out of the range of an integer type.
    """
    rounded, flags = np.rint(values), np.array([v.type == "Boolean" for v in variables])
    low, high = _LIMITS[dtype]
    fits = np.where(flags, np.isfinite(values), (rounded >= low) & (rounded <= high))  # NaN does not
    if not fits.all():
        first = int(np.argmin(fits))
        variable = variables[first]
        raise Unfit(f"{variable.name}: {values[first]:.9g} does not fit into {variable.native or variable.type}")
    return np.where(flags, rounded != 0.0, rounded)


def doubles(values: NDArray[Any], variables: Sequence[Variable]) -> Array:
    """Return values of another type as doubles; raise Unfit for an integer of 64 bits that is between two doubles."""
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        for variable, value in zip(variables, values.tolist(), strict=True):
            if abs(value) > _EXACT and int(float(value)) != value:
                raise Unfit(f"{variable.name}: {value} has more digits than the 53 bits that an adapter keeps")
    return values.astype(np.float64)


def finite(values: Array, given: Array, variables: Sequence[Variable]) -> None:
    """Raise Unfit if the conversion of finite numbers has led to one that is not."""
    found = np.isfinite(values)
    if not found.all() and np.isfinite(given).all():
        first = int(np.argmin(found))
        raise Unfit(f"{variables[first].name}: is {values[first]} after the conversion of {given.tolist()}")
