"""How deep must the block be, how fast may its layers grow, and which element does it take?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.block import BlockMeasurement
from validation.measures.common import base_surface, measure, rising
from validation.measures.measurement import grid_for
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SolidSpec
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    points_per_wave: float = 16.0,
    depths: tuple[float, ...] = (0.125, 0.25, 0.5, 0.75, 1.0, 1.5),
    growths: tuple[float, ...] = (1.05, 1.1, 1.2, 1.5),
    elements: tuple[str, ...] = ("Hex1", "Hex2"),
    poissons: tuple[float, ...] = (0.0, 0.3, 0.45),
    seed: int = 2006,
) -> xr.Dataset:
    """Vary depth, growth and Poisson ratio, one at a time around depth L, growth 1.2 and nu = 0.3, for every element.

    Parameters
    ----------
    scene : Scene, optional
        Gives Young's modulus, which scales out.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressure : float
        p*.
    points_per_wave : float
        Grid, as lambda_short/dx.
    depths : tuple of float
        Depths of the block, in periods.
    growths : tuple of float
        Ratios of successive layers.
    elements : tuple of str
        Hex1 (trilinear) and Hex2 (triquadratic).
    poissons : tuple of float
        Poisson ratios.
    seed : int
        Of the surface: H = 0.8, L/lambda_long = 1, lambda_long/lambda_short = 4, whose longest wave feels the bottom most.

    Returns
    -------
    xarray.Dataset
        Pressure differences against the half-space and against the bonded layer of the same depth, by case.
    """
    import xarray as xr

    surface = base_surface(hurst=0.8, size=1.0, ratio=4.0, seed=seed)
    young = 1e9 if scene is None else scene.solid.young
    points = grid_for(surface, points_per_wave)[0]
    settings = [(e, d, 1.2, 0.3, "depth") for e, d in itertools.product(elements, rising("depths", depths))]
    settings += [
        (e, 1.0, g, 0.3, "growth") for e, g in itertools.product(elements, rising("growths", growths))
    ]
    settings += [(e, 1.0, 1.2, nu, "poisson") for e, nu in itertools.product(elements, poissons)]
    solves = [
        BlockMeasurement(
            surface=surface,
            solid=SolidSpec(young=young, poisson=nu),
            reduced_pressure=reduced_pressure,
            points=points,
            element=element,
            depth=depth,
            growth=growth,
        )
        for element, depth, growth, nu, _ in settings
    ]
    measured = measure(bench, solves)
    names = {
        "pressure_half_space": "||p - p_half-space|| / ||p_half-space||",
        "pressure_layer": "||p - p_layer|| / ||p_layer||, bonded layer of the same depth",
        "area": "A/A_half-space - 1, points counted",
    }
    values = {name: [float(d[name]) for d in measured] for name in ("pressure_half_space", "pressure_layer")}
    values["area"] = [float(d.pixel / d.pixel_bem) - 1 for d in measured]
    return xr.Dataset(
        {name: ("case", array, {"long_name": names[name]}) for name, array in values.items()},
        coords={
            "element": ("case", [s[0] for s in settings]),
            "depth": ("case", [s[1] for s in settings], {"long_name": "depth / L"}),
            "growth": ("case", [s[2] for s in settings]),
            "poisson": ("case", [s[3] for s in settings]),
            "varied": ("case", [s[4] for s in settings]),
        },
        attrs={"study": "depth", "points_per_wave": points_per_wave, "methods": "bem fem"},
    )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each case."""
    rows = [
        (
            str(dataset.varied.values[i]),
            str(dataset.element.values[i]),
            float(dataset.depth[i]),
            float(dataset.growth[i]),
            float(dataset.poisson[i]),
            100 * float(dataset.pressure_half_space[i]),
            100 * float(dataset.pressure_layer[i]),
            100 * float(dataset.area[i]),
        )
        for i in range(dataset.sizes["case"])
    ]
    columns = (
        "varied",
        "element",
        "depth/L",
        "growth",
        "nu",
        "p - half-space [%]",
        "p - layer [%]",
        "A - half-space [%]",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return where the bottom is felt, and what the mesh alone is responsible for."""
    sentences = []
    for element in dict.fromkeys(dataset.element.values.tolist()):
        part = dataset.isel(
            case=np.flatnonzero((dataset.element.values == element) & (dataset.varied.values == "depth"))
        )
        bottom = part.pressure_half_space.values - part.pressure_layer.values
        deep = part.depth.values[np.abs(bottom) < 0.1 * part.pressure_layer.values]
        felt = f"from depth {deep.min():g} L on" if deep.size else "at no depth tried"
        sentences.append(
            f"{element}: the mesh alone (against a layer of the same depth) costs {100 * part.pressure_layer.values[-1]:.2g} % in pressure at depth "
            f"{part.depth.values[-1]:g} L; the bottom adds less than a tenth of that {felt}, and at {part.depth.values[0]:g} L the pressure is "
            f"{100 * part.pressure_half_space.values[0]:.3g} % from the half-space."
        )
        for dial in ("growth", "poisson"):
            part = dataset.isel(
                case=np.flatnonzero((dataset.element.values == element) & (dataset.varied.values == dial))
            )
            words = ", ".join(
                f"{100 * p:.2g} % at {v:g}"
                for p, v in zip(part.pressure_layer.values, part[dial].values, strict=True)
            )
            sentences.append(f"{element}, error of the mesh by {dial}: {words}.")
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the pressure difference against depth and growth."""
    from validation.studies import _plots_studies as plots_studies

    return (
        Drawing(
            name="block-depth",
            figure=plots_studies.block_depth(dataset),
            data=dataset[["pressure_half_space", "pressure_layer"]],
            caption="Pressure of the block against depth (left) and growth of the layers (right): filled, against the half-space; open, against the bonded layer of the same depth, which is the error of the mesh alone.",
        ),
    )
