"""The rigid profile between its points: its Fourier series and two derivatives, anywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array, Complex
from fem_contact.surface import HeightField
from fem_contact.surface.heights import interpolant


@dataclass(frozen=True, kw_only=True)
class Heights:
    """Heights h, slopes (h_x, h_y) and curvatures (h_xx, h_xy, h_yy) at points, stacked on the last axis."""

    height: Array
    slope: Array
    curvature: Array


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Trigonometric interpolant of a surface, in units of a length."""

    # (m,), (n,): Wavevectors times the length.
    qx: Array
    qy: Array
    coefficients: Complex  # (m, n): Over the length

    @classmethod
    def of(cls, surface: HeightField, *, unit: float) -> Profile:
        """Expand a surface, lengths in units of `unit` [m]."""
        qx, qy, coefficients = interpolant(surface)
        return cls(qx=qx * unit, qy=qy * unit, coefficients=coefficients / unit)

    def at(self, x: Array, y: Array) -> Heights:
        """Evaluate at points of any shape."""
        shape, (x, y) = x.shape, (x.ravel(), y.ravel())
        along_x = np.exp(1j * np.multiply.outer(x, self.qx))
        along_y = np.exp(1j * np.multiply.outer(y, self.qy))
        # Rows of derivatives of order 0, 1, 2 in x; then those in y.
        rows = [(along_x * (1j * self.qx) ** n) @ self.coefficients for n in range(3)]
        columns = [along_y * (1j * self.qy) ** n for n in range(3)]

        def part(n: int, m: int) -> Array:
            return np.asarray(np.einsum("pk,pk->p", rows[n], columns[m]).real.reshape(shape))

        return Heights(
            height=part(0, 0),
            slope=np.stack([part(1, 0), part(0, 1)], axis=-1),
            curvature=np.stack([part(2, 0), part(1, 1), part(0, 2)], axis=-1),
        )
