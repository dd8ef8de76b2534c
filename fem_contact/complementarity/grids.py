"""The grids of a nested solve: where their arrays are, and how fields are carried between them."""

from dataclasses import replace
from typing import Any

import numpy as np
import scipy.fft

from fem_contact._types import Lengths, Shape
from fem_contact.complementarity.fourier import carried, doubled, refined_along
from fem_contact.complementarity.free import operator_of
from fem_contact.complementarity.operator import Solution
from fem_contact.contact import residual_sums
from fem_contact.response import Response


class Grids:
    """Grids whose arrays are NumPy's, each as a whole; `shape` is that of the finest."""

    xp: Any = np  # Namespace of the arrays; its sums, means and extremes are those of the whole grid
    in_slabs = False  # Whether this process has but some rows of the finest grid

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
        names = ("force", "displacement", "in_contact", "at_bound")
        fields: dict[str, Any] = {name: self.fetched_field(getattr(solution, name)) for name in names}
        return replace(solution, **fields)

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
        rows, columns = carried(old[0], new[0]), (min(old[1], new[1]) - 1) // 2 + 1
        # Columns that the coarse grid does not carry are left out before the second transform.
        along = scipy.fft.rfft(heights, axis=1, norm="forward", workers=self.threads)[:, :columns]
        spectrum = scipy.fft.fft(along, axis=0, norm="forward", workers=self.threads)
        coarse = np.zeros((new[0], new[1] // 2 + 1), dtype=complex)
        coarse[rows % new[0], :columns] = spectrum[rows]
        return np.ascontiguousarray(scipy.fft.irfft2(coarse, s=new, norm="forward", workers=self.threads))

    def refined(self, field: Any, old: Shape, new: Shape) -> Any:
        """Carry a field to a finer grid, bilinearly: positive fields stay so."""
        if new == (2 * old[0], 2 * old[1]):
            return doubled(field)
        for axis in (0, 1):
            field = refined_along(field, axis, np.arange(new[axis]) * (old[axis] / new[axis]))
        return np.ascontiguousarray(field)

    def nearest(self, field: Any, new: Shape) -> Any:
        """Take a field of the finest grid at the points of a coarser one nearest below."""
        rows, columns = (np.arange(n) * old // n for old, n in zip(field.shape, new, strict=True))
        return np.ascontiguousarray(field[np.ix_(rows, columns)])
