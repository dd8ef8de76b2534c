"""Rough surfaces of rising bandwidth against the limits of this project, and what a digit costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from fem_contact import bem
from fem_contact.area import ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import located_limit
from fem_contact.response import HalfSpace
from validation.cases import Check
from validation.cases.scorecard.subject import SOFT, Subject, rough

__all__ = ["CostRow", "bandwidths", "cost", "rough_surface"]

_PRESSURE = 0.05
_WAVES = 2
#: Points per shortest wave of the two grids that a subject is asked for.
_POINTS = (4, 8)
#: Of the reference, with 2 x 2 sub-grid shifts on each.
_REFERENCE_POINTS = (6, 8, 12, 16)
#: lambda_long / lambda_short where a digit is priced, and the further grids of its reference.
_PRICED, _FURTHER_POINTS = 4, (24, 32)
#: What the perimeter correction of a good solver leaves at 8 points per shortest wave.
_CORRECTION_LEFT = 0.02
_SHIFTS = ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5))


@dataclass(frozen=True, kw_only=True)
class _Reference:
    """Limits of a surface by boundary elements.

    Attributes
    ----------
    area, area_error : float
        A/A0 and half of its 95 % interval.
    gap, energy : float
        Mean gap over h_rms and mean(p u) / (2 h_rms), finest grid.
    gap_error, energy_error : float
        Twice their change over the last doubling of the grid.
    """

    area: float
    area_error: float
    gap: float
    gap_error: float
    energy: float
    energy_error: float


@dataclass(frozen=True, kw_only=True)
class CostRow:
    """What one grid took and how near it came.

    Attributes
    ----------
    grid : int
        Points along a side.
    error : float
        Relative error of the area, located in the cells where the solver's edges can be and corrected by the
        perimeter elsewhere; what is not known of the limit counts as error.
    seconds : float
        Processor time.
    peak_bytes : int
    iterations : int
    """

    grid: int
    error: float
    seconds: float
    peak_bytes: int
    iterations: int


def bandwidths(subject: Subject) -> tuple[int, ...]:
    """lambda_long / lambda_short of the surfaces that its grids resolve."""
    most = (4 if subject.quick else 8) * subject.points
    return tuple(width for width in (4, 8, 16) if _WAVES * width * _POINTS[-1] <= most)


def _gap_and_energy(result: ContactResult) -> tuple[float, float]:
    moved = result.displacement - result.displacement.mean()
    rise = float(np.std(result.heights))
    return float(result.gap.mean()) / rise, float(np.mean(result.pressure * moved)) / (2 * rise)


@cache
def _reference(width: int) -> _Reference:
    areas, more = [], []
    for points in _REFERENCE_POINTS + (_FURTHER_POINTS if width == _PRICED else ()):
        surface = rough(_WAVES * width * points, bandwidth=width, waves=_WAVES)
        for shift in _SHIFTS:
            field = surface.shifted(shift)
            result = bem.solve(field, HalfSpace(solid=SOFT), mean_pressure=_PRESSURE).checked()
            areas.append(contact_areas(result, subcell=True))
            if shift == (0.0, 0.0) and points in (8, 16):
                more.append(_gap_and_energy(result))
    limit = located_limit(areas)
    (gap8, energy8), (gap, energy) = more
    return _Reference(
        area=limit.value,
        area_error=2 * limit.uncertainty,
        gap=gap,
        gap_error=2 * abs(gap - gap8),
        energy=energy,
        energy_error=2 * abs(energy - energy8),
    )


def _solved(
    subject: Subject, width: int, ladder: Sequence[int]
) -> list[tuple[int, ContactResult, ContactAreas]]:
    found = []
    for points in ladder:
        n = _WAVES * width * points
        result = subject.press(rough(n, bandwidth=width, waves=_WAVES), _PRESSURE).result
        constant, located = subject.solver.edge_constant(result), subject.solver.locates_edges
        areas = contact_areas(result, edge_constant=constant, subcell=located)
        found.append((n, result, areas))
    return found


def rough_surface(subject: Subject, width: int) -> Sequence[Check]:
    """Area, mean gap and energy of a rough surface are those of the limit, within what the grids allow."""
    reference, solved = _reference(width), _solved(subject, width, _POINTS)
    coarse, area = (areas.perimeter for _, _, areas in solved)
    result = solved[-1][1]
    gap, energy = _gap_and_energy(result)
    allowed = abs(area - coarse) / reference.area + reference.area_error / reference.area + _CORRECTION_LEFT
    return [
        Check.relative("A/A0, perimeter-corrected, 8 points per wave", area, reference.area, allowed),
        Check.relative("mean gap over h_rms", gap, reference.gap, reference.gap_error / reference.gap + 0.01),
        Check.relative(
            "energy mean(p u) / (2 h_rms)",
            energy,
            reference.energy,
            reference.energy_error / reference.energy + 0.01,
        ),
    ]


def cost(subject: Subject) -> tuple[CostRow, ...]:
    """Return what each grid of one rough surface took, and the error of its area."""
    reference = _reference(_PRICED)
    most = (4 if subject.quick else 8) * subject.points
    ladder = [points for points in (4, 8, 16, 32) if _WAVES * _PRICED * points <= most]
    return tuple(
        CostRow(
            grid=n,
            error=_error(areas, reference),
            seconds=result.cost.cpu_seconds,
            peak_bytes=result.cost.peak_bytes,
            iterations=result.cost.iterations,
        )
        for n, result, areas in _solved(subject, _PRICED, ladder)
    )


def _error(areas: ContactAreas, reference: _Reference) -> float:
    area = areas.perimeter if areas.subcell is None else areas.subcell
    return (abs(area - reference.area) + reference.area_error / 2) / reference.area
