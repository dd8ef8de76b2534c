"""Do finite elements and boundary elements agree on the same surface and grid, and ever better with refinement?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.block import BlockMeasurement
from validation.measures.common import at_least, base_surface, measure, rising, solid_of
from validation.measures.measurement import grid_for
from validation.measures.statistics import order_of_convergence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["figures", "findings", "run", "table"]

_NAMES = {
    "pressure_half_space": "||p_fem - p_bem|| / ||p_bem||",
    "pressure_inside": "the same, 1.5 cells and more from the edges",
    "area": "A_fem/A_bem - 1, points counted",
    "area_corrected": "A_fem/A_bem - 1, each with its perimeter correction",
    "gap": "(mean gap_fem - mean gap_bem) / h_rms: the offsets less C(0) p0",
    "residual": "largest contact residual of the finite elements",
    "seconds": "wall time of the finite elements [s]",
    "seconds_bem": "wall time of the boundary elements [s]",
}


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 2.0,
    ratio: float = 4.0,
    surfaces: int = 2,
    full_points_per_wave: tuple[float, ...] = (3.0, 4.0, 6.0),
    reduced_points_per_wave: tuple[float, ...] = (3.0, 4.0, 6.0, 8.0, 16.0, 32.0),
    elements: tuple[str, ...] = ("Hex1", "Hex2"),
    seed: int = 2006,
) -> xr.Dataset:
    """Press the same heights by both methods.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressure : float
        p*.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    full_points_per_wave : tuple of float
        Grids of the full Hex1 system: the independent leg, which shares no contact algorithm with the boundary elements.
    reduced_points_per_wave : tuple of float
        Grids of the exact reduction, which shares it: agreement there checks the discretisation only.
    elements : tuple of str
        Elements of the reduction.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        Differences with dimensions (case, surface); cases are labelled by leg.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 1)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    legs = [("full Hex1", "full", "Hex1", n) for n in rising("full_points_per_wave", full_points_per_wave)]
    legs += [
        (f"reduced {element}", "reduced", element, n)
        for element, n in itertools.product(
            elements, rising("reduced_points_per_wave", reduced_points_per_wave)
        )
    ]
    solves = [
        BlockMeasurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressure=reduced_pressure,
            points=grid_for(surface, n)[0],
            method="full" if method == "full" else "reduced",
            element=element,
        )
        for (_, method, element, n), k in itertools.product(legs, range(surfaces))
    ]
    measured = measure(bench, solves)
    shape = (len(legs), surfaces)
    values = {
        name: np.array([float(d[name]) for d in measured if name in d])
        for name in _NAMES
        if name in measured[0]
    }
    values["area"] = np.array([float(d.pixel / d.pixel_bem) - 1 for d in measured])
    values["area_corrected"] = np.array([float(d.perimeter / d.perimeter_bem) - 1 for d in measured])
    return xr.Dataset(
        {
            name: (("case", "surface"), array.reshape(shape), {"long_name": _NAMES[name]})
            for name, array in values.items()
        },
        coords={
            "leg": ("case", [leg for leg, *_ in legs]),
            "points_per_wave": ("case", [n for *_, n in legs], {"long_name": "lambda_short / dx"}),
        },
        attrs={"study": "cross", "reduced_pressure": reduced_pressure, "methods": "bem fem perimeter"},
    )


def _legs(dataset: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(dataset.leg.values.tolist()))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each leg and grid, means over surfaces."""
    names = (
        "pressure_half_space",
        "pressure_inside",
        "area",
        "area_corrected",
        "gap",
        "residual",
        "seconds",
        "seconds_bem",
    )
    rows: list[tuple[float | str, ...]] = [
        (
            str(dataset.leg.values[i]),
            float(dataset.points_per_wave[i]),
            *(float(dataset[name][i].mean()) for name in names),
        )
        for i in range(dataset.sizes["case"])
    ]
    return ResultTable.of(("leg", "lambda_short/dx", *(_NAMES[name] for name in names)), rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return how the differences fall for each leg, and what the agreement means."""
    sentences = []
    for leg in _legs(dataset):
        part = dataset.isel(case=np.flatnonzero(dataset.leg.values == leg))
        spacing = 1 / part.points_per_wave.values
        pressure = part.pressure_half_space.mean("surface").values
        area = np.abs(part.area.mean("surface").values)
        text = (
            f"{leg}: the pressures differ by {100 * pressure[0]:.2g} % at {part.points_per_wave.values[0]:g} points per shortest wave and by "
            f"{100 * pressure[-1]:.2g} % at {part.points_per_wave.values[-1]:g}, the counted areas by {100 * area[0]:.2g} % and {100 * area[-1]:.2g} %"
        )
        if spacing.size > 1:
            text += f" (fitted order of the pressure difference in dx: {order_of_convergence(spacing, pressure):.2f})"
        sentences.append(text + ".")
    sentences.append(
        "The full system shares no contact algorithm with the boundary elements: its agreement verifies both codes. The reduced one shares "
        "it: its agreement verifies the discretisation. What remains in the finest reduced rows includes the finite depth of the block."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the differences against the grid."""
    from validation.studies import _plots_studies as plots_studies

    return (
        Drawing(
            name="fem-against-bem",
            figure=plots_studies.fem_against_bem(dataset, _legs(dataset)),
            data=dataset[["pressure_half_space", "area", "area_corrected"]],
            caption="Difference of pressure (left) and of counted area (right) between finite and boundary elements on the same surface and points, by leg; dots, surfaces.",
        ),
    )
