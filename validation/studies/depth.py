"""How deep must the block be, how fast may its layers grow, and which element does it take?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from validation.measures.block import BlockMeasurement
from validation.measures.common import BASE_SOLID, Rising, base_case, base_surface, each, results_of
from validation.measures.measurement import grid_for
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Element, ReducedPressure, Seed
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]

#: What is kept while another dial is turned.
_DEPTH, _GROWTH, _POISSON = 1.0, 1.2, 0.3

_NAMES = {
    "pressure_half_space": "||p - p_half-space|| / ||p_half-space||",
    "pressure_layer": "||p - p_layer|| / ||p_layer||, bonded layer of the same depth",
    "area": "A/A_half-space - 1, points counted",
}


class Options(StudyOptions):
    """Dials of the block, turned one at a time around depth L, growth 1.2 and nu = 0.3, for every element.

    The surface has H = 0.8, L/lambda_long = 1, lambda_long/lambda_short = 4: its longest wave feels the bottom most.
    """

    own = "its surface is the one whose longest wave feels the bottom most"

    reduced_pressure: ReducedPressure = 0.05
    points_per_wave: float = Field(default=16.0, gt=0, description="grid, as lambda_short/dx")
    depths: Rising = Field(
        default=(0.125, 0.25, 0.5, 0.75, 1.0, 1.5), description="depths of the block, in periods"
    )
    growths: Rising = Field(
        default=(1.05, 1.1, 1.2, 1.5), description="ratios of the thicknesses of successive layers"
    )
    elements: tuple[Element, ...] = Field(
        default=("Hex1", "Hex2"), min_length=1, description="trilinear and triquadratic"
    )
    poissons: tuple[Annotated[float, Field(gt=-1, le=0.5)], ...] = Field(
        default=(0.0, 0.3, 0.45), description="Poisson ratios"
    )
    seed: Seed = 2006


@dataclass(frozen=True, kw_only=True)
class _Block:
    """One block, and which of its dials is turned."""

    varied: str
    element: str
    depth: float = _DEPTH
    growth: float = _GROWTH
    poisson: float = _POISSON


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Turn every dial.

    Returns
    -------
    xarray.Dataset
        Pressure differences against the half-space and against the bonded layer of the same depth, by case.
    """
    blocks = tuple(_blocks(options))
    return _dataset(results_of(bench, {block: _solve(block, options) for block in blocks}), options)


def _blocks(options: Options) -> Iterator[_Block]:
    for element, depth in itertools.product(options.elements, options.depths):
        yield _Block(varied="depth", element=element, depth=depth)
    for element, growth in itertools.product(options.elements, options.growths):
        yield _Block(varied="growth", element=element, growth=growth)
    for element, poisson in itertools.product(options.elements, options.poissons):
        yield _Block(varied="poisson", element=element, poisson=poisson)


def _solve(block: _Block, options: Options) -> BlockMeasurement:
    pressed = base_case(
        base_surface(hurst=0.8, periods=1.0, bandwidth=4.0, seed=options.seed),
        reduced_pressure=options.reduced_pressure,
        solid=SolidSpec(young=BASE_SOLID.young, poisson=block.poisson),
    )
    return BlockMeasurement(
        realised=pressed,
        grid=grid_for(pressed, options.points_per_wave),
        element=block.element,
        depth=block.depth,
        growth=block.growth,
    )


def _dataset(found: Mapping[_Block, xr.Dataset], options: Options) -> xr.Dataset:
    import xarray as xr

    values = {
        name: [float(data[name]) for data in found.values()]
        for name in ("pressure_half_space", "pressure_layer")
    }
    values["area"] = [float(data.pixel / data.pixel_bem) - 1 for data in found.values()]
    return xr.Dataset(
        {name: ("case", array, {"long_name": _NAMES[name]}) for name, array in values.items()},
        coords={
            "element": ("case", [block.element for block in found]),
            "depth": ("case", [block.depth for block in found], {"long_name": "depth / L"}),
            "growth": ("case", [block.growth for block in found]),
            "poisson": ("case", [block.poisson for block in found]),
            "varied": ("case", [block.varied for block in found]),
        },
        attrs={"study": "depth", "points_per_wave": options.points_per_wave, "methods": "bem fem"},
    )


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each case."""
    return ResultTable.of_rows(
        {
            "varied": str(case.varied.item()),
            "element": str(case.element.item()),
            "depth/L": float(case.depth),
            "growth": float(case.growth),
            "nu": float(case.poisson),
            "p - half-space [%]": 100 * float(case.pressure_half_space),
            "p - layer [%]": 100 * float(case.pressure_layer),
            "A - half-space [%]": 100 * float(case.area),
        }
        for case in each(dataset, "case")
    )


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
    return (
        Drawing(
            name="block-depth",
            figure=_block_depth(dataset),
            data=dataset[["pressure_half_space", "pressure_layer"]],
            caption="Pressure of the block against depth (left) and growth of the layers (right): filled, against the "
            "half-space; open, against the bonded layer of the same depth, which is the error of the mesh alone.",
        ),
    )


def _block_depth(dataset: xr.Dataset) -> Figure:
    """Pressure of the block against half-space and layer, over depth and over growth."""
    from validation.report.figure import new_figure, plain_look

    figure, panels = new_figure(width=9.0, columns=2)
    for axes, dial, label in zip(
        panels, ("depth", "growth"), ("depth / L", "growth of successive layers"), strict=True
    ):
        for k, element in enumerate(dict.fromkeys(dataset.element.values.tolist())):
            keep = (dataset.element.values == element) & (dataset.varied.values == dial)
            part, style = dataset.isel(case=np.flatnonzero(keep)), plain_look(k)
            axes.plot(part[dial], 100 * part.pressure_half_space, label=f"{element}, half-space", **style)
            axes.plot(
                part[dial],
                100 * part.pressure_layer,
                label=f"{element}, layer",
                mfc="white",
                ls="--",
                **style,
            )
        axes.set_yscale("log")
        axes.set_xlabel(label)
        axes.set_ylabel("relative L2 difference of pressure [%]")
    panels[0].legend(fontsize=8)
    return figure
