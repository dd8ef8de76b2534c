"""Means over the surfaces of a spectrum: what was read off them, sorted by the grid they end with, and how many it takes."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.special
import xarray as xr

from validation.arrays import Array, Grid
from validation.errors import NoLimit
from validation.execution.bench import Bench
from validation.execution.measurement import Call
from validation.measurements.control_variates import unsolved_pairs
from validation.measurements.controlled import Controlled, Known, Level, allocation, chained_mean
from validation.measurements.limits import solved
from validation.measurements.measurement import TOLERANCES_LEFT, area_limits, grid_for
from validation.measurements.pairs import Areas, area_pairs
from validation.measurements.statistics import Estimate, pair_means
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec

#: Pairs of a first look, by the grid they end with, which then grow by blocks of the same size; and how often the
#: numbers are chosen anew from what was found.
_FIRST, _ROUNDS = (16, 6, 2), 8
#: Pairs that are not solved, of a first look.
_FIRST_UNSOLVED = 64
#: Between the first surfaces that end with different grids, and the first that are not solved.
_APART = 1_000_000
#: Largest factor of Student's that numbers are first chosen with.
_STUDENT = 2.1
#: Share of an interval that the grids may take; with more, surfaces that make up for it are too many.
_GRID_SHARE = 0.9

#: Last grid, or how many there are for pairs that are only looked at; and the first pair of a block.
_Name = tuple[int, int]

#: Name: unit, meaning. All means over the surfaces of a spectrum.
QUANTITIES = {
    "area": "A/A0, edge located inside the cells, limit over grids",
    "gap": "mean gap / h_rms",
    "compliance": "p0 / (K h_rms), K = d p0 / d(approach), the contact conductance in other units; 0 in full contact",
    "energy_ratio": "elastic energy / that of full contact",
    "density_slope": "slope of P(sigma), times (E* h'_rms)^2, fitted between .1 and .4 E* h'_rms",
    "patch_density": "contact patches per lambda_long^2",
}


@dataclass(frozen=True, kw_only=True)
class Chained(ABC):
    """Surfaces of one spectrum, in pairs +h, -h, some of which end with each grid."""

    unsolved: Array  # (n, k): Statistics without a solve of the pairs that end with the coarsest grid
    further: Array  # (m, k): The same of pairs that are not solved at all
    unsolved_seconds: float  # Processor time of the statistics of all these
    ending: Sequence[Any]  # What was read off, by the last grid the surfaces are solved on, coarsest first

    @property
    def levels(self) -> int:
        """Number of grids."""
        return len(self.ending)

    @abstractmethod
    def values(self, name: str, ending: int, grid: int) -> Array:
        """Return a quantity on one grid, (load, surface), of the surfaces that end with another."""

    @abstractmethod
    def seconds(self, ending: int) -> Array:
        """Processor time of each surface that ends with a grid, on all its grids, (surface, load)."""

    @abstractmethod
    def grid_errors(self, name: str) -> Array:
        """Half of the 95 % interval of what the grids leave, (load,): alike on all surfaces, it does not average."""

    def chains(self, name: str) -> list[tuple[Controlled, ...]]:
        """Return the controlled means of a quantity on all grids, for each load; the last is the one that is asked for."""
        numbers = [pair_means(self.values(name, 0, 0))]
        for last in range(1, self.levels):
            numbers += [pair_means(self.values(name, last, grid)) for grid in (last, last - 1)]
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

    def parts(self, chain: Sequence[Controlled]) -> list[tuple[float, float]]:
        """Return variance and processor time of one pair that ends with each grid, then of one that is not solved."""
        count = len(self.unsolved) + len(self.further)
        look = self.unsolved_seconds / count
        times = [2 * float(self.seconds(ending).sum(axis=1).mean()) for ending in range(self.levels)]
        slopes = chain[0].coefficients
        explained = float(slopes @ np.cov(self.further, rowvar=False) @ slopes)
        # The mean of a level is multiplied by the coefficients of those above it.
        factors = [
            float(np.prod([mean.coefficients for mean in chain[k + 1 :]])) ** 2 for k in range(len(chain))
        ]
        solves = [(f * mean.left, time) for f, mean, time in zip(factors, chain, times, strict=True)]
        return [(solves[0][0], solves[0][1] + look), *solves[1:], (factors[0] * explained, look)]

    def savings(self, chains: Sequence[Sequence[Controlled]]) -> Array:
        """Return the processor time of plain means over single surfaces, for the same intervals, over that spent, (load,).

        The scatter of single surfaces is that of the coarsest grid, on which there are many; each takes all grids.
        """
        coarse = self.values("area", 0, 0)
        seconds = [self.seconds(ending) for ending in range(self.levels)]
        estimates = [chain[-1].estimate for chain in chains]
        errors = np.array(
            [estimate.half_width / estimate.value for estimate in estimates]
        ) / scipy.special.ndtri(0.975)
        plain = (coarse.std(axis=1, ddof=1) / coarse.mean(axis=1) / errors) ** 2 * seconds[-1].mean(axis=0)
        spent = sum(group.sum(axis=0) for group in seconds) + self.unsolved_seconds
        return np.asarray(plain / spent)


@dataclass(frozen=True, kw_only=True)
class Samples(Chained):
    """Surfaces of which many quantities were measured at several loads."""

    ending: Sequence[Sequence[xr.Dataset]]  # Measurements by the last grid they are solved on, coarsest first
    periods: float  # L / lambda_long

    def values(self, name: str, ending: int, grid: int) -> Array:
        """Return a quantity on one grid; the area by its limit where the grids allow one."""
        return np.array([self._read(data, name, grid) for data in self.ending[ending]]).T

    def _read(self, data: xr.Dataset, name: str, grid: int) -> Array:
        if name == "area" and (grid >= 2 or grid == self.levels - 1):
            return area_limits(data.isel(grid=slice(0, grid + 1)))[0]
        return _on_grid(data, name, grid=grid, periods=self.periods)

    def seconds(self, ending: int) -> Array:
        """Processor time of the solves."""
        return np.array([data.seconds.sum(("grid", "shift")).values for data in self.ending[ending]])

    def grid_errors(self, name: str) -> Array:
        """Half of the 95 % interval of what the grids leave, (load,)."""
        if name == "area":
            errors = np.array([area_limits(data)[1] for data in self.ending[-1]])
        else:
            finest, before = (
                np.array([_on_grid(data, name, grid=g, periods=self.periods) for data in self.ending[-1]])
                for g in (-1, -2)
            )
            errors = (finest - before) / 2
        return np.asarray(1.96 * np.sqrt(np.mean(errors**2, axis=0)))


@dataclass(frozen=True, kw_only=True)
class _Pressed(Chained):
    """Surfaces whose contact area alone was read off, at one load."""

    ending: Sequence[Areas]

    def values(self, name: str, ending: int, grid: int) -> Array:
        areas = self.ending[ending]
        if grid >= 2 or grid == self.levels - 1:
            return np.array([[limit.value for limit in areas.limits(grid)]])
        return areas.on_grid(grid)[None]

    def seconds(self, ending: int) -> Array:
        return self.ending[ending].seconds[:, None]

    def grid_errors(self, name: str) -> Array:
        errors = [limit.uncertainty for limit in self.ending[-1].limits(self.levels - 1)]
        return np.array([1.96 * float(np.sqrt(np.mean(np.square(errors))))])

    @property
    def doubt(self) -> str:
        """Why a surface has no limit; empty where all have."""
        # Coarser ones are controls: their areas are read as they are.
        used = [areas for areas in self.ending if len(areas.grids) >= min(3, self.levels)]
        limits = (limit for areas in used for limit in areas.limits(len(areas.grids) - 1))
        return next((limit.doubt for limit in limits if limit.doubt), "")


def _on_grid(data: xr.Dataset, name: str, *, grid: int, periods: float) -> Array:
    if name == "compliance":
        return np.asarray((1 / data.stiffness.isel(grid=grid)).mean("shift").values)
    mean = data.isel(grid=grid).mean("shift")
    scales: Mapping[str, tuple[str, float]] = {
        "gap": ("mean_gap", 1 / data.attrs["rms_height"]),
        "energy_ratio": ("energy", 1 / data.attrs["full_contact_energy"]),
        "density_slope": ("slope", 1.0),
        "patch_density": ("patches", 1 / periods**2),
        "area": ("subcell", 1.0),
    }
    variable, scale = scales.get(name, (name, 1.0))
    return np.asarray(mean[variable].values * scale)


@dataclass(frozen=True, kw_only=True)
class MeanArea:
    """The mean A/A0 over all surfaces of a spectrum."""

    estimate: Estimate  # Limit over grids, with what the scatter of surfaces leaves
    grid: float  # Half of the 95 % interval of what grids and solver leave
    grids: tuple[Grid, ...]
    pairs: tuple[int, ...]  # Pairs +h, -h that end with each grid, coarsest first
    unsolved: int  # Further pairs that are only looked at
    scatter: float  # Standard deviation of single surfaces over the mean, on the coarsest grid
    peak_bytes: int  # Largest memory of the arrays of any solve
    samples: Chained

    @property
    def surfaces(self) -> int:
        """Surfaces that were solved."""
        return 2 * sum(self.pairs)

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval: surfaces, grids and solver."""
        return float(np.hypot(self.estimate.half_width, self.grid))


