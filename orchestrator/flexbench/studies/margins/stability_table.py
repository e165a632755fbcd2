"""Stability over mode count and gain: which part of the structure a design was not made for, and how near it comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import log10
from typing import Any

from lockstep.errors import InputError

from .designed_loop import DesignedLoop
from .real_plant import MODE_COUNTS, Corner, Plants, Stability, stability

GAINS = (-12.0, -6.0, -3.0, 0.0, 3.0, 6.0, 12.0)  # dB, on all inputs of the plant together
LARGEST_DECIBELS = 100.0
STABLE = "stable"


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """Mode counts and gains at which stability is determined."""

    modes: tuple[int, ...] | None = None  # None for MODE_COUNTS, and all that the plant has
    gains: tuple[float, ...] = GAINS  # dB

    def __post_init__(self) -> None:
        for gain in self.gains:
            if not abs(gain) <= LARGEST_DECIBELS:
                raise InputError(f"--gains {gain:g}: must be from -{LARGEST_DECIBELS:g} to {LARGEST_DECIBELS:g} dB")

    def counts(self, most: int) -> tuple[int, ...]:
        """Return the mode counts on a plant with so many modes.

        Raises
        ------
        InputError
            For more than there are.
        """
        if self.modes is None:
            return tuple(sorted({count for count in MODE_COUNTS if count < most} | {most}))
        for count in self.modes:
            if not 1 <= count <= most:
                raise InputError(f"--modes {count}: must be from 1 to {most}, what the structure has")
        return self.modes


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
