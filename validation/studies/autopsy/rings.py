"""A surface as a stack of rings of waves: cut at rising magnification, each ring with either sign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, contact_areas
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.scenes import surfaces
from validation.scenes.realised import Realised
from validation.scenes.scene import SelfAffineSurface
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction
from validation.studies.autopsy.books import FLOWS, PROFILES, Pressed

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult
    from fem_contact.surface import RandomWaves

__all__ = ["AREAS", "RingSolve", "areas_of", "book_dataset", "pressed", "ring_ends"]

#: What limits of the area are made of, as `validation.measures.measurement` has them.
AREAS = ("pixel", "perimeter", "edge_fraction", "subcell")

#: Relative slack when a wave stands at the end of a ring.
_EDGE = 1e-9


def areas_of(result: ContactResult) -> tuple[float, ...]:
    """Return the numbers of `AREAS`."""
    areas = contact_areas(result, edge_constant=EDGE_CONSTANTS["bem"], subcell=True)
    assert areas.subcell is not None
    return areas.pixel, areas.perimeter, areas.edge_fraction, areas.subcell


def book_dataset(
    data: Mapping[str, Any],
    *,
    areas: Sequence[Sequence[tuple[float, ...]]],
    sums: Sequence[Mapping[str, Array]],
    bins: Sequence[Mapping[str, Array]],
) -> xr.Dataset:
    """Put together what a chain and a probe leave.

    Parameters
    ----------
    data : mapping
        Variables of their own.
    areas : (levels, 2, 4) sequence
        Numbers of `AREAS` of every state, with the ring and with its negative; first that without.
    sums, bins : sequences
        Of each step, means over both signs.
    """
    import xarray as xr

    table = np.array(areas)
    found = dict(data)
    found |= {name: (("sign", "level"), table[:, :, k].T) for k, name in enumerate(AREAS)}
    found |= {name: ("step", [row[name] for row in sums]) for name in FLOWS}
    found |= {name: (("step", "bin"), np.array([row[name] for row in bins])) for name in PROFILES}
    return xr.Dataset(found)


def pressed(result: ContactResult) -> Pressed:
    """Return pressures and contact of a result."""
    return Pressed(pressure=np.asarray(result.pressure), in_contact=np.asarray(result.in_contact))


def ring_ends(*, periods: float, bandwidth: float, steps_per_octave: int) -> Array:
    """Magnifications at which the rings of a square period end, those without a wave left out.

    Examples
    --------
    >>> ring_ends(periods=1, bandwidth=2.0, steps_per_octave=4).round(3)
    array([1.   , 1.414, 2.   ])
    """
    steps = round(steps_per_octave * float(np.log2(bandwidth)))
    ends = np.geomspace(1.0, bandwidth, steps + 1)
    top = int(np.ceil(bandwidth * periods))
    m, n = np.meshgrid(np.arange(top + 1), np.arange(top + 1))
    waves = np.unique(np.hypot(m, n))[1:] / periods
    counts = np.searchsorted(waves[waves >= 1 - _EDGE], ends * (1 + _EDGE), side="right")
    return np.asarray(ends[np.diff(np.concatenate([[0], counts])) > 0])


@dataclass(frozen=True, kw_only=True)
class RingSolve(NumbersSolve):
    """One surface at one nominal pressure on one square grid, its waves ring by ring.

    Attributes
    ----------
    realised : Realised
        The whole surface, solid and load.
    points : int
        Grid points along each axis.
    tolerance : float
        Of every solve; the area is off by less than that, relative, and every flow is much larger.
    """

    realised: Realised
    points: int
    tolerance: float = 1e-7

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        said = {"points": self.points, "tolerance": self.tolerance, "edges": LOCATED_EDGES}
        return {**self.realised.recipe, **said}

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        own = self.realised
        assert isinstance(own.surface, SelfAffineSurface)
        return (
            f"{self.prefix}, H = {own.surface.hurst:g}, p* = {own.load.values[0]:g}, "
            f"surface {own.realisation + 1}, {self.points}x{self.points}"
        )

    @property
    def solves(self) -> int:
        """How many contact problems it is."""
        raise NotImplementedError

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict seconds, memory and unknowns from the size of the grid."""
        n = self.points**2
        return Prediction(seconds=self.solves * (4e-3 + 7e-7 * n), peak_bytes=250 * n, unknowns=n)

    @property
    def points_per_wave(self) -> float:
        """lambda_short / dx."""
        return self.points * self.shortest / self.realised.lengths[0]

    @property
    def shortest(self) -> float:
        """lambda_short [m] of the waves there are."""
        return self.realised.shortest

    @property
    def half_space(self) -> HalfSpace:
        """The solid."""
        return HalfSpace(solid=self.realised.elastic)

    @cached_property
    def _waves(self) -> tuple[RandomWaves, Array]:
        """All waves of the surface, and q/q_long of each."""
        surface = self.realised.surface
        assert isinstance(surface, SelfAffineSurface)
        waves = surfaces.waves_of(surface, self.realised.realisation)
        lx, ly = waves.lengths
        q = 2 * np.pi * np.hypot(waves.m / lx, waves.n / ly)
        return waves, q * surface.lambda_long / (2 * np.pi)

    def heights(self, above: float, until: float) -> Array:
        """Heights [m] of the waves with above < q/q_long <= until."""
        waves, zeta = self._waves
        keep = (zeta > above * (1 + _EDGE)) & (zeta <= until * (1 + _EDGE))
        ring = replace(
            waves,
            m=waves.m[keep],
            n=waves.n[keep],
            amplitudes=waves.amplitudes[keep],
            q_short=waves.q_short * min(until / float(zeta.max()), 1.0),
        )
        return np.asarray(ring.on((self.points, self.points)).heights)

    def variance(self, heights: Array) -> float:
        """V [Pa^2] of these heights: the variance of the pressure at full contact, E*^2 m2 / 4."""
        field = HeightField(heights=heights, lengths=self.realised.lengths)
        return 0.25 * self.realised.contact_modulus**2 * field.moments[1]

    def press(self, heights: Array, *, load: float, start: Array | None = None) -> ContactResult:
        """Press these heights [m] at a nominal pressure [Pa], from a pressure field that is near."""
        from fem_contact import bem

        solved = bem.solve(
            HeightField(heights=heights, lengths=self.realised.lengths),
            self.half_space,
            mean_pressure=load,
            start=start,
            tolerance=self.tolerance,
            threads=1,
        )
        return solved.checked()
