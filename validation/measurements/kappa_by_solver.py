"""kappa of the same surfaces by several solvers, each by its own limit over its own grids."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from validation.execution.measurement import Call
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import base_surface
from validation.measurements.convergence import pressed_pairs
from validation.measurements.grids import method_limit
from validation.measurements.limits import limits_of
from validation.measurements.measurement import grid_for
from validation.report.estimates import derive, gather, mean
from validation.solvers import chosen_solver

_Case = tuple[Any, ...]


@dataclass(frozen=True, kw_only=True)
class KappaBySolver:
    """Which surfaces are pressed, and by whom beside boundary elements; the surfaces are pairs +h, -h."""

    solvers: tuple[str, ...]
    hursts: tuple[float, ...]
    bandwidth: float
    periods: float
    reduced_pressure: float
    pairs: int
    shifts: int
    seed: int
    bem_points_per_wave: tuple[float, ...]
    points_per_wave: tuple[float, ...]

    @property
    def cases(self) -> dict[_Case, Call]:
        """All solves: ("solver", name, H, surface), behind it points per wave where boundary elements stand beside."""
        cases: dict[_Case, Call] = {}
        for hurst in self.hursts:
            surface = base_surface(
                hurst=hurst, bandwidth=self.bandwidth, periods=self.periods, seed=self.seed
            )
            loads, per_wave = (self.reduced_pressure,), self.bem_points_per_wave
            solves = pressed_pairs(surface, loads, per_wave, pairs=self.pairs, shifts=self.shifts)
            cases |= {("solver", "bem", hurst, k): solve for k, solve in enumerate(solves)}
            for name, (k, solve), n in itertools.product(
                self.solvers, enumerate(solves), self.points_per_wave
            ):
                solver, settings = chosen_solver(name)
                cases["solver", name, hurst, k, n] = beside_bem(
                    problem=solve["problem"],
                    grid=grid_for(solve["problem"], n),
                    method=solver.name,
                    settings=tuple(settings.items()),
                )
        return cases

    def reduced(self, measured: Mapping[_Case, xr.Dataset]) -> xr.Dataset:
        """Reduce the results of `cases`: kappa (solver, hurst) by the solver's own limit, and over boundary elements'."""
        cases, parts = self.cases, dict[_Case, xr.Dataset]()
        for name, hurst, k in dict.fromkeys(case[1:4] for case in cases):
            if name == "bem":
                limit = limits_of(measured["solver", name, hurst, k]).isel(load=0, drop=True)
                limit = limit[["area_each", "area_each_error"]].drop_vars("reduced_pressure", errors="ignore")
            else:
                places = [("solver", name, hurst, k, n) for n in self.points_per_wave]
                answers = [measured[place] for place in places]
                limit = method_limit(answers, [cases[place]["grid"] for place in places])
                limit = limit.rename({name: str(name).replace("_other", "") for name in limit})
            parts[name, hurst, k] = limit.drop_attrs().assign_attrs(limit.attrs)
        surfaces = {"surface_by_solver": range(2 * self.pairs)}
        data = gather(parts, solver=("bem", *self.solvers), hurst=self.hursts, **surfaces)
        renamed = {name: str(name).replace("area", "area_by_solver") for name in data if name != "solve"}
        bem = data[[*renamed]].sel(solver="bem", drop=True)
        data = data.rename(renamed | {"solve": "solve_by_solver"}).drop_vars("surface_by_solver")
        data = data.assign({str(name).replace("area", "area_bem"): bem[name] for name in renamed})
        data["reduced_pressure_by_solver"] = self.reduced_pressure
        data["bandwidth_by_solver"] = self.bandwidth
        data = derive(
            data,
            kappa_persson_by_solver="erf(2**.5 * reduced_pressure_by_solver) / reduced_pressure_by_solver",
            kappa_by_solver_each="area_by_solver_each / reduced_pressure_by_solver",
            kappa_by_solver_difference_each="area_by_solver_each / area_bem_each - 1",
        )
        # The grids of a method are off to one side on all surfaces.
        names = ("kappa_by_solver", "kappa_by_solver_difference")
        return mean(data, *names, over="surface_by_solver", pairs=True, alike=True)
