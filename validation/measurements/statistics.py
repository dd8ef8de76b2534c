"""Numbers with their error: means over surfaces, never over pixels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def pair_means(values: ArrayLike) -> NDArray[np.float64]:
    """Means of the pairs (+h, -h) along the last axis, of shape (..., n/2); ValueError for an odd number.

    The two surfaces of a pair are anti-correlated, so that their mean is one sample, not two.

    >>> pair_means([1.0, 3.0, 2.0, 6.0])
    array([2., 4.])
    """
    array = np.asarray(values, dtype=float)
    if array.shape[-1] % 2:
        raise ValueError(f"{array.shape[-1]} values: pairs need an even number")
    return np.asarray(array.reshape(*array.shape[:-1], -1, 2).mean(axis=-1))


def relative_distance(first: ArrayLike, second: ArrayLike) -> float:
    """Euclidean norm of the difference of two fields over that of the second; NaN where that is 0.

    >>> relative_distance([1.0, 0.0], [0.8, 0.6])
    0.6324555320336759
    """
    size = float(np.linalg.norm(second))
    apart = np.asarray(first, dtype=float) - np.asarray(second, dtype=float)
    return float(np.linalg.norm(apart)) / size if size > 0 else math.nan


def largest_difference(first: ArrayLike, second: ArrayLike) -> float:
    """Largest difference of two fields over the largest size of the second.

    >>> largest_difference([1.0, 0.0], [1.0, -4.0])
    1.0
    """
    return float(np.max(np.abs(np.subtract(first, second))) / np.max(np.abs(second)))


def order_of_convergence(spacing: ArrayLike, error: ArrayLike) -> float:
    """Slope of log |error| against log spacing, by least squares over all grids.

    >>> round(order_of_convergence([0.4, 0.2, 0.1], [0.16, 0.04, 0.01]), 12)
    2.0
    """
    slope, _ = np.polyfit(np.log(spacing), np.log(np.abs(error)), 1)
    return float(slope)
