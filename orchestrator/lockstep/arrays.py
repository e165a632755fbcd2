"""Types of arrays, by what they hold; docstrings and comments give the shapes and units."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def refill(array: NDArray[Any], saved: NDArray[Any]) -> None:
    """Fill an array with a saved one; raise ValueError for another shape, which numpy might repeat to fit."""
    if saved.shape != array.shape:
        raise ValueError(f"an array is of shape {saved.shape} instead of {array.shape}")
    array[...] = saved
