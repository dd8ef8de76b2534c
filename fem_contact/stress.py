"""What is read off a result: P(sigma) and its start at zero, gap distribution, energy and stiffness."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fem_contact._checks import array, doubles, listed, non_negative, pair, whole
from fem_contact._types import Array
from fem_contact.contact import ContactResult, check_result, weights_of
from fem_contact.errors import InvalidInput
from fem_contact.patches import find_patches
from fem_contact.surface import HeightField, Patch


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
    check_result("result", result)
    edges = _checked_edges(edges, "pressures in Pa")
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
    spacing : float
        Geometric mean of dx and dy [m].
    """

    density: float
    reduced: float
    threshold: float
    points: int
    spacing: float


#: Window of `density_at_zero` in units of E* h'_rms, at one point per length l.
_WINDOW = 0.2


def _surface_of(result: ContactResult) -> HeightField:
    kind = HeightField if result.periodic else Patch
    return kind(heights=result.heights, lengths=result.lengths)


def density_at_zero(result: ContactResult) -> DensityAtZero:
    r"""Density of contact pressure at vanishing pressure, seen through a window that closes with the grid.

    .. math:: P(0^+) \approx \frac1\epsilon \int_0^\epsilon P\,d\sigma,\qquad
              \epsilon = 0.2\, E^* h' \sqrt{\Delta x / \ell},\quad \ell = 2\pi\sqrt{m_2/m_4}

    A window of fixed width would tend to the slope times half its width, never to zero; near an edge the
    pressure grows like the square root of the distance, so a window that shrinks like sqrt(dx) sees a fixed
    fraction of a cell.

    Parameters
    ----------
    result : ContactResult
        Of a rough surface.

    Raises
    ------
    InvalidInput
        For a flat surface, which has no such pressure scale.
    """
    check_result("result", result)
    _, m2, m4 = _surface_of(result).moments
    if not (m2 > 0 and m4 > 0):
        raise InvalidInput("a flat or unbent surface has no scale of pressure: P(0+) is undefined")
    dx, dy = result.spacing
    stress = result.contact_modulus * np.sqrt(m2)
    threshold = float(_WINDOW * stress * np.sqrt(np.sqrt(dx * dy) * np.sqrt(m4 / m2) / (2 * np.pi)))
    pressure, share = _contact_pressures(result)
    below = pressure < threshold
    density = float(share[below].sum()) / threshold
    return DensityAtZero(
        density=density,
        reduced=float(density * stress),
        threshold=threshold,
        points=int(np.count_nonzero(below)),
        spacing=float(np.sqrt(dx * dy)),
    )


@dataclass(frozen=True, kw_only=True)
class WindowSlope:
    """Mean slope of P(sigma) in a window of small pressures, and the patches it rests on.

    Attributes
    ----------
    slope : float
        Of a line through zero [1/Pa^2]. It is not P'(0+), which was 2 to 3 times as large as that between 0.1
        and 0.4 E* h'_rms at H = 0.8, bandwidth 4 and p* = 0.05: P bends over such a window.
    reduced : float
        slope * (E* h'_rms)^2.
    uncertainty : float
        Standard error of `reduced`, from the counts in the bins.
    patches : int
        Contact patches of the result. Each adds to the slope whatever its size, so a slope is converged only
        where their number is.
    """

    slope: float
    reduced: float
    uncertainty: float
    patches: int


def window_slope(
    result: ContactResult, *, window: tuple[float, float] = (0.1, 0.4), bins: int = 6
) -> WindowSlope:
    """Fit a straight line through zero to P(sigma) between two pressures above the reach of the grid.

    `validation.measurements.edge` has the limit of a closing window and of vanishing spacing, P'(0+).

    Parameters
    ----------
    result : ContactResult
        Of a rough surface.
    window : tuple of float
        Range of the fit in units of E* h'_rms; its lower end should lie above the window of
        `density_at_zero`.
    bins : int
        Bins of the fit.

    Raises
    ------
    InvalidInput
        For a flat surface, or a window that is not increasing.
    """
    check_result("result", result)
    bins = whole("bins", bins, least=1, most=10**6)
    window = pair("window", window, non_negative, what="two increasing pressures in units of E* h'_rms")
    stress = result.contact_modulus * _surface_of(result).rms_gradient
    if not stress > 0:
        raise InvalidInput("a flat surface has no scale of pressure: the slope of P is undefined")
    if not window[0] < window[1]:
        raise InvalidInput(f"window = {window!r}: must be two increasing pressures in units of E* h'_rms")
    edges = stress * np.linspace(window[0], window[1], bins + 1)
    distribution = pressure_distribution(result, edges)
    centres, density = distribution.centres / stress, distribution.density * stress
    # Poisson counts: the variance of a bin goes with its density, which here goes with the pressure.
    slope = float(np.sum(density) / np.sum(centres))
    count = float(np.sum(density)) * (window[1] - window[0]) / bins * result.pressure.size
    return WindowSlope(
        slope=slope / float(stress) ** 2,
        reduced=slope,
        uncertainty=slope / np.sqrt(count) if count > 0 else np.inf,
        patches=find_patches(result.in_contact, result.spacing, periodic=result.periodic).count,
    )


