"""What does one more decade of length scales cost, in time and in memory?

Persson (2006), Sec. 12, says: time and memory grow at least linearly with the number of grid points N = (L/a)^2, so
that one decade more costs a factor of 100 at least, and 2, at most 3 decades can be reached. Here N grows with the
bandwidth: each surface has waves down to the same number of grid spacings, so that nothing is merely interpolated.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats

from fem_contact.area import contact_areas
from fem_contact.solid import Solid
from validation.errors import UsageError
from validation.measures.common import at_least, base_surface, measure, solid_of
from validation.measures.single_solve import SingleSolve
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.surfaces import height_field, reference_field
from validation.solves.bench import Bench
from validation.solves.solve import Prediction

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["SolveCost", "figures", "findings", "run", "table"]

_COSTS = {"seconds": "s", "fft_pairs": "1", "peak_bytes": "byte"}
_WORDS = {"seconds": "time", "fft_pairs": "pairs of transforms", "peak_bytes": "memory"}


@dataclass(frozen=True, kw_only=True)
class SolveCost(SingleSolve):
    """One cold solve by boundary elements on one thread, reduced to what it cost."""

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"cost-{self.points}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"BEM {self.points}x{self.points}, surface {self.realisation + 1}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost."""
        n = self.points**2
        return Prediction(seconds=2e-3 + 1.2e-6 * n, peak_bytes=120 * n, unknowns=n)

    def measure(self) -> xr.Dataset:
        """Return seconds, pairs of transforms, bytes, and the located area."""
        import xarray as xr

        from fem_contact import bem
        from fem_contact.response import HalfSpace

        response = HalfSpace(solid=Solid(**self.solid.model_dump()))
        whole = reference_field(self.surface, realisation=self.realisation)
        field = height_field(self.surface, (self.points, self.points), realisation=self.realisation)
        pressure = self.reduced_pressure * response.contact_modulus * whole.rms_gradient
        result = bem.solve(field, response, mean_pressure=pressure, threads=1).checked()
        areas = contact_areas(result, subcell=True)
        data = {
            "seconds": result.cost.cpu_seconds,
            "fft_pairs": result.cost.fft_pairs,
            "peak_bytes": result.cost.peak_bytes,
            "area": np.nan if areas.subcell is None else areas.subcell,
        }
        return xr.Dataset({name: ((), float(value)) for name, value in data.items()})


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    points: tuple[int, ...] = (128, 256, 512, 1024, 2048),
    points_per_wave: float = 8.0,
    size: float = 4.0,
    hurst: float = 0.8,
    reduced_pressure: float = 0.05,
    surfaces: int = 3,
    seed: int = 1206,
) -> xr.Dataset:
    """Solve surfaces whose bandwidth grows with the grid, and measure what that costs.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid.
    bench : Bench, optional
        Times mean something only if nothing else runs: use one worker.
    points : tuple of int
        Grids, as points along each axis, rising.
    points_per_wave : float
        lambda_short/dx, the same on every grid.
    size : float
        L/lambda_long, the same on every grid.
    hurst, reduced_pressure : float
        H and p*.
    surfaces : int
        Realisations on each grid.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        seconds, fft_pairs, peak_bytes and area with dimensions (points, surface); the attributes hold the memory that
        was free [byte] when this was run.
    """
    import xarray as xr

    from validation.solves.cost import available_memory

    at_least("surfaces", surfaces, 2)
    coarsest = points_per_wave * size
    if len(points) < 3 or any(np.diff(points) <= 0) or points[0] <= coarsest:
        raise UsageError(
            f"--points = {','.join(map(str, points))}: at least three, rising, and above L/lambda_long x lambda_short/dx = "
            f"{coarsest:g}"
        )
    solves = [
        SolveCost(
            surface=base_surface(hurst=hurst, size=size, ratio=n / coarsest, seed=seed),
            realisation=k,
            solid=solid_of(scene),
            reduced_pressure=reduced_pressure,
            points=n,
        )
        for n, k in itertools.product(points, range(surfaces))
    ]
    found = measure(bench, solves)
    shape = (len(points), surfaces)
    units = {**_COSTS, "area": "1"}
    return xr.Dataset(
        {
            name: (
                ("points", "surface"),
                np.array([float(d[name]) for d in found]).reshape(shape),
                {"units": unit},
            )
            for name, unit in units.items()
        },
        coords={
            "points": ("points", list(points), {"long_name": "points along each axis"}),
            "bandwidth": (
                "points",
                [n / coarsest for n in points],
                {"long_name": "lambda_long / lambda_short"},
            ),
        },
        attrs={
            "study": "scaling",
            "reduced_pressure": reduced_pressure,
            "points_per_wave": points_per_wave,
            "size": size,
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
    wave, size = float(dataset.attrs["points_per_wave"]), float(dataset.attrs["size"])
    side = np.sqrt(most[limit])
    sentences.append(
        f"By these laws {memory_words(free)} and an hour on one thread allow {_round(side)} x {_round(side)} points ({limit} ends first): "
        f"{np.log10(side):.2f} decades from L to the spacing, {np.log10(side / wave):.2f} from L to the shortest wave at "
        f"{wave:g} points on it, {np.log10(side / wave / size):.2f} of roughness at L/lambda_long = {size:g}; the paper says 2 or at most 3."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw seconds, transforms and memory against N."""
    from validation.studies import _plots_studies as plots_studies

    laws = {name: power_law(dataset, name) for name in _COSTS}
    lines = {name: (law.coefficient, law.exponent) for name, law in laws.items()}
    return (
        Drawing(
            name="cost-against-points",
            figure=plots_studies.cost_against_points(dataset, lines),
            data=dataset[list(_COSTS)],
            caption="Processor time on one thread, pairs of transforms, and memory of a cold solve against the number of grid points, for surfaces whose bandwidth grows with the grid; lines: fitted powers of N.",
        ),
    )
