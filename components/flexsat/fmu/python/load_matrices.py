"""Read the matrices that travel with a component: one `.npz` with a set for each variant."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import IO, TypeVar

import numpy as np

from ...variants import CORRECTED, Variant

T = TypeVar("T")

MODEL_FILE = "model.npz"
COST = "cost"  # in the names of arrays that no component reads: what a run of the controller is evaluated with


def load_matrices(path: Path | IO[bytes], kind: type[T], variant: Variant = CORRECTED) -> T:
    """Return a frozen set of matrices from a file or its content; scalars are Python numbers.

    Raises
    ------
    ValueError
        If the file lacks one of them, or was built for a spacecraft without a published release.
    """
    with np.load(path) as archive:
        values = {}
        for item in fields(kind):  # type: ignore[arg-type]  # every set is a dataclass
            name = f"{variant.name}.{item.name}"
            if name not in archive:
                raise ValueError(variant.lacking(name, MODEL_FILE))
            array = archive[name]
            values[item.name] = array.item() if array.ndim == 0 else array
    return kind(**values)
