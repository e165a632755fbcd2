"""Prepare the data of a campaign's page: each column as 16 bits between its extremes, which no plot resolves finer."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexbench.campaign.samples import Band
from flexbench.campaign.statistics.describe import distribution_band
from flexbench.campaign.statistics.evaluation import Evaluation
from flexbench.campaign.statistics.tables import finite
from flexsat.arrays import Array

STEPS = 65534  # of a quantised column
LOST = 65535  # stands for a run without a value
MOST_BYTES = 9_000_000  # of all data on the page, as base64
MOST_CATEGORIES = 30  # of an input of texts: more leave no room between them
_SPREAD = 0.3  # of a category around its place, so that runs of one do not lie on one line
_GOLDEN = 0.6180339887498949
_BAND_SHARE = 0.4  # of those bytes, for bands
MOST_RUNS = 50_000  # of a system in plots
_MOST_TIMES = 1200  # of a band: more than a plot has pixels

Element = Callable[[str], str]  # stores a data element, and returns its id


def quantised(values: Array) -> tuple[NDArray[np.uint16], float, float]:
    """Return values as 16 bits between two bounds; those that are not finite as LOST."""
    good = np.isfinite(values)
    low, high = (float(values[good].min()), float(values[good].max())) if good.any() else (0.0, 0.0)
    scaled = np.zeros(len(values))
    if high > low:
        scaled[good] = np.rint((values[good] - low) / (high - low) * STEPS)
    return np.where(good, scaled, LOST).astype("<u2"), low, high


def encoded(values: NDArray[Any]) -> str:
    """Return the bytes of an array as base64."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def systems_data(found: Sequence[Evaluation], inputs: int | None, element: Element) -> list[dict[str, Any]]:
    """Return the columns of each system for the script.

    Parameters
    ----------
    found : evaluation of each system
    inputs : so many input columns of each system, those first that metrics depend on; None for all
    element : stores a data element
    """
    return [_system_data(one, inputs, element) for one in found]


def inputs_that_fit(found: Sequence[Evaluation]) -> int | None:
    """Return how many inputs of each system fit the page; None if all do."""
    room = int(MOST_BYTES * (1.0 - _BAND_SHARE))
    runs = sum(len(plotted_runs(one)) for one in found)
    columns = int(room / (runs * 2 * 4.0 / 3.0)) - max(len(one.metrics) for one in found) - 2  # numbers: four bytes
    most = max(len(shown_inputs(one, None)) for one in found)
    return None if columns >= most else max(0, columns)


def shown_inputs(one: Evaluation, most: int | None) -> list[str]:
    """Return the inputs that a page shows: numbers, those first that a metric depends on most, then texts."""
    strength: dict[str, float] = dict.fromkeys(one.sample.inputs, 0.0)
    for correlations in one.correlations:
        for each in correlations:
            strength[each.input] = max(strength[each.input], abs(each.value))
    texts = [name for name, values in one.sample.choices.items() if len(set(values)) <= MOST_CATEGORIES]
    return [*sorted(strength, key=lambda name: -strength[name]), *texts][:most]


def plotted_runs(one: Evaluation) -> NDArray[np.intp]:
    """Return the runs that plots show: all; of more than MOST_RUNS, evenly spaced ones and the ends of each metric."""
    count = len(one.sample)
    if count <= MOST_RUNS:
        return np.arange(count)
    spaced = np.linspace(0, count - 1, MOST_RUNS, dtype=np.intp)
    finite = [np.flatnonzero(np.isfinite(values)) for values in one.sample.metrics.values()]
    ends = [good[[np.argmin(values[good]), np.argmax(values[good])]]
            for good, values in zip(finite, one.sample.metrics.values(), strict=True) if len(good)]  # fmt: skip
    return np.unique(np.concatenate([spaced, *ends]))


