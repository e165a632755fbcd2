"""Reduce histories to what fits a page: every sample, or the minimum and maximum of each interval of rows."""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array

FLOAT = 4  # bytes of a sample, and of the two extremes of an interval
SHARES = 65_535  # of the range of a history, by which extremes are written: 16 bits
SMALLEST = 1e-9  # of the largest value, on a logarithmic axis; less is written as zero
LEAST_INTERVALS = 600  # of a history; those that do not fit with so many are left out
SAME = 1e-6  # relative difference of time steps that still count as uniform


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """One line of a plot."""

    name: str
    group: str  # the array it belongs to, or its own name
    element: str  # index in the array, or nothing
    unit: str
    description: str
    values: Array  # (rows,)
    logarithmic: bool = False  # axis on which it is shown


def stride_for(rows: int, changing: int, budget: int) -> int:
    """Return how many rows share one interval so that `changing` histories fit `budget` bytes.

    1 means every sample, which takes as many bytes as an interval.
    """
    if changing == 0 or rows * changing * FLOAT <= budget:
        return 1
    intervals = max(LEAST_INTERVALS, budget // (FLOAT * changing))
    return max(2, math.ceil(rows / intervals))


@dataclass(frozen=True, slots=True, kw_only=True)
class Extremes:
    """Minimum and maximum of intervals of rows as shares of the range: least + share * step.

    On a logarithmic axis that is the logarithm of a value for share - 1, and share 0 is zero.
    """

    shares: NDArray[np.uint16]  # (intervals, 2)
    least: float
    step: float
    logarithmic: bool

    @property
    def values(self) -> Array:
        """The extremes as the page reads them, (intervals, 2)."""
        shares = self.shares.astype(float)
        if not self.logarithmic:
            return self.least + shares * self.step
        return np.where(shares > 0.0, np.exp(self.least + (shares - 1.0) * self.step), 0.0)


def extremes(values: Array, stride: int, logarithmic: bool = False) -> Extremes:
    """Return minimum and maximum of each `stride` rows, rounded outwards to 16 bits of the range of the history.

    Parameters
    ----------
    values : (rows,), not all equal
    stride : rows of an interval
    logarithmic : of a norm, whose small values count as much as large ones; none is negative
    """
    starts = np.arange(0, len(values), stride)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    first = 0.0
    if logarithmic:
        floor = SMALLEST * float(values.max())
        low, high = (np.where(one >= floor, np.log(np.maximum(one, floor)), -np.inf) for one in (low, high))
        first = 1.0
    finite = np.concatenate([low, high])
    finite = finite[np.isfinite(finite)]
    least, most = float(finite.min()), float(finite.max())
    step = (most - least) / (SHARES - first) or 1.0
    below, above = (first + (one - least) / step for one in (low, high))  # -inf: less than the first share
    rounded = [np.floor(below * (1.0 + 1e-15)), np.ceil(above * (1.0 - 1e-15))]  # whole shares stay whole
    shares = np.clip(np.column_stack(rounded), 0.0, float(SHARES)).astype(np.uint16)
    return Extremes(shares=shares, least=least, step=step, logarithmic=logarithmic)


def encode(values: NDArray[Any]) -> str:
    """Return the bytes of an array, little-endian, as base64."""
    return base64.b64encode(np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"))).tobytes()).decode()


def time_base(time: Array, stride: int) -> dict[str, Any]:
    """Return start times of rows, or of intervals of `stride` rows: by start and step if uniform, else one by one."""
    starts = time[::stride]
    base: dict[str, Any] = {"count": len(starts), "end": float(time[-1]) if len(time) else 0.0, "stride": stride}
    steps = np.diff(time)
    if len(steps) == 0 or np.allclose(steps, steps[0], rtol=SAME, atol=0.0):
        step = float(time[-1] - time[0]) / len(steps) if len(steps) else 0.0
        return base | {"start": float(time[0]) if len(time) else 0.0, "step": step * stride}
    return base | {"times": encode(starts)}


def history_data(history: History, stride: int) -> tuple[dict[str, Any], str]:
    """Return the description of a history for the page, and its data as base64: none if it is constant."""
    values = history.values
    about: dict[str, Any] = {
        "name": history.name,
        "group": history.group,
        "element": history.element,
        "unit": history.unit,
        "description": history.description,
    }
    if history.logarithmic:
        about["logarithmic"] = True
    if len(values) == 0 or values.min() == values.max():
        return about | {"constant": float(values[0]) if len(values) else 0.0}, ""
    if stride == 1:
        return about | {"kind": "samples"}, encode(values.astype(np.float32))
    found = extremes(values, stride, history.logarithmic)
    return about | {"kind": "extremes", "least": found.least, "step": found.step}, encode(found.shares)


def histories_within(time: Array, histories: Sequence[History], budget: int) -> Mapping[str, Any]:
    """Return histories of one time base in about `budget` bytes of data, and the names of those left out."""
    changing = [h for h in histories if len(h.values) and h.values.min() != h.values.max()]
    stride = stride_for(len(time), len(changing), budget)
    room = max(1, budget // (FLOAT * math.ceil(len(time) / stride))) if stride > 1 else len(changing)
    left_out = {id(history) for history in changing[room:]}
    descriptions, data = [], []
    for history in histories:
        if id(history) not in left_out:
            about, text = history_data(history, stride)
            descriptions.append(about)
            data.append(text)
    return {
        "time": time_base(time, stride),
        "histories": descriptions,
        "data": data,
        "left_out": _left_out(changing, room),
    }


def _left_out(changing: Sequence[History], room: int) -> list[str]:
    """Return the groups of histories that have no room, and how many elements of a group have."""
    shown = Counter(history.group for history in changing[:room])
    lacking = Counter(history.group for history in changing[room:])
    return [
        f"{group} (but the first {shown[group]} of {shown[group] + count})" if shown[group] else group
        for group, count in sorted(lacking.items())
    ]
