"""What does one more decade of length scales cost, in time and in memory?

Persson (2006), Sec. 12, says: time and memory grow at least linearly with the number of grid points N = (L/a)^2, so
that one decade more costs a factor of 100 at least, and 2, at most 3 decades can be reached. Here N grows with the
bandwidth: each surface has waves down to the same number of grid spacings, so that nothing is merely interpolated.
"""

import itertools
from typing import Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from validation.arrays import Grid
from validation.files import available_memory
from validation.measurements.common import RisingGrids, base_case
from validation.measurements.flow import located_area
from validation.measurements.measurement import press_elastic
from validation.report.estimates import derive, power_law, reduce
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.studies._options import Periods, ReducedPressure, Seed, SurfaceOptions, Surfaces
from validation.studies._study import Bench, gathered, measurement, read_off
from validation.units import wrong

_COSTS = ("seconds", "fft_pairs", "peak_bytes")
#: Points along a side from which on powers are fitted, where three grids are that fine.
_LARGE = 256


class Options(SurfaceOptions):
    """Surfaces whose bandwidth grows with the grid. Times mean something only if nothing else runs: one worker."""

    why_no_scene = "its surfaces grow with the grid"

    grids: RisingGrids = Field(default=(128, 256, 512, 1024, 2048), min_length=3)
    """points along a side, rising"""
    points_per_wave: float = Field(default=8.0, ge=1)
    """lambda_short/dx, the same on every grid"""
    periods: Periods = 4.0
    reduced_pressure: ReducedPressure = 0.05
    surfaces: Surfaces = 3
    seed: Seed = 1206

    @property
    def coarsest(self) -> float:
        """Points along a side on which lambda_short is as long as lambda_long."""
        return self.points_per_wave * self.periods

    @model_validator(mode="after")
    def _rough(self) -> Self:
        if self.grids[0] <= self.coarsest:
            raise wrong(
                f"grids = {', '.join(map(str, self.grids))}: must be above L/lambda_long x lambda_short/dx = "
                f"{self.coarsest:g}"
            )
        return self


@measurement(
    "cost-{size}",
    kind="SolveCost",
    words="BEM",
    located=True,
    seconds=lambda points: 2e-3 + 1.2e-6 * points,
    bytes=120,
)
def cold_solve(*, problem: ContactProblem, grid: Grid) -> xr.Dataset:
    """Return seconds, pairs of transforms and bytes of one cold solve by boundary elements, and the located area."""
    result = press_elastic(problem.heights(grid), problem.elastic, problem.pressure)
    values = {"seconds": result.cost.cpu_seconds, "area": located_area(result)}
    values |= {name: float(getattr(result.cost, name)) for name in ("fft_pairs", "peak_bytes")}
    return xr.Dataset(values)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve surfaces whose bandwidth grows with the grid, and measure what that costs.

    Costs and located area (points, surface); the exponent of each cost in N, what one decade more costs, and how
    far the memory that was free and an hour reach.
    """
    taken = {"area_located_each": "area"} | {f"{name}_each": name for name in _COSTS}
    cases = {}
    for n, k in itertools.product(options.grids, range(options.surfaces)):
        surface = options.self_affine(bandwidth=n / options.coarsest)
        pressed = base_case(surface, reduced_pressure=options.reduced_pressure).further(k)
        cases[n, k] = cold_solve(problem=pressed, grid=(n, n))
    data = gathered(bench, cases, lambda d, _: read_off(d, **taken), "points", "surface")
    data = data.assign_coords(bandwidth=("points", [n / options.coarsest for n in options.grids]))
    data = derive(data, number="points**2.0")
    data = reduce(data, "mean", *_COSTS, "area_located")
    fine = data.points.values >= _LARGE
    fitted = data.isel(points=fine) if np.count_nonzero(fine) >= 3 else data
    for name in _COSTS:
        exponent = f"exponent_{name}"
        fit = power_law(fitted, exponent, of=f"{name}_each", x="number", along=("points", "surface"))
        data = data.assign({n: v for n, v in fit.data_vars.items() if str(n).startswith("exponent")})
        powers = {f"decade_{name}": f"100**{exponent}"}
        data = derive(data, **powers, **{f"{name}_fit": f"{exponent}_factor * number**{exponent}"})
    data = derive(
        data.assign(free_bytes=float(available_memory()), coarsest=options.coarsest),
        side_peak_bytes="(free_bytes / exponent_peak_bytes_factor)**(0.5 / exponent_peak_bytes)",
        side_seconds="(3600 / exponent_seconds_factor)**(0.5 / exponent_seconds)",
        decades="log(minimum(side_peak_bytes, side_seconds) / coarsest) / log(10)",
        excess_exponent="exponent_seconds - 1",
    )
    attributes = options.model_dump(include={"reduced_pressure", "points_per_wave", "periods"})
    return data.assign_attrs(methods="bem", **attributes)


def views(data: xr.Dataset) -> Views:
    """Exponents, what one more decade costs, and how many decades memory and an hour allow."""
    dots = {name: Line(f"{name}_each", by="surface", joined=False, label="") for name in _COSTS}
    return Views(
        table=Table(("points",), ("points", "bandwidth", *_COSTS, "area_located")),
        figures=[
            Figure(
                "cost-against-points",
                "Processor time on one thread, pairs of transforms and memory of a cold solve, for surfaces "
                "whose bandwidth grows with the grid; lines, fitted powers of the number of points.",
                [against("number", dots[name], f"{name}_fit", y=name, log="xy") for name in _COSTS],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    form = "Costs grow as powers of the number of points N: time {exponent_seconds}, pairs of transforms "
    form += "{exponent_fft_pairs}, memory {exponent_peak_bytes}."
    yield finding("value", form, data)
    form = "Persson (2006), Sec. 12: at least linear in N, 100 times per decade of L/dx. The exponent of the time "
    form += "measured here is {verdict} 1; a decade costs {decade_seconds} times the time and "
    form += "{decade_peak_bytes} times the memory."
    yield finding("comparison", form, data, by="excess_exponent")
    form = "By these laws the free memory allows {side_peak_bytes} points along a side and an hour on one thread "
    form += "{side_seconds}: {decades} decades of roughness; the paper says 2, at most 3."
    yield finding("cost", form, data)
