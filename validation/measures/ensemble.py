"""Means over the surfaces of a spectrum: what was read off them, sorted by the grid they end with, and how many it takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from validation.measures.common import results_of
from validation.measures.controlled import Controlled, Known, Level, allocation, chained_mean
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.measures.statistics import Estimate, pair_means
from validation.measures.without_solve import UnsolvedPairs
from validation.scenes.realised import Realised
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "MeanArea", "Samples", "mean_area"]

Array = NDArray[np.float64]

#: Pairs of a first look, by the grid they end with, and how often the numbers are chosen anew from what was found.
_FIRST, _ROUNDS = (16, 6, 2), 6
#: Pairs that are not solved, of a first look.
_FIRST_UNSOLVED = 64
#: Between the first surfaces that end with different grids, and the first that are not solved.
_APART = 1_000_000

#: Name: unit, meaning. All means over the surfaces of a spectrum.
QUANTITIES = {
    "area": "A/A0, edge located inside the cells, limit over grids",
    "gap": "mean gap / h_rms",
    "compliance": "p0 / (K h_rms), K = d p0 / d(approach), the contact conductance in other units; 0 in full contact",
    "energy": "elastic energy / that of full contact",
    "slope": "P'(0) (E* h'_rms)^2, fitted between .1 and .4 E* h'_rms",
    "patches": "contact patches per lambda_long^2",
}


@dataclass(frozen=True, kw_only=True)
class Samples:
    """Surfaces of one spectrum, in pairs +h, -h.

    Attributes
    ----------
    ending : sequence of sequences of xarray.Dataset
        Measurements by the last grid they are solved on, coarsest first.
    unsolved : (n, k) array
        Statistics without a solve of the pairs that end with the coarsest grid.
    further : (m, k) array
        The same of pairs that are not solved at all.
    unsolved_seconds : float
        Processor time of the statistics of all these.
    periods : float
        L / lambda_long.
    """

    ending: Sequence[Sequence[xr.Dataset]]
    unsolved: Array
    further: Array
    unsolved_seconds: float
    periods: float

    def chain(self, name: str, load: int) -> tuple[Controlled, ...]:
        """Return the controlled means of a quantity on all grids; the last is the one that is asked for."""
        levels = [Level(values=self._pairs(name, 0, 0)[load], controls=self.unsolved)]
        for last in range(1, len(self.ending)):
            values, controls = (self._pairs(name, last, grid)[load] for grid in (last, last - 1))
            levels.append(Level(values=values, controls=controls))
        return chained_mean(levels, Known.of_samples(self.further))

    def _pairs(self, name: str, ending: int, grid: int) -> Array:
        """Return a quantity on one grid, (load, pair), of the surfaces that end with another."""
        read = [self._read(data, name, grid) for data in self.ending[ending]]
        return pair_means(np.array(read).T)

    def _read(self, data: xr.Dataset, name: str, grid: int) -> Array:
        """Return a quantity of one surface over the loads on one grid; the area by its limit where the grids allow one."""
        if name == "area" and (grid >= 2 or grid == len(self.ending) - 1):
            return area_limits(data.isel(grid=slice(0, grid + 1)))[0]
        return _on_grid(data, name, grid=grid, periods=self.periods)

    def grid_error(self, name: str, load: int) -> float:
        """Half of the 95 % interval of what the grids leave: off to the same side on all surfaces, it does not average."""
        if name == "area":
            errors = np.array([area_limits(data)[1][load] for data in self.ending[-1]])
        else:
            last = [
                [_on_grid(data, name, grid=grid, periods=self.periods)[load] for grid in (-1, -2)]
                for data in self.ending[-1]
            ]
            errors = np.diff(np.array(last), axis=1)[:, 0] / 2
        return float(1.96 * np.sqrt(np.mean(errors**2)))

    def parts(self, chain: Sequence[Controlled]) -> list[tuple[float, float]]:
        """Return variance and processor time of one pair that ends with each grid, then of one that is not solved."""
        count = len(self.unsolved) + len(self.further)
        look = self.unsolved_seconds / count
        times = [2 * float(np.mean([float(d.seconds.sum()) for d in group])) for group in self.ending]
        slopes = chain[0].coefficients
        told = float(slopes @ np.cov(self.further, rowvar=False) @ slopes)
        # The mean of a level is multiplied by the coefficients of those above it.
        factors = [
            float(np.prod([one.coefficients for one in chain[k + 1 :]])) ** 2 for k in range(len(chain))
        ]
        solves = [(f * one.left, time) for f, one, time in zip(factors, chain, times, strict=True)]
        return [(solves[0][0], solves[0][1] + look), *solves[1:], (factors[0] * told, look)]

    def saving(self, found: Sequence[Controlled], load: int) -> float:
        """Return the processor time of plain means over single surfaces, for the same interval, over that spent.

        The scatter of single surfaces is that of the coarsest grid, on which there are many; each takes all grids.
        """
        coarse = np.array([self._read(data, "area", 0)[load] for data in self.ending[0]])
        share = float(coarse.var(ddof=1) / coarse.mean() ** 2)
        asked = found[-1].estimate.half_width / found[-1].estimate.value / float(scipy.stats.norm.ppf(0.975))
        each = float(np.mean([_seconds(data, load) for data in self.ending[-1]]))
        spent = sum(_seconds(data, load) for group in self.ending for data in group)
        return share / asked**2 * each / (spent + self.unsolved_seconds)


def _seconds(data: xr.Dataset, load: int) -> float:
    return float(data.seconds.isel(load=load).sum())


def _on_grid(data: xr.Dataset, name: str, *, grid: int, periods: float) -> Array:
    """Return one quantity of one surface over the loads, on one grid, mean over its shifts."""
    if name == "compliance":
        return np.asarray((1 / data.stiffness.isel(grid=grid)).mean("shift").values)
    mean = data.isel(grid=grid).mean("shift")
    scales: Mapping[str, tuple[str, float]] = {
        "gap": ("mean_gap", 1 / data.attrs["rms_height"]),
        "energy": ("energy", 1 / data.attrs["full_contact_energy"]),
        "patches": ("patches", 1 / periods**2),
        "area": ("subcell", 1.0),
    }
    variable, scale = scales.get(name, (name, 1.0))
    return np.asarray(mean[variable].values * scale)


@dataclass(frozen=True, kw_only=True)
class MeanArea:
    """The mean A/A0 over all surfaces of a spectrum.

    Attributes
    ----------
    estimate : Estimate
        Limit over grids, with what the scatter of surfaces leaves.
    grid : float
        Half of the 95 % interval of what the grids leave.
    pairs : tuple of int
        Pairs +h, -h that end with each grid, coarsest first.
    unsolved : int
        Further pairs that are only looked at.
    samples : Samples
    """

    estimate: Estimate
    grid: float
    pairs: tuple[int, ...]
    unsolved: int
    samples: Samples

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval: surfaces and grids."""
        return float(np.hypot(self.estimate.half_width, self.grid))


