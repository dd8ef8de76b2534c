"""Fit the second part of the edge map and the law of error of the limits, and see whether they hold.

Random surfaces of H = .1 to 1, lambda_long/lambda_short = 4 to 32, at p* = .01 to .6, pressed from coarse
grids to fine: elastic ones; with a hardness of .1 to 1.5 E* h'_rms; on trilinear hexahedra, nu = 0 to .4.

Run as ``python tests/benchmarks/area_law.py fit`` (some 15 minutes) or ``... check [elastic | hardness |
elements] [surfaces]``. The monomials of the edge map are nearly dependent on each other, so that another fit
has other coefficients. Those of `fem_contact.area` are of grids up to 32 points per shortest wave at no shift
and (1/2, 1/2); truth were limits of areas that are .71 (islands less holes) cells too small.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy.fft
import scipy.optimize
from numpy.typing import NDArray

from fem_contact import bem, block
from fem_contact.area import EDGE_MAPS, ContactAreas, Limit, contact_areas, contact_edges, subgrid_shifts
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import located_limit, perimeter_limit
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

Array = NDArray[np.float64]
Kind = Literal["elastic", "hardness", "elements"]

#: Seeds of the surfaces that are fitted.
FITTED = range(1, 141)

#: Points per shortest wave, with the number of shifts of each along an axis; the last stand for the truth.
LEVELS = {3: 2, 4: 2, 6: 2, 8: 2, 10: 1, 12: 1, 16: 1, 24: 1, 32: 1, 48: 1}
TRUTH = (24, 32, 48)

#: Grids that are extrapolated together.
LADDERS = ((4,), (8,), (16,), (4, 6), (6, 8), (8, 12), (8, 16), (4, 6, 8), (6, 8, 12), (8, 12, 16))


@dataclass(frozen=True, kw_only=True)
class Case:
    """A surface of unit rms gradient on a unit square, what it is pressed on, and how hard."""

    seed: int
    kind: Kind
    hurst: float
    ratio: float
    periods: float
    load: float
    poisson: float = 0.0
    hardness: float | None = None

    @classmethod
    def drawn(cls, seed: int, *, kind: Kind = "elastic", waves: float = 32) -> Case:
        """Draw a spectrum of at most so many shortest waves on the period, and a load."""
        generator, further = (np.random.default_rng([seed, key]) for key in (20261122, 7))
        hurst = generator.uniform(0.1, 1.0)
        ratio = min(float(np.exp(generator.uniform(np.log(4), np.log(32)))), waves)
        most = min(4.0, waves / ratio)
        periods = float(np.exp(generator.uniform(0, np.log(most)))) if most > 1 else 1.0
        load = float(np.exp(generator.uniform(np.log(0.01), np.log(0.6))))
        told = {"seed": seed, "kind": kind, "hurst": hurst, "ratio": ratio, "periods": periods}
        if kind == "elements":
            return cls(**told, load=load, poisson=float(further.choice([0.0, 0.2, 0.3, 0.3, 0.4])))
        if kind == "hardness":
            hardness = float(np.exp(further.uniform(np.log(0.1), np.log(1.5))))
            return cls(**told, load=min(load, 0.5 * hardness), hardness=hardness)
        return cls(**told, load=load)

    @cached_property
    def surface(self) -> HeightField:
        """On three points per shortest wave."""
        n = 2 * int(np.ceil(1.5 * self.periods * self.ratio))
        surface = random_surface(
            lambda q: np.where(q > 0.999 * 2 * np.pi * self.periods, q ** (-2 - 2 * self.hurst), 0.0),
            q_short=2 * np.pi * self.periods * self.ratio,
            lengths=(1.0, 1.0),
            shape=(n, n),
            seed=self.seed,
        )
        return HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))

    def pressed(self, level: int, shift: tuple[float, float]) -> ContactResult:
        """Press on a grid of at least so many points per shortest wave; E* = 1."""
        n = 2 * scipy.fft.next_fast_len(int(np.ceil(level * self.periods * self.ratio / 2)), real=True)
        field = self.surface.resampled((n, n)).shifted(shift)
        solid = Solid(young=1 - self.poisson**2, poisson=self.poisson)
        if self.kind == "elements":
            found = block.solve(field, solid, mean_pressure=self.load, method="reduced")
            return found.contact.checked()
        return bem.solve(
            field,
            HalfSpace(solid=solid),
            mean_pressure=self.load,
            pressure_bound=self.hardness,
            threads=1,
        ).checked()


def measured(case: Case, levels: Mapping[int, int]) -> dict[int, list[ContactAreas]]:
    """Return the areas of one surface at every level and shift."""
    return {
        level: [
            contact_areas(case.pressed(level, shift), subcell=case.kind == "elastic")
            for shift in subgrid_shifts(shifts)
        ]
        for level, shifts in levels.items()
    }


def limit_of(
    areas: Mapping[int, list[ContactAreas]],
    ladder: Sequence[int],
    *,
    limit: Callable[[Sequence[ContactAreas]], Limit],
    truth: Limit,
) -> float:
    """Return how far the limit of a ladder is off, over the uncertainties of both."""
    found = limit([area for level in ladder for area in areas[level]])
    if not found.determinable:
        return 0.0
    return (found.value - truth.value) / float(np.hypot(found.uncertainty, truth.uncertainty))


def check(kind: Kind, surfaces: int) -> None:
    """Print how far limits are off on surfaces that were not fitted, over what they claim."""
    limit = located_limit if kind == "elastic" else perimeter_limit
    misses = []
    for k in range(surfaces):
        case = Case.drawn(1001 + k, kind=kind, waves=32 if kind == "elastic" else 16)
        areas = measured(case, LEVELS)
        truth = limit([area for level in TRUTH for area in areas[level]])
        misses.append([limit_of(areas, ladder, limit=limit, truth=truth) for ladder in LADDERS])
    for ladder, column in zip(LADDERS, np.array(misses).T, strict=True):
        print(
            f"{ladder!s:>14}: held {np.mean(np.abs(column) < 2):.3f}, mean {column.mean():+.2f}, "
            f"root mean square {np.sqrt(np.mean(column**2)):.2f}, worst {np.abs(column).max():.1f}"
        )


@dataclass(frozen=True, kw_only=True)
class _Row:
    """What a solve of a fitted surface says: sums of the features over its edges, in cells."""

    level: int
    cells: int
    fraction: float
    plain: float
    sums: Array


def _rows(case: Case) -> list[_Row]:
    """Solve the levels of one surface; `plain` is the area by the first part of the edge map alone."""
    straight = np.array(EDGE_MAPS["bem"])
    bends = contact_edges(case.pressed(4, (0.0, 0.0))).bends().shape[1]
    straight[-bends:] = 0.0
    rows = []
    for level, shifts in LEVELS.items():
        for shift in subgrid_shifts(shifts):
            result = case.pressed(level, shift)
            areas, edges = contact_areas(result, subcell=True, edge_map=straight), contact_edges(result)
            assert areas.subcell is not None
            rows.append(
                _Row(
                    level=level,
                    cells=areas.cells,
                    fraction=areas.edge_fraction,
                    plain=areas.subcell,
                    sums=edges.cosine**2 @ edges.bends(),
                )
            )
    return rows


def _truth(rows: Sequence[_Row]) -> float:
    """Area without the second order, by a straight line in 1/cells through the finest grids."""
    fine = [row for row in rows if row.level in TRUTH]
    x, y = np.array([1 / row.cells for row in fine]), np.array([row.plain for row in fine])
    return float(np.polyfit(x, y, 1, w=x**-0.75)[1])


def fit(seeds: Iterable[int] = FITTED) -> None:
    """Print the second part of the edge map, and the deviations of the law of error that is left."""
    surfaces = [_rows(Case.drawn(seed)) for seed in seeds]
    truths = [_truth(rows) for rows in surfaces]
    design, target, weight = [], [], []
    for rows, truth in zip(surfaces, truths, strict=True):
        for row in rows:
            z = row.fraction / (truth * (1 - truth) ** 1.25)
            design.append(row.sums)
            target.append((truth - row.plain) * row.cells)
            # Noise of a hundredth of a cell per edge, and what is left of the second order.
            weight.append(1 / np.hypot(0.014, 0.002 * z * np.sqrt(row.fraction * row.cells)))
            weight[-1] /= np.sqrt(row.fraction * row.cells)
    scale = np.array(weight)
    matrix = np.array(design) * scale[:, None]
    bends, *_ = np.linalg.lstsq(matrix, np.array(target) * scale)
    print("second part of the edge map:", np.array2string(bends.reshape(-1, 6), precision=5, separator=", "))
    print("deviations of f z, f z^(3/2), f z^2, f z^3; noise a, b:", _law(surfaces, bends))


def _law(surfaces: Sequence[Sequence[_Row]], bends: Array) -> Array:
    """Deviations of largest likelihood, whatever the area of each surface is."""
    data = []
    for rows in surfaces:
        finest_first = sorted({row.level for row in rows}, reverse=True)
        groups = [[row for row in rows if row.level == level] for level in finest_first]
        area = np.array([np.mean([row.plain + row.sums @ bends / row.cells for row in g]) for g in groups])
        f = np.array([np.mean([row.fraction for row in g]) for g in groups])
        count = np.array([len(g) * g[0].cells for g in groups])
        kept = area > 0
        z = f / (area[0] * (1 - area[0]) ** 1.25)
        data.append([values[kept] for values in (area - area[0], f, z, count)])

    def minus_logarithm(logarithms: Array) -> float:
        *terms, low, high = np.exp(logarithms)
        total = 0.0
        for area, f, z, count in data:
            orders = np.stack([s * f * z**k for s, k in zip(terms, (1, 1.5, 2, 3), strict=True)])
            spread = orders.T @ orders + np.diag(np.hypot(low, high * z) ** 2 * f / count)
            inverse = np.linalg.inv(spread)
            ones = inverse.sum(axis=0)
            total += np.linalg.slogdet(spread)[1] + np.log(ones.sum())
            total += area @ inverse @ area - (ones @ area) ** 2 / ones.sum()
        return float(total / 2)

    start = np.log([5e-4, 5e-4, 5e-4, 3e-4, 5e-3, 4e-2])
    found = scipy.optimize.minimize(minus_logarithm, start, method="Nelder-Mead", options={"maxfev": 600})
    return np.asarray(np.exp(found.x).round(5))


if __name__ == "__main__":
    if sys.argv[1:2] == ["fit"]:
        fit()
    else:
        check(
            *(kind(text) for kind, text in zip((str, int), sys.argv[2:] or ("elastic", "40"), strict=False))
        )
