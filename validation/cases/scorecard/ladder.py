"""Rough surfaces of rising bandwidth against the limits of this project, and what a digit costs.

Areas converge in first order of the spacing: what a subject is allowed is its own change from grid to grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.extrapolation import located_limit
from fem_contact.surface import HeightField
from validation.cases import Checks, NotJudged, near, relative, within
from validation.cases.scorecard.subject import Subject, rough
from validation.solvers.bem import Bem

_PRESSURE = 0.05
_WAVES = 2
#: Points per shortest wave of the two grids that a subject is asked for.
_POINTS = (4, 8)
#: Of the reference, with 2 x 2 sub-grid shifts on each.
_REFERENCE_POINTS = (6, 8, 12, 16)
#: lambda_long / lambda_short where a digit is priced, and the further grids of its reference.
PRICED, _FURTHER_POINTS = 4, (24, 32)
#: What the perimeter correction of a good solver leaves at 8 points per shortest wave.
_CORRECTION_LEFT = 0.02
#: What locating the edges leaves there.
_LOCATED_LEFT = 0.01
#: Pressures that count as low, over E* h'_rms.
_LOW = 0.2
_WORDS = {
    "gap": "mean gap over h_rms",
    "stiffness": "stiffness, as K h_rms / p0",
    "energy": "energy mean(p u) / (2 h_rms)",
}
_SHIFTS = ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5))


@dataclass(frozen=True)
class CostRow:
    """What one grid took, of so many points along a side, and the relative error of its area.

    The area is located in the cells where the solver's edges can be, and corrected by the perimeter
    elsewhere; what is not known of the limit counts as error.
    """

    points: int
    area_miss: float
    seconds: float
    peak_bytes: int
    iterations: int


def bandwidths(subject: Subject) -> tuple[int, ...]:
    """lambda_long / lambda_short of the surfaces that its grids resolve; the first one always."""
    most = subject.most_points
    return tuple(width for width in (4, 8, 16) if width == 4 or _WAVES * width * _POINTS[-1] <= most)


def _areas(subject: Subject, field: HeightField) -> ContactAreas:
    """Return the areas of a surface, with what is known of the edges of its solver."""
    result = subject.press(field, _PRESSURE).result
    solver = subject.solver
    return contact_areas(result, edge_constant=solver.edge_constant(result), subcell=solver.locates_edges)


def _low(subject: Subject, field: HeightField) -> float:
    """Share of the nominal area of a surface that carries low pressures."""
    result = subject.press(field, _PRESSURE).result
    return float((result.in_contact & (result.pressure < _LOW * field.rms_gradient)).mean())


def _means(subject: Subject, field: HeightField) -> dict[str, float]:
    """Return mean gap over h_rms, mean(p u) / (2 h_rms), and K h_rms / p0 by two loads beside."""
    result, rise = subject.press(field, _PRESSURE).result, field.rms_height
    lighter, heavier = (subject.press(field, part * _PRESSURE).result.mean_gap for part in (0.9, 1.1))
    moved = result.displacement - result.displacement.mean()
    return {
        "gap": result.mean_gap / rise,
        "energy": np.mean(result.pressure * moved) / (2 * rise),
        "stiffness": 0.2 * rise / (lighter - heavier),
    }


def _surface(width: int, points: int) -> HeightField:
    return rough(_WAVES * width * points, bandwidth=width, waves=_WAVES)


@cache
def _reference(width: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return limits by boundary elements, "area", "low" and what `_means` returns, and their errors."""
    subject = Subject(name="bem", solver=Bem(), settings={}, seconds=math.inf)
    further = _FURTHER_POINTS if width == PRICED else ()
    surfaces = {points: _surface(width, points) for points in _REFERENCE_POINTS + further}
    limit = located_limit(
        [_areas(subject, surface.shifted(shift)) for surface in surfaces.values() for shift in _SHIFTS]
    )
    low_coarse, low = (_low(subject, surfaces[points]) for points in (8, 16))
    coarse, fine = (_means(subject, surfaces[points]) for points in (12, 16))
    # Low pressures are counted, so that their share is off in first order.
    values = {"area": limit.value, "low": 2 * low - low_coarse, **fine}
    errors = {"area": 2 * limit.uncertainty, "low": abs(low - low_coarse) / 2}
    return values, errors | {name: 2 * abs(fine[name] - coarse[name]) for name in fine}


def rough_surface(subject: Subject, *, width: int) -> Checks:
    """Areas, gap, stiffness, energy and low pressures are those of the limit, within what the grids allow."""
    # The finer grid first: what it is not tried on, the coarser one need not be solved for.
    surfaces = [_surface(width, points) for points in reversed(_POINTS)]
    fine, coarse = (_areas(subject, surface) for surface in surfaces)
    values, errors = _reference(width)
    area, known = values["area"], errors["area"] / values["area"]
    excess = (coarse.pixel - area) / (fine.pixel - area)
    # Of first order it is 2; of one area with its scatter the order is between a half and two.
    yield within("A/A0 counted, excess at 4 over that at 8 points per wave", excess, math.sqrt(2), 4)
    allowed = abs(fine.perimeter - coarse.perimeter) / area + known + _CORRECTION_LEFT
    yield relative("A/A0, perimeter-corrected, 8 points per wave", fine.perimeter, area, allowed)
    if fine.subcell is not None:
        yield relative("A/A0, edges located in the cells", fine.subcell, area, known + _LOCATED_LEFT)
    for name, mean in _means(subject, surfaces[0]).items():
        yield relative(_WORDS[name], mean, values[name], errors[name] / values[name] + 0.01)
    # At an order of .6, the least that is taken for convergence, half of the error is left.
    low, low_coarse = (_low(subject, surface) for surface in surfaces)
    allowed = errors["low"] + 2 * abs(low - low_coarse)
    yield near(f"share of the area with p < {_LOW:g} E* h'_rms", low, values["low"], allowed)


def cost(subject: Subject) -> tuple[CostRow, ...]:
    """Return what each grid of one rough surface took and the error of its area, as long as time allows."""
    values, errors = _reference(PRICED)
    rows = []
    for points in (4, 8, 16, 32):
        n = _WAVES * PRICED * points
        if n > subject.most_points:
            break
        surface = _surface(PRICED, points)
        try:
            areas, paid = _areas(subject, surface), subject.press(surface, _PRESSURE).result.cost
        except NotJudged:
            break
        area = areas.perimeter if areas.subcell is None else areas.subcell
        miss = (abs(area - values["area"]) + errors["area"] / 2) / values["area"]
        rows.append(CostRow(n, miss, paid.cpu_seconds, paid.peak_bytes, paid.iterations))
    return tuple(rows)
