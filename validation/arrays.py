"""How arrays of numbers, and the points of a grid, are called in signatures; rows of any lengths as one."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Points along x and y; lengths, steps or a shift along them.
Grid = tuple[int, int]
Pair = tuple[float, float]


def padded(rows: Iterable[Iterable[float]]) -> Array:
    """Return rows of any lengths, at least one, as an array, NaN where one has no more.

    >>> padded([[1, 2], [3]])
    array([[ 1.,  2.],
           [ 3., nan]])
    """
    rows = list(rows)
    columns = list(itertools.zip_longest(*rows, fillvalue=np.nan))
    return np.array(columns, dtype=float).reshape(-1, len(rows)).T
