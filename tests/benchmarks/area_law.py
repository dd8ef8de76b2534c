"""Fit the second part of the edge map and the law of error of the limits, and see whether they hold.

Random surfaces of H = .1 to 1, lambda_long/lambda_short = 4 to 32, at p* = .01 to .6, pressed from coarse
grids to fine: elastic ones; on trilinear hexahedra, nu = 0 to .4; with every effect of a scene (`KINDS`); and
surfaces unlike those of the law (`SHAPES`): wide bands, stretched, smooth but not Gaussian, with kinks.

Run as ``python tests/benchmarks/area_law.py fit`` (some five minutes), ``... law`` (fifteen) or ``... check
[kind] [surfaces] [first seed]``, one solve on each grid.

`fit` gives the second part of the edge map of `fem_contact.area`: coefficients within .011, and areas within
2e-5 of themselves from 4 points per shortest wave on. The monomials nearly depend on each other, so that
rounding moves coefficients but no area (the first fit read fields of single precision).

`law` gives what is left: means and deviations of largest likelihood. Those in use came from the same
surfaces, the first 140 of them on fewer shifts. Their noise is four fifths of the most likely one: a few
surfaces far off make it wider than intervals of 95 % ask for.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from area_cases import Case

from fem_contact import ContactAreas, Limit, contact_areas, located_limit, perimeter_limit, subgrid_shifts
from fem_contact.area import EDGE_MAPS, contact_edges
from fem_contact.area_error import GAP_POWER, LOCATED, WIDEST, ErrorLaw, PlannedGrid, error_covariance

#: Seeds of the surfaces to which the edge map is fitted, and to which the law of error.
FITTED = range(1, 141)
LAW = (*FITTED, *range(1001, 1115), *range(5001, 5099))

#: Points per shortest wave, with the number of shifts of each along an axis; the last stand for the truth.
LEVELS = {3: 2, 4: 2, 6: 2, 8: 2, 10: 1, 12: 1, 16: 1, 24: 1, 32: 1, 48: 1}
TRUTH = (24, 32, 48)

#: Shifts of the grids that are fitted, the first alone where they are fine; powers of z of what the first
#: part of the map leaves.
_SHIFTS = ((0.0, 0.0), (0.5, 0.5))
_POWERS = (1, 1.5, 2, 3)

#: Grids that are extrapolated together.
LADDERS = (
    *((4,), (8,), (16,), (4, 6), (4, 8), (8, 12), (8, 16)),
    *((3, 4, 6), (4, 6, 8), (6, 8, 12), (8, 12, 16)),
)


def measured(case, levels):
    """Return the areas of one surface at every level and shift."""
    return {
        level: [
            contact_areas(case.pressed(level, shift), subcell=case.located)
            # A patch with edges cannot be moved under the grid.
            for shift in subgrid_shifts(1 if case.kind in ("ball", "patch") else shifts)
        ]
        for level, shifts in levels.items()
    }


def limit_of(areas, ladder, *, limit, truth):
    """Return how far the limit of a ladder is off, over both uncertainties, and its own relative one."""
    found = limit([area for level in ladder for area in areas[level]])
    if not found.determinable:
        return 0.0, np.nan
    # Full contact is certain.
    both = max(float(np.hypot(found.uncertainty, truth.uncertainty)), 1e-15)
    return (found.value - truth.value) / both, found.uncertainty / found.value


def coverage(kind, surfaces, first):
    """Return distances from the truth over uncertainties, and relative ones, by ladder and surface."""
    rows = []
    # Wide bands take too long on the finest grids.
    levels = dict.fromkeys([level for level in LEVELS if kind != "wide" or level <= 24], 1)
    levels |= {96: 1} if kind == "kinked" else {}
    for seed in range(first, first + surfaces):
        case = Case.drawn(seed, kind=kind, waves=32 if kind == "elastic" else 16)
        areas = measured(case, levels)
        limit = located_limit if case.located else perimeter_limit
        rows.append([limit_of(areas, ladder, limit=limit, truth=truth_of(case, areas)) for ladder in LADDERS])
    return np.swapaxes(rows, 0, 1)


def truth_of(case, areas):
    """Limit over the finest grids; in first order from two of them where heights have kinks."""
    if case.kind != "kinked":
        fine = [area for level in TRUTH if level in areas for area in areas[level]]
        return (located_limit if case.located else perimeter_limit)(fine or areas[16] + areas[24])
    coarse, fine = (areas[level][0].subcell for level in (48, 96))
    assert coarse is not None
    assert fine is not None
    half = (fine - coarse) / 2
    return Limit(value=fine + half, uncertainty=abs(half) + 1e-12, grids=2, definition="subcell")


def check(kind, surfaces, first=1001):
    """Print how far limits are off on surfaces that were not fitted, over what they claim."""
    for ladder, both in zip(LADDERS, coverage(kind, surfaces, first), strict=True):
        off, share = both[np.isfinite(both[:, 1])].T
        if not off.size:
            print(f"{ladder!s:>14}: no limits")
            continue
        print(
            f"{ladder!s:>14}: {off.size} of {len(both)} limits, held {np.mean(np.abs(off) < 2):.3f}, mean "
            f"{off.mean():+.2f}, root mean square {np.sqrt(np.mean(off**2)):.2f}, worst "
            f"{np.abs(off).max():.1f}; two standard errors, median {200 * np.median(share):.3f} %"
        )


@dataclass(frozen=True, kw_only=True)
class _Row:
    """What a solve of a fitted surface says: sums of the features over its edges, in cells."""

    level: int
    cells: int
    fraction: float
    plain: float
    islands: float
    sums: np.ndarray


def _rows(case):
    """Solve the levels of one surface; `plain` is the area by the first part of the edge map alone."""
    straight = np.array(EDGE_MAPS["bem"])
    bends = contact_edges(case.pressed(4, (0.0, 0.0))).bends().shape[1]
    straight[-bends:] = 0.0
    rows = []
    for level in LEVELS:
        for shift in _SHIFTS if level < min(TRUTH) else _SHIFTS[:1]:
            result = case.pressed(level, shift)
            areas, edges = contact_areas(result, subcell=True, edge_map=straight), contact_edges(result)
            assert areas.subcell is not None
            rows.append(
                _Row(
                    level=level,
                    cells=areas.cells,
                    fraction=areas.edge_fraction,
                    plain=areas.subcell,
                    islands=_islands(result.in_contact),
                    sums=edges.cosine**2 @ edges.bends(),
                )
            )
    return rows


def _islands(contact):
    """Patches less holes of a periodic contact map, from its corners."""
    corners = contact.astype(int)
    for axis in (0, 1):
        corners = corners + np.roll(corners, -1, axis)
    return float(np.count_nonzero(corners == 1) - np.count_nonzero(corners == 3)) / 4


def _truth(rows):
    """Limit of the area without the second order, and its standard error, from the finest four grids.

    What the error is on average, by patches less holes, and the deviations of the rest are of largest
    likelihood on the same surfaces.
    """
    finest = {row.cells: row for row in reversed(rows) if row.level >= 16 and row.plain > 0}
    fine = [finest[cells] for cells in sorted(finest, reverse=True)]
    cells, plain = np.array([row.cells for row in fine]), np.array([row.plain for row in fine])
    f = fine[0].fraction * np.sqrt(cells[0] / cells)
    z = f / (plain[0] * (1 - plain[0]) ** 1.25)
    value = plain + 0.712 * np.array([row.islands for row in fine]) / cells
    value -= 0.011 * f * z + 0.0066 * f * z**1.5
    orders = np.stack(
        [s * f * z**k for s, k in zip((0.0042, 0.0034, 0.00125, 0.00067), _POWERS, strict=True)]
    )
    weights = np.linalg.inv(orders.T @ orders + np.diag(np.hypot(0.0127, 0.0388 * z) ** 2 * f / cells))
    limit = float(weights.sum(axis=0) @ value / weights.sum())
    scatter = float((value - limit) @ weights @ (value - limit)) / max(len(fine) - 1, 1)
    return limit, float(np.sqrt(max(scatter, 1.0) / weights.sum()))


def fit(seeds=FITTED):
    """Print the second part of the edge map."""
    surfaces = [_rows(Case.drawn(seed)) for seed in seeds]
    truths = [_truth(rows) for rows in surfaces]
    # The finest grids serve the truth alone.
    surfaces = [[row for row in rows if row.level < max(LEVELS)] for rows in surfaces]
    design, target, weight = [], [], []
    for rows, (truth, error) in zip(surfaces, truths, strict=True):
        for row in rows:
            z = row.fraction / (truth * (1 - truth) ** 1.25)
            edges = row.fraction * row.cells
            design.append(row.sums)
            target.append((truth - row.plain) * row.cells)
            # Noise of a hundredth of a cell per edge, error of the truth, what is left of the second order.
            noise, left = 0.0002 * edges, 0.002 * z**2 * edges
            weight.append(1 / np.sqrt(noise + (error * row.cells) ** 2 + left**2))
    scale = np.array(weight)
    matrix = np.array(design) * scale[:, None]
    normal = matrix.T @ matrix
    bends = np.linalg.solve(normal + 1e-10 * np.diag(np.diag(normal)), matrix.T @ (np.array(target) * scale))
    print("second part of the edge map:", np.array2string(bends.reshape(-1, 6), precision=5, separator=", "))


@dataclass(frozen=True, kw_only=True)
class _Ladder:
    """Mean areas of one surface, finest grid first, and what the law has to know of them."""

    areas: np.ndarray
    fraction: float
    grids: Sequence[PlannedGrid]
    orders: np.ndarray
    like: ContactAreas

    @classmethod
    def of(cls, levels):
        """Average over shifts; grids without area inside their edges are left out."""
        groups = [levels[level] for level in sorted(levels, reverse=True)]
        groups = [g for g in groups if np.mean([one.subcell for one in g]) > 0]
        areas = np.array([np.mean([one.subcell for one in g]) for g in groups])
        own = np.array([np.mean([one.edge_fraction for one in g]) for g in groups])
        inside = np.clip(areas, 1e-9, 1 - 1e-9)
        width = np.minimum(own / (inside * (1 - inside) ** GAP_POWER), WIDEST)
        powers = [power for power, _, _ in LOCATED.terms if power]
        return cls(
            areas=areas,
            fraction=float(own[0]),
            grids=[PlannedGrid(spacing=g[0].spacing, cells=g[0].cells, solves=len(g)) for g in groups],
            orders=np.stack([own * width**power for power in powers], axis=1),
            like=groups[0][0],
        )

    def weights(self, law):
        """Inverse covariance, whatever the area is, and the logarithm of its determinant."""
        covariance = error_covariance(law, float(self.areas[0]), self.fraction, self.grids, like=self.like)
        inverse = np.linalg.inv(covariance)
        ones = inverse.sum(axis=0)
        logarithm = float(np.linalg.slogdet(inverse)[1] - np.log(ones.sum()))
        return inverse - np.outer(ones, ones) / ones.sum(), logarithm


def _means(ladders, law):
    """Most likely means under given deviations, and minus the logarithm of the likelihood."""
    normal, right, total = np.zeros((4, 4)), np.zeros(4), 0.0
    for one in ladders:
        weights, logarithm = one.weights(law)
        off = one.areas - one.areas[0]
        normal += one.orders.T @ weights @ one.orders
        right += one.orders.T @ weights @ off
        total += off @ weights @ off - logarithm
    means = np.linalg.solve(normal, right)
    return means, float(total - right @ means) / 2


def fit_law(ladders):
    """Print means, deviations and noise of the law of error, and how likely the one in use is beside them."""
    powers = [power for power, _, _ in LOCATED.terms]

    def law(logarithms):
        *deviations, low, high, odd = np.exp(logarithms).tolist()
        terms = tuple((power, 0.0, d) for power, d in zip(powers, deviations, strict=True))
        return ErrorLaw(terms=terms, odd=odd, noise=(low, high), alike=LOCATED.alike, averaging=0.25)

    used = np.log([*(d for _, _, d in LOCATED.terms), *LOCATED.noise, LOCATED.odd])
    found = scipy.optimize.minimize(
        lambda x: _means(ladders, law(x))[1], used, method="Nelder-Mead", options={"maxfev": 500}
    )
    print("deviations of f, f z, f z^(3/2), f z^2, f z^3; noise a, b; odd:", np.exp(found.x).round(5))
    print("means of all but f:", _means(ladders, law(found.x))[0].round(5))
    means, least = _means(ladders, law(used))
    print(f"with the deviations in use: {means.round(5)}, likelihood exp(-{least - found.fun:.1f}) of that")


if __name__ == "__main__":
    if sys.argv[1:2] == ["fit"]:
        fit()
    elif sys.argv[1:2] == ["law"]:
        fit_law([_Ladder.of(measured(Case.drawn(seed), LEVELS)) for seed in LAW])
    else:
        told = [*sys.argv[2:], *("elastic", "40", "1001")[len(sys.argv[2:]) :]]
        check(told[0], int(told[1]), int(told[2]))
