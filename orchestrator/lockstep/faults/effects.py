"""Compute the effect of each kind of fault on values: arithmetic on small arrays, with memory where it is needed."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.arrays import Array

GroupValues = NDArray[Any]  # one value for each variable of a group, in the type in which they are exchanged
Function = Callable[[int, Array], Array]  # of a tick and the values
Limits = tuple[Array, Array]  # the smallest and largest values that fit


class Effect(Protocol):
    """One fault on variables that are always transferred together."""

    def observe(self, tick: int, values: GroupValues) -> None:
        """Observe a transfer, in the window or before it."""
        ...

    def act(self, tick: int, values: GroupValues) -> GroupValues:
        """Return the values for the consumer in the window, in the type of `values`; called after `observe`."""
        ...

    def saved(self) -> Any:
        """Return the memory in types of JSON."""
        ...

    def restore(self, saved: Any) -> None:
        """Restore a saved memory."""
        ...


class Stuck:
    """Hold given values, or those of the last transfer before the window; without one, those of the first."""

    def __init__(self, begin: int, value: GroupValues | None = None) -> None:
        self._begin, self._held, self._given = begin, value, value is not None

    def observe(self, tick: int, values: GroupValues) -> None:
        """Keep the last values before the window."""
        if not self._given and (tick < self._begin or self._held is None):
            self._held = values.copy()

    def act(self, _tick: int, values: GroupValues) -> GroupValues:
        """Return the held values."""
        return values if self._held is None else self._held.astype(values.dtype)

    def saved(self) -> Any:
        """Return the held values."""
        return None if self._held is None else _packed(self._held)

    def restore(self, saved: Any) -> None:
        """Restore the held values."""
        self._held = None if saved is None else _unpacked(saved)


class Delay:
    """Return the values transferred at least some ticks earlier; before that, those of the first transfer."""

    def __init__(self, ticks: int) -> None:
        self._ticks = ticks
        self._history: deque[tuple[int, GroupValues]] = deque()

    def observe(self, tick: int, values: GroupValues) -> None:
        """Keep the history that can still be needed."""
        history = self._history
        history.append((tick, values.copy()))
        while len(history) > 1 and history[1][0] <= tick - self._ticks:
            history.popleft()

    def act(self, _tick: int, _values: GroupValues) -> GroupValues:
        """Return the oldest values kept."""
        return self._history[0][1]

    def saved(self) -> Any:
        """Return the history."""
        return [[tick, _packed(values)] for tick, values in self._history]

    def restore(self, saved: Any) -> None:
        """Restore the history."""
        self._history = deque((tick, _unpacked(values)) for tick, values in saved)


class Change:
    """Apply a function of time and values; whole numbers are rounded to the nearest in the range of their type."""

    def __init__(self, function: Function, limits: Limits | None = None) -> None:
        self._function = function
        self._low, self._high = limits or (np.empty(0), np.empty(0))  # Reals are not clipped

    def observe(self, tick: int, values: GroupValues) -> None:
        """Keep nothing."""

    def act(self, tick: int, values: GroupValues) -> GroupValues:
        """Return the changed values."""
        doubles = values.astype(np.float64)
        changed = self._function(tick, doubles)
        if values.dtype.kind == "f":
            return changed
        rounded = np.rint(np.clip(changed, self._low, self._high)).astype(values.dtype)
        return np.where(changed == doubles, values, rounded)  # a double may lack digits of 64 bits

    def saved(self) -> Any:
        """Return nothing."""
        return None

    def restore(self, saved: Any) -> None:
        """Do nothing."""


class SingleSpike:
    """Change the first transfer in the window."""

    def __init__(self, begin: int, change: Change) -> None:
        self._begin, self._change = begin, change
        self._first: int | None = None

    def observe(self, tick: int, _values: GroupValues) -> None:
        """Keep the tick of the first transfer."""
        if self._first is None and tick >= self._begin:
            self._first = tick

    def act(self, tick: int, values: GroupValues) -> GroupValues:
        """Change the first transfer."""
        return self._change.act(tick, values) if tick == self._first else values

    def saved(self) -> Any:
        """Return the tick of the first transfer."""
        return self._first

    def restore(self, saved: Any) -> None:
        """Restore that tick."""
        self._first = saved


def _packed(values: GroupValues) -> list[Any]:
    return [values.dtype.str, values.tolist()]


def _unpacked(saved: Any) -> GroupValues:
    values: GroupValues = np.array(saved[1], saved[0])
    return values


def bias(value: Array) -> Function:
    """Add a constant."""
    return lambda _tick, values: values + value


def scale(factor: Array) -> Function:
    """Multiply by a factor."""
    return lambda _tick, values: values * factor


def quantisation(step: Array) -> Function:
    """Round to multiples of the step; halves go to the even multiple."""
    return lambda _tick, values: step * np.rint(values / step)


def not_a_number() -> Function:
    """Replace all values by NaN."""
    return lambda _tick, values: np.full_like(values, np.nan)


def noise(deviation: Array, seed: int, names: Sequence[str]) -> Function:
    """Add normal noise of this standard deviation."""
    draw = drawn_from(seed, names)
    return lambda tick, values: values + deviation * draw(tick).standard_normal(len(values))


def random_spikes(value: Array, probability: float, seed: int, names: Sequence[str]) -> Function:
    """Add to each value with this probability, with a random sign."""
    draw = drawn_from(seed, names)

    def spiked(tick: int, values: Array) -> Array:
        hit, sign = draw(tick).uniform(size=(2, len(values)))
        return np.where(hit < probability, values + np.copysign(value, sign - 0.5), values)

    return spiked


def limits_of(lowest: Sequence[int], highest: Sequence[int]) -> Limits:
    """Return ranges of integers as doubles inside them: the nearest double to a limit of 64 bits is outside."""
    low, high = (np.array(numbers, np.float64) for numbers in (lowest, highest))
    outside = [value > exact for value, exact in zip(high.tolist(), highest, strict=True)]
    return low, np.where(outside, np.nextafter(high, 0.0), high)


def drawn_from(seed: int, names: Sequence[str]) -> Callable[[int], np.random.Generator]:
    """Return a function from a tick to a generator whose numbers depend on seed, names and tick alone."""
    digest = hashlib.sha256("\n".join([str(seed), *names]).encode()).digest()
    bits = np.random.Philox(key=np.frombuffer(digest[:16], np.uint64))
    generator, state = np.random.Generator(bits), bits.state

    def at(tick: int) -> np.random.Generator:
        # a counter of four words, the lowest first: each tick has 2**64 blocks. A third of the time of a new generator
        state["state"]["counter"] = np.array([0, tick, 0, 0], np.uint64)
        bits.state = state
        return generator

    return at