def mean_area(
    base: Realised,
    *,
    half_width: float,
    bench: Bench,
    points_per_wave: tuple[float, float, float] = (3.0, 6.0, 12.0),
    tolerance: float = 1e-6,
) -> MeanArea:
    """Mean contact area of all surfaces of a spectrum to a given accuracy, from as few solves as it takes.

    Parameters
    ----------
    base : Realised
        Surface, solid and one load.
    half_width : float
        Half of the 95 % interval that is asked for, relative to the mean: surfaces and grids.
    bench : Bench
    points_per_wave : tuple of float
        Three grids.
    tolerance : float
        Of the solver.

    Returns
    -------
    MeanArea
        Wider than asked where the grids leave more than that, or six rounds did not suffice.

    Notes
    -----
    After a first look the numbers of pairs are those of least cost (`allocation`), from the variances and times found.
    """
    grids = tuple(grid_for(base, points) for points in points_per_wave)
    counts, looked_at = list(_FIRST), [(3 * _APART, _FIRST_UNSOLVED)]
    parts = [(0, counts[0])]
    for again in range(_ROUNDS):
        cases: dict[tuple[int, ...], Measurement | UnsolvedPairs] = {
            (last, k, sign): Measurement(
                realised=replace(base.further(k + last * _APART), inverted=bool(sign)),
                grids=grids[: last + 1],
                shifts=1,
                tolerance=tolerance,
            )
            for last, count in enumerate(counts)
            for k in range(count)
            for sign in (0, 1)
        }
        for first, count in (*parts, *looked_at):
            cases[first, count] = UnsolvedPairs(realised=base, grid=grids[0], first=first, count=count)
        solved = results_of(bench, cases)
        told, further = ([solved[part] for part in which] for which in (parts, looked_at))
        samples = Samples(
            ending=[
                [data for name, data in solved.items() if len(name) == 3 and name[0] == last]
                for last in range(len(counts))
            ],
            unsolved=np.concatenate([data.value.values for data in told]),
            further=np.concatenate([data.value.values for data in further]),
            unsolved_seconds=sum(float(data.attrs["seconds"]) for data in (*told, *further)),
            periods=min(base.lengths) / base.longest,
        )
        chain = samples.chain("area", 0)
        found = MeanArea(
            estimate=chain[-1].estimate,
            grid=samples.grid_error("area", 0),
            pairs=tuple(counts),
            unsolved=len(samples.further),
            samples=samples,
        )
        asked = np.sqrt(max((half_width * found.estimate.value) ** 2 - found.grid**2, 0.0))
        if again == _ROUNDS - 1 or found.estimate.half_width <= asked or asked == 0:
            break
        aim = asked * found.estimate.standard_error / found.estimate.half_width
        *solves, unsolved = allocation(samples.parts(chain), aim)
        grown = [max(old, new) for old, new in zip(counts, solves, strict=True)]
        if grown[0] > counts[0]:
            parts.append((counts[0], grown[0] - counts[0]))
        if unsolved > found.unsolved:
            looked_at.append((3 * _APART + found.unsolved, unsolved - found.unsolved))
        counts = grown
    return found
