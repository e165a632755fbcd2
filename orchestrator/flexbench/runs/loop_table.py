"""Print and store the numbers of a loop: the table at the end of a run, and its part of metrics.json."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from flexsat.parameters import ARCSECOND

from .loop_numbers import QUANTITIES, LoopNumbers


def header(numbers: LoopNumbers) -> tuple[str, ...]:
    """Return the columns of `rows`: RMS and peak of each window."""
    return ("", "unit", *(f"{one.window.name}: {kind}" for one in numbers.windows for kind in ("RMS", "peak")))


def rows(numbers: LoopNumbers) -> list[tuple[str, ...]]:
    """Return a row for each quantity that was recorded, in the units that are printed."""
    found = []
    for quantity in QUANTITIES:
        cells = [
            f"{values[quantity.key] / quantity.scale:.3g}"
            for one in numbers.windows
            for values in (one.rms, one.peak)
            if quantity.key in values
        ]
        if cells:
            found.append((quantity.label, quantity.unit, *cells))
    return found


def notes(numbers: LoopNumbers) -> Iterator[str]:
    """Yield the times of the windows, and when the run settled."""
    if numbers.windows:
        windows = "; ".join(one.window.text for one in numbers.windows)
        yield f"{windows}. Errors refer to {numbers.reference}."
    last = numbers.slews[-1] if numbers.slews else None
    if last is not None and last.end is None:
        yield f"The slew that begins at {last.start:.4g} s goes on when the run ends: no settling time."
    for one in numbers.settlings:
        band = f"{one.band / ARCSECOND:g} arcsec"
        if one.time is None:
            yield f"Not settled: the pointing error is not within {band} to the end of the run after {one.after}."
        elif one.time == 0.0:
            yield (
                f"Settled from {one.after} at {one.since:.4g} s on: the pointing error stays within {band} to the end"
                " of the run."
            )
        else:
            yield (
                f"Settled {one.time:.4g} s after {one.after} at {one.since:.4g} s: the pointing error stays within"
                f" {band} from {one.since + one.time:.4g} s to the end."
            )


def as_json(numbers: LoopNumbers) -> dict[str, Any]:
    """Return the numbers as tables, in SI."""
    return {
        "reference": numbers.reference,
        "slews": [{"start": slew.start, "end": slew.end} for slew in numbers.slews],
        "settling": [
            {"after": one.after, "since": one.since, "band": one.band, "time": one.time} for one in numbers.settlings
        ],
        "windows": [
            {
                "name": one.window.name,
                "spans": [list(span) for span in one.window.spans],
                "rms": dict(one.rms),
                "peak": dict(one.peak),
            }
            for one in numbers.windows
        ],
    }
