"""Stability over mode count and gain: which part of the structure a design was not made for, and how near it comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import log10
from typing import Any

from .designed_loop import DesignedLoop
from .real_plant import MODE_COUNTS, Corner, Plants, Stability, stability

GAINS = (-12.0, -6.0, -3.0, 0.0, 3.0, 6.0, 12.0)  # dB, on all inputs of the plant together
STABLE = "stable"


def mode_counts(most: int, wanted: Sequence[int] = MODE_COUNTS) -> tuple[int, ...]:
    """Return the mode counts to try on a plant with at most so many, which are always one of them."""
    return tuple(sorted({count for count in wanted if count < most} | {most}))


def stability_over_modes_and_gain(
    plants: Plants,
    counts: Sequence[int],
    gains: Sequence[float] = GAINS,
    fine: bool = True,
    loop: DesignedLoop | None = None,
) -> list[Stability]:
    """Return the stability for each mode count and each gain [dB]; the other arguments are those of `stability`."""
    return [
        stability(plants, Corner(modes=count, gain=10.0 ** (gain / 20.0)), fine, loop)
        for count in counts
        for gain in gains
    ]


def as_table(found: Sequence[Stability]) -> list[dict[str, Any]]:
    """Return what JSON can hold of each corner."""
    return [
        {**asdict(each.corner), "highest": each.highest, "growth": each.growth, "frequency": each.frequency,
         "stable": each.stable}
        for each in found
    ]  # fmt: skip


def grid_header(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Return the header of the grid: a column for each gain."""
    return ("modes", "to [Hz]", *(f"gain {_decibel(gain):+g} dB" for gain in gains_of(rows)))


def grid_rows(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return a row for each mode count, with the growth rate [1/s] where the loop is unstable."""
    growth = {(row["modes"], row["gain"]): row["growth"] for row in rows}
    highest = {row["modes"]: row["highest"] for row in rows}
    return [
        (
            f"{modes:g}",
            f"{highest[modes]:.1f}",
            *(STABLE if growth[modes, gain] < 0.0 else f"{growth[modes, gain]:+.3g}/s" for gain in gains_of(rows)),
        )
        for modes in sorted(highest)
    ]


def gains_of(rows: Sequence[Mapping[str, Any]]) -> list[float]:
    """Return the gains of a grid, as factors, ascending."""
    return sorted({float(row["gain"]) for row in rows})


def _decibel(factor: float) -> float:
    return round(20.0 * log10(factor), 2) + 0.0  # without a negative zero
