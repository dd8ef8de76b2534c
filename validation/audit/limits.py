"""The limit of the contact area over grids, from the stored fields of one surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from validation.audit.stored import Pair

#: What contour and heights are like.
TRAITS = ("alignment", "anisotropy", "unresolved", "wavenumber")


#: Of one surface on one grid and shift: `pixel` counted, `perimeter` corrected, `subcell` where its edge is
#: `located`, `spacing`, `cells`, `edges` over cells, and traits.
Areas: TypeAlias = Any

#: Powers of the width in the error law, means and deviations of their coefficients; noise; least contact.
_LAW = {
    0.0: (0.0, 0.00011),
    1.0: (-0.00359, 0.0003),
    1.5: (0.00919, 0.00055),
    2.0: (-0.00678, 0.00015),
    3.0: (0.00087, 0.00025),
}
_GAP_POWER, _NOISE, LEAST_POINTS = 1.25, (0.006, 0.026), 16
#: What each grid is off by anew, over edges times width squared; largest width of the means; patches to which
#: the deviations belong, what one counts, and the power with which they fall.
_ODD, _WIDEST, _PATCHES, _ROUND, _AVERAGING = 0.0005, 3.5, 80.0, 20.0, 0.25
#: Likewise of the area that is corrected by a constant; what means and deviations gain for each unit by which
#: it exceeds that of boundary elements.
_CORRECTED, _CORRECTED_NOISE = {0.0: (0.0, 0.02), 1.0: (0.0, 0.01)}, (0.23, 0.0)
_SOFTER, _CONSTANT = {0.0: (-0.15, 0.15), 1.0: (0.15, 0.08)}, 0.103
#: What edges that lie alike between the grid points are off by, in cells and over the width: on every grid,
#: and anew on each; likewise of the corrected area.
_ALIKE, _CORRECTED_ALIKE = ((0.0075, 0.01), (0.003, 0.03)), ((0.05, 0.0), (0.3, 0.0))
#: Growth of the deviations with anisotropy beyond what is chance; with a share of the curvature that is
#: unresolved; least share of them on many patches; least width over wavenumber.
_ANISOTROPIC, _CHANCE, _COARSE, _COARSE_SHARE, _LEAST, _NARROW = 6.5, 0.12, 1.5, 0.05, 0.8, 1.5
#: Unresolved shares between which heights become kinked, and that of steps; error there that grids may not
#: show, and of one, in cells.
_SMOOTH, _KINKED, _STEPS, _HIDDEN, _UNSEEN = 0.05, 0.2, 0.7, 0.02, 0.15


def limit_over(solves: Sequence[Areas]) -> Pair:
    """A/A0 for vanishing spacing and its standard error; NaN where these grids do not give it.

    It is of the area whose edge is located where it is in all solves, else of the corrected one.
    """
    groups: dict[Pair, list[Areas]] = {}
    for one in solves:
        groups.setdefault(one.spacing, []).append(one)
    grids = [groups[key] for key in sorted(groups, key=math.prod)]
    few = not grids or np.mean([one.pixel * one.cells for one in grids[0]]) < LEAST_POINTS * (1 - 1e-9)
    value, error = (math.nan, math.nan) if few else _best(grids, located=all(one.located for one in solves))
    return (value, error) if 0 < value <= 1 + 1e-12 else (math.nan, math.nan)


def _mean(group: Sequence[Areas], name: str) -> float:
    return float(np.mean([getattr(one, name) for one in group]))


def _best(grids: Sequence[Sequence[Areas]], *, located: bool) -> Pair:
    """Best estimate of A from areas whose errors are correlated as the error law says."""
    name = "subcell" if located else "perimeter"
    finest = {trait: _mean(grids[0], trait) for trait in (*TRAITS, "edges", "pixel", name)}
    used = [group for k, group in enumerate(grids) if k == 0 or _mean(group, name) > 0]
    area, own = (np.array([_mean(group, of) for group in used]) for of in (name, "edges"))
    step = np.array([math.sqrt(math.prod(group[0].spacing)) for group in used])
    fraction, unresolved = own[0] * step / step[0], finest["unresolved"]
    # Kinks that one grid or one in full contact says nothing of, and steps.
    if unresolved > _SMOOTH and (fraction[0] == 0 or unresolved >= (_STEPS if area.size > 1 else _KINKED)):
        return math.nan, math.nan
    if fraction[0] == 0 or not 0 < area[0] < 1:
        return float(area[0]), 0.0
    z = fraction / (area[0] * (1 - area[0]) ** _GAP_POWER)
    shifts = np.array([len(group) for group in used])
    count = shifts * [group[0].cells for group in used]
    law, noise, odd = (_LAW, _NOISE, _ODD) if located else (_CORRECTED, _CORRECTED_NOISE, 0.0)
    if not located:  # what was taken off is the constant times the edges
        soft = (finest["pixel"] - area[0]) / fraction[0] - _CONSTANT
        law = {k: (a * soft, math.hypot(law[k][1], b * soft)) for k, (a, b) in _SOFTER.items()}
    patches = max(fraction[0] * z[0] * grids[0][0].cells / _ROUND, 1.0)
    few = max((_PATCHES / patches) ** _AVERAGING, _LEAST) if located else 1.0
    few = few * (1 + _ANISOTROPIC * max(finest["anisotropy"] - _CHANCE, 0.0))
    few += _COARSE * min(unresolved / _COARSE_SHARE, 1.0) ** 0.25
    z = np.maximum(z, _NARROW * finest["wavenumber"] * fraction / fraction[0])
    common, anew = (
        finest["alignment"] * fraction * (a + b * z) for a, b in (_ALIKE if located else _CORRECTED_ALIKE)
    )
    spread = np.outer(common, common) + np.diag(
        fraction * (noise[0] ** 2 + (noise[1] * z) ** 2) / count
        + (odd * few * fraction * z * z) ** 2
        + anew**2 / (np.sqrt(patches) * shifts)
    )
    wide = np.minimum(own / (area * np.maximum(1 - area, 1e-9) ** _GAP_POWER), _WIDEST)
    raw = area
    for power, (mean, deviation) in law.items():
        term = (few if power else 1.0) * deviation * fraction * z**power
        spread = spread + np.outer(term, term)
        area = area - mean * own * wide**power
    weight = np.linalg.solve(spread, np.ones(area.size))
    value = float(area[0] + weight @ (area - area[0]) / weight.sum())
    rest = area - value
    # What one grid is told by the law alone is a tenth wider.
    misfit = float(rest @ np.linalg.solve(spread, rest)) / (area.size - 1) if area.size > 1 else 1.1**2
    error = math.sqrt(max(1.0, misfit) / weight.sum())
    if unresolved <= _SMOOTH:
        return value, error
    kinked = min((unresolved - _SMOOTH) / (_KINKED - _SMOOTH), 1.0)
    # As if areas converged in first order, and never better than some share of a cell.
    apart = np.abs(raw[1:] - raw[0]) * step[0] / (step[1:] - step[0])
    hidden = (_HIDDEN if apart.size else _UNSEEN) * fraction[0]
    return value, math.hypot(error, kinked * apart.max(initial=0.0), kinked * hidden)
