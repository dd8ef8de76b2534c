"""Means over the surfaces of a spectrum: what was read off them, sorted by the grid they end with, and how many it takes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from validation.measures.common import results_of
from validation.measures.controlled import Controlled, Known, Level, allocation, chained_mean
from validation.measures.measurement import Grid, Measurement, area_limits, grid_for
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

#: Last grid, number of the pair, sign; or first and count of those that are only looked at.
_Name = tuple[int, ...]

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

    def chains(self, name: str) -> list[tuple[Controlled, ...]]:
        """Return the controlled means of a quantity on all grids, for each load; the last is the one that is asked for."""
        numbers = [self._pairs(name, 0, 0)]
        for last in range(1, len(self.ending)):
            numbers += [self._pairs(name, last, last), self._pairs(name, last, last - 1)]
        known = Known.of_samples(self.further)
        return [
            chained_mean(
                [
                    Level(values=first, controls=self.unsolved),
                    *(Level(values=rest[k], controls=rest[k + 1]) for k in range(0, len(rest), 2)),
                ],
                known,
            )
            for first, *rest in zip(*numbers, strict=True)
        ]

    def _pairs(self, name: str, ending: int, grid: int, *, paired: bool = True) -> Array:
        """Return a quantity on one grid, (load, pair) or (load, surface), of the surfaces that end with another."""
        read = np.array([self._read(data, name, grid) for data in self.ending[ending]]).T
        return pair_means(read) if paired else read

    def _read(self, data: xr.Dataset, name: str, grid: int) -> Array:
        """Return a quantity of one surface over the loads on one grid; the area by its limit where the grids allow one."""
        if name == "area" and (grid >= 2 or grid == len(self.ending) - 1):
            return area_limits(data.isel(grid=slice(0, grid + 1)))[0]
        return _on_grid(data, name, grid=grid, periods=self.periods)

    def grid_errors(self, name: str) -> Array:
        """Half of the 95 % interval of what the grids leave, (load,): alike on all surfaces, it does not average."""
        if name == "area":
            errors = np.array([area_limits(data)[1] for data in self.ending[-1]])
        else:
            finest, before = (
                np.array([_on_grid(data, name, grid=g, periods=self.periods) for data in self.ending[-1]])
                for g in (-1, -2)
            )
            errors = (finest - before) / 2
        return np.asarray(1.96 * np.sqrt(np.mean(errors**2, axis=0)))

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

    def savings(self, chains: Sequence[Sequence[Controlled]]) -> Array:
        """Return the processor time of plain means over single surfaces, for the same intervals, over that spent, (load,).

        The scatter of single surfaces is that of the coarsest grid, on which there are many; each takes all grids.
        """
        coarse = self._pairs("area", 0, 0, paired=False)
        seconds = [
            np.array([data.seconds.sum(("grid", "shift")).values for data in group]) for group in self.ending
        ]
        found = [chain[-1].estimate for chain in chains]
        asked = np.array([one.half_width / one.value for one in found]) / scipy.stats.norm.ppf(0.975)
        plain = (coarse.std(axis=1, ddof=1) / coarse.mean(axis=1) / asked) ** 2 * seconds[-1].mean(axis=0)
        spent = sum(group.sum(axis=0) for group in seconds) + self.unsolved_seconds
        return np.asarray(plain / spent)


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
    drawn = _Drawn(base=base, grids=grids, tolerance=tolerance)
    solved: dict[_Name, xr.Dataset] = {}
    for _ in range(_ROUNDS):
        solved |= results_of(bench, {name: case for name, case in drawn.cases() if name not in solved})
        samples = drawn.samples(solved)
        (chain,) = samples.chains("area")
        found = MeanArea(
            estimate=chain[-1].estimate,
            grid=float(samples.grid_errors("area")[0]),
            pairs=tuple(drawn.counts),
            unsolved=len(samples.further),
            samples=samples,
        )
        asked = float(np.sqrt(max((half_width * found.estimate.value) ** 2 - found.grid**2, 0.0)))
        if found.estimate.half_width <= asked or asked == 0:
            break
        aim = asked * found.estimate.standard_error / found.estimate.half_width
        drawn.grow(allocation(samples.parts(chain), aim))
    return found


class _Drawn:
    """Surfaces of one spectrum that are solved or looked at so far; their numbers only grow."""

    def __init__(self, *, base: Realised, grids: tuple[Grid, ...], tolerance: float) -> None:
        self.base, self.grids, self.tolerance = base, grids, tolerance
        self.counts = list(_FIRST)
        # First and count of those that are looked at: of the coarsest grid, and of no grid.
        self.told, self.further = [(0, _FIRST[0])], [(len(grids) * _APART, _FIRST_UNSOLVED)]

    def cases(self) -> Iterator[tuple[_Name, Measurement | UnsolvedPairs]]:
        for last, count in enumerate(self.counts):
            for k, sign in itertools.product(range(count), (0, 1)):
                yield (
                    (last, k, sign),
                    Measurement(
                        realised=replace(self.base.further(k + last * _APART), inverted=bool(sign)),
                        grids=self.grids[: last + 1],
                        shifts=1,
                        tolerance=self.tolerance,
                    ),
                )
        for first, count in (*self.told, *self.further):
            yield (
                (first, count),
                UnsolvedPairs(realised=self.base, grid=self.grids[0], first=first, count=count),
            )

    def samples(self, solved: Mapping[_Name, xr.Dataset]) -> Samples:
        told, further = ([solved[part] for part in which] for which in (self.told, self.further))
        return Samples(
            ending=[
                [solved[last, k, sign] for k in range(count) for sign in (0, 1)]
                for last, count in enumerate(self.counts)
            ],
            unsolved=np.concatenate([data.value.values for data in told]),
            further=np.concatenate([data.value.values for data in further]),
            unsolved_seconds=sum(float(data.attrs["seconds"]) for data in (*told, *further)),
            periods=min(self.base.lengths) / self.base.longest,
        )

    def grow(self, numbers: Sequence[int]) -> None:
        """Take so many pairs that end with each grid, and so many that are only looked at."""
        *solves, unsolved = numbers
        grown = [max(old, new) for old, new in zip(self.counts, solves, strict=True)]
        known = sum(count for _, count in self.further)
        if grown[0] > self.counts[0]:
            self.told.append((self.counts[0], grown[0] - self.counts[0]))
        if unsolved > known:
            self.further.append((self.further[0][0] + known, unsolved - known))
        self.counts = grown
