"""Figures from the literature, each with its paper; shown beside results, never used to make them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["PUBLISHED", "Published", "papers_of", "published"]


@dataclass(frozen=True, kw_only=True)
class Published:
    """A number as published.

    Attributes
    ----------
    quantity : str
        What it is, by its name in datasets.
    papers : tuple of str
        Who gave it, by the keys of `validation.report.papers.PAPERS`.
    words : str
        Who, and how it was found, in a few words.
    hurst : (float, float)
        Range of Hurst exponents.
    low, high : float
        The same for a single number.
    """

    quantity: str
    papers: tuple[str, ...]
    words: str
    hurst: tuple[float, float]
    low: float
    high: float


PUBLISHED = (
    Published(
        quantity="kappa",
        papers=("hyun2004", "campana2007", "prodanov2014", "yastrebov2015", "monti2021"),
        words="resolved surfaces, five groups 2004-2021",
        hurst=(0.3, 0.9),
        low=2.0,
        high=2.2,
    ),
    Published(
        quantity="kappa",
        papers=("hyun2004", "persson2006"),
        words="Hyun 2004 as read by Persson 2006: roughness to the grid scale",
        hurst=(0.8, 0.8),
        low=1.8,
        high=1.8,
    ),
    # alpha of A = alpha F over that of the theory, as Persson (2006, Sec. 3.5) quotes it for D_f = 2.2.
    Published(
        quantity="kappa_ratio",
        papers=("yang2006", "persson2006"),
        words="Yang 2006, molecular dynamics",
        hurst=(0.8, 0.8),
        low=1.14,
        high=1.14,
    ),
    Published(
        quantity="kappa_ratio",
        papers=("hyun2004", "persson2006"),
        words="Hyun 2004, finite elements",
        hurst=(0.8, 0.8),
        low=1.13,
        high=1.13,
    ),
    Published(
        quantity="kappa_ratio",
        papers=("borri2006", "persson2006"),
        words="Borri-Brunetto 2006, discretised continuum",
        hurst=(0.8, 0.8),
        low=0.8,
        high=0.8,
    ),
)


def published(quantity: str) -> xr.Dataset:
    """Return what was published of a quantity, over the papers and the ends of their range of Hurst exponents.

    ``<quantity>_published`` is the lowest value, ``_published_high`` the highest.

    Examples
    --------
    >>> published("kappa").kappa_published_high.values.tolist()
    [[2.2, 2.2], [1.8, 1.8]]
    """
    import xarray as xr

    of = [one for one in PUBLISHED if one.quantity == quantity]
    dims = (f"paper_{quantity}", "end")
    return xr.Dataset(
        {
            f"{quantity}_published": (dims, [[one.low] * 2 for one in of]),
            f"{quantity}_published_high": (dims, [[one.high] * 2 for one in of]),
            "hurst_published": (dims, [one.hurst for one in of]),
        },
        coords={dims[0]: [one.words for one in of]},
    )


def papers_of(*quantities: str) -> str:
    """Return the keys of their papers, for the attribute ``methods`` of a dataset."""
    keys = (key for one in PUBLISHED if one.quantity in quantities for key in one.papers)
    return " ".join(dict.fromkeys(keys))
