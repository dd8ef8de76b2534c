"""Bumps on bumps: a hierarchy of waves in both directions, pressed along a path of loads, beside Archard's spheres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from fem_contact.surface import HeightField
from persson.archard import archard_hierarchy
from validation.arrays import Array
from validation.execution.measurement import measurement
from validation.measurements.common import BASE_SOLID
from validation.measurements.flow import located_area
from validation.measurements.measurement import elastic_path

#: Amplitude of the largest wave over the period: it scales out.
_SLOPE = 0.01


@measurement(
    lambda waves, points: f"archard-{len(waves)}-{points}",
    kind="Hierarchy",
    words="bumps on {waves} waves,",
    located=True,
    version=2,
    seconds=lambda points, loads: len(loads) * (2e-3 + 8e-7 * points),
    bytes=120,
)
def press_bumps(
    *,
    waves: tuple[int, ...],
    heights: tuple[float, ...],
    places: tuple[tuple[float, float], ...],
    loads: tuple[float, ...],
    points: int,
) -> xr.Dataset:
    """Press along the path of loads, each from the one before; located A/A0, NaN where too few points touch.

    Each level has so many `waves` on a period, from 1, of `heights` over that of the first, moved by
    `places` of a period; `loads` are rising p0 / (E* H_0 / L).
    """
    solid, areas = BASE_SOLID.elastic, []
    pressures = [load * _SLOPE * solid.contact_modulus for load in loads]
    for solved in elastic_path(bumps(waves, heights, places, points=points), solid, pressures):
        few = np.count_nonzero(solved.in_contact) < LEAST_CONTACT_POINTS
        areas.append(np.nan if few else located_area(solved))
    return xr.Dataset({"area_each": ("load", areas)})


def bumps(
    waves: Sequence[int], heights: Sequence[float], places: Sequence[tuple[float, float]], *, points: int
) -> HeightField:
    r"""Heights on a period of 1: sum over the levels of H_k / 2 [cos(2 pi n_k x) + cos(2 pi n_k y)]."""
    x = np.arange(points) / points
    total = np.zeros((points, points))
    for count, height, (along, across) in zip(waves, heights, places, strict=True):
        first, second = (np.cos(2 * np.pi * count * (x + place)) for place in (along, across))
        total += _SLOPE * height / 2 * (first[:, None] + second[None, :])
    return HeightField(heights=total, lengths=(1.0, 1.0))


def radii_of(waves: Sequence[int], heights: Sequence[float]) -> list[float]:
    """Radius of curvature of the tops of each level, on a period of 1: 1 / (2 pi^2 n_k^2 H_k)."""
    levels = zip(waves, heights, strict=True)
    return [1 / (2 * math.pi**2 * count**2 * _SLOPE * height) for count, height in levels]


def archard_of(
    waves: Sequence[int], heights: Sequence[float], *, loads: Sequence[float]
) -> tuple[Array, float]:
    """A/A0 of Archard's spheres on spheres for these waves, and the exponent of the load.

    Spheres of level k have the curvature of its tops; n_k^2 of them stand on the period, on the first one too.
    """
    spheres = archard_hierarchy(
        np.array(loads) * _SLOPE,
        radii=radii_of(waves, heights),
        densities=[float(count**2) for count in waves[1:]],
        contact_modulus=1.0,
    )
    return spheres.area, spheres.exponent