@dataclass(frozen=True, kw_only=True)
class GapDistribution:
    """Histogram of the gap over the points out of contact, per nominal area.

    Attributes
    ----------
    edges : (n + 1,) array
        Bin edges [m].
    density : (n,) array
        Share of the nominal area per gap [1/m]; it integrates to 1 - A/A0 over all gaps.
    mean : float
        Mean gap over the whole area [m].
    """

    edges: Array
    density: Array
    mean: float


def gap_distribution(result: ContactResult, edges: ArrayLike) -> GapDistribution:
    """Distribution of the gap.

    Parameters
    ----------
    result : ContactResult
    edges : (n + 1,) array
        Increasing bin edges [m].

    Raises
    ------
    InvalidInput
        For edges that do not increase.
    """
    check_result("result", result)
    edges = _checked_edges(edges, "lengths in m")
    weights = weights_of(result)
    apart = ~result.in_contact
    counts, _ = np.histogram(result.gap[apart], bins=edges, weights=weights[apart])
    density = counts / (result.gap.size * np.diff(edges))
    return GapDistribution(edges=edges, density=density, mean=result.mean_gap)


def elastic_energy(result: ContactResult) -> float:
    """Elastic energy per nominal area [J/m^2], half the mean of p u.

    On a periodic half-space u has zero mean, so this is the energy of the roughness alone (Persson 2006, Eq.
    43 refers to the same). Under a patch with free sides u has a mean, which counts.
    """
    check_result("result", result)
    return 0.5 * float(np.mean(result.pressure * weights_of(result) * result.displacement))


def loading_work(results: Sequence[ContactResult]) -> Array:
    """Work per nominal area [J/m^2] done by the load along a path, from its first state to the others.

    The work is the integral of p0 over the approach, -offset. Between two states p0 is taken to be
    exponential in the approach, as it nearly is, which makes the logarithmic mean of both loads the mean
    load. Between elastic states the work equals the difference of their energies, with an error of second
    order in the steps.
    """
    load, approach = _loads(results)
    if load.size == 0 or np.any(load <= 0):
        raise InvalidInput(f"{load.size} results: the work needs at least one, each under a positive load")
    growth = np.log(load[1:] / load[:-1])
    # Near equal loads the logarithmic mean is 0 / 0; its series there is the plain mean.
    steady = np.abs(growth) < 1e-6
    exact = np.diff(load) / np.where(steady, 1.0, growth)
    mean = np.where(steady, 0.5 * (load[1:] + load[:-1]), exact)
    return np.append(0.0, np.cumsum(mean * np.diff(approach)))


def contact_stiffness(results: Sequence[ContactResult]) -> Array:
    """Contact stiffness d p0 / d(approach) [Pa/m] at each state of a path, by differences of second order.

    Raises
    ------
    InvalidInput
        For fewer than three states.
    """
    load, approach = _loads(results)
    if load.size < 3:
        raise InvalidInput(f"{load.size} states: the stiffness needs at least three")
    # In ln p0 the approach is nearly straight, so differences are taken there.
    return np.asarray(load / np.gradient(approach, np.log(load)))


def _loads(results: Sequence[ContactResult]) -> tuple[Array, Array]:
    """Mean pressures [Pa] and approaches [m] along a path."""
    listed("results", results, ContactResult, what="`ContactResult`s")
    load, offset = np.array([(result.mean_pressure, result.offset) for result in results]).reshape(-1, 2).T
    return load, -offset


def _contact_pressures(result: ContactResult) -> tuple[Array, Array]:
    """Pressure [Pa] at the contact points, and the share of the nominal area each carries."""
    contact = result.in_contact
    return result.pressure[contact], weights_of(result)[contact] / contact.size


def _checked_edges(edges: ArrayLike, kind: str) -> Array:
    values = array("edges", edges)
    if values.ndim != 1 or values.size < 2 or not np.all(np.diff(values) > 0):
        raise InvalidInput(f"edges: must be at least two increasing {kind}")
    return values


def von_mises(tensor: ArrayLike) -> Array:
    r"""Von Mises stress of stress tensors.

    .. math:: \sigma_v^2 = \tfrac12\bigl[(\sigma_{xx}-\sigma_{yy})^2 + (\sigma_{yy}-\sigma_{zz})^2
              + (\sigma_{zz}-\sigma_{xx})^2\bigr] + 3(\sigma_{yz}^2 + \sigma_{xz}^2 + \sigma_{xy}^2)

    Parameters
    ----------
    tensor : (..., 6) array
        Components xx, yy, zz, yz, xz, xy [Pa].

    Returns
    -------
    (...) array
        [Pa].

    Raises
    ------
    InvalidInput
        For another number of components.

    Examples
    --------
    >>> float(von_mises([-3.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    3.0
    """
    values = doubles("tensor", tensor, unit="Pa")
    if values.ndim == 0 or values.shape[-1] != 6:
        raise InvalidInput(f"tensor of shape {values.shape}: must have 6 components along its last axis")
    xx, yy, zz, yz, xz, xy = np.moveaxis(values, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3 * (yz**2 + xz**2 + xy**2)))