#: Called with what was found so far and the solves that come next; raises to stop.
Watch = Callable[[MeanArea, Sequence[Call]], None]


def mean_area(
    base: ContactProblem,
    *,
    half_width: float,
    bench: Bench,
    grids: Sequence[Grid] = (),
    effects: Sequence[EffectSpec] = (),
    tolerance: float = 1e-6,
    watch: Watch | None = None,
) -> MeanArea:
    """Mean contact area of all surfaces of a spectrum to a given accuracy, from as few solves as it takes.

    Parameters
    ----------
    base : ContactProblem
        Surface, solid and one load; each surface meets it as it is said, p* of its own gradient or one pressure for all.
    half_width : float
        Half of the 95 % interval that is asked for, relative to the mean: surfaces, grids and solver.
    grids : sequence of (int, int)
        Two or three, ascending; of 3, 6 and 12 points per shortest wave if not given.
    effects : sequence
        Of a scene: of those whose corrected area has a law of error (`fem_contact.extrapolation.perimeter_limit`).
    tolerance : float
        Of the solver; seven times that is counted as left.
    watch : callable, optional
        Called before each round but the first with what was found and the solves that come next; raises to stop.

    Returns
    -------
    MeanArea
        Wider than asked where the grids leave nine tenths of that or more, or eight rounds did not suffice.

    Raises
    ------
    NoLimit
        For a surface without a limit, as a contact of too few points has none.

    Notes
    -----
    After a first look the numbers of pairs are those of least cost (`allocation`), from the variances and times found.
    """
    grids = tuple(grids) or tuple(grid_for(base, points) for points in (3.0, 6.0, 12.0))
    drawn = _Drawn(base=base, grids=grids, tolerance=tolerance, effects=tuple(effects))
    known: dict[_Name, xr.Dataset] = solved(bench, drawn.cases())
    for rounds in itertools.count(1):
        result, chain = _estimated(drawn, known)
        target = half_width * result.estimate.value
        left = float(np.sqrt(max(target**2 - result.grid**2, 0.0)))
        enough = result.estimate.half_width <= left or result.grid >= _GRID_SHARE * target
        if enough or rounds == _ROUNDS:
            break
        factor = result.estimate.half_width / result.estimate.standard_error
        parts = result.samples.parts(chain)
        # What Student's factor of few pairs adds goes with more of them.
        drawn.grow(allocation(parts, left / min(factor, _STUDENT)))
        missing = {name: case for name, case in drawn.cases().items() if name not in known}
        if not missing:
            drawn.grow(allocation(parts, left / factor))
            missing = {name: case for name, case in drawn.cases().items() if name not in known}
        if watch is not None:
            watch(result, tuple(missing.values()))
        known |= solved(bench, missing)
    return result


