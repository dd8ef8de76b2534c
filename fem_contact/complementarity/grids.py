"""The grids of a nested solve: where their arrays are, and how fields are carried between them."""

from typing import Any

import numpy as np

from fem_contact._types import Lengths, Shape
from fem_contact.complementarity.fourier import coarsened, nearest, refined
from fem_contact.complementarity.free import operator_of
from fem_contact.complementarity.operator import Solution
from fem_contact.contact import residual_sums
from fem_contact.response import Response


class Grids:
    """Grids whose arrays are NumPy's, each as a whole.

    Parameters
    ----------
    shape : tuple of int
        Points (nx, ny) of the finest grid.

    Attributes
    ----------
    xp
        Namespace of the arrays; its sums, means and extremes are those of the whole grid.
    in_slabs : bool
        Whether this process has but some rows of the finest grid.
    """

    xp: Any = np
    in_slabs = False

    def __init__(self, shape: Shape, *, threads: int) -> None:
        self.shape, self.threads = shape, threads

    def operator_of(self, response: Response, shape: Shape, lengths: Lengths) -> Any:
        """Return the response of a solid on one of the grids."""
        return operator_of(response, shape, lengths, threads=self.threads)

    def put(self, field: Any) -> Any:
        """Return a field of the finest grid where it is computed with; None stays so."""
        return field

    def fetched(self, solution: Solution) -> Solution:
        """Return a solution whose fields are NumPy's."""
        return solution

    def fetched_field(self, field: Any) -> Any:
        """Return one field as NumPy's."""
        return field

    def residual_sums(self, pressure: Any, gap: Any, at_bound: Any) -> list[float]:
        """Return what the residuals are made of; see `fem_contact.contact.residual_sums`."""
        return residual_sums(pressure, gap, at_bound=at_bound)

    def rms_gradient(self, surface: Any, heights: Any) -> float:
        """Return h'_rms of the surface on the finest grid."""
        return float(surface.rms_gradient)

    def coarsened(self, heights: Any, old: Shape, new: Shape) -> Any:
        """Return heights on a coarser grid, freed of the waves that it cannot carry."""
        return coarsened(heights, new, threads=self.threads)

    def refined(self, field: Any, old: Shape, new: Shape) -> Any:
        """Carry a field to a finer grid, bilinearly."""
        return refined(field, new)

    def nearest(self, field: Any, new: Shape) -> Any:
        """Take a field of the finest grid at the points of a coarser one nearest below."""
        return nearest(field, new)
