"""Trajectories: what the outputs were after each step, and whether two of them have the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.check.dynamic.experiment import Experiment


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """Outputs after each step; rows are steps, columns the outputs of a type in the order of the file."""

    reals: NDArray[np.float64]
    integers: NDArray[np.int64]  # and booleans, by the type in which they travel
    strings: NDArray[np.bytes_]

    def __len__(self) -> int:
        return len(self.reals)

    def __getitem__(self, rows: slice) -> Trajectory:
        return Trajectory(reals=self.reals[rows], integers=self.integers[rows], strings=self.strings[rows])

    def save(self, path: Path) -> None:
        """Write to a file of numpy."""
        with path.open("wb") as stream:
            np.savez(stream, reals=self.reals, integers=self.integers, strings=self.strings)

    @classmethod
    def load(cls, path: Path) -> Trajectory:
        """Read what `save` wrote."""
        with np.load(path, allow_pickle=False) as data:
            return cls(reals=data["reals"], integers=data["integers"], strings=data["strings"])

    @classmethod
    def joined(cls, parts: Sequence[Trajectory]) -> Trajectory:
        """Return one trajectory of several that follow each other; there is at least one."""
        return cls(
            reals=np.concatenate([part.reals for part in parts]),
            integers=np.concatenate([part.integers for part in parts]),
            strings=np.concatenate([part.strings for part in parts]),
        )

    @classmethod
    def of_rows(cls, rows: Sequence[tuple[Any, Any, Any]], experiment: Experiment) -> Trajectory:
        """Stack the rows that an instance returned."""
        reals = len(experiment.of_kind("outputs", "Real"))
        texts = len(experiment.of_kind("outputs", "String"))
        strings = np.array([row[2] for row in rows], dtype=np.bytes_)
        return cls(
            reals=np.array([row[0] for row in rows], np.float64).reshape(len(rows), reals),
            integers=np.array([row[1] for row in rows], np.int64).reshape(
                len(rows), len(experiment.outputs) - reals - texts
            ),
            strings=strings.reshape(len(rows), texts),
        )


def output_names(experiment: Experiment) -> list[str]:
    """Return the names of the outputs in the order of the columns of `unlike`."""
    numbers = [port.name for ports in experiment.by_type("outputs").values() for port in ports]
    return numbers + [port.name for port in experiment.of_kind("outputs", "String")]


def unlike(one: Trajectory, other: Trajectory) -> NDArray[np.bool_]:
    """Return where two trajectories of one length differ in a bit, (steps, outputs). Equal not-a-numbers are equal."""
    bits = [np.ascontiguousarray(t.reals).view(np.uint64) for t in (one, other)]
    return np.hstack([bits[0] != bits[1], one.integers != other.integers, one.strings != other.strings])


def difference(got: Trajectory, expected: Trajectory, experiment: Experiment, first: int = 0) -> str:
    """Describe where a trajectory first differs from another; nothing when they have the same bits.

    `first` is the number of the step that the first rows belong to.
    """
    if len(got) != len(expected):
        return f"{len(got)} steps instead of {len(expected)}"
    where = unlike(got, expected)
    if not where.any():
        return ""
    row, column = (int(i) for i in np.argwhere(where)[0])
    names = output_names(experiment)
    values = [str([*t.reals[row].tolist(), *t.integers[row].tolist(), *t.strings[row].tolist()][column])
              for t in (got, expected)]  # fmt: skip
    others = int(where.any(axis=0).sum()) - 1
    also = f", and {others} other output{'s' * (others > 1)} sooner or later" if others else ""
    return f"{names[column]} is {values[0]} instead of {values[1]} after step {first + row + 1}{also}"


def relative_difference(got: Trajectory, expected: Trajectory) -> float:
    """Return the largest difference of a real output over the largest magnitude that the output has."""
    if not expected.reals.size or len(got) != len(expected):
        return 0.0 if len(got) == len(expected) else np.inf
    same = np.ascontiguousarray(got.reals).view(np.uint64) == np.ascontiguousarray(expected.reals).view(np.uint64)
    with np.errstate(all="ignore"):
        gap = np.where(same, 0.0, np.abs(got.reals - expected.reals)).max(axis=0)
        size = np.nan_to_num(np.abs(expected.reals)).max(axis=0)
        ratios = np.where(gap == 0.0, 0.0, gap / size)
    return float(np.nan_to_num(ratios, nan=np.inf).max())
