"""What the reference table is made of: means over the surfaces of a spectrum, at loads by either gradient, and parts joined."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline, PchipInterpolator

from validation.arrays import Array
from validation.errors import UsageError
from validation.execution.measurement import Call
from validation.measurements.common import persson_area
from validation.measurements.control_variates import unsolved_pairs
from validation.measurements.ensemble import QUANTITIES, Samples
from validation.measurements.limits import ABSENT
from validation.measurements.measurement import TOLERANCES_LEFT, grid_for, press_on_grids
from validation.report.estimates import LIMIT, claim, error_of
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import SelfAffineSurface
from validation.scenes.surfaces import spectrum_of

#: A quantity beside those of `Samples`: the area at p* = p0 / (E* h'_rms) with the gradient of C(q).
BY_SPECTRUM = "area_by_spectrum"


def at_loads(
    areas: Array, *, loads: Array, wanted: Array, interpolator: Callable[..., Any] = CubicSpline
) -> Array:
    """Read A/A0 of a surface off between its loads: A over Persson's is interpolated in ln p*.

    Parameters
    ----------
    areas, loads : (n,) arrays
        A/A0 at p*, rising.
    wanted : (m,) array
        p*; a little beyond the first and the last it is extrapolated.
    """
    ratio = areas / persson_area(loads)
    return np.asarray(persson_area(wanted) * interpolator(np.log(loads), ratio)(np.log(wanted)))


@dataclass(frozen=True, kw_only=True)
class LoadedSamples(Samples):
    """Surfaces of one spectrum with the area at both kinds of p*."""

    loads: Array  # (n,): p* of the solves, by the gradient of each surface
    gradient: float  # h'_rms of C(q)

    def _read(self, data: xr.Dataset, name: str, grid: int) -> Array:
        if name != BY_SPECTRUM:
            return super()._read(data, name, grid)
        return at_loads(super()._read(data, "area", grid), loads=self.loads, wanted=self._wanted(data))

    def _wanted(self, data: xr.Dataset) -> Array:
        return np.asarray(self.loads * self.gradient / data.attrs["rms_gradient"])

    def grid_errors(self, name: str) -> Array:
        """Half of the 95 % interval of what the grids leave; that of the area by either load."""
        return super().grid_errors("area" if name == BY_SPECTRUM else name)

    def reading_errors(self) -> Array:
        """Mean distance of `BY_SPECTRUM` by a cubic spline from that by monotone cubics, (load,)."""
        differences = []
        for data in self.ending[0]:
            areas, wanted = super()._read(data, "area", 0), self._wanted(data)
            smooth, monotone = (
                at_loads(areas, loads=self.loads, wanted=wanted, interpolator=kind)
                for kind in (CubicSpline, PchipInterpolator)
            )
            differences.append(smooth - monotone)
        return np.asarray(np.abs(np.mean(differences, axis=0)))


def controlled_means(samples: LoadedSamples, *, tolerance: float) -> xr.Dataset:
    """Reduce the surfaces of one spectrum: the controlled mean of each quantity over (reduced_pressure), with its errors.

    ``saving`` is the time of plain means of the same interval over the time spent; ``area_by_spectrum_reading`` what the
    interpolation to these loads leaves, a part of the grids' error.
    """
    at = {"reduced_pressure": samples.loads}
    data = xr.Dataset(coords=at)
    reading = xr.DataArray(samples.reading_errors(), dims="reduced_pressure", coords=at)
    for name in (*QUANTITIES, BY_SPECTRUM):
        chains = samples.chains(name)
        estimates = [chain[-1].estimate for chain in chains]
        value, half, grid = (
            xr.DataArray(numbers, dims="reduced_pressure", coords=at)
            for numbers in (
                [estimate.value for estimate in estimates],
                [estimate.half_width for estimate in estimates],
                samples.grid_errors(name),
            )
        )
        data[name] = value.assign_attrs(reduction="controlled mean")
        data[f"{name}_error"] = error_of(
            value,
            surfaces=half,
            grid=(grid**2 + reading**2) ** 0.5 if name == BY_SPECTRUM else grid,
            solver=TOLERANCES_LEFT * tolerance * value,
            **ABSENT,
        )
        # Where the size of the sample was looked at, it is a part of the interval.
        data[f"{name}_error"].attrs[LIMIT] = "size"
        if name == "area":
            data["saving"] = ("reduced_pressure", samples.savings(chains))
    data[f"{BY_SPECTRUM}_reading"] = reading
    return data


#: Order in which grids came to the table, which numbers its pairs and so keeps its solves.
_GREW = (2, 0, 1)


@dataclass(frozen=True, kw_only=True)
class SampledSpectrum:
    """Pairs +h, -h of one spectrum, some of which end with each grid, and pairs that are only looked at."""

    base: ContactProblem
    loads: tuple[float, ...]  # p*, by the gradient of each surface
    points_per_wave: tuple[float, ...]  # Grids, coarse first
    pairs: tuple[int, ...]  # That end with each grid
    unsolved: int  # Pairs that are only looked at, for each that ends with the coarsest grid
    shifts: int
    tolerance: float

    @property
    def cases(self) -> dict[tuple[Any, ...], Call]:
        """Solves by last grid, number of the pair and sign; statistics without a solve by the pairs they are of."""
        order = sorted(range(len(self.pairs)), key=lambda g: _GREW.index(g) if g in _GREW else g)
        lasts = [last for last in order for _ in range(self.pairs[last])]
        grids = tuple(grid_for(self.base, points) for points in self.points_per_wave)
        calls: dict[tuple[Any, ...], Call] = {
            (last, k, inverted): press_on_grids(
                problem=replace(self.base.further(k), inverted=inverted),
                reduced_pressures=self.loads,
                grids=grids[: last + 1],
                shifts=self.shifts,
                tolerance=self.tolerance,
                keep=("stiffness", "slope"),
            )
            for k, last in enumerate(lasts)
            for inverted in (False, True)
        }
        coarsest = self.pairs[0]
        further = {"first": len(lasts), "count": coarsest * self.unsolved}
        looked = {"coarsest": {"first": lasts.index(0), "count": coarsest}, "further": further}
        return calls | {
            (name,): unsolved_pairs(problem=self.base, grid=grids[0], **which)
            for name, which in looked.items()
        }

    def reduced(self, measured: Mapping[tuple[Any, ...], xr.Dataset]) -> xr.Dataset:
        """Reduce the results of `cases`: the controlled means, and how many pairs end with which points per wave."""
        surface = self.base.surface
        assert isinstance(surface, SelfAffineSurface)
        coarsest, further = measured["coarsest",], measured["further",]
        samples = LoadedSamples(
            ending=[
                [data for case, data in measured.items() if case[0] == last]
                for last in range(len(self.pairs))
            ],
            unsolved=coarsest.value.values,
            further=further.value.values,
            unsolved_seconds=float(coarsest.attrs["seconds"]) + float(further.attrs["seconds"]),
            periods=surface.length[0] / surface.lambda_long,
            loads=np.array(self.loads),
            gradient=float(spectrum_of(surface).m2() ** 0.5),
        )
        ends = zip(self.pairs, self.points_per_wave, strict=True)
        pairs = ", ".join(f"{count} on {points:g}" for count, points in ends)
        return controlled_means(samples, tolerance=self.tolerance).assign(pairs=pairs)


#: Of relative intervals: below it two numbers are the same.
_SURE = 1e-12


def joined(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return one table of parts with some of its Hurst exponents and bandwidths; NaN where nobody made a cell.

    Parameters
    ----------
    parts : sequence of xarray.Dataset
        Of `fem-contact study reference`, each with the same loads and `periods`.

    Raises
    ------
    UsageError
        For parts that were not made alike.
    """
    for name in ("study", "periods", "tolerance"):
        values = sorted({str(part.attrs.get(name)) for part in parts})
        if len(values) != 1:
            raise UsageError(f"{name} = {', '.join(values)}: the parts of a table have one")
    table = xr.merge([part.drop_attrs(deep=False) for part in parts], join="outer", compat="no_conflicts")
    table["pairs"] = table.pairs.fillna("")
    return table.sortby(["hurst", "bandwidth", "reduced_pressure"]).assign_attrs(parts[0].attrs)