def _estimated(drawn: _Drawn, known: Mapping[_Name, xr.Dataset]) -> tuple[MeanArea, tuple[Controlled, ...]]:
    samples = drawn.samples(known)
    if samples.doubt:
        raise NoLimit(f"a surface of the ensemble has no limit: {samples.doubt}; all solves are stored")
    (chain,) = samples.chains("area")
    estimate, coarse = chain[-1].estimate, samples.values("area", 0, 0)
    return (
        MeanArea(
            estimate=estimate,
            grid=float(samples.grid_errors("area")[0]) + TOLERANCES_LEFT * drawn.tolerance * estimate.value,
            grids=drawn.grids,
            pairs=tuple(drawn.counts),
            unsolved=len(samples.further),
            scatter=float(coarse.std(ddof=1) / coarse.mean()),
            peak_bytes=max(areas.peak_bytes for areas in samples.ending),
            samples=samples,
        ),
        chain,
    )


@dataclass(kw_only=True)
class _Drawn:
    """Surfaces of one spectrum that are solved or looked at so far; their numbers only grow."""

    base: ContactProblem
    grids: tuple[Grid, ...]
    tolerance: float
    effects: tuple[EffectSpec, ...] = ()
    counts: list[int] = field(init=False)
    further: int = _FIRST_UNSOLVED

    def __post_init__(self) -> None:
        self.counts = [self._block(last) for last in range(len(self.grids))]

    def cases(self) -> dict[_Name, Call]:
        """Return the blocks of pairs that end with each grid, and of those that are only looked at."""
        calls: dict[_Name, Call] = {}
        for last, count in enumerate(self.counts):
            size = self._block(last)
            for k in range(0, count, size):
                calls[last, k] = area_pairs(
                    problem=self.base,
                    grids=self.grids[: last + 1],
                    first=k + last * _APART,
                    count=size,
                    tolerance=self.tolerance,
                    effects=self.effects,
                )
        for k in range(0, self.further, _FIRST_UNSOLVED):
            first = k + len(self.grids) * _APART
            calls[len(self.grids), k] = unsolved_pairs(
                problem=self.base, grid=self.grids[0], first=first, count=_FIRST_UNSOLVED
            )
        return calls

    def _block(self, last: int) -> int:
        return _FIRST[0] if last == 0 else _FIRST[len(_FIRST) - len(self.grids) + last]

    def samples(self, known: Mapping[_Name, xr.Dataset]) -> _Pressed:
        cases = self.cases()
        parts = [[name for name in cases if name[0] == last] for last in range(len(self.grids) + 1)]
        ending = [Areas.joined(cases[names[0]], [known[name] for name in names]) for names in parts[:-1]]
        looked = [known[name] for name in parts[-1]]
        return _Pressed(
            ending=ending,
            unsolved=np.concatenate([known[name].value.values for name in parts[0]]),
            further=np.concatenate([data.value.values for data in looked]),
            # Of the pairs that are solved, too: as long for each as for those that are not.
            unsolved_seconds=sum(float(data.attrs["seconds"]) for data in looked)
            * (1 + self.counts[0] / self.further),
        )

    def grow(self, numbers: Sequence[int]) -> None:
        """Take at least so many pairs that end with each grid, and so many that are only looked at, in whole blocks."""
        *solves, unsolved = numbers
        self.counts = [
            max(old, self._block(last) * math.ceil(new / self._block(last)))
            for last, (old, new) in enumerate(zip(self.counts, solves, strict=True))
        ]
        self.further = max(self.further, _FIRST_UNSOLVED * math.ceil(unsolved / _FIRST_UNSOLVED))
