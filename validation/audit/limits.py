"""The limit of the contact area over grids, from the stored fields of one surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

__all__ = ["Limit", "limit_over"]


class Areas(Protocol):
    """The areas of one surface on one grid and shift, by definition."""

    @property
    def spacing(self) -> tuple[float, float]:
        """(dx, dy)."""

    @property
    def cells(self) -> int:
        """Number of cells."""

    @property
    def pixel(self) -> float:
        """Counted."""

    @property
    def perimeter(self) -> float:
        """Corrected at its edge."""

    @property
    def edges(self) -> float:
        """Edges over cells."""

    @property
    def subcell(self) -> float:
        """With its edge located."""

    @property
    def alignment(self) -> float:
        """How far the contour runs in one direction."""


#: Powers of the width in the error law, means and deviations of their coefficients; noise; least contact.
_LAW = {
    0.0: (0.0, 0.00011),
    1.0: (-0.00359, 0.0003),
    1.5: (0.00919, 0.00055),
    2.0: (-0.00678, 0.00015),
    3.0: (0.00087, 0.00025),
}
_GAP_POWER, _NOISE, _LEAST_POINTS = 1.25, (0.006, 0.026), 16
#: What each grid is off by anew, over edges times width squared; largest width of the means; patches to which
#: the deviations belong, what one counts, and the power with which they fall.
_ODD, _WIDEST, _PATCHES, _ROUND, _AVERAGING = 0.0005, 3.5, 80.0, 20.0, 0.25
#: Likewise of the area that is corrected by a constant.
_CORRECTED, _CORRECTED_NOISE = {0.0: (0.0, 0.025), 1.0: (0.0, 0.01)}, (0.23, 0.0)
#: What edges that lie alike between the grid points are off by: on every grid, and anew on each, in cells.
_ALIKE = (0.008, 0.012)


@dataclass(frozen=True, kw_only=True)
class Limit:
    """A/A0 for vanishing spacing, its standard error, number of solves and the area extrapolated."""

    value: float
    error: float
    solves: int
    definition: str


def limit_over(solves: Sequence[Areas], *, located: bool) -> Limit | None:
    """Return the limit, or None where these grids do not give one."""
    groups: dict[tuple[float, float], list[Areas]] = {}
    for one in solves:
        groups.setdefault(one.spacing, []).append(one)
    if len(groups) < 2:
        return None
    grids = [groups[key] for key in sorted(groups, key=lambda s: s[0] * s[1])]
    if np.mean([one.pixel * one.cells for one in grids[0]]) < _LEAST_POINTS * (1 - 1e-9):
        return None
    found = _best(grids, located=located)
    limit = Limit(
        value=found[0], error=found[1], solves=len(solves), definition="subcell" if located else "perimeter"
    )
    return limit if 0 < limit.value <= 1 + 1e-12 else None


def _best(grids: Sequence[Sequence[Areas]], *, located: bool) -> tuple[float, float]:
    """Best estimate of A from areas whose errors are correlated as the error law says."""
    means = [float(np.mean([one.subcell if located else one.perimeter for one in group])) for group in grids]
    used = [k for k, mean in enumerate(means) if mean > 0 or k == 0]
    area = np.array([means[k] for k in used])
    step = np.array([math.sqrt(grids[k][0].spacing[0] * grids[k][0].spacing[1]) for k in used])
    fraction = float(np.mean([one.edges for one in grids[0]])) * step / step[0]
    if fraction[0] == 0 or not 0 < area[0] < 1:
        return float(area[0]), 0.0
    z = fraction / (area[0] * (1 - area[0]) ** _GAP_POWER)
    count = np.array([len(grids[k]) * grids[k][0].cells for k in used])
    law, noise, odd = (_LAW, _NOISE, _ODD) if located else (_CORRECTED, _CORRECTED_NOISE, 0.0)
    few = 1.0
    if located:
        few = (_PATCHES / max(fraction[0] * z[0] * grids[0][0].cells / _ROUND, 1.0)) ** _AVERAGING
    spread = np.diag(
        fraction * (noise[0] ** 2 + (noise[1] * z) ** 2) / count + (odd * few * fraction * z * z) ** 2
    )
    own = np.array([float(np.mean([one.edges for one in grids[k]])) for k in used])
    wide = np.minimum(own / (area * np.maximum(1 - area, 1e-9) ** _GAP_POWER), _WIDEST)
    for power, (mean, deviation) in law.items():
        term = (few if power else 1.0) * deviation * fraction * z**power
        spread = spread + np.outer(term, term)
        area = area - mean * own * wide**power
    aligned = fraction * (float(np.mean([one.alignment for one in grids[0]])) if located else 0.0)
    shifts = np.array([len(grids[k]) for k in used])
    spread = (
        spread + np.outer(aligned, aligned) * _ALIKE[0] ** 2 + np.diag((_ALIKE[1] * aligned) ** 2 / shifts)
    )
    ones = np.ones(area.size)
    weight = np.linalg.solve(spread, ones)
    value = float(area[0] + weight @ (area - area[0]) / weight.sum())
    rest = area - value
    misfit = float(rest @ np.linalg.solve(spread, rest)) / max(area.size - 1, 1)
    return value, math.sqrt(max(1.0, misfit) / float(weight.sum()))
