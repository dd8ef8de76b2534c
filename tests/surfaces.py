"""Surfaces that the tests of solvers share, and the lattice sum behind Hertz's contact on a period."""

from __future__ import annotations

import numpy as np

from fem_contact.surface import HeightField, random_surface

__all__ = ["LATTICE_CUBE", "rough_surface"]

#: Sum of |n|^-3 over the points of the square lattice but the origin: what the images of a load do to
#: the curvature below it.
LATTICE_CUBE = 9.03362168


def rough_surface(
    shape: tuple[int, int],
    lengths: tuple[float, float] = (1.0, 1.0),
    *,
    seed: int,
    waves: float,
    longest: float = 0.0,
    gradient: float = 0.1,
) -> HeightField:
    """Heights of H = 0.8 with waves of 1/`longest` to 1/`waves` of the longer side, and that rms gradient."""
    unit = 2 * np.pi / max(lengths)
    surface = random_surface(
        lambda q: np.where(q >= longest * unit * (1 - 1e-9), (q / unit) ** -3.6, 0.0),
        q_short=waves * unit,
        lengths=lengths,
        shape=shape,
        seed=seed,
    )
    return HeightField(heights=surface.heights * (gradient / surface.rms_gradient), lengths=lengths)
