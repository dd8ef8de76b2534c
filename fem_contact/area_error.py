r"""What contact areas of a grid are off by: the law of error that limits over grids rest on.

The area with its edge located inside the cells (`fem_contact.area.subcell_area`) is off by

.. math:: A_h - A = f \left( k_0 + k_1 z + k_{3/2} z^{3/2} + k_2 z^2 + k_3 z^3 \right)
          + f^{1/2} n^{-1/2} \nu(z), \qquad z = \frac{f}{A (1 - A)^{5/4}}

where f is the edge fraction, in proportion to the spacing, z is the spacing in units of the width of the
contact patches (near full contact, of a little less than that of the gaps), n the number of cells and nu a
random number. The edge map takes out the first order, of contours of all directions, but for k_0, which is
what another map fitted to the same surfaces says; and of the second order what can be known: how the fields
bend beside the edge. Where the contour runs in one direction (`ContactAreas.alignment`), as that of a wave
does, f (k_a + k'_h) is left, too, and more where z is large. The half power follows from the square-root
fields of the edge.

The coefficients k depend on surface and load, and k' on the grid, too: on a few grids they cannot all be
fitted, and leaving one out makes any fit look better than it is. They are therefore taken as random numbers,
whose means and sizes were measured, and the limit is what the areas of the grids at hand then say of A, with
the spread that remains. Each patch of contact has its own, so that they differ the less from surface to
surface the more patches there are; and the more the further a surface is from isotropic ones that the grid
resolves (`ContactAreas.anisotropy`, `unresolved`). At kinks and steps areas converge with f or slower: there
the limit is as uncertain as the grids disagree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fem_contact._checks import pair, positive, whole
from fem_contact._types import Array, Lengths
from fem_contact.area import EDGE_CONSTANTS, ContactAreas


@dataclass(frozen=True, kw_only=True)
class PlannedGrid:
    """A grid that is to be solved."""

    spacing: Lengths  # (dx, dy) [m]
    cells: int  # Number of its cells
    solves: int = 1  # Sub-grid shifts that are averaged

    def __post_init__(self) -> None:
        pair("spacing", self.spacing, positive, what="the size of a cell (dx, dy) in m")
        whole("cells", self.cells, least=1, most=10**15)
        whole("solves", self.solves, least=1, most=10**6)

    @property
    def size(self) -> float:
        """Root of the area of a cell [m]."""
        return float(np.sqrt(self.spacing[0] * self.spacing[1]))


@dataclass(frozen=True, kw_only=True)
class ErrorLaw:
    """What the areas of a definition are off by."""

    # Powers of z, and the means and standard deviations of their coefficients.
    terms: tuple[tuple[float, float, float], ...]
    odd: float  # Standard deviation of what each grid is off by anew, whatever its shifts, over f z^2
    # Of one solve, from where the edges fall between the grid points: nu = hypot(a, b z)
    noise: tuple[float, float]
    # What edges of one direction are off by together, in cells, a + b z: the same on every grid; and
    # anew on each, where it falls with the root of the number of lines.
    alike: tuple[tuple[float, float], tuple[float, float]]
    # All deviations but that of power 0 fall with this power of the number of patches; they are those
    # of `_PATCHES`.
    averaging: float = 0.0


#: Boundary elements, edge located, from 352 surfaces (H = .1 to 1, lambda_long/lambda_short = 4 to 32, p* =
#: .01 to .6, grids of 3 to 48 points per shortest wave, tests/benchmarks/area_law.py): means of largest
#: likelihood; deviations near it, with four fifths of its noise, which rare surfaces make wider than 95 %
#: intervals ask for. Power 0 has no mean there (-.0001 +- .0002), nor on Hertzian contacts of 40 and 60 cells
#: in radius (.00004 +- .00005, .00008 +- .00003); its deviation covers other maps fitted to these surfaces.
LOCATED = ErrorLaw(
    terms=(
        (0.0, 0.0, 0.00011),
        (1.0, -0.00359, 0.0003),
        (1.5, 0.00919, 0.00055),
        (2.0, -0.00678, 0.00015),
        (3.0, 0.00087, 0.00025),
    ),
    odd=0.0005,
    noise=(0.006, 0.026),
    alike=((0.0075, 0.01), (0.003, 0.03)),
    averaging=0.25,
)

#: Number of patches to which the deviations of a law belong, and f^2 n / (A (1 - A)^(5/4)) of a round one.
_PATCHES, _ROUND = 80.0, 20.0
#: Share of its deviations that a surface of ever so many patches keeps: lambda_long/lambda_short to 64.
_LEAST_SPREAD = 0.8
#: Largest z for which means were measured.
WIDEST = 3.5

#: Corrected at the edge by a constant, which depends a little on what is pressed: likewise of 240 surfaces on
#: boundary elements (with a hardness of .1 to 1.5 E* h'_rms, layers, adhesion, a free boundary).
_PERIMETER = ErrorLaw(
    terms=((0.0, 0.0, 0.02), (1.0, 0.0, 0.01)), odd=0.0, noise=(0.23, 0.0), alike=((0.05, 0.0), (0.3, 0.0))
)

#: By power of z, what means and deviations of its coefficients gain for each unit by which the constant
#: exceeds that of boundary elements: the softer cells are at the spacing of the grid, the more they err in
#: second order, too. Of 510 surfaces on hexahedra: trilinear ones at nu = 0 to .4, others there, at .49, .5.
_SOFT = ((-0.15, 0.15), (0.15, 0.08))
#: Power of 1 - A in z.
GAP_POWER = 1.25
#: Deviations grow by the first for each unit of anisotropy beyond the second, which isotropic surfaces of few
#: waves have by chance; and by the third where the first share of the curvature is unresolved, less below it
#: with its fourth root.
_ANISOTROPIC, _CHANCE = 6.5, 0.12
_COARSE, _COARSE_SHARE = 1.5, 0.05
#: Patches may be wide, but their edges are no smoother than the heights: least z over the wavenumber.
_NARROW = 1.5
#: Unresolved shares from which and beyond which heights count as kinked; error at kinks that grids may not
#: show, and that of a single grid [cells].
_KINKED, _HIDDEN, _UNSEEN = (0.05, 0.2), 0.02, 0.15
#: Unresolved share of heights with steps: at .9 their areas were off by half at 4, 6 and 8 points per wave,
#: which nearly agreed.
_STEPS = 0.7
#: A single grid is told its error by the law alone, from which surfaces differ by so much.
ALONE = 1.1


def perimeter_law(edge_constant: float) -> ErrorLaw:
    """Law of error of areas that are corrected at their edge by a constant."""
    soft = edge_constant - EDGE_CONSTANTS["bem"]
    terms = (
        (power, mean * soft, float(np.hypot(deviation, wider * soft)))
        for (power, _, deviation), (mean, wider) in zip(_PERIMETER.terms, _SOFT, strict=True)
    )
    return replace(_PERIMETER, terms=tuple(terms))


def mean_error(law: ErrorLaw, areas: Array, fractions: Array) -> Array:
    """Return what areas are off by on average."""
    inside = np.clip(areas, 1e-9, 1 - 1e-9)
    width = np.minimum(fractions / (inside * (1 - inside) ** GAP_POWER), WIDEST)
    return fractions * sum(mean * width**power for power, mean, _ in law.terms)


def error_covariance(
    law: ErrorLaw, area: float, fraction: float, grids: Sequence[PlannedGrid], *, like: ContactAreas
) -> Array:
    """Covariance of the errors of A/A0 on several grids of a surface, by the law that was calibrated.

    Three parts: power laws of the cell's size over the width of a patch, common to all grids; how the grid
    lies on the surface (``alignment``), common in part; noise of each grid, less with its cells and solves.
    The fraction is the share of cells at an edge of contact on the first grid, from which others follow;
    `like` tells what was measured: anisotropy, wavenumber of the edges, unresolved curvature.
    """
    fractions = fraction * np.array([grid.size for grid in grids]) / grids[0].size
    width = fractions / (area * (1 - area) ** GAP_POWER)
    patches = fraction * width[0] * grids[0].cells / _ROUND
    width = np.maximum(width, _NARROW * like.wavenumber * fractions / like.edge_fraction)
    spread = max((max(patches, 1.0) / _PATCHES) ** -law.averaging, _LEAST_SPREAD if law.averaging else 0.0)
    spread *= 1 + _ANISOTROPIC * max(like.anisotropy - _CHANCE, 0.0)
    spread += _COARSE * min(like.unresolved / _COARSE_SHARE, 1.0) ** 0.25
    terms = np.stack(
        [
            fractions * width**power * deviation * (spread if power else 1.0)
            for power, _, deviation in law.terms
        ],
        axis=1,
    )
    noise = np.hypot(law.noise[0], law.noise[1] * width) ** 2 * fractions
    each = np.array([grid.cells * grid.solves for grid in grids])
    common, anew = (like.alignment * (a + b * width) * fractions for a, b in law.alike)
    lines = np.sqrt(max(patches, 1.0)) * np.array([grid.solves for grid in grids])
    odd = law.odd * spread * fractions * width**2
    variances = noise / each + anew**2 / lines + odd**2
    return np.asarray(terms @ terms.T + np.outer(common, common) + np.diag(variances))


def kinked(areas: ContactAreas) -> float:
    """How far heights count as kinked: 0 where the grid resolves them, 1 where it certainly does not."""
    low, high = _KINKED
    return min(max((areas.unresolved - low) / (high - low), 0.0), 1.0)


def too_rough(finest: ContactAreas, *, alone: bool) -> str:
    """Say why grids do not tell what kinks and steps of the heights leave; empty where they do."""
    share = f"{finest.unresolved:.0%} of the curvature of the heights is in waves of less than four points"
    if kinked(finest) == 1 and alone:
        return f"{share} (kinks, steps or a coarse grid): one grid does not tell its error, press another"
    if finest.unresolved >= _STEPS:
        return f"{share}: the heights have steps, at which areas do not converge on such grids"
    if kinked(finest) > 0 and finest.edge_fraction == 0:
        return f"{share} (kinks), and the finest grid touches everywhere: press a finer one"
    return ""


def kink_error(areas: ContactAreas, *, alone: bool) -> float:
    """Error of an area at kinks that grids do not show: they may agree by chance, or there is but one."""
    return kinked(areas) * (_UNSEEN if alone else _HIDDEN) * areas.edge_fraction
