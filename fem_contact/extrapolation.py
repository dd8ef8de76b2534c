r"""The limit of the located contact area over grids, and how far it may be from the truth.

The area with its edge located inside the cells (`fem_contact.area.subcell_area`) is off by

.. math:: A_h - A = f \left( k_0 + k_1 z + k_{3/2} z^{3/2} + k_2 z^2 + k_3 z^3 \right)
          + f^{1/2} n^{-1/2} \nu(z), \qquad z = \frac{f}{A (1 - A)^{5/4}}

where f is the edge fraction, in proportion to the spacing, z is the spacing in units of the width of the
contact patches (near full contact, of a little less than that of the gaps), n the number of cells and nu a
random number. The edge map takes out the first order, of contours of all directions, but for k_0, which is
what another map fitted to the same surfaces says; and of the second order what can be known: how the fields
bend beside the edge. Where the contour runs in one direction (`ContactAreas.alignment`), as that of a wave
does, f (k_a + k'_h) is left, too. The half power follows from the square-root fields of the edge.

The coefficients k depend on surface and load, and k' on the grid, too: on a few grids they cannot all be
fitted, and leaving one out makes any fit look better than it is. They are therefore taken as random numbers,
whose means and sizes were measured, and the limit is what the areas of the grids at hand then say of A, with
the spread that remains. Each patch of contact has its own, so that they differ the less from surface to
surface the more patches there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fem_contact._checks import choice, finite, instance, listed, pair, positive, whole
from fem_contact.area import ContactAreas
from fem_contact.errors import InvalidInput

__all__ = [
    "LEAST_CONTACT_POINTS",
    "Limit",
    "PlannedGrid",
    "limit_area",
    "located_limit",
    "perimeter_limit",
    "predicted_uncertainty",
    "too_small",
]

Array = NDArray[np.float64]

#: Scatter of the place of an edge on the grid [cells], per edge, as counted areas of Hertzian contacts show.
_SCATTER = 0.2


@dataclass(frozen=True, kw_only=True)
class _Law:
    """What the areas of a definition are off by.

    Attributes
    ----------
    terms : tuple of (float, float, float)
        Powers of z, and the means and standard deviations of their coefficients.
    odd : float
        Standard deviation of what each grid is off by anew, whatever its shifts, over f z^2.
    noise : tuple of float
        Of one solve, from where the edges fall between the grid points: nu = hypot(a, b z).
    averaging : float
        All deviations but that of power 0 fall with this power of the number of patches; they are those of
        `_PATCHES`.
    """

    terms: tuple[tuple[float, float, float], ...]
    odd: float
    noise: tuple[float, float]
    averaging: float = 0.0


#: Boundary elements, edge located, from 352 surfaces (H = .1 to 1, lambda_long/lambda_short = 4 to 32, p* =
#: .01 to .6, grids of 3 to 48 points per shortest wave, tests/benchmarks/area_law.py): means of largest
#: likelihood; deviations near it, with four fifths of its noise, which rare surfaces make wider than 95 %
#: intervals ask for. Power 0 has no mean there (-.0001 +- .0002), nor on Hertzian contacts of 40 and 60 cells
#: in radius (.00004 +- .00005, .00008 +- .00003); its deviation covers other maps fitted to these surfaces.
_LOCATED = _Law(
    terms=(
        (0.0, 0.0, 0.00011),
        (1.0, -0.00359, 0.0003),
        (1.5, 0.00919, 0.00055),
        (2.0, -0.00678, 0.00015),
        (3.0, 0.00087, 0.00025),
    ),
    odd=0.0005,
    noise=(0.006, 0.026),
    averaging=0.25,
)

#: Number of patches to which the deviations of a law belong, and f^2 n / (A (1 - A)^(5/4)) of a round one.
_PATCHES, _ROUND = 80.0, 20.0

#: Largest z for which means were measured.
_WIDEST = 3.5

#: Corrected at the edge by a constant, which depends a little on what is pressed: likewise of 45 surfaces
#: with a hardness of .1 to 1.5 E* h'_rms and 30 pressed on trilinear hexahedra (nu = 0 to .4, growth 1.2).
_PERIMETER = _Law(terms=((0.0, 0.0, 0.025), (1.0, 0.0, 0.01)), odd=0.0, noise=(0.23, 0.0))

#: Power of 1 - A in z.
_GAP_POWER = 1.25

#: What edges of one direction are off by together, in cells: the same on every grid, and anew on each, where
#: they all lie alike between the points. Of straight waves in five directions; a contour of all averages it.
_ALIKE = (0.008, 0.012)

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
    edge_constant : float
        Fitted excess per edge fraction; of the located area, on the coarsest grid.
    grids : int
        Number of areas that went into the fit.
    definition : str
        Which area was extrapolated: "pixel" or "subcell".
    doubt : str
        Why there is no limit, in words, with NaN as its value and uncertainty; empty where there is one.
    """

    value: float
    uncertainty: float
    edge_constant: float
    grids: int
    definition: str = "pixel"
    doubt: str = ""

    @property
    def determinable(self) -> bool:
        """Whether there is a limit."""
        return not self.doubt


