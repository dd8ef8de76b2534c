"""How arrays of numbers, and the points of a grid, are called in signatures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Points along x and y.
Grid = tuple[int, int]
