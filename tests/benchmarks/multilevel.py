"""Is the mean area over surfaces cheaper from many coarse grids and few fine ones?

``python tests/benchmarks/multilevel.py [surfaces]`` prints, for each definition of the area, scatter and
cost of the terms of the telescoping sum over grids of 4, 8 and 16 points per shortest wave (each term from
surfaces of its own, the two grids of a difference sharing theirs), and what the best numbers of surfaces
save against the finest grid alone.
"""

from __future__ import annotations

import sys

import numpy as np

from validation.measurements.common import base_case, base_surface
from validation.measurements.measurement import grid_for, grid_tolerance, press_on_grids

POINTS_PER_WAVE = (4.0, 8.0, 16.0)
#: Between the first surfaces of neighbouring levels, so that no surface serves two of them.
APART = 100_000


def measured(surfaces: int) -> list[list]:
    """Measure so many surfaces of each level, each on the two grids of the level."""
    surface = base_surface(hurst=0.8, periods=4.0, bandwidth=8.0, seed=1607)
    first = base_case(surface, reduced_pressure=0.05)
    grids = [grid_for(first, n) for n in POINTS_PER_WAVE]
    return [
        [
            press_on_grids(
                problem=first.further(k + APART * level),
                grids=tuple(grids[max(level - 1, 0) : level + 1]),
                shifts=1,
                tolerance=grid_tolerance(first, grids),
            ).measure()
            for k in range(surfaces)
        ]
        for level in range(len(grids))
    ]


def main(surfaces: int) -> None:
    """Print the table."""
    levels = measured(surfaces)
    cost = [float(np.mean([one.seconds.sum() for one in level])) for level in levels]
    finest_cost = float(np.mean([one.seconds[-1].sum() for one in levels[-1]]))
    for name in ("pixel", "perimeter", "subcell"):
        on = [np.array([one[name][:, 0, 0].values for one in level]) for level in levels]
        terms = [values[:, -1] - values[:, 0] if values.shape[1] > 1 else values[:, 0] for values in on]
        variance = [float(term.var(ddof=1)) for term in terms]
        # The few surfaces of the finest level tell its variance badly; that of the coarsest is well known,
        # and by how much it changes from grid to grid is, too, since both grids of a level share their
        # surfaces.
        finest = variance[0] * np.prod([v[:, -1].var(ddof=1) / v[:, 0].var(ddof=1) for v in on[1:]])
        saving = finest * finest_cost / sum(np.sqrt(v * c) for v, c in zip(variance, cost, strict=True)) ** 2
        mean = sum(term.mean() for term in terms)
        scatter = ", ".join(f"{100 * np.sqrt(v) / mean:.3g} %" for v in variance)
        print(f"{name:10} A/A0 {mean:.5f}, scatter of the terms {scatter}; saves {saving:.3g} times")
    print(
        "seconds of a surface:", ", ".join(f"{c:.3g}" for c in cost), f"; finest grid alone {finest_cost:.3g}"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 12)