@dataclass(frozen=True, kw_only=True)
class PlannedGrid:
    """A grid that is to be solved.

    Attributes
    ----------
    spacing : tuple of float
        (dx, dy) [m].
    cells : int
        Number of its cells.
    solves : int
        Sub-grid shifts that are averaged.
    """

    spacing: tuple[float, float]
    cells: int
    solves: int = 1

    def __post_init__(self) -> None:
        dx, dy = pair("spacing", self.spacing, what="the size of a cell (dx, dy) in m")
        positive("spacing", dx, unit="m")
        positive("spacing", dy, unit="m")
        whole("cells", self.cells, least=1, most=10**15)
        whole("solves", self.solves, least=1, most=10**6)


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
        grids disagree by more than the law allows, it is widened by the factor they disagree. NaN, with a
        `doubt`, for a contact of too few points to carry the law, and for an estimate outside (0, 1].

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
    _check_areas(areas)
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
        .025 only, which several grids then tell better.

    Raises
    ------
    InvalidInput
        For no area.

    Notes
    -----
    For contours of all directions. Edges that all lie alike between the grid points are off together by more.
    """
    _check_areas(areas)
    if not areas:
        raise InvalidInput("0 areas: a limit needs at least one")
    return _limit(areas, "perimeter")


def _limit(areas: Sequence[ContactAreas], definition: Literal["subcell", "perimeter"]) -> Limit:
    doubt = too_small(areas)
    if doubt:
        return _no_limit(doubt, len(areas), definition=definition)
    law, alignment = _LOCATED if definition == "subcell" else _PERIMETER, 0.0
    groups: dict[tuple[float, float], list[ContactAreas]] = {}
    for area in areas:
        groups.setdefault(area.spacing, []).append(area)
    # Finest first: it says how long the edges are.
    shifts = [groups[spacing] for spacing in sorted(groups, key=lambda s: s[0] * s[1])]
    means = [float(np.mean([getattr(area, definition) for area in group])) for group in shifts]
    shifts = [group for group, mean in zip(shifts, means, strict=True) if mean > 0 or group is shifts[0]]
    value = np.array([mean for k, mean in enumerate(means) if mean > 0 or k == 0])
    fraction = float(np.mean([area.edge_fraction for area in shifts[0]]))
    plan = [
        PlannedGrid(spacing=group[0].spacing, cells=group[0].cells, solves=len(group)) for group in shifts
    ]
    told: dict[str, Any] = {"grids": len(areas), "definition": definition}
    if fraction == 0 or not 0 < value[0] < 1:
        return _checked(Limit(value=float(value[0]), uncertainty=0.0, edge_constant=0.0, **told))
    if definition == "subcell":
        alignment = float(np.mean([area.alignment for area in shifts[0]]))
    covariance = _covariance(law, float(value[0]), fraction, plan, alignment=alignment)
    own = np.array([np.mean([area.edge_fraction for area in group]) for group in shifts])
    expected = value - _known(law, value, own)
    weights = np.linalg.inv(covariance)
    precision = float(weights.sum())
    # Around the finest area, so that nothing is lost to rounding where all are nearly equal.
    limit = float(expected[0] + (weights @ (expected - expected[0])).sum() / precision)
    rest = expected - limit
    disagreement = float(rest @ weights @ rest) / max(len(plan) - 1, 1)
    coarsest = fraction * _size(plan[-1]) / _size(plan[0])
    return _checked(
        Limit(
            value=limit,
            uncertainty=float(np.sqrt(max(disagreement, 1.0) / precision)),
            edge_constant=float((value[-1] - limit) / coarsest),
            **told,
        )
    )


def too_small(areas: Sequence[ContactAreas]) -> str:
    """Say that the contact is too small for a limit over these grids; empty where it is not.

    Parameters
    ----------
    areas : sequence of ContactAreas
        Of one surface at one load, from one grid or more.
    """
    _check_areas(areas)
    if not areas:
        raise InvalidInput("0 areas: at least one is needed")
    finest = min(area.spacing[0] * area.spacing[1] for area in areas)
    points = float(
        np.mean([a.pixel * a.cells for a in areas if a.spacing[0] * a.spacing[1] <= finest * (1 + 1e-9)])
    )
    if points >= LEAST_CONTACT_POINTS * (1 - 1e-9):
        return ""
    count = f"{points:.3g} point{'' if round(points, 2) == 1 else 's'}"
    return f"the contact has {count} on the finest grid; a limit needs {LEAST_CONTACT_POINTS}"


def _check_areas(areas: Sequence[ContactAreas]) -> None:
    listed("areas", areas, ContactAreas, what="`ContactAreas`")


def _no_limit(doubt: str, grids: int, *, definition: str) -> Limit:
    nan = float("nan")
    return Limit(
        value=nan, uncertainty=nan, edge_constant=nan, grids=grids, definition=definition, doubt=doubt
    )


def _checked(limit: Limit) -> Limit:
    """Return a limit that is a share of the nominal area, or none."""
    # Fits of complete contact end at 1 but for rounding.
    if 0 < limit.value <= 1 + 1e-12:
        return limit
    doubt = f"the grids extrapolate to A/A0 = {limit.value:.3g}, which is no share of an area"
    return _no_limit(doubt, limit.grids, definition=limit.definition)


def predicted_uncertainty(coarse: ContactAreas, grids: Sequence[PlannedGrid]) -> float:
    """Return the standard error that a limit will claim from grids not solved yet; inf if none.

    Parameters
    ----------
    coarse : ContactAreas
        Of any grid of the same surface at the same load: says how large the contact is, how long its edges,
        and whether they are located, for `located_limit`, or corrected, for `perimeter_limit`.
    grids : sequence of PlannedGrid
    """
    instance("coarse", coarse, ContactAreas, what="`ContactAreas`")
    listed("grids", grids, PlannedGrid, what="`PlannedGrid`s")
    if not grids:
        raise InvalidInput("grids: at least one is needed")
    area = coarse.pixel if coarse.subcell is None else coarse.subcell
    area = min(max(area, coarse.cell_share), 1 - coarse.cell_share)
    if coarse.edge_fraction == 0:
        return 0.0
    ordered = sorted(grids, key=_size)
    if area * ordered[0].cells < LEAST_CONTACT_POINTS:
        return float("inf")
    size = np.sqrt(coarse.spacing[0] * coarse.spacing[1])
    fraction = coarse.edge_fraction * _size(ordered[0]) / float(size)
    located = coarse.subcell is not None
    covariance = _covariance(
        _LOCATED if located else _PERIMETER,
        area,
        fraction,
        ordered,
        alignment=coarse.alignment if located else 0.0,
    )
    return float(1 / np.sqrt(np.linalg.inv(covariance).sum()))


def _size(grid: PlannedGrid) -> float:
    return float(np.sqrt(grid.spacing[0] * grid.spacing[1]))


def _known(law: _Law, areas: Array, fractions: Array) -> Array:
    """Return what areas are off by on average."""
    inside = np.clip(areas, 1e-9, 1 - 1e-9)
    width = np.minimum(fractions / (inside * (1 - inside) ** _GAP_POWER), _WIDEST)
    return fractions * sum(mean * width**power for power, mean, _ in law.terms)


def _covariance(
    law: _Law, area: float, fraction: float, grids: Sequence[PlannedGrid], *, alignment: float
) -> Array:
    """Covariance of the areas of grids, the first of which has the edge fraction given."""
    fractions = fraction * np.array([_size(grid) for grid in grids]) / _size(grids[0])
    width = fractions / (area * (1 - area) ** _GAP_POWER)
    patches = fraction * width[0] * grids[0].cells / _ROUND
    spread = (max(patches, 1.0) / _PATCHES) ** -law.averaging
    terms = np.stack(
        [
            fractions * width**power * deviation * (spread if power else 1.0)
            for power, _, deviation in law.terms
        ],
        axis=1,
    )
    noise = np.hypot(law.noise[0], law.noise[1] * width) ** 2 * fractions
    each = np.array([grid.cells * grid.solves for grid in grids])
    common, anew = (alignment * deviation * fractions for deviation in _ALIKE)
    solves = np.array([grid.solves for grid in grids])
    odd = law.odd * spread * fractions * width**2
    own = noise / each + anew**2 / solves + odd**2
    return np.asarray(terms @ terms.T + np.outer(common, common) + np.diag(own))


def limit_area(
    areas: Sequence[ContactAreas],
    *,
    definition: Literal["pixel", "subcell"] = "pixel",
    known_constant: tuple[float, float] | None = None,
) -> Limit:
    """Limit of the contact area of one surface over its grids, by regression of fixed order.

    The pixel area is fitted as A + c (P_edge dx), the located one as A + c (P_edge dx) dx; the order is not
    fitted, since the order observed on a few grids scatters too much to extrapolate with. Where an edge falls
    between grid points is random, so the area of one grid scatters like (number of edges)^(1/2) dx dy, and
    each grid is weighted accordingly.

    Parameters
    ----------
    areas : sequence of ContactAreas
        Of one surface at one load, on at least three grids, not all of one spacing; several shifts of a grid
        may appear.
    definition : {"pixel", "subcell"}
        Which area is extrapolated.
    known_constant : tuple of float, optional
        What is known of c beforehand, and its standard deviation, as ``(EDGE_CONSTANTS["bem"], 0.01)``. It
        enters like a measurement, and steadies the limit of a few coarse grids. Pixel areas only.

    Raises
    ------
    InvalidInput
        For fewer than three areas, areas of a single spacing, or a definition that was not measured.
    """
    listed("areas", areas, ContactAreas, what="`ContactAreas`")
    choice("definition", definition, ("pixel", "subcell"))
    if known_constant is not None:
        known, spread = pair("known_constant", known_constant, what="a constant and its deviation")
        known_constant = finite("known_constant", known), positive("known_constant", spread)
    sizes = {area.spacing for area in areas}
    if len(areas) < 3 or len(sizes) < 2:
        raise InvalidInput(
            f"{len(areas)} areas on {len(sizes)} spacings: a limit needs three areas on at least two spacings"
        )
    if definition == "subcell" and (
        known_constant is not None or any(area.subcell is None for area in areas)
    ):
        raise InvalidInput("definition = 'subcell': not measured by contact_areas, or given a constant")
    fraction = np.array([area.edge_fraction for area in areas])
    cell = np.array([area.spacing[0] * area.spacing[1] for area in areas])
    value = np.array([area.pixel if definition == "pixel" else area.subcell for area in areas], dtype=float)
    if not np.any(fraction):
        mean = float(value.mean())
        return Limit(value=mean, uncertainty=0.0, edge_constant=0.0, grids=len(areas), definition=definition)
    size = np.sqrt(cell / cell.max())
    deviation = np.sqrt(fraction) * size
    deviation = np.maximum(deviation / deviation.max(), 1e-3)
    excess = fraction if definition == "pixel" else fraction * size
    design = np.stack([np.ones_like(excess), excess], axis=1) / deviation[:, None]
    target = value / deviation
    if known_constant is not None:
        # In units of the scatter of the coarsest grid: .2 cells per edge, as Hertzian contacts show.
        coarsest = int(np.argmax(np.sqrt(fraction) * size))
        scatter = _SCATTER * np.sqrt(fraction[coarsest] * areas[coarsest].cell_share)
        design = np.vstack([design, [0.0, scatter / known_constant[1]]])
        target = np.append(target, known_constant[0] * scatter / known_constant[1])
    limit, constant, error = _least_squares(design, target)
    return Limit(
        value=limit, uncertainty=error, edge_constant=constant, grids=len(areas), definition=definition
    )


def _least_squares(design: NDArray[np.float64], target: NDArray[np.float64]) -> tuple[float, float, float]:
    """Intercept and slope of equations of equal weight, and the standard error of the intercept."""
    (intercept, slope), *_ = np.linalg.lstsq(design, target)
    rest = target - design @ np.array([intercept, slope])
    variance = float(rest @ rest) / (target.size - 2)
    covariance = variance * np.linalg.pinv(design.T @ design)
    return float(intercept), float(slope), float(np.sqrt(covariance[0, 0]))
