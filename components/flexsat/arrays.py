"""Types of arrays, by what they hold; docstrings and comments give the shapes and units."""

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]
Flags = NDArray[np.bool_]


def make_read_only(prepared: Any) -> None:
    """Replace each array of a frozen dataclass by a read-only view of it; called from `__post_init__`."""
    for item in fields(prepared):
        value = getattr(prepared, item.name)
        if isinstance(value, np.ndarray):
            view = value.view()
            view.flags.writeable = False
            object.__setattr__(prepared, item.name, view)
