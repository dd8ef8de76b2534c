"""What the reference table is made of: means over the surfaces of a spectrum, at loads by either gradient, and parts joined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PchipInterpolator

from persson import elastic
from validation.arrays import Array
from validation.errors import UsageError
from validation.execution.measurement import Call
from validation.measurements.control_variates import unsolved_pairs
from validation.measurements.ensemble import Chained, common_error
from validation.measurements.limits import ABSENT, Measured
from validation.measurements.measurement import (
    TOLERANCES_LEFT,
    area_limits,
    grids_for,
    press_on_grids,
    reduced_numbers,
)
from validation.report.estimates import LIMIT, claim, error_of
from validation.scenes.problem import ContactProblem
from validation.scenes.surfaces import spectrum_of
from validation.scenes.tables import SelfAffineSurface

QUANTITIES = ("area", "gap", "compliance", "energy_ratio", "density_slope", "patch_density")
#: The area at p* = p0 / (E* h'_rms) with the gradient of C(q).
BY_SPECTRUM = "area_by_spectrum"


def at_loads(
    areas: Array, *, loads: ArrayLike, targets: Array, interpolator: Callable[..., Any] = CubicSpline
) -> Array:
    """Read A/A0 (n,) of a surface off between its rising loads p*, at `targets` p* (m,).

    A over Persson's is interpolated in ln p*; a little beyond the first and the last it is extrapolated.
    """
    theory = partial(elastic.contact_area, stress_variance=0.25)  # of Persson; V is (E* h'_rms)^2 / 4
    ratio = areas / theory(loads)
    return np.asarray(theory(targets) * interpolator(np.log(loads), ratio)(np.log(targets)))


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
        grids = grids_for(self.base, self.points_per_wave)
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
        looked = partial(unsolved_pairs, problem=self.base, grid=grids[0])
        coarsest = self.pairs[0]
        calls["coarsest",] = looked(first=lasts.index(0), count=coarsest)
        calls["further",] = looked(first=len(lasts), count=coarsest * self.unsolved)
        return calls

    @cached_property
    def _gradient(self) -> float:
        surface = self.base.surface
        assert isinstance(surface, SelfAffineSurface)
        return float(spectrum_of(surface).m2() ** 0.5)

    def _by_spectrum(self, data: xr.Dataset, grid: int, **how: Any) -> Array:
        """Areas at p* by the gradient of a surface where that by the gradient of C(q) is one of the loads."""
        wanted = np.asarray(self.loads) * self._gradient / data.attrs["rms_gradient"]
        return at_loads(self._values(data, "area", grid), loads=self.loads, targets=wanted, **how)

    def _values(self, data: xr.Dataset, name: str, grid: int) -> Array:
        """Return a quantity of a surface on one grid over the loads; the area by its limit where the grids allow one."""
        if name == BY_SPECTRUM:
            return self._by_spectrum(data, grid)
        if name == "area" and (grid >= 2 or grid == len(self.pairs) - 1 > 0):
            return area_limits(data.isel(grid=slice(0, grid + 1)))[0]
        on_grid, periods = data.isel(grid=grid), self.base.lengths[0] / self.base.longest
        read = reduced_numbers(on_grid) | {"area": on_grid.subcell, "density_slope": on_grid.slope}
        read["patch_density"] = on_grid.patches / periods**2
        return np.asarray(read[name].mean("shift").values)

    def _grid_errors(self, name: str, finest: Sequence[xr.Dataset]) -> Array:
        """Half of the 95 % interval of what the grids leave, (load,): alike on all surfaces, it does not average."""
        if len(self.pairs) == 1:
            return np.full(len(self.loads), np.nan)
        if name in ("area", BY_SPECTRUM):
            return common_error([area_limits(data)[1] for data in finest])
        return common_error(
            [(self._values(data, name, -1) - self._values(data, name, -2)) / 2 for data in finest]
        )

    def reduced(self, measured: Measured) -> xr.Dataset:
        """Reduce the results of `cases`: the controlled mean of each quantity over (reduced_pressure), with its errors.

        ``saving`` is the time of plain means of the same interval over the time spent;
        ``area_by_spectrum_reading`` what the interpolation to these loads leaves, a part of the grids' error.
        """
        ending = [
            [data for case, data in measured.items() if case[0] == last] for last in range(len(self.pairs))
        ]
        chained = Chained.of(
            [measured["coarsest",]],
            [measured["further",]],
            [np.array([d.seconds.sum(("grid", "shift")).values for d in group]) for group in ending],
        )
        over_loads = partial(
            xr.DataArray, dims="reduced_pressure", coords={"reduced_pressure": list(self.loads)}
        )
        # Cubic splines beside monotone cubics.
        differences = [
            self._by_spectrum(surface, 0) - self._by_spectrum(surface, 0, interpolator=PchipInterpolator)
            for surface in ending[0]
        ]
        reading = over_loads(np.abs(np.mean(differences, axis=0)))
        data = xr.Dataset()
        for name in (*QUANTITIES, BY_SPECTRUM):

            def values(last: int, grid: int, name: str = name) -> Array:
                return np.array([self._values(data, name, grid) for data in ending[last]]).T

            chains = chained.chains(values)
            value = over_loads([chain[-1].value for chain in chains])
            grid = over_loads(self._grid_errors(name, ending[-1]))
            errors = {
                "surfaces": over_loads([chain[-1].half_width for chain in chains]),
                "grid": (grid**2 + reading**2) ** 0.5 if name == BY_SPECTRUM else grid,
                "solver": TOLERANCES_LEFT * self.tolerance * value,
            }
            data[name] = value.assign_attrs(reduction="controlled mean")
            # Where the size of the sample was looked at, it is a part of the interval.
            data[f"{name}_error"] = error_of(value, **errors, **ABSENT).assign_attrs({LIMIT: "size"})
            if name == "area":
                data["saving"] = over_loads(chained.savings(chains, values(0, 0)))
        ends = zip(self.pairs, self.points_per_wave, strict=True)
        pairs = ", ".join(f"{count} on {points:g}" for count, points in ends)
        return data.assign({f"{BY_SPECTRUM}_reading": reading, "pairs": pairs})


#: Of relative intervals: below it two numbers are the same.
_SURE = 1e-12


def joined(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return one table of parts with some of its Hurst exponents and bandwidths; NaN where nobody made a cell.

    The parts are of `fem-contact study reference`; UsageError where they were not made alike.
    """
    for name in ("study", "periods", "tolerance", "rolloff"):
        values = sorted({str(({"rolloff": "sharp"} | part.attrs).get(name)) for part in parts})
        if len(values) != 1:
            raise UsageError(f"{name} = {', '.join(values)}: the parts of a table have one")
    table = xr.merge([part.drop_attrs(deep=False) for part in parts], join="outer", compat="no_conflicts")
    if "pairs" in table:
        table["pairs"] = table.pairs.fillna("")
    return table.sortby(["hurst", "bandwidth", "reduced_pressure"]).assign_attrs(parts[0].attrs)


