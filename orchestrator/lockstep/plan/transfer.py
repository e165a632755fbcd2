"""Convert arrays of values between outputs and inputs: transformations, and changes of type."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.errors import RunError
from lockstep.fmi.slave import DTYPES, Scalar
from lockstep.system.transformation import Function

ValueArray = NDArray[Any]  # of any type that is exchanged
Convert = Callable[[ValueArray], ValueArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """The conversion of one value: gain * source + bias for Reals, or a function."""

    source: Scalar
    gain: float = 1.0
    bias: float = 0.0
    function: Function | None = None

    def is_identity(self, target: Scalar) -> bool:
        """Return whether the value is unchanged."""
        return self.source == target and (self.gain, self.bias, self.function) == (1.0, 0.0, None)


@dataclass(frozen=True, slots=True)
class SetValue:
    """One value to set: its input, its position on the bus of its source's type, and its conversion."""

    target: int
    position: int
    way: Way


def linear(ways: Iterable[Way], target: Scalar) -> bool:
    """Return whether one product and one sum of Reals convert all of them."""
    return target == "Real" and all(way.source == "Real" and way.function is None for way in ways)


def converter(target: Scalar, ways: Sequence[Way], names: Sequence[str]) -> Convert:
    """Return the conversion of values, (n,), to another type. `names` are the n targets, for errors.

    An integer outside the range of its new type is a RunError.
    """
    functions = [(k, way.function) for k, way in enumerate(ways) if way.function is not None]
    gain, bias = np.array([way.gain for way in ways]), np.array([way.bias for way in ways])
    scaled = target == "Real" and (bool(np.any(gain != 1.0)) or bool(np.any(bias)))

    def convert(values: ValueArray) -> ValueArray:
        if functions:
            found = values.tolist()  # Python's integers: exact at any width
            for k, function in functions:
                found[k] = function(found[k])
            values = np.array(found, np.object_)
        if target == "String":
            return values
        if target == "Real":
            reals = values.astype(np.float64)
            return np.asarray(gain * reals + bias) if scaled else reals
        if target == "Boolean":
            return np.asarray(values != 0).astype(np.int32)
        return _whole(values, target, names)

    return convert


def _whole(values: ValueArray, target: Scalar, names: Sequence[str]) -> ValueArray:
    limits = np.iinfo(DTYPES[target])
    for name, value in zip(names, values.tolist(), strict=True):
        if not limits.min <= value <= limits.max:
            raise RunError(f"{name}: {value} is outside [{limits.min}, {limits.max}], the range of its type")
    return values.astype(DTYPES[target])
