"""What does one more decade of length scales cost, in time and in memory?

Persson (2006), Sec. 12, says: time and memory grow at least linearly with the number of grid points N = (L/a)^2, so
that one decade more costs a factor of 100 at least, and 2, at most 3 decades can be reached. Here N grows with the
bandwidth: each surface has waves down to the same number of grid spacings, so that nothing is merely interpolated.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
import scipy.stats
from pydantic import Field, model_validator

from fem_contact.area import contact_areas
from validation.measures.common import RisingGrids, base_case, base_surface, results_of
from validation.measures.single_solve import SingleSolve, Takes
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._options import Hurst, Periods, ReducedPressure, Seed, Surfaces
from validation.studies._study import StudyOptions
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "PowerLaw", "SolveCost", "figures", "findings", "power_law", "run", "table"]

_COSTS = {"seconds": "s", "fft_pairs": "1", "peak_bytes": "byte"}
_WORDS = {"seconds": "time", "fft_pairs": "pairs of transforms", "peak_bytes": "memory"}


class Options(StudyOptions):
    """Surfaces whose bandwidth grows with the grid. Times mean something only if nothing else runs: one worker."""

    own = "its surfaces grow with the grid"

    grids: Annotated[RisingGrids, Field(min_length=3, description="points along a side, rising")] = (
        128,
        256,
        512,
        1024,
        2048,
    )
    points_per_wave: float = Field(default=8.0, gt=0, description="lambda_short/dx, the same on every grid")
    periods: Periods = 4.0
    hurst: Hurst = 0.8
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


@dataclass(frozen=True, kw_only=True)
class SolveCost(SingleSolve):
    """One cold solve by boundary elements on one thread, reduced to what it cost."""

    kind, words = "cost", "BEM"
    located = True
    takes = Takes(seconds=2e-3, each_point=1.2e-6, bytes=120)

    def measure(self) -> xr.Dataset:
        """Return seconds, pairs of transforms, bytes, and the located area."""
        import xarray as xr

        from fem_contact import bem

        pressure = self.realised.pressure
        result = bem.solve(self.heights(), self.half_space, mean_pressure=pressure, threads=1).checked()
        areas = contact_areas(result, subcell=True)
        data = {
            "seconds": result.cost.cpu_seconds,
            "fft_pairs": result.cost.fft_pairs,
            "peak_bytes": result.cost.peak_bytes,
            "area": np.nan if areas.subcell is None else areas.subcell,
        }
        return xr.Dataset({name: ((), float(value)) for name, value in data.items()})


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve surfaces whose bandwidth grows with the grid, and measure what that costs.

    Returns
    -------
    xarray.Dataset
        seconds, fft_pairs, peak_bytes and area with dimensions (points, surface); the attributes hold the memory that
        was free [byte] when this was run.
    """
    return _dataset(results_of(bench, _cases(options)), options)


def _cases(options: Options) -> dict[tuple[int, int], SolveCost]:
    """List the solves by points along a side and number of the surface."""
    cases = {}
    for n, k in itertools.product(options.grids, range(options.surfaces)):
        surface = base_surface(
            hurst=options.hurst, periods=options.periods, bandwidth=n / options.coarsest, seed=options.seed
        )
        pressed = base_case(surface, reduced_pressure=options.reduced_pressure).further(k)
        cases[n, k] = SolveCost(realised=pressed, grid=(n, n))
    return cases


def _dataset(found: Mapping[tuple[int, int], xr.Dataset], options: Options) -> xr.Dataset:
    import xarray as xr

    from validation.solves.cost import available_memory

    def rows(name: str) -> Any:
        return np.array([[float(found[n, k][name]) for k in range(options.surfaces)] for n in options.grids])

    bandwidth = [n / options.coarsest for n in options.grids]
    return xr.Dataset(
        {
            name: (("points", "surface"), rows(name), {"units": unit})
            for name, unit in {**_COSTS, "area": "1"}.items()
        },
        coords={
            "points": ("points", list(options.grids), {"long_name": "points along each axis"}),
            "bandwidth": ("points", bandwidth, {"long_name": "lambda_long / lambda_short"}),
        },
        attrs={
            "study": "scaling",
            "reduced_pressure": options.reduced_pressure,
            "points_per_wave": options.points_per_wave,
            "periods": options.periods,
            "memory": available_memory(),
            "methods": "bem",
        },
    )


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """cost = coefficient N^exponent.

    Attributes
    ----------
    exponent, half_width : float
        With half of its 95 % interval.
    coefficient : float
        Cost at N = 1, by the fit.
    """

    exponent: float
    half_width: float
    coefficient: float

    def points(self, cost: float) -> float:
        """Return the number of points N at which that cost is reached."""
        return float((cost / self.coefficient) ** (1 / self.exponent))