def with_size(table: xr.Dataset, small: xr.Dataset, larger: xr.Dataset) -> xr.Dataset:
    r"""Claim what the size of the sample leaves: the change from samples as in a table to larger ones, on one grid.

    .. math:: s = 2 |\bar d| + w, \qquad d = Q_\mathrm{larger} / Q_\mathrm{small} - 1

    What is left after a doubling is at most that once more, if it falls like 1/L or faster. d is fitted by a plane
    in H and the logarithm of the bandwidth, weighed by the surfaces' variances, for each of `QUANTITIES` and
    load; w is half of the 95 % interval of the plane. Of a single H or bandwidth it does not depend on it.
    """
    dims = ("reduced_pressure", "hurst", "bandwidth")
    middle = [float(of.mean()) for of in (small.hurst, np.log(small.bandwidth))]

    def plane(part: xr.Dataset) -> Array:
        places = np.meshgrid(part.hurst - middle[0], np.log(part.bandwidth) - middle[1], indexing="ij")
        return np.stack([np.ones(places[0].size), *(of.ravel() for of in places)], 1)

    def flat(values: xr.DataArray) -> Array:
        return values.transpose(..., *dims).values.reshape(small.sizes["reduced_pressure"], -1)

    claimed = table
    for name in QUANTITIES:
        widths = [part[f"{name}_error"].sel(source="surfaces", drop=True) for part in (small, larger)]
        # Nothing gives way in full contact, on samples of any size.
        scale = abs(small[name]).where(small[name] != 0, 1.0)
        weight = flat(((widths[0] ** 2 + widths[1] ** 2) / scale**2).clip(min=_SURE**2) ** -1.0)
        # So that cells without a scatter leave the others a say.
        root = np.minimum(weight, 1e6 * np.median(weight, axis=1, keepdims=True))[..., None] ** 0.5
        change = flat((larger[name] - small[name]) / scale)[..., None]
        # Values of the plane in the cells of the table, of those in the cells that were doubled.
        across = plane(table) @ np.linalg.pinv(plane(small) * root, rcond=1e-6)
        like = table[name].transpose(..., *dims)
        size = 2 * abs(across @ (root * change))[..., 0] + np.linalg.norm(across, axis=-1)
        claimed = claim(claimed, name, size=abs(like) * size.reshape(like.shape))
    return claimed.assign_attrs(larger_periods=larger.attrs["periods"])
