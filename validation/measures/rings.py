"""A surface as a stack of rings of waves, each pressed with either sign: a chain of them, or a single one."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, contact_areas
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.measures.budgets import Memory, Pressed, diffused_area, flows, mean_of, profile
from validation.measures.common import reduced_load
from validation.scenes import surfaces
from validation.scenes.realised import Realised
from validation.scenes.scene import SelfAffineSurface
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult
    from fem_contact.surface import RandomWaves

__all__ = ["AREAS", "RING", "Chain", "Probe", "RingSolve", "even_points", "ring_ends"]

#: What limits of the area are made of, as `validation.measures.measurement` has them.
AREAS = ("pixel", "perimeter", "edge_fraction", "subcell")

#: Relative slack when a wave stands at the end of a ring.
_EDGE = 1e-9


def areas_of(result: ContactResult) -> tuple[float, ...]:
    """Return the numbers of `AREAS`."""
    areas = contact_areas(result, edge_constant=EDGE_CONSTANTS["bem"], subcell=True)
    assert areas.subcell is not None
    return areas.pixel, areas.perimeter, areas.edge_fraction, areas.subcell


def _dataset(
    data: Mapping[str, Any],
    *,
    areas: Sequence[Sequence[tuple[float, ...]]],
    sums: Sequence[Mapping[str, Array]],
) -> xr.Dataset:
    """Put together what a chain or a probe leaves.

    Parameters
    ----------
    data : mapping
        Variables of their own.
    areas : (levels, 2, 4) sequence
        Numbers of `AREAS` of every state, with the ring and with its negative; first that without.
    sums : sequence
        Of each step, means over both signs.
    """
    import xarray as xr

    table = np.array(areas)
    made = dict(data) | {name: (("sign", "level"), table[:, :, k].T) for k, name in enumerate(AREAS)}
    for name in sums[0]:
        values = np.array([row[name] for row in sums])
        made[name] = (("step", "bin")[: values.ndim], values)
    return xr.Dataset(made)


def _step(before: Pressed, after: Sequence[Pressed], *, unit: float) -> dict[str, Array]:
    """Return the sums of a step over all points and by pressure, means over both signs."""
    return mean_of([{**flows(before, s, unit=unit), **profile(before, s, unit=unit)} for s in after])


def pressed(result: ContactResult) -> Pressed:
    """Return pressures and contact of a result."""
    return Pressed(pressure=np.asarray(result.pressure), in_contact=np.asarray(result.in_contact))


def even_points(points: float) -> int:
    """Return the smallest even number of points that is at least that."""
    return 2 * int(np.ceil(points / 2 - 1e-9))


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
        return {**self.realised.recipe, **said, "version": 2}

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


@dataclass(frozen=True, kw_only=True)
class Chain(RingSolve):
    """A surface pressed with its waves up to rising magnifications, each ring with both signs.

    Attributes
    ----------
    ends : tuple of float
        Magnifications q/q_long at which the rings end, rising.
    restarts : tuple of float
        Those among them at which absorbing diffusion is started from the truth.
    """

    ends: tuple[float, ...]
    restarts: tuple[float, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {**super().recipe, "ends": list(self.ends), "restarts": list(self.restarts)}

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"rings-{self.points}"

    @property
    def solves(self) -> int:
        """Two for each ring."""
        return 2 * len(self.ends) - 1

    def states(self) -> Iterator[tuple[float, ContactResult, ContactResult]]:
        """Yield V [Pa^2], the result with the ring just added, and that with its negative, from coarse to fine."""
        heights, load = self.heights(0.0, self.ends[0]), self.realised.pressure
        state = self.press(heights, load=load)
        yield self.variance(heights), state, state
        for above, until in itertools.pairwise(self.ends):
            ring = self.heights(above, until)
            other = self.press(heights - ring, load=load, start=state.pressure)
            heights = heights + ring
            state = self.press(heights, load=load, start=state.pressure)
            yield self.variance(heights), state, other

    def measure(self) -> xr.Dataset:
        """Press everything and keep the sums; dimensions (sign, level), (step), (step, bin), (octave, level)."""
        variance: list[float] = []
        areas: list[list[tuple[float, ...]]] = []
        square: list[float] = []
        sums: list[dict[str, Array]] = []
        starts: dict[float, tuple[float, Pressed]] = {}
        diffused = np.full((len(self.restarts), len(self.ends)), np.nan)
        before, memory = None, None
        for zeta, (v, result, other) in zip(self.ends, self.states(), strict=True):
            state = pressed(result)
            areas.append([areas_of(result), areas_of(other)])
            square.append(float(np.mean(state.pressure**2)) / v)
            if before is None or memory is None:
                memory = Memory(state, steps=len(self.ends))
            else:
                unit = float(np.sqrt(variance[-1]))
                sums.append(_step(before, (state, pressed(other)), unit=unit))
                memory.add(state, unit=unit)
            for row, (began, start) in enumerate(starts.values()):
                diffused[row, len(variance)] = diffused_area(start, np.array([v - began]))[0]
            if zeta in self.restarts:
                starts[zeta] = v, state
                diffused[len(starts) - 1, len(variance)] = areas[-1][0][0]
            before = state
            variance.append(v)
        assert memory is not None
        data: dict[str, Any] = {
            "variance_share": ("level", np.array(variance) / variance[-1]),
            "mean_square": ("level", square),
            "area_diffused": (("octave", "level"), diffused),
            "inflow": ("pair", memory.two_step),
            "inflow_composed": ("pair", memory.composed),
            "points_out": ("age", memory.out),
            "points_returned": ("age", memory.returned),
            "contact_out": ("level", memory.out_at),
            "contact_crossed": ((), memory.crossed),
            "nominal": ((), self.realised.pressure / np.sqrt(variance[-1])),
        }
        return _dataset(data, areas=areas, sums=sums)


#: The ring ends at this multiple of the magnification at which it begins.
RING = 2**0.25


@dataclass(frozen=True, kw_only=True)
class Probe(RingSolve):
    """A surface with its waves up to one magnification, and the next ring with both signs at several heights.

    The load p* counts in the gradient of the waves up to that magnification.

    Attributes
    ----------
    magnification : float
        q/q_long of the last wave there is.
    steps : tuple of float
        Delta V / V of the ring.
    """

    magnification: float
    steps: tuple[float, ...]

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {**super().recipe, "magnification": self.magnification, "steps": list(self.steps)}

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"probe-{self.points}"

    @property
    def solves(self) -> int:
        """The surface, and two for each step."""
        return 1 + 2 * len(self.steps)

    @property
    def shortest(self) -> float:
        """Wave length [m] at the magnification of the probe; that of the ring is a little shorter."""
        return self.realised.longest / self.magnification

    def measure(self) -> xr.Dataset:
        """Press everything and keep the sums; dimensions (), (step), (step, bin)."""
        heights = self.heights(0.0, self.magnification)
        ring = self.heights(self.magnification, self.magnification * RING)
        v, natural = self.variance(heights), self.variance(ring)
        unit = float(np.sqrt(v))
        # E* h'_rms = 2 sqrt(V).
        load = 2 * reduced_load(self.realised) * unit
        first = self.press(heights, load=load)
        before = pressed(first)
        sums: list[dict[str, Array]] = []
        areas = [[areas_of(first)] * 2]
        for step in self.steps:
            scaled = ring * np.sqrt(step * v / natural)
            pair = [self.press(heights + sign * scaled, load=load, start=first.pressure) for sign in (1, -1)]
            sums.append(_step(before, [pressed(result) for result in pair], unit=unit))
            areas.append([areas_of(result) for result in pair])
        data: dict[str, Any] = {"nominal": ((), load / unit)}
        return _dataset(data, areas=areas, sums=sums)
