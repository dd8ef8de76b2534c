"""Figures from the literature, each with its paper; shown beside results, never used to make them."""

from __future__ import annotations

from typing import NamedTuple

import xarray as xr

from validation.report.estimates import derive, total_error


class Published(NamedTuple):
    """A number as published: for a range of Hurst exponents, who gave it (by `PAPERS`), and by which method.

    `quantity` is its name in datasets; `low` and `high` are the same for a single number.
    """

    quantity: str
    low: float
    high: float
    hurst: tuple[float, float]
    method: str
    papers: tuple[str, ...]


_FIVE = ("hyun2004", "campana2007", "prodanov2014", "yastrebov2015", "monti2021")
_GRID_SCALE = "Hyun 2004 as read by Persson 2006: roughness to the grid scale"
_BORRI = ("borri2006", "persson2006")
_H = (0.8, 0.8)

PUBLISHED = (
    Published("kappa", 2.0, 2.2, (0.3, 0.9), "resolved surfaces, five groups 2004-2021", _FIVE),
    Published("kappa", 1.8, 1.8, _H, _GRID_SCALE, ("hyun2004", "persson2006")),
    # A/A0 = 0.1147 at p* = 0.0542.
    Published("kappa", 2.116, 2.116, _H, "Xu 2024: bandwidth 100, counted on 4 points per wave", ("xu",)),
    # alpha of A = alpha F over that of the theory, as Persson (2006, Sec. 3.5) quotes it for D_f = 2.2.
    Published("kappa_ratio", 1.14, 1.14, _H, "Yang 2006, molecular dynamics", ("yang2006", "persson2006")),
    Published("kappa_ratio", 1.13, 1.13, _H, "Hyun 2004, finite elements", ("hyun2004", "persson2006")),
    Published("kappa_ratio", 0.8, 0.8, _H, "Borri-Brunetto 2006, discretised continuum", _BORRI),
)


def published(quantity: str) -> xr.Dataset:
    """Return what was published of a quantity, over the papers and the ends of their range of Hurst exponents.

    ``<quantity>_published`` is the lowest value, ``_published_high`` the highest.

    >>> published("kappa").kappa_published_high.values.tolist()
    [[2.2, 2.2], [1.8, 1.8], [2.116, 2.116]]
    """
    of = [row for row in PUBLISHED if row.quantity == quantity]
    dims = (f"paper_{quantity}", "end")
    return xr.Dataset(
        {
            f"{quantity}_published": (dims, [[row.low] * 2 for row in of]),
            f"{quantity}_published_high": (dims, [[row.high] * 2 for row in of]),
            "hurst_published": (dims, [row.hurst for row in of]),
        },
        coords={
            dims[0]: [row.method for row in of],
            f"{quantity}_published_range": (
                dims[0],
                [" to ".join(dict.fromkeys((f"{row.low:g}", f"{row.high:g}"))) for row in of],
            ),
        },
    )


def beside_published(data: xr.Dataset) -> xr.Dataset:
    """Add how far kappa is from each published range; NaN where its interval is wider than that range."""
    data = data.merge(published("kappa").isel(end=0, drop=True))
    inside = "minimum(maximum(kappa, kappa_published), kappa_published_high)"
    half, width = total_error(data, "kappa"), data.kappa_published_high - data.kappa_published
    data["kappa_comparable"] = (1.0 + 0.0 * width).where((width == 0) | (half <= width / 2))
    return derive(data, kappa_difference=f"kappa_comparable * (kappa - {inside})")


def ladders_beside_published(climbed: xr.Dataset) -> xr.Dataset:
    """Add alpha(zeta) of A = alpha F over Persson's, on every rung of the bandwidth, and its distance from what was published."""
    climbed = climbed.merge(published("kappa_ratio").kappa_ratio_published.isel(end=0, drop=True))
    return derive(
        climbed,
        kappa_persson_ladder="erf(2**.5 * reduced_pressure_ladder) / reduced_pressure_ladder",
        kappa_ratio_by_bandwidth="kappa_by_bandwidth / kappa_persson_ladder",
        kappa_ratio_difference="kappa_ratio_by_bandwidth.isel(bandwidth_rung=-1) - kappa_ratio_published",
    )


def papers_of(*quantities: str) -> str:
    """Return the keys of their papers, for the attribute ``methods`` of a dataset."""
    keys = (key for row in PUBLISHED if row.quantity in quantities for key in row.papers)
    return " ".join(dict.fromkeys(keys))
