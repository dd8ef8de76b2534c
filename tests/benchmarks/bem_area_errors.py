"""Error of the contact area by each definition, over random surfaces and grids.

Self-affine surfaces with lambda_short = L/16 and lambda_long = L/2, each refined; the reference is the
located area at lambda_short / dx = 48, checked against the extrapolated pixel area.

Run as ``python tests/benchmarks/bem_area_errors.py [surfaces] [p*] [H]``.
"""

from __future__ import annotations

import sys

import numpy as np

from fem_contact.area import contact_areas, subcell_area, subgrid_shifts
from fem_contact.bem import solve
from fem_contact.extrapolation import limit_area, located_limit
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
RESOLUTIONS = (4, 6, 8, 12, 16, 24, 48)
NAMES = (
    "pixel",
    "perimeter",
    "subcell",
    "subcell, 4 shifts",
    "3 grids, pixel",
    "3 grids, located",
)


def surface_of(seed: int, hurst: float) -> HeightField:
    """Unit rms gradient."""
    q_long = 4 * np.pi
    surface = random_surface(
        lambda q: np.where(q > 0.999 * q_long, q ** (-2 - 2 * hurst), 0.0),
        q_short=32 * np.pi,
        lengths=(1.0, 1.0),
        shape=(64, 64),
        seed=seed,
    )
    return HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))


def errors_of(seed: int, *, pressure: float, hurst: float) -> dict[int, list[float]]:
    """Relative errors in per cent per resolution, in the order of `NAMES`."""
    surface = surface_of(seed, hurst)
    values, areas = {}, {}
    for resolution in RESOLUTIONS:
        n = 16 * resolution
        sampled = surface.resampled((n, n))
        result = solve(sampled, SOFT, mean_pressure=pressure).checked()
        areas[resolution] = contact_areas(result, subcell=True)
        located = subcell_area(result)
        values[resolution] = [areas[resolution].pixel, areas[resolution].perimeter, located]
        shifts = subgrid_shifts(2)[1:] if resolution <= 16 else []
        moved = [solve(sampled.shifted(shift), SOFT, mean_pressure=pressure).checked() for shift in shifts]
        values[resolution].append(np.mean([located, *map(subcell_area, moved)]))
    for k, resolution in enumerate(RESOLUTIONS):
        used = [areas[r] for r in RESOLUTIONS[max(k - 2, 0) : k + 1]]
        full = len(used) == 3
        values[resolution].append(limit_area(used).value if full else np.nan)
        values[resolution].append(located_limit(used).value if full else np.nan)
    reference = values[RESOLUTIONS[-1]][2]
    return {r: [100 * (v / reference - 1) for v in row] for r, row in values.items()}


def main(surfaces: int = 50, pressure: float = 0.05, hurst: float = 0.8) -> None:
    """Print mean, root mean square and largest error."""
    tables = [errors_of(1000 + k, pressure=pressure, hurst=hurst) for k in range(surfaces)]
    print(f"{surfaces} surfaces, p* = {pressure}, H = {hurst}")
    print("error of A/A0 in %: mean, root mean square, worst")
    print("lambda_short/dx " + "".join(f"{name:>28}" for name in NAMES))
    rms = {}
    for resolution in RESOLUTIONS:
        table = np.array([t[resolution] for t in tables])
        rms[resolution] = np.sqrt(np.mean(table**2, axis=0))
        worst = np.abs(table).max(axis=0)
        cells = zip(table.mean(axis=0), rms[resolution], worst, strict=True)
        print(f"{resolution:15d} " + "".join(f"{m:12.3f}{s:8.3f}{w:8.3f}" for m, s, w in cells))
    for name, column in zip(NAMES[:4], range(4), strict=True):
        errors = [rms[r][column] for r in (4, 8, 16)]
        print(
            f"order of {name} between 4 and 16, between 8 and 16: {np.log2(errors[0] / errors[2]) / 2:.2f}, "
            f"{np.log2(errors[1] / errors[2]):.2f}"
        )


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float, float), sys.argv[1:], strict=False)))
