"""The arrays that all modules speak of."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Complex = NDArray[np.complex128]
Numbers = NDArray[np.int64]
Mask = NDArray[np.bool_]
AnyArray = NDArray[Any]
Shape = tuple[int, int]
Lengths = tuple[float, float]