def with_size(table: xr.Dataset, larger: xr.Dataset) -> xr.Dataset:
    r"""Claim what the size of the sample leaves, from some of the spectra of a table on samples of another size.

    .. math:: s = \max(|\bar d|, w), \qquad d = Q_\mathrm{larger} / Q_\mathrm{table} - 1

    The mean of d is over the cells that both have, weighed by the surfaces' variances, and w half of its 95 % interval;
    the grids are off alike on both and leave d. There is one s for each of `QUANTITIES` and load.
    """
    cells = ("hurst", "bandwidth")
    same = table.sel({name: larger[name] for name in cells})
    claimed = table
    for name in QUANTITIES:
        small, other = same[name], larger[name]
        widths = [part[f"{name}_error"].sel(source="surfaces", drop=True) for part in (same, larger)]
        # Nothing gives way in full contact, on samples of any size.
        scale = abs(small).where(small != 0, 1.0)
        weight = ((widths[0] ** 2 + widths[1] ** 2) / scale**2).clip(min=_SURE**2) ** -1.0
        mean = (weight * (other - small) / scale).sum(cells) / weight.sum(cells)
        share = np.maximum(abs(mean), weight.sum(cells) ** -0.5)
        claimed = claim(claimed, name, size=abs(table[name]) * share)
    return claimed.assign_attrs(larger_periods=larger.attrs["periods"])