def _system_data(one: Evaluation, inputs: int | None, element: Element) -> dict[str, Any]:
    sample, shown = one.sample, plotted_runs(one)
    columns = []
    for metric, about in zip(one.metrics, one.descriptions, strict=True):
        limits = [
            {"name": each.requirement.name, "most": _scaled(each.requirement.most, metric.scale),
             "least": _scaled(each.requirement.least, metric.scale)}
            for each in one.judgements
            if each.requirement.metric == metric.name
        ]  # fmt: skip
        percentiles = [
            {"share": p.share, "value": finite(p.value / metric.scale), "low": finite(p.low / metric.scale),
             "high": finite(p.high / metric.scale)}
            for p in about.percentiles
        ]  # fmt: skip
        extra = {"worse": metric.worse, "limits": limits, "percentiles": percentiles}
        columns.append(
            _column(
                metric.name, "metric", metric.shown_unit, sample.metrics[metric.name][shown] / metric.scale, element
            )
            | extra
        )
    for name in shown_inputs(one, inputs):
        if name in sample.choices:
            columns.append(_categories(name, [sample.choices[name][i] for i in shown], element))
        else:
            columns.append(_column(name, "input", sample.units.get(name, ""), sample.inputs[name][shown], element))
    return {
        "name": sample.system,
        "runs": len(shown),
        "numbers": element(encoded(sample.numbers[shown].astype("<i4"))),
        "band": distribution_band(len(sample)),
        "columns": columns,
    }


def _scaled(limit: float | None, scale: float) -> float | None:
    return None if limit is None else limit / scale


def _column(name: str, kind: str, unit: str, values: Array, element: Element) -> dict[str, Any]:
    codes, low, high = quantised(values)
    return {"name": name, "kind": kind, "unit": unit, "low": low, "high": high, "id": element(encoded(codes)),
            "positive": bool(np.all(values[np.isfinite(values)] > 0.0))}  # fmt: skip


def _categories(name: str, texts: Sequence[str], element: Element) -> dict[str, Any]:
    """Return a column of texts: category k lies between k - 0.5 and k + 0.5."""
    categories = sorted(set(texts))
    places = {text: k for k, text in enumerate(categories)}
    spread = _SPREAD * (2.0 * np.modf(_GOLDEN * np.arange(len(texts)))[0] - 1.0)
    shares = (np.array([places[text] for text in texts]) + spread + 0.5) / len(categories)
    codes = np.rint(shares * STEPS).astype("<u2")
    return {"name": name, "kind": "input", "unit": "", "low": -0.5, "high": len(categories) - 0.5,
            "id": element(encoded(codes)), "positive": False, "categories": categories}  # fmt: skip


def bands_data(bands: Sequence[Band], element: Element) -> tuple[list[dict[str, Any]], list[str]]:
    """Return bands for the script, and the signals that found no room."""
    room = int(MOST_BYTES * _BAND_SHARE)
    shown: list[dict[str, Any]] = []
    left_out: list[str] = []
    for band in bands:
        reduced = _reduced({"time": band.time, **band.levels}, list(band.levels))
        texts = {name: encoded(column.astype("<f4")) for name, column in reduced.items()}
        size = sum(len(text) for text in texts.values())
        if size > room:
            left_out.append(band.signal)
            continue
        room -= size
        shown.append({"signal": band.signal, "system": band.system, "levels": list(band.levels), "runs": band.runs,
                      "data": {name: element(text) for name, text in texts.items()}})  # fmt: skip
    return shown, list(dict.fromkeys(left_out))


def _reduced(columns: dict[str, Array], levels: Sequence[str]) -> dict[str, Array]:
    """Return bands over fewer intervals of time: the lower half by their minimum, the upper half by their maximum."""
    count = len(columns["time"])
    stride = -(-count // _MOST_TIMES)
    if stride == 1:
        return columns
    starts = np.arange(0, count, stride)
    lower = levels[: len(levels) // 2]
    found = {"time": columns["time"][starts]}
    for name in levels:
        found[name] = (np.minimum if name in lower else np.maximum).reduceat(columns[name], starts)
    return found
