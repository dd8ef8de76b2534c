"""Area against magnification: roughness added wave by wave on one surface, against Eq. 20 of Persson 2006."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from validation.bench import Bench
from validation.scene import Number
from validation.statistics import mean_over_surfaces
from validation.studies.common import (
    Ascending,
    Count,
    ResultTable,
    SurfaceOptions,
    base_surface,
    checked,
    persson_area,
    solid_of,
)
from validation.studies.measurement import Measurement, area_limits, grid_for

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from validation.scene import Scene

__all__ = ["QUESTION", "Options", "figures", "findings", "run", "table"]

QUESTION = "How does the contact area fall as shorter and shorter waves are added to one surface?"


class Options(SurfaceOptions):
    """Settings of the study."""

    ratio: Number = Field(default=16.0, gt=1, description="lambda_long / lambda_short")
    reduced_pressures: Ascending = Field(default=(0.05, 0.2), description="p*, with the gradient of all waves")
    magnifications: Ascending = Field(
        default=(1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0), description="zeta = q / q_long, ascending"
    )
    surfaces: Annotated[Count, Field(ge=2)] = Field(default=4, description="realisations")
    points_per_wave: Ascending = Field(default=(3.0, 6.0), description="grids, on the shortest wave of all")
    shifts: Count = Field(default=2, description="sub-grid shifts along each axis")


def run(scene: Scene | None = None, *, bench: Bench | None = None, **options: Any) -> xr.Dataset:
    """Press every surface with its waves up to each magnification, always at the same nominal pressures.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    **options
        Fields of `Options`.

    Returns
    -------
    xarray.Dataset
        area (limit over grids) with dimensions (surface, magnification, load), and the theory with the realised gradient
        of the waves that are there.
    """
    import xarray as xr

    bench = bench or Bench.default()
    settings = checked(Options, options)
    surface = base_surface(settings)
    grids = tuple(grid_for(surface, points) for points in settings.points_per_wave)
    q_long = 2 * np.pi / surface.lambda_long
    cases = [
        Measurement(
            surface=surface,
            realisation=k,
            truncation=zeta * q_long,
            solid=solid_of(scene),
            reduced_pressures=settings.reduced_pressures,
            grids=grids,
            shifts=settings.shifts,
        )
        for k, zeta in itertools.product(range(settings.surfaces), settings.magnifications)
    ]
    measured = bench.run(cases)
    shape = (settings.surfaces, len(settings.magnifications), len(settings.reduced_pressures))
    limits = [area_limits(data) for data in measured]
    # p* of a truncated surface grows as its gradient shrinks, at the same nominal pressure.
    partial = np.array([case.field(grids[0]).rms_gradient for case in cases])
    whole = np.array([data.attrs["rms_gradient"] for data in measured])
    pressures = np.array(settings.reduced_pressures) * (whole / partial)[:, None]
    return xr.Dataset(
        {
            "area": (("surface", "magnification", "load"), np.array([v for v, _ in limits]).reshape(shape)),
            "area_error": (("surface", "magnification", "load"), np.array([e for _, e in limits]).reshape(shape)),
            "theory": (("surface", "magnification", "load"), persson_area(pressures).reshape(shape)),
        },
        coords={
            "magnification": ("magnification", list(settings.magnifications), {"long_name": "q / q_long"}),
            "reduced_pressure": ("load", list(settings.reduced_pressures)),
        },
        attrs={"study": "magnification", "hurst": settings.hurst, "size": settings.size, "ratio": settings.ratio},
    )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load and magnification."""
    rows = []
    for j, i in itertools.product(range(dataset.sizes["load"]), range(dataset.sizes["magnification"])):
        area = mean_over_surfaces(dataset.area[:, i, j].values)
        theory = float(dataset.theory[:, i, j].mean())
        rows.append(
            (
                float(dataset.reduced_pressure[j]),
                float(dataset.magnification[i]),
                area.value,
                area.half_width,
                theory,
                area.value / theory,
            )
        )
    return ResultTable.of(("p* (all waves)", "zeta", "A/A0 limit", "+- (95 %)", "A/A0 Persson", "ratio"), rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return how the distance to the theory builds up with magnification."""
    sentences = []
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = dataset.area[:, :, j].mean("surface").values
        ratio = (dataset.area / dataset.theory)[:, :, j].mean("surface").values
        zeta = dataset.magnification.values
        falls = bool(np.all(np.diff(area) < 0))
        sentences.append(
            f"At p* = {pressure:g} (all waves) the area {'falls with every wave added' if falls else 'does not fall at every step'}, from {area[0]:.3f} "
            f"at zeta = {zeta[0]:g} to {area[-1]:.4f} at {zeta[-1]:g}; over the theory it is {ratio[0]:.3f} there and {ratio[-1]:.3f} here."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """Draw area against magnification, simulation and theory."""
    from validation import plots_studies

    return {"area-against-magnification": plots_studies.area_against_magnification(dataset)}