def power_law(dataset: xr.Dataset, name: str) -> PowerLaw:
    """Fit a cost against N by least squares of logarithms; from grids of 256 points along each axis on, if three are."""
    points = dataset.points.values
    large = points >= 256 if np.count_nonzero(points >= 256) >= 3 else np.full(points.shape, True)
    number = np.log(np.repeat(points[large] ** 2.0, dataset.sizes["surface"]))
    fit = scipy.stats.linregress(number, np.log(dataset[name].values[large].ravel()))
    width = float(scipy.stats.t.ppf(0.975, number.size - 2) * fit.stderr)
    return PowerLaw(exponent=float(fit.slope), half_width=width, coefficient=float(np.exp(fit.intercept)))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return the cost of each grid, and the fitted exponents."""
    rows: list[tuple[float | str, ...]] = []
    for i, n in enumerate(dataset.points.values):
        mean = [float(dataset[name][i].mean()) for name in _COSTS]
        rows.append(
            (
                f"{n} x {n}",
                float(dataset.bandwidth[i]),
                *mean[:2],
                mean[2] / 2**20,
                float(dataset.area[i].mean()),
            )
        )
    laws = [power_law(dataset, name) for name in _COSTS]
    rows.append(("exponent of N", "", *(law.exponent for law in laws), ""))
    rows.append(("its +- (95 %)", "", *(law.half_width for law in laws), ""))
    rows.append(("one decade of L/dx costs", "", *(100**law.exponent for law in laws), ""))
    columns = ("grid", "lambda_long/lambda_short", "seconds", "FFT pairs", "MiB", "A/A0 subcell")
    return ResultTable.of(columns, rows)


def _round(value: float) -> int:
    """Round to two digits.

    >>> _round(18234.0)
    18000
    """
    return int(float(f"{value:.2g}"))


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the exponents, what one more decade costs, and how many decades memory and an hour allow."""
    from validation.solves.cost import memory_words

    laws = {name: power_law(dataset, name) for name in _COSTS}
    sentences = [
        f"{_WORDS[name].capitalize()} grow{'' if name == 'fft_pairs' else 's'} like N^({law.exponent:.3f} +- {law.half_width:.2g}) "
        f"(95 %); one decade more of L/dx costs a factor of {100**law.exponent:.3g}."
        for name, law in laws.items()
    ]
    time = laws["seconds"]
    below, above = time.exponent + time.half_width < 1, time.exponent - time.half_width > 1
    verdict = "less than" if below else ("more than" if above else "within its uncertainty just")
    sentences.append(
        f"At least linear in N and 100 times per decade, says Sec. 12 of the paper: the time measured is {verdict} linear."
    )
    free = float(dataset.attrs["memory"])
    most = {"memory": laws["peak_bytes"].points(free), "an hour": time.points(3600.0)}
    limit = min(most, key=lambda name: most[name])
    wave, periods = float(dataset.attrs["points_per_wave"]), float(dataset.attrs["periods"])
    side = np.sqrt(most[limit])
    sentences.append(
        f"By these laws {memory_words(free)} and an hour on one thread allow {_round(side)} x {_round(side)} points ({limit} ends first): "
        f"{np.log10(side):.2f} decades from L to the spacing, {np.log10(side / wave):.2f} from L to the shortest wave at "
        f"{wave:g} points on it, {np.log10(side / wave / periods):.2f} of roughness at L/lambda_long = {periods:g}; the paper says 2 or at most 3."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw seconds, transforms and memory against N."""
    return (
        Drawing(
            name="cost-against-points",
            figure=_cost_against_points(dataset),
            data=dataset[list(_COSTS)],
            caption="Processor time on one thread, pairs of transforms, and memory of a cold solve against the number of "
            "grid points, for surfaces whose bandwidth grows with the grid; lines: fitted powers of N.",
        ),
    )


def _cost_against_points(dataset: xr.Dataset) -> Figure:
    """Seconds, transforms and memory against N, with the powers fitted to them."""
    from validation.report.figure import new_figure, plain_look

    figure, panels = new_figure(width=9.5, columns=3, height=3.4)
    labels = {
        "seconds": ("processor time [s]", 1.0),
        "fft_pairs": ("pairs of transforms", 1.0),
        "peak_bytes": ("memory [MiB]", 2.0**20),
    }
    number = dataset.points.values**2.0
    for k, (axes, (name, (label, unit))) in enumerate(zip(panels, labels.items(), strict=True)):
        for column in dataset[name].values.T:
            axes.plot(number, column / unit, ls="", **plain_look(k))
        law = power_law(dataset, name)
        fitted = law.coefficient * number**law.exponent / unit
        axes.plot(number, fitted, color="black", lw=0.8, label=f"$N^{{{law.exponent:.2f}}}$")
        axes.set_xscale("log")
        if name != "fft_pairs":
            axes.set_yscale("log")
        axes.set_xlabel("grid points N")
        axes.set_ylabel(label)
        axes.legend(fontsize=8)
    return figure
