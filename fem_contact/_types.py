"""The arrays that all modules speak of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Shape = tuple[int, int]
Lengths = tuple[float, float]
