"""Reduce histories to what fits a page: every sample, or the minimum and maximum of each interval of rows."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsat.arrays import Array

FLOAT = 4  # bytes
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

    1 means every sample, which takes half the bytes of an interval.
    """
    if changing == 0 or rows * changing * FLOAT <= budget:
        return 1
    intervals = max(LEAST_INTERVALS, budget // (2 * FLOAT * changing))
    return max(2, math.ceil(rows / intervals))


def extremes(values: Array, stride: int) -> NDArray[np.float32]:
    """Return minimum and maximum of each `stride` rows, (intervals, 2), rounded outwards to single precision."""
    starts = np.arange(0, len(values), stride)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    below, above = low.astype(np.float32), high.astype(np.float32)
    below = np.where(below > low, np.nextafter(below, np.float32(-np.inf)), below)
    above = np.where(above < high, np.nextafter(above, np.float32(np.inf)), above)
    return np.column_stack([below, above])


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
    return about | {"kind": "extremes"}, encode(extremes(values, stride))


def histories_within(time: Array, histories: Sequence[History], budget: int) -> Mapping[str, Any]:
    """Return histories of one time base in about `budget` bytes of data, and the names of those left out."""
    changing = [h for h in histories if len(h.values) and h.values.min() != h.values.max()]
    stride = stride_for(len(time), len(changing), budget)
    room = max(1, budget // (2 * FLOAT * math.ceil(len(time) / stride))) if stride > 1 else len(changing)
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
        "left_out": sorted({history.group for history in changing[room:]}),
    }
