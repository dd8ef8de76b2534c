r"""Adhesion as a law of the gap: energy phi(g) and attraction tau = phi'(g), outside a hard wall at g = 0.

Both laws give the same work of adhesion, -phi(0) = w, when two surfaces are pulled apart without deforming.
"""

import math
from dataclasses import dataclass, replace
from typing import Protocol, Self, runtime_checkable

import numpy as np

from fem_contact._checks import array, positive, positive_fields, within
from fem_contact._types import Array


@runtime_checkable
class GapLaw(Protocol):
    """Attraction between two surfaces as a function of their gap g >= 0."""

    @property
    def work(self) -> float:
        """Work of adhesion w [J/m^2]."""

    @property
    def reach(self) -> float:
        """Length over which the attraction acts, w / strength [m]."""

    @property
    def strength(self) -> float:
        """Largest attraction sigma_th [Pa]."""

    @property
    def steepest(self) -> float:
        """Largest fall of the attraction with the gap, max -d tau / d g [Pa/m]."""

    def energy(self, gap: Array) -> Array:
        """Return phi(g) [J/m^2], 0 at infinity."""

    def traction(self, gap: Array) -> Array:
        """Return the attraction tau = d phi / d g [Pa], not negative."""

    def slope(self, gap: Array) -> Array:
        """Return d tau / d g [Pa/m]."""

    def on_grid(self, *, spacing: float, contact_modulus: float) -> Self:
        """Return the law as a grid of that spacing [m] sees it."""


def _gaps(gap: Array) -> Array:
    # The solver hands in arrays of doubles, many times: only what else comes is looked at.
    return gap if type(gap) is np.ndarray and gap.dtype == np.float64 else array("gap", gap)


def _check_grid(spacing: float, contact_modulus: float) -> None:
    positive("spacing", spacing)
    positive("contact_modulus", contact_modulus)


@dataclass(frozen=True, kw_only=True)
class _Law:
    work: float
    reach: float

    def __post_init__(self) -> None:
        positive_fields(self, "work", "reach")

    @property
    def strength(self) -> float:
        """Largest attraction, work over reach [Pa]."""
        return self.work / self.reach


@dataclass(frozen=True, kw_only=True)
class Exponential(_Law):
    r"""The exponential law.

    .. math:: \phi(g) = -w\, e^{-g/\rho}

    Parameters
    ----------
    work : float
        Work of adhesion w [J/m^2], positive.
    reach : float
        Range rho [m], positive.

    Examples
    --------
    >>> law = Exponential(work=0.05, reach=2e-9)
    >>> f"{law.strength:.3g} {law.traction(np.array([2e-9]))[0] / law.strength:.4f}"
    '2.5e+07 0.3679'
    """

    @property
    def steepest(self) -> float:
        """Fall at zero gap, w / rho^2 [Pa/m]."""
        return self.work / self.reach / self.reach

    def energy(self, gap: Array) -> Array:
        """Return -w exp(-g / rho) [J/m^2]."""
        return self._falling(-self.work, gap)

    def traction(self, gap: Array) -> Array:
        """Return (w / rho) exp(-g / rho) [Pa]."""
        return self._falling(self.strength, gap)

    def slope(self, gap: Array) -> Array:
        """Return -(w / rho^2) exp(-g / rho) [Pa/m]."""
        return self._falling(-self.steepest, gap)

    def _falling(self, factor: float, gap: Array) -> Array:
        with np.errstate(over="ignore"):
            return factor * np.exp(-_gaps(gap) / self.reach)

    def on_grid(self, *, spacing: float, contact_modulus: float) -> Self:
        """Return the law itself: it is smooth."""
        _check_grid(spacing, contact_modulus)
        return self


@dataclass(frozen=True, kw_only=True)
class Dugdale(_Law):
    """The Dugdale law: constant attraction w / h0 up to the gap h0, none beyond.

    Parameters
    ----------
    work : float
        Work of adhesion w [J/m^2], positive.
    reach : float
        Range h0 [m], positive.
    ramp : float
        Width, in units of h0, over which the attraction falls linearly to zero, centred on h0; from 0 to 2.
        The work is the same for every width.

    Notes
    -----
    A jump of the attraction cannot be carried by a grid: whatever the spacing, single cells would snap one
    after the other, and the front of a crack would be pinned by the lattice. The solver therefore spreads the
    fall over the least width at which a cell is stiffer than the law is steep; it shrinks with the spacing,
    so the limit over grids is the Dugdale law.
    """

    ramp: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        within("ramp", self.ramp, "[0, 2]")

    @property
    def steepest(self) -> float:
        """Attraction over the width of its fall [Pa/m]; infinite for a jump."""
        return math.inf if self.ramp == 0 else self.strength / (self.ramp * self.reach)

    def _place(self, gap: Array) -> Array:
        """Position within the fall: 0 where it starts, 1 where it ends."""
        start = 1 - self.ramp / 2
        if self.ramp == 0:
            return np.where(gap < self.reach, 0.0, 1.0)
        return np.clip((gap / self.reach - start) / self.ramp, 0.0, 1.0)

    def energy(self, gap: Array) -> Array:
        """Return phi(g) [J/m^2]: -w (1 - g / h0) before the fall, 0 beyond it."""
        gap = _gaps(gap)
        t, start = self._place(gap), 1 - self.ramp / 2
        within = -0.5 * self.ramp * (1 - t) ** 2
        return self.work * (within - np.maximum(start - gap / self.reach, 0.0))

    def traction(self, gap: Array) -> Array:
        """Return the attraction [Pa]."""
        return self.strength * (1 - self._place(_gaps(gap)))

    def slope(self, gap: Array) -> Array:
        """Return d tau / d g [Pa/m]: constant within the fall, 0 elsewhere."""
        gap = _gaps(gap)
        if self.ramp == 0:
            return np.zeros_like(gap)
        t = self._place(gap)
        return np.where((t > 0) & (t < 1), -self.steepest, 0.0)

    def on_grid(self, *, spacing: float, contact_modulus: float) -> Self:
        """Return the law with the least ramp that cells of that spacing [m] carry without snapping singly."""
        _check_grid(spacing, contact_modulus)
        least = self.strength / contact_modulus * (spacing / self.reach) / STEEPNESS
        return replace(self, ramp=min(2.0, max(self.ramp, least)))


#: Steepest law a grid carries, in units of E* / spacing. A single cell of a half-space resists with about
#: 1.2 E* / dx; a front moves smoothly over the lattice when the law stays well below that.
STEEPNESS = 0.25
