r"""A surface as a stack of rings of waves, each pressed with either sign, and what a ring does to the pressure of every point.

A point in contact before the ring either stays or is *lost*, its pressure p then falling to zero; others *enter*. With the change
delta of the pressure, and sums per nominal area over the points that are in contact before (c) or enter (e),

.. math::
    \Delta A &= \text{entered} - \text{lost}, \\
    \Delta\langle p \rangle = 0 &= \sum_c \delta + \sum_e p', \\
    \Delta\langle p^2 \rangle &= \sum_c \delta^2 + 2 \sum_c p\,\delta + \sum_e p'^2 .

Drift and diffusivity are the means of delta and delta^2 over the points in contact before, by Delta V. In the theory a pressure
diffuses until it is absorbed at zero: its drift is zero at any step, since a stopped walk is a martingale, its diffusivity tends to
1, and nothing enters.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from fem_contact.surface import HeightField
from persson import elastic
from validation.arrays import Array
from validation.execution.measurement import measurement
from validation.measurements.common import reduced_load
from validation.measurements.measurement import AREAS, press_elastic, stacked
from validation.scenes import surfaces
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SelfAffineSurface

#: Relative slack when a wave stands at the end of a ring.
_EDGE = 1e-9


def areas_of(result: ContactResult) -> dict[str, float]:
    """Return the four counts of A/A0 named in `AREAS` of a boundary-element result."""
    areas = contact_areas(result, subcell=True)
    return {name: float(getattr(areas, name)) for name in AREAS}


def _dataset(areas: Sequence[Any], sums: Sequence[Mapping[str, Array]], **data: Any) -> xr.Dataset:
    """Return areas[level][sign] and sums[step], by their names, as variables beside others."""
    data |= stacked([*zip(*areas, strict=True)], "sign", "level")
    data |= {name: (("step", "bin")[: v.ndim], v) for name, (_, v) in stacked(sums, "step").items()}
    return xr.Dataset(data)


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
        q_short = self.waves.q_short * min(until / self.zeta.max(), 1.0)
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
    contacts, variance = [state.in_contact], list[float]()
    composed, areas, square, sums = [], [], [], []
    for k, zeta in enumerate(ends):
        if k:
            ring, unit = rings.heights(ends[k - 1], zeta), np.sqrt(variance[-1])
            pair = rings.press_both(heights, ring, load=load, start=pair[0].pressure)
            heights, before, (state, other) = heights + ring, state, map(pressed, pair)
            sums.append(budget(before, (state, other), unit=unit))
            contacts.append(state.in_contact)
            if k > 1:
                composed.append(composed_inflow(~contacts[-3], before, state, unit=unit))
        v = rings.variance(heights)
        variance.append(v)
        areas.append([areas_of(result) for result in pair])
        square.append(np.mean(state.pressure**2) / v)
        diffused[: len(starts), k] = [diffused_area(start, v - began) for began, start in starts]
        if zeta in restarts:
            diffused[len(starts), k] = areas[-1][0]["pixel"]
            starts.append((v, state))
    return _dataset(
        areas,
        sums,
        variance_share=("level", np.array(variance) / variance[-1]),
        mean_square=("level", square),
        area_diffused=(("octave", "level"), diffused),
        inflow_composed=("pair", composed),
        nominal=problem.pressure / np.sqrt(variance[-1]),
        **memory(contacts),
    )


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
    unit = np.sqrt(v)
    # E* h'_rms = 2 sqrt(V).
    load = 2 * reduced_load(problem) * unit
    first = rings.press(heights, load=load)
    sums, areas = [], [[areas_of(first)] * 2]
    for step in steps:
        scaled = ring * np.sqrt(step * v / natural)
        pair = rings.press_both(heights, scaled, load=load, start=first.pressure)
        sums.append(budget(pressed(first), [*map(pressed, pair)], unit=unit))
        areas.append([*map(areas_of, pair)])
    return _dataset(areas, sums, nominal=load / unit)


#: Bins of p/sqrt(V) and their edges, crowded near zero; what lies above counts in the last.
BINS = 40
PROFILE_EDGES = 6.0 * np.linspace(0.0, 1.0, BINS + 1) ** 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """Pressures [Pa] of all points, zero where there is no contact, and which points are in contact."""

    pressure: Array
    in_contact: NDArray[np.bool_]


def budget(before: Pressed, after: Sequence[Pressed], *, unit: float) -> dict[str, Array]:
    """Return the sums of one step per nominal area, and by the bins of the pressure before, by their names in the registry.

    They are means over the states `after` a ring and after its negative: what is odd in the ring drops out.
    Pressures in `unit` [Pa], sqrt(V) before the step; the points are the same without and with the ring.
    """
    sums, points = [_sums(before, state, unit=unit) for state in after], before.pressure.size
    return {name: np.mean([s[name] / points for s in sums], axis=0) for name in sums[0]}


def _sums(before: Pressed, after: Pressed, *, unit: float) -> dict[str, Any]:
    lost, entered = before.in_contact & ~after.in_contact, after.in_contact & ~before.in_contact
    p = before.pressure[before.in_contact] / unit
    delta = np.where(after.in_contact, after.pressure, 0.0)[before.in_contact] / unit - p
    new = after.pressure[entered] / unit
    total = [state.pressure[state.in_contact] / unit for state in (before, after)]
    binned = partial(np.bincount, bins_of(p), minlength=BINS)
    return {
        "area_lost": np.count_nonzero(lost),
        "area_entered": new.size,
        "load_entered": new.sum(),
        "square_entered": new @ new,
        "pressure_change": delta.sum(),
        "pressure_cross_change": p @ delta,
        "pressure_change_square": delta @ delta,
        "square_change": total[1] @ total[1] - total[0] @ total[0],
        "bin_contact": binned(),
        "bin_lost": binned(lost[before.in_contact]),
        "bin_pressure": binned(p),
        "bin_change": binned(delta),
        "bin_change_square": binned(delta * delta),
    }


def bins_of(pressure: Array) -> NDArray[np.int64]:
    """Return the bin of each reduced pressure."""
    return np.clip(np.searchsorted(PROFILE_EDGES, pressure, side="right") - 1, 0, BINS - 1)


def diffused_area(state: Pressed, added: float) -> float:
    r"""Contact area that absorbing diffusion makes of given pressures, over A_0, by Delta V [Pa^2].

    .. math:: \frac{A}{A_0} = \frac{1}{N} \sum_\text{contact} \operatorname{erf}\frac{p}{\sqrt{2 \Delta V}}

    The equation is linear: a point with pressure p before is a surface under the nominal pressure p, whose
    waves so far are none (Persson 2006, Eqs. 17, 19 and 20).
    """
    pressure = state.pressure[state.in_contact]
    areas = elastic.contact_area(pressure[pressure > 0], stress_variance=added)
    return np.sum(areas) / state.pressure.size


def memory(contacts: Sequence[NDArray[np.bool_]]) -> dict[str, Any]:
    """Return what became of every point along a chain of steps, whose states it was in contact in, by names of `chain`.

    ``points_out`` and ``points_returned`` (age) count points that were out of contact when a step began, and those of
    them that it brought back, by the steps since they had left; index 0 is those that were never in contact. Of the
    contact at the end, ``contact_out`` is the share that was out in each state, ``contact_crossed`` that had left at
    least once. ``inflow``: share of the nominal area out before two steps and in contact after.
    """
    out, returned = np.zeros((2, len(contacts) + 1))
    since = np.zeros(contacts[0].shape, dtype=np.int16)
    ever_left = np.zeros(contacts[0].shape, dtype=bool)
    for before, after in itertools.pairwise(contacts):
        for counts, points in ((out, ~before), (returned, after & ~before)):
            counts += np.bincount(since[points], minlength=out.size)
        # Those never in contact stay at 0; the others count the steps from the one that took them out.
        since[(since > 0) & ~after] += 1
        since[after] = 0
        since[before & ~after] = 1
        ever_left |= before & ~after
    last = contacts[-1]
    left, *away = (
        np.mean(flags[last]) if last.any() else np.nan for flags in (ever_left, *(~c for c in contacts))
    )
    return {
        "points_out": ("age", out),
        "points_returned": ("age", returned),
        "contact_out": ("level", away),
        "contact_crossed": left,
        "inflow": ("pair", [np.mean(~a & b) for a, b in zip(contacts, contacts[2:], strict=False)]),
    }


def composed_inflow(was_out: NDArray[np.bool_], before: Pressed, after: Pressed, *, unit: float) -> float:
    """Share of the nominal area that comes in over two steps, if the second knows the state before it alone.

    `was_out` are the points out of contact before the first step. The law of the second is the chance of a
    point in contact to stay, by the bin of its pressure over `unit` [Pa], and that of a point out of
    contact to enter.
    """
    touching = before.in_contact
    binned = partial(np.bincount, bins_of(before.pressure[touching] / unit), minlength=BINS)
    stayed, came = binned(after.in_contact[touching]), binned(was_out[touching])
    by_contact = np.sum(came * stayed / np.maximum(binned(), 1))
    out, entered, still_out = (
        np.count_nonzero(points & ~touching) for points in (~touching, after.in_contact, was_out)
    )
    return (by_contact + still_out * entered / (out or 1)) / was_out.size
