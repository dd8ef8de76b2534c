"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.block import BlockMeasurement
from validation.measures.budget import Budget, budget_table, grid_share, solver_error
from validation.measures.common import at_least, base_surface, ladder, measure, persson_area, rising, solid_of
from validation.measures.distributions import Distributions
from validation.measures.ladders import spectral_share, usual_ladders
from validation.measures.measurement import grid_for
from validation.measures.references import KAPPA_LITERATURE
from validation.measures.statistics import Estimate, combined, mean_over_surfaces, order_of_convergence
from validation.measures.theory import ensemble_area, modes_sentence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._grid_roughness import GridRoughness
from validation.studies._refinement_data import AREAS, finite_elements, on_grids

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["budget", "figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 4,
    points_per_wave: tuple[float, ...] = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0),
    shifts: int = 2,
    grid_scale_points: tuple[int, ...] = (64, 128, 256),
    elements: tuple[str, ...] = ("Hex1", "Hex2"),
    fem_points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    ladders: bool = True,
    seed: int = 2006,
) -> xr.Dataset:
    """Measure the area on every grid, by boundary and by finite elements, and with roughness down to the grid scale.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressure : float
        p*.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising; 2 and less is run, labelled and left out of the limit.
    shifts : int
        Sub-grid shifts along each axis.
    grid_scale_points : tuple of int
        Grids of the same surfaces with roughness down to the grid scale.
    elements : tuple of str
        Finite elements of a block one period deep, reduced to its surface; none to leave them out.
    fem_points_per_wave : tuple of float
        Their grids, as lambda_short/dx, rising, at least three.
    ladders : bool
        Also measure how kappa moves with bandwidth and sample, for the budget.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        Areas with dimensions (surface, grid), means over the shifts; `limit` per surface; moments of P(sigma) and sizes of
        patches; areas of finite elements with dimensions (element, surface, fem_grid); kappa of the grid-scale protocol
        with dimensions (surface, protocol_grid, slope).
    """
    at_least("surfaces", surfaces, 2)
    if elements:
        at_least("number of fem_points_per_wave", len(rising("fem_points_per_wave", fem_points_per_wave)), 3)
    points_per_wave = ladder("points_per_wave", points_per_wave, shifts=shifts)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    grids = tuple(grid_for(surface, points) for points in points_per_wave)
    cases = [
        Distributions(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressures=(reduced_pressure,),
            grids=grids,
            shifts=shifts,
        )
        for k in range(surfaces)
    ]
    # What the stopping of the solver does shows on coarse grids, too.
    few = max(2, sum(points <= _SOLVER_POINTS for points in points_per_wave))
    strict = replace(cases[0], grids=grids[:few], tolerance=cases[0].tolerance / 100)
    protocol = [
        GridRoughness(
            surface=surface, realisation=k, solid=solid, reduced_pressure=reduced_pressure, points=n
        )
        for k, n in itertools.product(range(surfaces), grid_scale_points)
    ]
    blocks = [
        BlockMeasurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressure=reduced_pressure,
            points=grid_for(surface, n)[0],
            element=element,
        )
        for element, k, n in itertools.product(elements, range(surfaces), fem_points_per_wave)
    ]
    first_blocks = blocks[:: surfaces * len(fem_points_per_wave)]
    strict_blocks = [replace(block, tolerance=_STRICT) for block in first_blocks]
    climbed = usual_ladders(hurst=hurst, size=size, reduced_pressure=reduced_pressure, solid=solid, seed=seed)
    rungs = climbed.cases if ladders else []
    results = iter(measure(bench, [*cases, strict, *protocol, *blocks, *strict_blocks, *rungs]))
    counts = (surfaces, 1, len(protocol), len(blocks), len(strict_blocks), len(rungs))
    measured, strictly, rough, fem, fem_strictly, climbed_to = (
        list(itertools.islice(results, n)) for n in counts
    )
    data = on_grids(measured).assign_coords(slope=["spectral", "forward", "central"])
    data["ensemble"] = ensemble_area(
        surface, [reduced_pressure], rms_gradients=[d.attrs["rms_gradient"] for d in measured]
    ).mean()
    kappa = np.array([d.kappa.values for d in rough]).reshape(surfaces, len(grid_scale_points), 3)
    data["kappa_grid_scale"] = (("surface", "protocol_grid", "slope"), kappa)
    data["solver_error"] = solver_error(measured[0].isel(grid=slice(0, few)), strictly[0])
    data = data.assign_coords(protocol_points=("protocol_grid", list(grid_scale_points)))
    if elements:
        data = data.merge(finite_elements(fem, elements, fem_points_per_wave, surfaces=surfaces))
        counted = np.array([float(d.pixel) for d in fem[:: surfaces * len(fem_points_per_wave)]])
        strictly_counted = np.array([float(d.pixel) for d in fem_strictly])
        # Less than one node cannot be seen, and counts as one.
        node = np.array([1 / block.points**2 for block in first_blocks])
        change = np.maximum(np.abs(counted - strictly_counted), node) / strictly_counted
        data["fem_solver_error"] = ("element", change)
    if ladders:
        data = data.merge(climbed.dataset(climbed_to))
    return data.assign_attrs(
        study="refinement",
        reduced_pressure=reduced_pressure,
        hurst=hurst,
        size=size,
        ratio=ratio,
        shifts=shifts,
        methods="theory bem fem perimeter" if elements else "theory bem perimeter",
    )


