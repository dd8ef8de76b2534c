"""The limit of a contact area over grids, and how far it may be from the truth (`fem_contact.area_error`)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fem_contact._checks import instance, listed
from fem_contact.area import ContactAreas, mean_areas
from fem_contact.area_error import (
    ALONE,
    LOCATED,
    error_covariance,
    kink_error,
    kinked,
    mean_error,
    perimeter_law,
    too_rough,
)
from fem_contact.area_error import PlannedGrid as PlannedGrid
from fem_contact.errors import InvalidInput

#: Contact points on the finest grid below which no limit is claimed. On 8 surfaces of H = .3 and .8 at p*
#: from 1e-5 to .02, twice the claimed error held the limit of grids of 384 and 512 points in 315 of 320
#: ladders whose finest grid has 16 points of contact or more (it is 8 % wide at 16 to 32, and at worst 40 %),
#: but in 56 of 75 with 1 to 3 points, where 19 of the estimates were negative. With 4 to 15 it held, too, but
#: says little: +- 18 to 60 %.
LEAST_CONTACT_POINTS = 16


@dataclass(frozen=True, kw_only=True)
class Limit:
    """An area extrapolated to vanishing spacing.

    Attributes
    ----------
    value : float
        A/A0 in the limit.
    uncertainty : float
        Its standard error, from the scatter of the grids about the fit.
    grids : int
        Number of areas that went into the fit.
    definition : str
        Which area was extrapolated: "subcell" or "perimeter".
    doubt : str
        Why there is no limit, in words, with NaN as its value and uncertainty; empty where there is one.
    """

    value: float
    uncertainty: float
    grids: int
    definition: str
    doubt: str = ""

    @property
    def determinable(self) -> bool:
        """Whether there is a limit."""
        return not self.doubt


def located_limit(areas: Sequence[ContactAreas]) -> Limit:
    """Limit of the located area of one surface over its grids, with an uncertainty that holds.

    Parameters
    ----------
    areas : sequence of ContactAreas
        Of one surface at one load by boundary elements, with located areas, from one grid or more; several
        shifts of a grid may appear and are averaged. Grids of every density help: the error law weighs them.

    Returns
    -------
    Limit
        Its `uncertainty` is one standard error; twice that holds the truth on 95 % of surfaces. Where the
        grids disagree by more than the law allows, it is widened by the factor they disagree, and where
        heights have kinks by all that they disagree, as if areas converged in first order. NaN, with a
        `doubt`, for a contact of too few points to carry the law, for heights with steps, or kinks that a
        single grid or one in full contact does not tell the error of, and for an estimate outside (0, 1].

    Raises
    ------
    InvalidInput
        For no area, or areas whose edges were not located.

    Notes
    -----
    Generalised least squares with flat prior on A. From a single grid the limit is its area less what such
    areas are off by on average, and the uncertainty what the law says of such a grid. Grids so coarse that no
    area remains inside their located edges say nothing and are left out.
    """
    listed("areas", areas, ContactAreas, what="`ContactAreas`")
    if not areas or any(area.subcell is None for area in areas):
        raise InvalidInput(f"{len(areas)} areas: a limit needs at least one, each with its edge located")
    return _limit(areas, "subcell")


def perimeter_limit(areas: Sequence[ContactAreas]) -> Limit:
    """Limit of the area corrected at its edge by a constant, for results whose edges cannot be located.

    Parameters
    ----------
    areas : sequence of ContactAreas
        Of one surface at one load by one method, from one grid or more: of finite elements, of solids that
        yield or on cells that are not square.

    Returns
    -------
    Limit
        As `located_limit` gives it. The constant of `fem_contact.area.EDGE_CONSTANTS` is taken to be known to
        .02 only, which several grids then tell better.

    Raises
    ------
    InvalidInput
        For no area.

    Notes
    -----
    For contours of all directions. Edges that all lie alike between the grid points are off together by more.
    """
    return _limit(areas, "perimeter")


def _limit(areas: Sequence[ContactAreas], definition: Literal["subcell", "perimeter"]) -> Limit:
    doubt = too_small(areas)
    described: dict[str, Any] = {"grids": len(areas), "definition": definition}
    if doubt:
        return _no_limit(doubt, **described)
    groups: dict[tuple[float, float], list[ContactAreas]] = {}
    for area in areas:
        groups.setdefault(area.spacing, []).append(area)
    # Finest first: it says how long the edges are.
    ordered = sorted(groups.items(), key=lambda group: group[0][0] * group[0][1])
    means = [(mean_areas(group), len(group)) for _, group in ordered]
    means = [(mean, count) for mean, count in means if getattr(mean, definition) > 0 or mean is means[0][0]]
    value = np.array([getattr(mean, definition) for mean, _ in means])
    plan = [PlannedGrid(spacing=mean.spacing, cells=mean.cells, solves=count) for mean, count in means]
    finest = means[0][0]
    law = LOCATED if definition == "subcell" else perimeter_law(finest.edge_constant)
    fraction = finest.edge_fraction
    doubt = too_rough(finest, alone=len(plan) == 1)
    if doubt:
        return _no_limit(doubt, **described)
    if fraction == 0 or not 0 < value[0] < 1:
        return _checked(Limit(value=float(value[0]), uncertainty=0.0, **described))
    size = np.array([grid.size for grid in plan])
    coarser = size > 1.01 * size[0]
    weights = np.linalg.inv(error_covariance(law, float(value[0]), fraction, plan, like=finest))
    expected = value - mean_error(law, value, np.array([mean.edge_fraction for mean, _ in means]))
    precision = float(weights.sum())
    # Around the finest area, so that nothing is lost to rounding where all are nearly equal.
    limit = float(expected[0] + (weights @ (expected - expected[0])).sum() / precision)
    rest = expected - limit
    disagreement = float(rest @ weights @ rest) / (len(plan) - 1) if len(plan) > 1 else ALONE**2
    uncertainty = float(np.sqrt(max(disagreement, 1.0) / precision))
    left = np.abs(value - value[0])[coarser] * size[0] / (size[coarser] - size[0])
    uncertainty = math.hypot(
        uncertainty,
        kinked(finest) * float(np.max(left, initial=0.0)),
        kink_error(finest, alone=not left.size),
    )
    return _checked(Limit(value=limit, uncertainty=uncertainty, **described))


def too_small(areas: Sequence[ContactAreas]) -> str:
    """Say that the contact is too small for a limit over these grids; empty where it is not."""
    listed("areas", areas, ContactAreas, what="`ContactAreas`")
    if not areas:
        raise InvalidInput("0 areas: a limit needs at least one")
    sizes = [area.spacing[0] * area.spacing[1] for area in areas]
    finest = [a for a, size in zip(areas, sizes, strict=True) if size <= min(sizes) * (1 + 1e-9)]
    points = float(np.mean([area.pixel * area.cells for area in finest]))
    if points >= LEAST_CONTACT_POINTS * (1 - 1e-9):
        return ""
    count = f"{points:.3g} point{'' if round(points, 2) == 1 else 's'}"
    return f"the contact has {count} on the finest grid; a limit needs {LEAST_CONTACT_POINTS}"


def _no_limit(doubt: str, grids: int, *, definition: str) -> Limit:
    return Limit(value=math.nan, uncertainty=math.nan, grids=grids, definition=definition, doubt=doubt)


def _checked(limit: Limit) -> Limit:
    """Return a limit that is a share of the nominal area, or none."""
    # Fits of complete contact end at 1 but for rounding.
    if 0 < limit.value <= 1 + 1e-12:
        return limit
    doubt = f"the grids extrapolate to A/A0 = {limit.value:.3g}, which is no share of an area"
    return _no_limit(doubt, limit.grids, definition=limit.definition)


def predicted_uncertainty(coarse: ContactAreas, grids: Sequence[PlannedGrid]) -> float:
    """Return the standard error that a limit will claim from grids not solved yet; inf if none.

    The areas of any grid of the same surface at the same load say how large the contact is, how long its
    edges, and whether they are located, for `located_limit`, or corrected, for `perimeter_limit`.
    """
    instance("coarse", coarse, ContactAreas, what="`ContactAreas`")
    listed("grids", grids, PlannedGrid, what="`PlannedGrid`s")
    if not grids:
        raise InvalidInput("grids: at least one is needed")
    area = coarse.pixel if coarse.subcell is None else coarse.subcell
    area = min(max(area, coarse.cell_share), 1 - coarse.cell_share)
    if coarse.edge_fraction == 0:
        return 0.0 if coarse.pixel > 0 else float("inf")
    ordered = sorted(grids, key=lambda grid: grid.size)
    if area * ordered[0].cells < LEAST_CONTACT_POINTS:
        return float("inf")
    size = np.sqrt(coarse.spacing[0] * coarse.spacing[1])
    fraction = coarse.edge_fraction * ordered[0].size / float(size)
    located = coarse.subcell is not None
    law = LOCATED if located else perimeter_law(coarse.edge_constant)
    covariance = error_covariance(law, area, fraction, ordered, like=coarse)
    alone = len({grid.spacing for grid in ordered}) == 1
    expected = (ALONE if alone else 1.0) / float(np.sqrt(np.linalg.inv(covariance).sum()))
    return math.hypot(expected, kink_error(replace(coarse, edge_fraction=fraction), alone=alone))
