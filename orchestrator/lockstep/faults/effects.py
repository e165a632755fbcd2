"""Compute the effect of each kind of fault on values: arithmetic on small arrays, with memory where it is needed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lockstep.arrays import Array

GroupValues = NDArray[Any]  # one value for each variable of a group, in the type in which they are exchanged
Function = Callable[[int, Array], Array]  # of a tick and the values
Linear = Literal["add", "multiply"]
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
    """Hold given values, or those of the last transfer before the window; without one, those of the first.

    The memory does not move, as the tick in C shares it: `values`, and `history`, which is 0 while nothing is held, 1
    afterwards, and 2 for given values.
    """

    def __init__(self, begin: int, value: GroupValues | None = None) -> None:
        self._begin, self._given = begin, value is not None
        self.values = value
        self.history = np.array([2 * self._given], np.int64)

    def prepare(self, like: GroupValues) -> GroupValues:
        """Return the memory, for values of this type and number."""
        if self.values is None or self.values.dtype != like.dtype:
            self.values = np.zeros_like(like) if self.values is None else self.values.astype(like.dtype)
        return self.values

    def observe(self, tick: int, values: GroupValues) -> None:
        """Keep the last values before the window."""
        if not self._given and (tick < self._begin or not self.history[0]):
            self.prepare(values)[:] = values
            self.history[0] = 1

    def act(self, _tick: int, values: GroupValues) -> GroupValues:
        """Return the held values."""
        return self.prepare(values).copy() if self.history[0] else values

    def saved(self) -> Any:
        """Return the held values."""
        return _packed(self.values) if self.history[0] and self.values is not None else None

    def restore(self, saved: Any) -> None:
        """Restore the held values."""
        if saved is None:
            self.history[0] = 0
            return
        values = _unpacked(saved)
        self.prepare(values)[:] = values
        self.history[0] = 1 + self._given


_FIRST, _COUNT, _CAPACITY, _DELAY, _TICKS = range(5)  # of the history of a delay: the last is where ticks begin


class Delay:
    """Return the values transferred at least some ticks earlier; before that, those of the first transfer.

    `values` (n, k) is a ring of transfers, and `history` says which of them there are and of which ticks they are. The
    tick in C shares both, and they do not move once they are large enough.
    """

    def __init__(self, ticks: int) -> None:
        self.ticks = ticks
        self.values: GroupValues | None = None
        self.history = np.zeros(_TICKS, np.int64)

    def prepare(self, like: GroupValues, room: int) -> GroupValues:
        """Return the memory, for values of this type and number, with room for so many transfers at least."""
        if self.values is None or len(self.values) < room:
            entries = self._entries()
            self.values = np.zeros((room, len(like)), like.dtype)
            self.history = np.zeros(_TICKS + room, np.int64)
            self.history[_CAPACITY], self.history[_DELAY] = room, self.ticks
            for tick, values in entries:
                self._append(tick, values)
        return self.values

    def _entries(self) -> list[tuple[int, GroupValues]]:
        """Return the transfers, the oldest first."""
        if self.values is None:
            return []
        first, count, room = self.history[:_DELAY].tolist()
        places = [(first + k) % room for k in range(count)]
        return [(int(self.history[_TICKS + place]), self.values[place].copy()) for place in places]

    def _append(self, tick: int, values: GroupValues) -> None:
        assert self.values is not None
        history = self.history
        place = int((history[_FIRST] + history[_COUNT]) % history[_CAPACITY])
        self.values[place], history[_TICKS + place] = values, tick
        history[_COUNT] += 1

    def observe(self, tick: int, values: GroupValues) -> None:
        """Keep the history that can still be needed."""
        if self.values is None or self.history[_COUNT] == len(self.values):
            self.prepare(values, 2 * int(self.history[_COUNT]) + 8)
        self._append(tick, values)
        history = self.history
        first, count, room = history[:_DELAY].tolist()
        while count > 1 and history[_TICKS + (first + 1) % room] <= tick - self.ticks:
            first, count = (first + 1) % room, count - 1
        history[_FIRST], history[_COUNT] = first, count

    def act(self, _tick: int, _values: GroupValues) -> GroupValues:
        """Return the oldest values kept."""
        assert self.values is not None
        oldest: GroupValues = self.values[self.history[_FIRST]].copy()
        return oldest

    def saved(self) -> Any:
        """Return the history."""
        return [[tick, _packed(values)] for tick, values in self._entries()]

    def restore(self, saved: Any) -> None:
        """Restore the history."""
        self.history[: _COUNT + 1] = 0
        for tick, packed in saved:
            values = _unpacked(packed)
            if self.values is None or self.history[_COUNT] == len(self.values):
                self.prepare(values, 2 * int(self.history[_COUNT]) + 8)
            self._append(tick, values)


class Change:
    """Apply a function of time and values; whole numbers are rounded to the nearest in the range of their type.

    `linear` is what it does to Reals, if it adds or multiplies: `add` or `multiply`, and the amounts.
    """

    def __init__(
        self, function: Function, limits: Limits | None = None, linear: tuple[Linear, Array] | None = None
    ) -> None:
        self._function, self.linear = function, linear
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
