"""A surface as a stack of rings of waves, each pressed with either sign: a chain of them, or a single one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.execution.measurement import measurement
from validation.measurements.budgets import Memory, Pressed, budget, diffused_area
from validation.measurements.common import reduced_load
from validation.measurements.measurement import AREAS, press_elastic
from validation.scenes import surfaces
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SelfAffineSurface

#: Relative slack when a wave stands at the end of a ring.
_EDGE = 1e-9


def areas_of(result: ContactResult) -> tuple[float, ...]:
    """Return the four counts of A/A0 named in `AREAS`, in that order, of a boundary-element result."""
    areas = contact_areas(result, subcell=True)
    return tuple(float(getattr(areas, name)) for name in AREAS)


def _dataset(
    data: Mapping[str, Any],
    *,
    areas: Sequence[Sequence[tuple[float, ...]]],
    sums: Sequence[Mapping[str, Array]],
) -> xr.Dataset:
    """Return areas[level][sign], four numbers as `AREAS` names them, and sums[step] by name, as variables."""
    table = np.array(areas)
    made = dict(data) | {name: (("sign", "level"), table[:, :, k].T) for k, name in enumerate(AREAS)}
    for name in sums[0]:
        values = np.array([row[name] for row in sums])
        made[name] = (("step", "bin")[: values.ndim], values)
    return xr.Dataset(made)


def pressed(result: ContactResult) -> Pressed:
    """Return pressures and contact of a result."""
    return Pressed(pressure=result.pressure, in_contact=result.in_contact)


def ring_ends(*, periods: float, bandwidth: float, steps_per_octave: int) -> Array:
    """Magnifications at which the rings of a square period end, those without a wave left out.

    >>> ring_ends(periods=1, bandwidth=2.0, steps_per_octave=4).round(3)
    array([1.   , 1.414, 2.   ])
    """
    steps = round(steps_per_octave * float(np.log2(bandwidth)))
    ends = np.geomspace(1.0, bandwidth, steps + 1)
    top = int(np.ceil(bandwidth * periods))
    m, n = np.meshgrid(np.arange(top + 1), np.arange(top + 1))
    waves = np.unique(np.hypot(m, n))[1:] / periods
    counts = np.searchsorted(waves[waves >= 1 - _EDGE], ends * (1 + _EDGE), side="right")
    return ends[np.diff(np.concatenate([[0], counts])) > 0]


class Rings:
    """One surface at one nominal pressure on one square grid, its waves ring by ring."""

    def __init__(self, problem: ContactProblem, points: int, tolerance: float) -> None:
        surface = problem.surface
        assert isinstance(surface, SelfAffineSurface)
        self.problem, self.points, self.tolerance = problem, points, tolerance
        self.waves = surfaces.waves_of(surface, problem.realisation)
        lx, ly = self.waves.lengths
        self.zeta = surface.lambda_long * np.hypot(self.waves.m / lx, self.waves.n / ly)

    def heights(self, above: float, until: float) -> Array:
        """Heights [m] of the waves with above < q/q_long <= until."""
        keep = (self.zeta > above * (1 + _EDGE)) & (self.zeta <= until * (1 + _EDGE))
        parts = {name: getattr(self.waves, name)[keep] for name in ("m", "n", "amplitudes")}
        q_short = self.waves.q_short * min(until / float(self.zeta.max()), 1.0)
        return replace(self.waves, q_short=q_short, **parts).on((self.points, self.points)).heights

    def variance(self, heights: Array) -> float:
        """V [Pa^2] of these heights: the variance of the pressure at full contact, E*^2 m2 / 4."""
        field = HeightField(heights=heights, lengths=self.problem.lengths)
        return 0.25 * self.problem.contact_modulus**2 * field.moments[1]

    def press(self, heights: Array, *, load: float, start: Array | None = None) -> ContactResult:
        """Press these heights [m] at a nominal pressure [Pa], from a pressure field that is near."""
        surface = HeightField(heights=heights, lengths=self.problem.lengths)
        return press_elastic(surface, self.problem.elastic, load, start=start, tolerance=self.tolerance)

    def press_both(
        self, heights: Array, ring: Array, *, load: float, start: Array
    ) -> tuple[ContactResult, ContactResult]:
        """Press heights with a ring more, and with its negative."""
        more, less = (self.press(heights + sign * ring, load=load, start=start) for sign in (1, -1))
        return more, less


@measurement(
    "rings-{points}",
    kind="Chain",
    words="rings,",
    located=True,
    version=2,
    seconds=lambda points, ends: (2 * len(ends) - 1) * (4e-3 + 7e-7 * points),
    bytes=250,
)
def chain(
    *,
    problem: ContactProblem,
    points: int,
    ends: tuple[float, ...],
    restarts: tuple[float, ...] = (),
    tolerance: float = 1e-7,
) -> xr.Dataset:
    """Press a surface with its waves up to rising magnifications, each ring with both signs, and keep the sums.

    Over (sign, level), (step), (step, bin), (octave, level). Rings end at q/q_long = `ends`; at those among
    them in `restarts` absorbing diffusion is started from the truth. The area is off by less than the
    relative `tolerance`, and every flow is much larger.
    """
    starts: list[tuple[float, Pressed]] = []
    diffused = np.full((len(restarts), len(ends)), np.nan)
    rings, load = Rings(problem, points, tolerance), problem.pressure
    heights = rings.heights(0.0, ends[0])
    pair = (rings.press(heights, load=load),) * 2
    state = pressed(pair[0])
    memory = Memory(state, steps=len(ends))
    variance, areas, square, sums = [], [], [], []
    for k, zeta in enumerate(ends):
        if k:
            ring, unit = rings.heights(ends[k - 1], zeta), float(np.sqrt(variance[-1]))
            pair = rings.press_both(heights, ring, load=load, start=pair[0].pressure)
            heights, before, (state, other) = heights + ring, state, map(pressed, pair)
            sums.append(budget(before, (state, other), unit=unit))
            memory.add(state, unit=unit)
        v = rings.variance(heights)
        variance.append(v)
        areas.append([areas_of(result) for result in pair])
        square.append(float(np.mean(state.pressure**2)) / v)
        diffused[: len(starts), k] = [diffused_area(start, v - began) for began, start in starts]
        if zeta in restarts:
            diffused[len(starts), k] = areas[-1][0][0]
            starts.append((v, state))
    data: dict[str, Any] = {
        "variance_share": ("level", np.array(variance) / variance[-1]),
        "mean_square": ("level", square),
        "area_diffused": (("octave", "level"), diffused),
        "inflow": ("pair", memory.two_step),
        "inflow_composed": ("pair", memory.composed),
        "points_out": ("age", memory.out),
        "points_returned": ("age", memory.returned),
        "contact_out": ("level", memory.out_at),
        "contact_crossed": memory.crossed,
        "nominal": problem.pressure / np.sqrt(variance[-1]),
    }
    return _dataset(data, areas=areas, sums=sums)


#: The ring ends at this multiple of the magnification at which it begins.
RING = 2**0.25


@measurement(
    "probe-{points}",
    kind="Probe",
    words="one ring,",
    located=True,
    version=2,
    seconds=lambda points, steps: (1 + 2 * len(steps)) * (4e-3 + 7e-7 * points),
    bytes=250,
)
def probe(
    *,
    problem: ContactProblem,
    points: int,
    magnification: float,
    steps: tuple[float, ...],
    tolerance: float = 1e-7,
) -> xr.Dataset:
    """Press a surface with its waves up to one magnification, and the next ring with both signs at several heights.

    Over (), (step), (step, bin); `steps` are Delta V / V of the ring. The load p* counts in the gradient of
    the waves up to q/q_long = `magnification`.
    """
    rings = Rings(problem, points, tolerance)
    heights = rings.heights(0.0, magnification)
    ring = rings.heights(magnification, magnification * RING)
    v, natural = rings.variance(heights), rings.variance(ring)
    unit = float(np.sqrt(v))
    # E* h'_rms = 2 sqrt(V).
    load = 2 * reduced_load(problem) * unit
    first = rings.press(heights, load=load)
    sums, areas = [], [[areas_of(first)] * 2]
    for step in steps:
        scaled = ring * np.sqrt(step * v / natural)
        pair = rings.press_both(heights, scaled, load=load, start=first.pressure)
        sums.append(budget(pressed(first), [*map(pressed, pair)], unit=unit))
        areas.append([*map(areas_of, pair)])
    return _dataset({"nominal": load / unit}, areas=areas, sums=sums)
