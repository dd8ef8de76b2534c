"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.bench import Bench
from validation.drawing import Drawing
from validation.statistics import mean_over_surfaces, order_of_convergence
from validation.studies._common import (
    ResultTable,
    at_least,
    base_surface,
    ladder,
    measure,
    persson_area,
    solid_of,
)
from validation.studies._grid_roughness import GridRoughness
from validation.studies._measurement import Measurement, area_limits, grid_for

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]

_AREAS = ("pixel", "perimeter", "subcell")


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
    seed: int = 2006,
) -> xr.Dataset:
    """Measure the area on every grid, and the same surfaces with roughness down to the grid scale.

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
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        Areas with dimensions (surface, grid), means over the shifts; `limit` per surface; kappa of the grid-scale
        protocol with dimensions (surface, protocol_grid, slope).
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    points_per_wave = ladder("points_per_wave", points_per_wave, shifts=shifts)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    grids = tuple(grid_for(surface, points) for points in points_per_wave)
    pressures = (reduced_pressure,)
    cases = [
        Measurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressures=pressures,
            grids=grids,
            shifts=shifts,
        )
        for k in range(surfaces)
    ]
    protocol = [
        GridRoughness(
            surface=surface, realisation=k, solid=solid, reduced_pressure=reduced_pressure, points=n
        )
        for k, n in itertools.product(range(surfaces), grid_scale_points)
    ]
    results = measure(bench, [*cases, *protocol])
    measured, rough = results[: len(cases)], results[len(cases) :]
    names = (*_AREAS, "density_at_zero", "patches", "cells_per_patch", "edge_fraction", "residual")
    data: dict[str, Any] = {
        name: (("surface", "grid"), np.array([d[name].isel(load=0).mean("shift").values for d in measured]))
        for name in names
    }
    data["seconds"] = (
        ("surface", "grid"),
        np.array([d.seconds.isel(load=0).sum("shift").values for d in measured]),
    )
    limits = [area_limits(d) for d in measured]
    data["limit"] = (("surface",), np.array([value[0] for value, _ in limits]))
    data["limit_error"] = (("surface",), np.array([error[0] for _, error in limits]))
    kappa = np.array([d.kappa.values for d in rough]).reshape(surfaces, len(grid_scale_points), 3)
    data["kappa_grid_scale"] = (("surface", "protocol_grid", "slope"), kappa)
    return xr.Dataset(
        data,
        coords={
            "points_per_wave": (
                "grid",
                measured[0].points_per_wave.values,
                {"long_name": "lambda_short / dx"},
            ),
            "points": ("grid", measured[0].points.values),
            "protocol_points": ("protocol_grid", list(grid_scale_points)),
            "slope": ("slope", ["spectral", "forward", "central"]),
        },
        attrs={
            "study": "refinement",
            "reduced_pressure": reduced_pressure,
            "hurst": hurst,
            "size": size,
            "ratio": ratio,
            "shifts": shifts,
        },
    )


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
        for name in _AREAS:
            values = overestimate(dataset, name)[:, i].values
            errors += [100 * float(values.mean()), 100 * mean_over_surfaces(values).half_width]
        rows.append(
            (
                f"{int(dataset.points[i])}{label}",
                float(per_wave),
                float(dataset.cells_per_patch[:, i].mean()),
                float(dataset.pixel[:, i].mean()) / pressure,
                *errors,
                float(dataset.density_at_zero[:, i].mean()),
                float(dataset.patches[:, i].mean()),
                float(dataset.seconds[:, i].mean()),
            )
        )
    columns = (
        "grid",
        "lambda_short/dx",
        "cells in the median patch",
        "kappa pixel",
        *(f"{name} {what} [%]" for name in _AREAS for what in ("- limit", "+- (95 %)")),
        "P(0+) E*h'",
        "patches",
        "seconds",
    )
    return ResultTable.of(columns, rows)


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
    ]
    for name in _AREAS:
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
    return tuple(sentences)


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
    from validation import plots_studies

    errors = {name: overestimate(dataset, name) for name in _AREAS}
    theory = float(persson_area(dataset.attrs["reduced_pressure"])) / float(dataset.attrs["reduced_pressure"])
    return (
        Drawing(
            name="error-against-resolution",
            figure=plots_studies.error_against_resolution(dataset, errors),
            data=dataset[["pixel", "perimeter", "subcell", "limit"]],
            caption="Distance of each definition of the area from the limit of its own surface: lines, mean over surfaces; dots, single surfaces; dashed, first order in dx.",
        ),
        Drawing(
            name="error-against-cells",
            figure=plots_studies.error_against_cells(dataset, errors["pixel"]),
            data=dataset[["pixel", "limit", "cells_per_patch"]],
            caption="Overestimate by counting against the size of the contact patches in cells, the criterion of Persson 2006, Sec. 12; grey, what it asks for.",
        ),
        Drawing(
            name="grid-scale-protocol",
            figure=plots_studies.grid_scale_protocol(dataset, theory),
            data=dataset[["kappa_grid_scale"]],
            caption="kappa when the roughness goes down to the grid scale and nodes are counted, by the way the slope is measured; bars, scatter between surfaces.",
        ),
    )
