"""How do area, mean gap, stiffness, elastic energy and patches change from light load to full contact?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.bench import Bench
from validation.drawing import Drawing
from validation.studies._common import (
    ResultTable,
    at_least,
    base_surface,
    measure,
    over_surfaces,
    persson_area,
    rising,
    solid_of,
)
from validation.studies._measurement import Measurement, area_limits, grid_for

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressures: tuple[float, ...] = (0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2),
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 4,
    points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    shifts: int = 2,
    seed: int = 2006,
) -> xr.Dataset:
    """Press every surface along the path of loads.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressures : tuple of float
        p*, rising: one warm path of loads.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        With dimensions (surface, load): area (limit over grids), and from the finest grid the mean gap over h_rms, the
        energy over that of full contact, the contact stiffness between neighbouring loads, and the patches.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    reduced_pressures, points_per_wave = (
        rising("reduced_pressures", reduced_pressures),
        rising("points_per_wave", points_per_wave),
    )
    surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed)
    cases = [
        Measurement(
            surface=surface,
            realisation=k,
            solid=solid_of(scene),
            reduced_pressures=reduced_pressures,
            grids=tuple(grid_for(surface, points) for points in points_per_wave),
            shifts=shifts,
        )
        for k in range(surfaces)
    ]
    measured = measure(bench, cases)
    limits = [area_limits(data) for data in measured]
    finest = [data.isel(grid=-1).mean("shift") for data in measured]
    pressure = np.array(reduced_pressures)
    gap = np.array([d.mean_gap.values / m.attrs["rms_height"] for d, m in zip(finest, measured, strict=True)])
    full = np.array([[m.attrs["full_contact_energy"]] for m in measured])
    data = {
        "area": np.array([value for value, _ in limits]),
        "area_error": np.array([error for _, error in limits]),
        "pixel": np.array([d.pixel.values for d in finest]),
        "gap": gap,
        "energy": np.array([d.energy.values for d in finest]) / full,
        "gamma": -np.gradient(gap, np.log(pressure), axis=1),
        "patches": np.array([d.patches.values for d in finest]),
        "patch_size": np.array([d.patch_size.values for d in finest]) / surface.lambda_short**2,
    }
    return xr.Dataset(
        {name: (("surface", "load"), values, {"long_name": _WORDS[name]}) for name, values in data.items()},
        coords={"reduced_pressure": ("load", pressure, {"long_name": "p0 / (E* h'_rms)"})},
        attrs={"study": "pressure", "hurst": hurst, "size": size, "ratio": ratio},
    )


_WORDS = {
    "area": "A/A0, limit over grids",
    "area_error": "standard error of that limit",
    "pixel": "A/A0, points counted on the finest grid",
    "gap": "mean gap / h_rms",
    "energy": "elastic energy over that of full contact",
    "gamma": "p0 / (K h_rms) = -d(gap/h_rms)/d ln p0, K the contact stiffness dp0/du",
    "patches": "number of contact patches on the finest grid",
    "patch_size": "sum A_i^2 / sum A_i over lambda_short^2",
}


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each load, means over the surfaces."""
    rows = []
    for j, pressure in enumerate(dataset.reduced_pressure.values):
        area = over_surfaces(dataset.area[:, j])
        mean = {name: float(dataset[name][:, j].mean()) for name in _WORDS}
        rows.append(
            (
                float(pressure),
                area.value,
                area.half_width,
                area.value / pressure,
                float(persson_area(pressure)),
                mean["gap"],
                mean["gamma"],
                mean["energy"],
                mean["patches"],
                mean["patch_size"],
            )
        )
    columns = (
        "p*",
        "A/A0 limit",
        "+- (95 %)",
        "kappa",
        "A/A0 Persson",
        "gap/h_rms",
        "p0/(K h_rms)",
        "U/U_full",
        "patches",
        "mean patch/lambda_short^2",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return where the theory holds, and what does not change with load while contact is light."""
    theory = persson_area(dataset.reduced_pressure.values)
    area = dataset.area.mean("surface").values
    ratio = area / theory
    sentences = [
        "Simulated area (limit) over Persson's: "
        + ", ".join(f"{r:.3f} at A/A0 = {a:.3g}" for r, a in zip(ratio, area, strict=True))
        + "."
    ]
    light = np.flatnonzero(area < 0.1)
    if light.size > 1:
        kappa = area[light] / dataset.reduced_pressure.values[light]
        size = dataset.patch_size.mean("surface").values[light]
        count = dataset.patches.mean("surface").values[light]
        sentences.append(
            f"Between A/A0 = {area[light[0]]:.2g} and {area[light[-1]]:.2g} kappa goes from {kappa[0]:.2f} to {kappa[-1]:.2f}, the mean patch "
            f"size grows {size[-1] / size[0]:.1f}-fold and the number of patches {count[-1] / count[0]:.1f}-fold, where the theories of "
            "independent patches say that size stays and number grows with the area, "
            f"{area[light[-1]] / area[light[0]]:.1f}-fold."
        )
        gamma = dataset.gamma.mean("surface").values[light]
        sentences.append(
            f"The mean gap falls with ln p0 by gamma h_rms with gamma = {gamma.min():.2f} to {gamma.max():.2f} at these loads."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area, gap, energy and patches against load."""
    from validation import plots_studies

    return (
        Drawing(
            name="area-against-pressure",
            figure=plots_studies.area_against_pressure(dataset, persson_area),
            data=dataset[["area", "area_error"]],
            caption="Contact area against load (left) and its ratio to Persson's theory (right); bars, scatter between surfaces.",
        ),
        Drawing(
            name="gap-and-energy",
            figure=plots_studies.gap_and_energy(dataset),
            data=dataset[["gap", "energy"]],
            caption="Mean gap (left) and elastic energy over that of full contact (right) against load; bars, scatter between surfaces.",
        ),
    )
