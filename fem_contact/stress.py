"""Distribution of the contact pressure, P(sigma), and its value at vanishing pressure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.surface import HeightField

__all__ = ["DensityAtZero", "PressureDistribution", "density_at_zero", "pressure_distribution"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PressureDistribution:
    """Histogram of the contact pressure per nominal area.

    Attributes
    ----------
    edges : (n + 1,) array
        Bin edges [Pa].
    density : (n,) array
        P(sigma) [1/Pa]: share of the nominal area per pressure. The non-contact area (a delta at 0) is left
        out, so the integral over all pressures is A/A0 (Persson 2006, Eq. 16).
    area : float
        A/A0, contact points by weight.
    """

    edges: Array
    density: Array
    area: float

    @property
    def centres(self) -> Array:
        """Middle of each bin [Pa]."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    @property
    def per_contact_area(self) -> Array:
        """P(sigma) / (A/A0) [1/Pa], which integrates to 1."""
        return self.density / self.area


def pressure_distribution(result: ContactResult, edges: ArrayLike) -> PressureDistribution:
    """Distribution of pressure over the contact points, per nominal area.

    Parameters
    ----------
    result : ContactResult
    edges : (n + 1,) array
        Increasing bin edges [Pa]; pressures outside them are not counted.

    Raises
    ------
    InvalidInput
        For edges that do not increase.
    """
    edges = np.asarray(edges, dtype=float)
    if edges.ndim != 1 or edges.size < 2 or not np.all(np.diff(edges) > 0):
        raise InvalidInput("edges: must be at least two increasing pressures in Pa")
    pressure, share = _contact_pressures(result)
    counts, _ = np.histogram(pressure, bins=edges, weights=share)
    return PressureDistribution(edges=edges, density=counts / np.diff(edges), area=float(share.sum()))


@dataclass(frozen=True, kw_only=True)
class DensityAtZero:
    """Estimate of P(0+) from the points below a small pressure.

    Attributes
    ----------
    density : float
        P(sigma < threshold) / threshold [1/Pa].
    reduced : float
        density * E* h'_rms, dimensionless.
    threshold : float
        The small pressure [Pa].
    points : int
        Contact points below it.
    """

    density: float
    reduced: float
    threshold: float
    points: int


def density_at_zero(result: ContactResult, *, factor: float = 0.2) -> DensityAtZero:
    r"""Density of contact pressure at vanishing pressure, seen through a window that closes with the grid.

    .. math:: P(0^+) \approx \frac1\epsilon \int_0^\epsilon P\,d\sigma,\qquad
              \epsilon = f\, E^* h' \sqrt{\Delta x / \ell},\quad \ell = 2\pi\sqrt{m_2/m_4}

    A window of fixed width would tend to the slope times half its width, never to zero; near an edge the
    pressure grows like the square root of the distance, so a window that shrinks like sqrt(dx) sees a fixed
    fraction of a cell.

    Parameters
    ----------
    result : ContactResult
        Of a rough surface.
    factor : float
        f, the window in units of E* h'_rms at one point per length l.

    Raises
    ------
    InvalidInput
        For a flat surface, which has no such pressure scale.
    """
    _, m2, m4 = HeightField(heights=result.heights, lengths=result.lengths).moments
    if not m2 > 0:
        raise InvalidInput("a flat surface has no scale of pressure: P(0+) is undefined")
    dx, dy = result.spacing
    stress = result.contact_modulus * np.sqrt(m2)
    threshold = float(factor * stress * np.sqrt(np.sqrt(dx * dy) * np.sqrt(m4 / m2) / (2 * np.pi)))
    pressure, share = _contact_pressures(result)
    below = pressure < threshold
    density = float(share[below].sum()) / threshold
    return DensityAtZero(
        density=density,
        reduced=float(density * stress),
        threshold=threshold,
        points=int(np.count_nonzero(below)),
    )


def _contact_pressures(result: ContactResult) -> tuple[Array, Array]:
    """Pressure [Pa] at the contact points, and the share of the nominal area each carries."""
    contact = result.in_contact
    pressure = result.pressure[contact]
    if result.weights is None:
        return pressure, np.full(pressure.shape, 1 / contact.size)
    return pressure, result.weights[contact] / contact.size
