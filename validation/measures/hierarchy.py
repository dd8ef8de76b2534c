"""Bumps on bumps: a hierarchy of waves in both directions, pressed along a path of loads, beside Archard's spheres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField
from persson.archard import archard_hierarchy
from validation.arrays import Array
from validation.measures.common import BASE_SOLID
from validation.measures.flow import located_area
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Hierarchy"]

#: Amplitude of the largest wave over the period: it scales out.
_SLOPE = 0.01


@dataclass(frozen=True, kw_only=True)
class Hierarchy(NumbersSolve):
    """One hierarchy on one grid along a path of loads.

    Attributes
    ----------
    waves : tuple of int
        Waves of each level on a period, from 1.
    heights : tuple of float
        Of each level, over that of the first.
    places : tuple of (float, float)
        By how much of a period each level is moved.
    loads : tuple of float
        p0 / (E* H_0 / L), rising.
    points : int
        Along a side.
    """

    waves: tuple[int, ...]
    heights: tuple[float, ...]
    places: tuple[tuple[float, float], ...]
    loads: tuple[float, ...]
    points: int

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {
            "waves": list(self.waves),
            "heights": list(self.heights),
            "places": [list(place) for place in self.places],
            "loads": list(self.loads),
            "points": self.points,
            "edges": LOCATED_EDGES,
            "version": 2,
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"archard-{len(self.waves)}-{self.points}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{len(self.waves)} levels of bumps, {self.points}x{self.points}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost from the number of points."""
        n = self.points**2
        return Prediction(seconds=len(self.loads) * (2e-3 + 8e-7 * n), peak_bytes=120 * n, unknowns=n)

    def field(self) -> HeightField:
        r"""Heights on a period of 1: sum over the levels of H_k / 2 [cos(2 pi n_k x) + cos(2 pi n_k y)]."""
        x = np.arange(self.points) / self.points
        total = np.zeros((self.points, self.points))
        for count, height, (along, across) in zip(self.waves, self.heights, self.places, strict=True):
            first, second = (np.cos(2 * np.pi * count * (x + place)) for place in (along, across))
            total += _SLOPE * height / 2 * (first[:, None] + second[None, :])
        return HeightField(heights=total, lengths=(1.0, 1.0))

    @property
    def radii(self) -> list[float]:
        """Radius of curvature of the tops of each level, on a period of 1: 1 / (2 pi^2 n_k^2 H_k)."""
        return [
            1 / (2 * math.pi**2 * count**2 * _SLOPE * height)
            for count, height in zip(self.waves, self.heights, strict=True)
        ]

    def measure(self) -> xr.Dataset:
        """Press along the path of loads, each from the one before; located A/A0, NaN where too few points touch."""
        import xarray as xr

        from fem_contact import bem

        field, start, areas = self.field(), None, []
        half_space = HalfSpace(solid=BASE_SOLID.elastic)
        for load in self.loads:
            pressure = load * _SLOPE * half_space.contact_modulus
            solved = bem.solve(field, half_space, mean_pressure=pressure, start=start, threads=1).checked()
            start = solved.pressure
            few = np.count_nonzero(solved.in_contact) < LEAST_CONTACT_POINTS
            areas.append(np.nan if few else located_area(solved))
        return xr.Dataset({"area_each": ("load", areas)})

    def theory(self) -> tuple[Array, float]:
        """A/A0 of Archard's spheres with these radii and densities, and the power of the load."""
        densities = [float(count**2) for count in self.waves[1:]]
        found = archard_hierarchy(
            np.array(self.loads) * _SLOPE, radii=self.radii, densities=densities, contact_modulus=1.0
        )
        return np.asarray(found.area), found.exponent
