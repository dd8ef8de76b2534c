"""Gauss's rule, on one interval and on panels."""

import numpy as np

from persson._checks import Array


def gauss(order: int) -> tuple[Array, Array]:
    """Return points in (0, 1) and weights of sum 1."""
    points, weights = np.polynomial.legendre.leggauss(order)
    return (1 + points) / 2, weights / 2


def panels(edges: Array, order: int) -> tuple[Array, Array]:
    """Return points and weights between edges."""
    (points, weights), width = gauss(order), np.diff(edges)[:, None]
    return (edges[:-1, None] + width * points).ravel(), (width * weights).ravel()
