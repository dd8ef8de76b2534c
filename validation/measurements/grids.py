"""Areas on every grid: of boundary elements, finite elements, other methods; observed orders; roughness down to the grid scale."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy.special
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.surface import HeightField
from persson.elastic import pressure_distribution, stress_variance
from validation.arrays import Array, Grid
from validation.effects.base import ContactModel
from validation.execution.measurement import measurement
from validation.execution.solve import Prediction
from validation.measurements.common import reduced_load
from validation.measurements.limits import Measured, limit_dataset, limits_of, shift_means
from validation.measurements.measurement import PATCH_EDGES, STRESS_EDGES, limit_over, no_limit, stored_areas
from validation.measurements.references import published
from validation.measurements.statistics import order_of_convergence, weighted_percentile
from validation.report.estimates import change, claim, claim_shares, derive, error_of, mean
from validation.report.places import gather
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SelfAffineSurface
from validation.solvers import find_solver

#: Stress, over E* h'_rms, that is small; distance from the limit that is close.
SMALL, _CLOSE = 0.2, 0.05
#: Points per shortest wave at and below which nothing is resolved.
_RESOLVED = 2 * (1 + 1e-9)
#: Parts of the contact area at which patch sizes are read: newborn patches are one cell on every grid, and count little.
_PARTS = (0.1, 0.5, 0.9)


def on_grids(measured: xr.Dataset, *, wave_share: float) -> xr.Dataset:
    """Reduce a measurement that keeps distributions, at one load: its limit, and over (grid) areas, moments of P(sigma), patches, cost.

    `wave_share` is that of lambda_short^2 in the period.
    """
    data = limits_of(measured).isel(load=0, drop=True)
    bare = measured.drop_vars(["points", "cells"], errors="ignore")
    plain = bare.isel(load=0, drop=True)
    names = {"area_pixel": "pixel", "area_perimeter": "perimeter", "area_located": "subcell"}
    names |= {n: n for n in ("density_at_zero", "patches", "cells_per_patch", "edge_fraction", "residual")}
    at_load = {name: f"{of}.isel(load=0)" for name, of in names.items()}
    read: dict[str, Any] = shift_means(bare, **at_load)
    width = np.diff(STRESS_EDGES)[0]
    cells = [
        [weighted_percentile(row, PATCH_EDGES, part) * wave_share * n for part in _PARTS]
        for row, n in zip(plain.patch_area_profile.values, measured.cells.values, strict=True)
    ]
    return data.assign(
        **read,
        seconds_each=plain.seconds.sum("shift"),
        first_moment_each=plain.load_profile.sum("load_bin"),
        stress_density_each=(("grid", "stress_bin"), plain.stress_profile.values / width),
        cells_at_part_each=(("grid", "part"), cells),
    ).assign_coords(
        points=("grid", measured.points.values),
        stress=("stress_bin", (STRESS_EDGES[1:] + STRESS_EDGES[:-1]) / 2),
        part=list(_PARTS),
    )


def with_distances(data: xr.Dataset, *, theory: bool) -> xr.Dataset:
    """Add kappa, distances from the limit with their orders, and what P(sigma) has too much of on a coarse grid.

    To `on_grids` by surface, with ``area_persson_each``, ``area_ensemble_each`` and ``reduced_pressure``;
    `theory` is whether its P(sigma) is that of the bare half-space.
    """
    resolved, areas = data.points_per_wave.values > _RESOLVED, ("pixel", "perimeter", "located")
    data = data.assign_coords(resolution=("grid", np.where(resolved, "resolved", "under-resolved")))
    first = int(np.argmax(resolved))
    data = derive(
        data,
        kappa_each="area_each / reduced_pressure",
        kappa_pixel_each="area_pixel_each / reduced_pressure",
        area_persson="area_persson_each.mean('surface')",
        kappa_persson="area_persson / reduced_pressure",
        kappa_ensemble_each="area_ensemble_each / reduced_pressure",
        area_excess_each="area_each / area_persson_each - 1",
        **{f"distance_{name}_each": f"area_{name}_each / area_each - 1" for name in areas},
        stress_density="stress_density_each.mean('surface')",
        grid_part_each="(area_pixel_each - area_each) / (area_pixel_each - area_persson_each)",
    )
    data = change(data, "area_pixel", along="grid", first=-1, last=first)
    data = mean(data, *(f"{of}_{name}" for of in ("area", "distance") for name in areas), *_AVERAGED)
    for name in areas:
        orders = observed_order(data.isel(grid=resolved), f"distance_{name}", to=f"order_{name}")
        data = data.assign({n: orders[n] for n in (f"order_{name}", f"order_{name}_error")})
    data = derive(data, **{f"distance_{name}_size": f"abs(distance_{name})" for name in areas})
    # Above the last pressure at which the coarse grid has more, it must have less: the load is the same.
    coarse, fine = (f"stress_density.isel(grid={k})" for k in (first, -1))
    low, high = (f"where(stress {sign} {SMALL}, 0).sum('stress_bin')" for sign in ("<", ">="))
    data = derive(
        data,
        small_stress_part=f"({coarse} - {fine}).{low} / ({coarse} - {fine}).sum('stress_bin')",
        large_stress_change=f"{coarse}.{high} / {fine}.{high} - 1",
    )
    variance, load = stress_variance(1.0, contact_modulus=1.0), float(data.reduced_pressure)
    law = pressure_distribution(data.stress.values, pressure=load, stress_variance=variance)
    close = np.flatnonzero(resolved & (data.distance_pixel_size.values < _CLOSE))
    return data.assign(
        stress_density_persson=("stress_bin", law * (1.0 if theory else np.nan)),
        points_per_wave_close=float(data.points_per_wave[close[0]]) if close.size else np.nan,
        cells_per_patch_close=float(data.cells_per_patch[close[0]]) if close.size else np.nan,
    )


#: What else is averaged over the surfaces.
_AVERAGED = (
    *("area", "kappa", "kappa_pixel", "kappa_ensemble", "area_excess", "grid_part", "area_pixel_change"),
    *("first_moment", "patches", "cells_at_part", "cells_per_patch", "density_at_zero"),
    *("residual", "seconds", "edge_fraction"),
)


@dataclass(frozen=True)
class _Other:
    """A method on one of its grids, as coordinates."""

    method_other: str
    grid_other: str
    points_per_wave_other: float


def with_methods(
    data: xr.Dataset, answers: Measured, grids: Mapping[str, Sequence[Grid]], first: ContactProblem
) -> xr.Dataset:
    """Add other methods beside boundary elements: areas on every grid, and limits where grids allow one.

    `answers` by name of the method, number of the surface, and number of the grid.
    """
    cases = {
        (m, g): _Other(m, "{} x {}".format(*grid), first.points_per_wave(grid))
        for m, on in grids.items()
        for g, grid in enumerate(on)
    }
    names = {n: f"{n}_other_each" for n in ("residual", "converged", "seconds")}
    names |= {"pixel": "area_other_pixel_each", "perimeter": "area_other_perimeter_each"}
    names |= {"subcell": "area_other_located_each"}
    parts = {(cases[m, g], k): answer[[*names]].rename(names) for (m, k, g), answer in answers.items()}
    other = gather(parts, "other_case", "surface").rename(solve="solve_other")
    limits = {
        (m, k): method_limit([answers[m, k, g] for g in range(len(on))], on, "area_other").drop_attrs(
            deep=False
        )
        for (m, on), k in itertools.product(grids.items(), range(data.sizes["surface"]))
    }
    added = [other, gather(limits, "other", "surface")]
    data = xr.merge([data, *added], compat="no_conflicts", combine_attrs="override")
    ways = ("other", "other_pixel", "other_perimeter", "other_located")
    data = derive(
        data,
        kappa_other_each="area_other_each / reduced_pressure",
        **{f"distance_{way}_each": f"area_{way}_each / area_each - 1" for way in ways},
    )
    others = [f"{name}_other" for name in ("area", "kappa", "residual", "converged", "seconds")]
    data = mean(data, *(f"distance_{way}" for way in ways), *others)
    return derive(data, **{f"distance_{way}_size": f"abs(distance_{way})" for way in ways[1:3]})


def with_block_errors(
    data: xr.Dataset, blocks: Measured, strict: Mapping[str, xr.Dataset], grids: Sequence[Grid]
) -> xr.Dataset:
    """Claim what the finite depth and the stopping of blocks leave, and how far their limits are from the other one.

    `blocks` as `with_methods` has them, on `grids`; `strict` the first of each element with a smaller residual. Less
    than one node of the coarsest grid cannot be seen, and counts as one.
    """
    # On the finest grid, where one node is least.
    finest = [blocks[e, k, len(grids) - 1] for e in strict for k in range(data.sizes["surface"])]
    share = np.mean([abs(float(block.pixel_layer / block.pixel_bem) - 1) for block in finest])
    solver = {
        e: max(abs(float(blocks[e, 0, 0].pixel - block.pixel)), 1 / math.prod(grids[0])) / float(block.pixel)
        for e, block in strict.items()
    }
    names = data.other.values.tolist()
    depth, solver_share = (
        xr.DataArray([of.get(name, np.nan) for name in names], dims="other")
        for of in (dict.fromkeys(strict, share), solver)
    )
    data = claim(data.assign(depth_share=share), "distance_other", depth=depth)
    # How far two discretisations of the same surfaces are apart in the limit is a part of their grids' error.
    grid_error = data.kappa_other_error.sel(source="grid", drop=True)
    grid = (grid_error**2 + (data.distance_other * data.kappa_other) ** 2) ** 0.5
    data = claim_shares(data, "kappa_other", depth=depth, solver=solver_share)
    return claim(data, "kappa_other", grid=grid)


def method_limit(answers: Sequence[xr.Dataset], grids: Sequence[Grid], name: str) -> xr.Dataset:
    """Limit of one surface over the grids of a method, by a name, with its interval and solves; NaN where they are too few."""
    areas = [
        stored_areas(answer, grid=grid, edge_constant=float(answer.edge_constant))
        for answer, grid in zip(answers, grids, strict=True)
    ]
    enough = len(areas) > 2 or all(area.subcell is not None for area in areas)
    enough = enough and len({area.spacing for area in areas}) > 1
    data = limit_dataset(limit_over(areas) if enough else no_limit("too few grids"), name)
    return data.assign_attrs(solve=" ".join(str(answer.attrs.get("solve", "")) for answer in answers))


def protocol(rough: Measured, points: Sequence[int]) -> xr.Dataset:
    """Reduce the grid-scale protocol, by surface and grid: kappa by the way the slope is measured, and its spread."""
    kappas = {case: one[["kappa"]].rename(kappa="kappa_protocol_each") for case, one in rough.items()}
    data = gather(kappas, "surface", "protocol_grid").rename(solve="solve_protocol")
    data = mean(data.drop_vars("protocol_grid"), "kappa_protocol")
    last = "kappa_protocol.isel(protocol_grid=-1)"
    spread = derive(data[["kappa_protocol"]], kappa_protocol_spread=f"{last}.max() / {last}.min() - 1")
    data = data.assign(kappa_protocol_spread=spread.kappa_protocol_spread)
    # By one word alone, `spectral` would be what is predicted from C(q).
    slopes = [f"{name} slope" for name in data.slope.values]
    return data.assign_coords(points_protocol=("protocol_grid", list(points)), slope=slopes)


#: Solvers of the grid-scale protocol: those of this project, and as Hyun et al. had it.
PROTOCOL_METHODS: tuple[Literal["bem", "fem"], ...] = ("bem", "fem")
_PROTOCOL = "kappa_protocol_by_solver"


def protocol_of_solvers(rough: Measured, fine: Measured, data: xr.Dataset, *, points: int) -> xr.Dataset:
    """Reduce the protocol by solver, H and surface, beside the converged kappa of the same surfaces, by H and surface."""
    counted = {case: one[["kappa"]].rename(kappa=f"{_PROTOCOL}_each") for case, one in rough.items()}
    there = ("hurst_protocol", "surface")
    made = gather(counted, "solver", *there).rename(solve="solve_scale")
    names = ["area_each", "area_each_error", "area_each_drift"]
    limits = {case: limits_of(one).isel(load=0, drop=True)[names] for case, one in fine.items()}
    converged = gather(limits, *there).rename(
        {n: n.replace("area", "area_protocol") for n in names} | {"solve": "solve_converged"}
    )
    hyun = published("kappa").isel(end=0, paper_kappa=1, drop=True)
    made = made.merge(converged, combine_attrs="override").assign(
        slope=[f"{name} slope" for name in made.slope.values],
        points_protocol_by_solver=points,
        kappa_persson=data.kappa_persson,
        reduced_pressure=data.reduced_pressure,
        kappa_hyun=hyun.kappa_published,
        hurst_hyun=hyun.hurst_published,
    )
    kappa, limit = f"{_PROTOCOL}_each", "kappa_protocol_limit_each"
    made = derive(made, kappa_protocol_limit_each="area_protocol_each / reduced_pressure")
    made = derive(
        made,
        kappa_excess_protocol_each=f"{kappa} / {limit} - 1",
        grid_part_protocol_each=f"({kappa} - {limit}) / ({kappa} - kappa_persson)",
    )
    made = mean(made, _PROTOCOL, "kappa_protocol_limit", "kappa_excess_protocol", "grid_part_protocol")
    return derive(made, kappa_hyun_difference="kappa_hyun - kappa_protocol_limit")


def observed_order(data: xr.Dataset, name: str, *, to: str) -> xr.Dataset:
    """Add the order with which a mean over surfaces falls with the spacing, by least squares of the logarithms.

    Its 95 % interval is that of the jackknife over the surfaces. NaN where a value is.
    """
    rows = data[f"{name}_each"].transpose("surface", "grid").values
    spacing, count = 1 / data.points_per_wave.values, rows.shape[0]

    def order(some: np.ndarray) -> float:
        error = some.mean(axis=0)
        if not np.isfinite(error).all() or error.size < 2:
            return math.nan
        return order_of_convergence(spacing, np.where(error == 0, 1e-12, error))

    places = {"x": "points_per_wave", "along": "grid", "over": "surface"}
    made: dict[str, Any] = {"reduction": "order", "of": f"{name}_each", **places}
    value, half = xr.DataArray(order(rows), attrs=made), math.nan
    if count > 1:
        left = np.array([order(np.delete(rows, k, axis=0)) for k in range(count)])
        half = np.sqrt((count - 1) / count * ((left - left.mean()) ** 2).sum())
        half *= scipy.special.stdtrit(count - 1, 0.975)
    return data.assign({to: value, f"{to}_error": error_of(value, surfaces=half)})


def _recipe(made: dict[str, Any], method: str) -> dict[str, Any]:
    made = {name: value for name, value in made.items() if (name, value) != ("method", "bem")}
    return made | {"surface": {n: v for n, v in made["surface"].items() if n != "lambda_short"}}


def _predicted(points: int, method: str) -> Prediction:
    """Such roughness converges slowly; a block has some fifty unknowns below each of its points."""
    seconds, size = (1.2e-4, 2500) if method == "fem" else (4e-6, 120)
    return Prediction(seconds=2e-3 + seconds * points, peak_bytes=size * points, unknowns=points)


@measurement(
    "grid-roughness-{size}",
    kind="GridRoughness",
    words="roughness to the grid scale,",
    recipe=_recipe,
    predict=_predicted,
)
def grid_roughness(
    *, problem: ContactProblem, grid: Grid, method: Literal["bem", "fem"] = "bem"
) -> xr.Dataset:
    """Continue the waves of a surface with its power law to the shortest a grid can carry, and press them on that grid.

    The surface gives H, lambda_long, period and seed; its lambda_short is replaced by two spacings. The reduced
    pressure is that of the spectral slope. Returns kappa for the three slopes, by boundary elements or, as Hyun et al.
    had them, by a whole block of finite elements one period deep.
    """
    field, modulus = down_to_grid(problem, grid[0]).heights(grid), problem.contact_modulus
    slopes = rms_slopes(field)
    pressure = reduced_load(problem) * modulus * slopes["spectral"]
    result = find_solver(method).pressed(field, ContactModel(solid=problem.elastic), pressure).checked()
    pixel = contact_areas(result).pixel
    kappa = [pixel * modulus * slope / pressure for slope in slopes.values()]
    return xr.Dataset(
        {"kappa": ("slope", kappa), "pixel": pixel, "seconds": result.cost.wall_seconds},
        coords={"slope": list(slopes)},
    )


def down_to_grid(problem: ContactProblem, points: int) -> ContactProblem:
    """Continue the waves of a surface to the shortest that so many points along a side carry."""
    surface = problem.surface
    assert isinstance(surface, SelfAffineSurface)
    # The Nyquist wave itself has no phase on the grid: stop one wave short of it.
    shortest = surface.length[0] / (points // 2 - 1)
    return replace(problem, surface=surface.model_copy(update={"lambda_short": shortest}))


def rms_slopes(field: HeightField) -> dict[str, float]:
    """Root mean square gradient by spectral, forward and central differences.

    >>> x = np.arange(64) / 64
    >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 1.0))
    >>> [round(slope / wave.rms_gradient, 4) for slope in rms_slopes(wave).values()]
    [1.0, 0.9996, 0.9984]
    """
    back = {"forward": 0, "central": 1}
    differences = {name: float(np.sqrt(squared_gradient(field, k).mean())) for name, k in back.items()}
    return {"spectral": field.rms_gradient} | differences


def squared_gradient(field: HeightField, back: int) -> Array:
    """|grad h|^2 from the next point and that so many steps back."""
    h = field.heights
    along = [
        (np.roll(h, -1, k) - np.roll(h, back, k)) / ((1 + back) * d) for k, d in enumerate(field.spacing)
    ]
    return along[0] ** 2 + along[1] ** 2
