"""Types of arrays, by what they hold; docstrings and comments give the shapes and units."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]