#: Tolerance of the finite-element solves that show what their usual one leaves.
_STRICT = 1e-10

#: Finest grid of the check of the solver, as lambda_short/dx.
_SOLVER_POINTS = 8.0


def overestimate(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the relative distance of an area from the limit of its own surface, (surface, grid)."""
    return dataset[name] / dataset["limit"] - 1


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each grid, then the limit, the theory and the grid-scale protocol."""
    pressure = float(dataset.attrs["reduced_pressure"])
    rows: list[tuple[float | str, ...]] = []
    for i, per_wave in enumerate(dataset.points_per_wave.values):
        label = "" if per_wave > 2 * (1 + 1e-9) else " (under-resolved)"
        errors = []
        for name in AREAS:
            values = overestimate(dataset, name)[:, i].values
            errors += [100 * float(values.mean()), 100 * mean_over_surfaces(values).half_width]
        rows.append(
            (
                f"{int(dataset.points[i])}{label}",
                float(per_wave),
                float(dataset.cells_per_patch[:, i].mean()),
                float(dataset.pixel[:, i].mean()) / pressure,
                *errors,
                float(dataset.first_moment[:, i].mean()),
                float(dataset.density_at_zero[:, i].mean()),
                float(dataset.patches[:, i].mean()),
                *(float(dataset.cells[:, i, m].mean()) for m in range(dataset.sizes["part"])),
                float(dataset.seconds[:, i].mean()),
            )
        )
    if "element" in dataset.dims:
        rows += _fem_rows(dataset)
    columns = (
        "grid",
        "lambda_short/dx",
        "cells in the median patch",
        "kappa, counted (zeroth moment / p*)",
        *(f"{name} {what} [%]" for name in AREAS for what in ("- limit", "+- (95 %)")),
        "first moment / p0",
        "P(0+) E*h'",
        "patches",
        *(f"cells at {100 * float(part):g} % of the area" for part in dataset.part.values),
        "seconds",
    )
    return ResultTable.of(columns, rows)


def _fem_rows(dataset: xr.Dataset) -> list[tuple[float | str, ...]]:
    """Rows of the finite elements, with both countings against the limit of the boundary elements."""
    pressure, nan = float(dataset.attrs["reduced_pressure"]), float("nan")
    rows: list[tuple[float | str, ...]] = []
    for e, g in itertools.product(range(dataset.sizes["element"]), range(dataset.sizes["fem_grid"])):
        counted = (dataset.fem_pixel[e, :, g] / dataset.limit - 1).values
        corrected = (dataset.fem_perimeter[e, :, g] / dataset.limit - 1).values
        errors = []
        for values in (counted, corrected):
            errors += [100 * float(values.mean()), 100 * mean_over_surfaces(values).half_width]
        rows.append(
            (
                f"FEM {dataset.element.values[e]}",
                float(dataset.fem_points_per_wave[g]),
                nan,
                float(dataset.fem_pixel[e, :, g].mean()) / pressure,
                *errors,
                *([nan] * (6 + dataset.sizes["part"])),
            )
        )
    return rows


def budget(dataset: xr.Dataset) -> ResultTable:
    """Return what is uncertain about kappa in the limit, by boundary and by finite elements."""
    pressure = float(dataset.attrs["reduced_pressure"])
    spectral: dict[str, float] = {}
    if "ladder" in dataset.dims:
        steps = {"size": 1 / float(dataset.attrs["size"]), "bandwidth": 1 / float(dataset.attrs["ratio"])}
        size, band = (
            spectral_share(dataset, kind, hurst=float(dataset.attrs["hurst"]), step=step)
            for kind, step in steps.items()
        )
        spectral = {"finite size": size, "bandwidth": band}
    limit = mean_over_surfaces(dataset.limit.values)
    shares = {
        "grid": grid_share(
            dataset.limit.values, errors=dataset.limit_error.values, drifts=dataset.limit_drift.values
        ),
        "solver": float(dataset.solver_error),
        "surfaces": limit.half_width / limit.value,
    }
    budgets = [
        Budget(quantity="kappa, boundary elements", value=limit.value / pressure, shares=shares | spectral)
    ]
    for e in range(dataset.sizes.get("element", 0)):
        found = mean_over_surfaces(dataset.fem_limit[e].values)
        # How far two discretisations of the same surfaces are apart in the limit is a part of their grids' error.
        apart = float((dataset.fem_limit[e] / dataset.limit).mean()) - 1
        random = grid_share(
            dataset.fem_limit[e].values, errors=dataset.fem_limit_error[e].values, drifts=[0.0]
        )
        fem_shares = {
            "grid": combined(random, apart),
            "solver": float(dataset.fem_solver_error[e]),
            "surfaces": found.half_width / found.value,
            "depth": float(dataset.depth_error),
        }
        name = f"kappa, finite elements {dataset.element.values[e]}"
        budgets.append(Budget(quantity=name, value=found.value / pressure, shares=fem_shares | spectral))
    return budget_table(budgets)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what refinement shows, in words."""
    pressure = float(dataset.attrs["reduced_pressure"])
    limit = mean_over_surfaces(dataset.limit.values / pressure)
    theory = float(persson_area(pressure)) / pressure
    resolved = dataset.isel(grid=np.flatnonzero(dataset.points_per_wave.values > 2 * (1 + 1e-9)))
    spacing = 1 / resolved.points_per_wave.values
    sentences = [
        f"kappa in the limit of vanishing spacing is {limit} (95 %, {limit.samples} surfaces) at p* = {pressure:g}; Persson's theory "
        f"gives {theory:.4g}: {100 * (1 - theory / limit.value):.0f} % of the simulated area is not explained by the grid.",
        _verdict(resolved, limit.value, theory),
        modes_sentence([theory * pressure], [float(dataset.ensemble)]),
        _load_identity(resolved),
    ]
    for name in AREAS:
        error = overestimate(resolved, name).mean("surface").values
        if not np.all(np.isfinite(error)):
            continue
        order = order_of_convergence(spacing, np.where(error == 0, 1e-12, error))
        parts = ", ".join(
            f"{100 * e:+.2g} % at {p:g}" for e, p in zip(error, resolved.points_per_wave.values, strict=True)
        )
        sentences.append(
            f"The {name} area differs from the limit by {parts} points per shortest wave (mean over surfaces; fitted order {order:.2f})."
        )
    enough = resolved.points_per_wave.values[
        np.abs(overestimate(resolved, "pixel").mean("surface").values) < 0.05
    ]
    if enough.size:
        first = int(np.flatnonzero(resolved.points_per_wave.values == enough.min())[0])
        cells = float(resolved.cells_per_patch[:, first].mean())
        sentences.append(
            f"Counting is within 5 % of the limit from lambda_short/dx = {enough.min():g} on; half of the contact area then lies in patches "
            f"of at least {cells:.0f} cells (Persson's criterion asks for 100 to 10000)."
        )
    sentences.append(_protocol(dataset, limit.value, theory))
    sentences.append(_published(dataset, limit))
    sentences += [_element_sentence(dataset, e) for e in range(dataset.sizes.get("element", 0))]
    return tuple(sentences)


def _verdict(resolved: xr.Dataset, limit: float, theory: float) -> str:
    """Say how much of a counted kappa is the grid, and what remains to the theory without it."""
    pressure = float(resolved.attrs["reduced_pressure"])
    words = []
    for g in range(resolved.sizes["grid"]):
        counted = float(resolved.pixel[:, g].mean()) / pressure
        words.append(
            f"{100 * (counted - limit) / (counted - theory):.0f} % at {float(resolved.points_per_wave[g]):g}"
        )
    coarse = float(resolved.pixel[:, 0].mean()) / pressure
    return (
        f"Verdict: counted on {float(resolved.points_per_wave[0]):g} points per shortest wave kappa is {coarse:.2f}, of which {coarse - limit:+.2f} is "
        f"the grid; without it {limit:.2f} remains, {limit - theory:+.2f} ({100 * (limit / theory - 1):+.0f} %) from the theory. The grid's part "
        f"of the distance between counted value and theory is {', '.join(words)} points per wave."
    )


def _load_identity(resolved: xr.Dataset) -> str:
    """Say what the grid does to P(sigma) at fixed load: Persson 2006, Sec. 12."""
    first = float(np.abs(resolved.first_moment - 1).max())
    coarse, fine = (resolved.density.isel(grid=g).values for g in (0, -1))
    stress = resolved.stress.values
    # Above the last pressure at which the coarse grid has more, it must have less: the load is the same.
    small = stress < _SMALL
    excess = float((coarse - fine).sum())
    low = float((coarse - fine)[small].sum())
    change = float(coarse[~small].sum() / fine[~small].sum() - 1)
    zeroth = float((resolved.pixel[:, 0] / resolved.pixel[:, -1]).mean() - 1)
    return (
        f"The first moment of P(sigma) is p0 on every grid (to {first:.1g}); the zeroth, the area, is {100 * zeroth:+.1f} % on "
        f"{float(resolved.points_per_wave[0]):g} against {float(resolved.points_per_wave[-1]):g} points per wave. Of that excess {100 * low / excess:.0f} % lies at "
        f"sigma < {_SMALL:g} E* h'_rms, and above it the coarse grid holds {100 * change:+.1f} %: what is too much at small pressure is "
        "balanced by too little at large pressure."
    )


#: Pressure, over E* h'_rms, below which the excess of a coarse grid is looked for.
_SMALL = 0.2


def _published(dataset: xr.Dataset, limit: Estimate) -> str:
    """Put the published values beside the converged one and beside what the grid can make of it."""
    last = dataset.kappa_grid_scale.isel(protocol_grid=-1).mean("surface").values
    words = []
    for published in KAPPA_LITERATURE:
        low, high = published.kappa
        if low == high:
            inside = last.min() <= low <= last.max()
            words.append(
                f"{low:g} ({published.source}) lies {100 * (low / limit.value - 1):+.0f} % from it, and {'inside' if inside else 'outside'} the "
                f"{last.min():.2f} to {last.max():.2f} that roughness at the grid scale gives by the definition of the slope"
            )
        else:
            inside = limit.value + limit.half_width >= low and limit.value - limit.half_width <= high
            words.append(
                f"{low:g} to {high:g} ({published.note}) {'agree' if inside else 'do not agree'} with the converged {limit}"
            )
    return f"Published kappa: {'; '.join(words)}."


def _element_sentence(dataset: xr.Dataset, e: int) -> str:
    """Say how finite elements count, corrected and in the limit."""
    counted = (dataset.fem_pixel[e] / dataset.limit - 1).mean("surface").values
    corrected = (dataset.fem_perimeter[e] / dataset.limit - 1).mean("surface").values
    apart = mean_over_surfaces((dataset.fem_limit[e] / dataset.limit - 1).values)
    points = dataset.fem_points_per_wave.values
    rows = ", ".join(
        f"{100 * a:+.2g} ({100 * b:+.2g}) % at {p:g}"
        for a, b, p in zip(counted, corrected, points, strict=True)
    )
    return (
        f"Finite elements {dataset.element.values[e]}, nodes counted (with the element's edge constant), differ from the limit of the boundary elements by {rows}; "
        f"their own limit differs by {100 * apart.value:+.2f} +- {100 * apart.half_width:.2f} %, of which a block one period deep can explain "
        f"{100 * float(dataset.depth_error):.2f} %."
    )


def _protocol(dataset: xr.Dataset, limit: float, theory: float) -> str:
    """Say what roughness down to the grid scale does, by the definition of the slope."""
    last = dataset.kappa_grid_scale.isel(protocol_grid=-1)
    words = ", ".join(f"{float(last.sel(slope=name).mean()):.2f} ({name})" for name in dataset.slope.values)
    values = [float(last.sel(slope=name).mean()) for name in dataset.slope.values]
    spread = max(values) / min(values) - 1
    span = (
        " on both sides of"
        if min(values) < limit < max(values)
        else (" above" if min(values) > limit else " below")
    )
    return (
        f"With roughness down to the grid scale on {int(dataset.protocol_points[-1])} points and nodes counted, kappa is {words}, by how the slope is "
        f"measured: a spread of {100 * spread:.0f} %,{span} the converged {limit:.2f}; the theory's {theory:.2f} is "
        f"{'below all of them' if theory < min(values) else 'not below all of them'}."
    )


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw error against resolution, error against cells per patch, and kappa of the grid-scale protocol."""
    from validation.studies import _plots_limits as plots_limits
    from validation.studies import _plots_studies as plots_studies

    errors = {name: overestimate(dataset, name) for name in AREAS}
    theory = float(persson_area(dataset.attrs["reduced_pressure"])) / float(dataset.attrs["reduced_pressure"])
    return (
        Drawing(
            name="error-against-resolution",
            figure=plots_studies.error_against_resolution(dataset, errors),
            data=dataset[[*AREAS, "limit", *(n for n in ("fem_pixel", "fem_perimeter") if n in dataset)]],
            caption="Distance of each definition of the area from the limit of its own surface: lines, mean over surfaces; dots, single surfaces; dashed, first order in dx; open, finite elements by element, counted and with the edge constant of the element.",
        ),
        Drawing(
            name="error-against-cells",
            figure=plots_studies.error_against_cells(dataset, errors["pixel"]),
            data=dataset[["pixel", "limit", "cells_per_patch"]],
            caption="Overestimate by counting against the size of the contact patches in cells, the criterion of Persson 2006, Sec. 12; grey, what it asks for.",
        ),
        Drawing(
            name="stress-on-grids",
            figure=plots_limits.stress_on_grids(dataset),
            data=dataset[["density", "first_moment", "pixel"]],
            caption="P(sigma) on every grid, mean over surfaces (left), with Persson's; its first and zeroth moment over those of the limit (right): the load is kept, the area is not.",
        ),
        Drawing(
            name="patches-on-grids",
            figure=plots_limits.patches_on_grids(dataset),
            data=dataset[["patches", "cells"]],
            caption="Number of contact patches against the grid (left), and the cells of the patches that hold 10, 50 and 90 % of the area (right); grey, what Persson 2006, Sec. 12, asks for.",
        ),
        Drawing(
            name="grid-scale-protocol",
            figure=plots_studies.grid_scale_protocol(dataset, theory),
            data=dataset[["kappa_grid_scale"]],
            caption="kappa when the roughness goes down to the grid scale and nodes are counted, by the way the slope is measured; bars, scatter between surfaces.",
        ),
    )
