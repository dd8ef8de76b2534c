"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from validation.effects.base import SlotName
from validation.measures.block import BlockMeasurement
from validation.measures.budget import Budget, budget_table, grid_share, solver_error
from validation.measures.common import SHIFTS, Ladder, RisingOrNone, each, over_surfaces, persson_area
from validation.measures.distributions import Distributions
from validation.measures.ladders import Ladders, spectral_errors
from validation.measures.measurement import Grid, grid_for
from validation.measures.side_by_side import ByMethod
from validation.measures.statistics import combined, mean_over_surfaces
from validation.measures.theory import ensemble_area
from validation.methods.theory import predict
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.studies._options import Element, Methods, ReducedPressure, Surfaces
from validation.studies._scene import Asked, PressedOptions
from validation.studies.refinement.data import (
    AREAS,
    finite_elements,
    on_grids,
    other_methods,
    overestimate,
)
from validation.studies.refinement.grid_roughness import GridRoughness
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.solves.solve import NumbersSolve

__all__ = ["Options", "budget", "figures", "findings", "overestimate", "run", "table"]

#: Tolerance of the finite-element solves that show what their usual one leaves.
_STRICT = 1e-10

#: Finest grid of the check of the solver, as lambda_short/dx.
_SOLVER_POINTS = 8.0

#: Areas of other methods, which figures draw where they are.
_BESIDE = ("fem_pixel", "fem_perimeter", "other_pixel", "other_perimeter")

#: A part of the study, then what is told apart in it.
_Case = tuple[str | float | int, ...]


class Options(PressedOptions):
    """Surfaces, grids, and what is measured beside them."""

    off: ClassVar[Mapping[str, Any]] = {"grid_scale_grids": (), "elements": (), "ladders": False}
    slots: ClassVar[frozenset[SlotName]] = frozenset({"response", "pressure bound"})
    plain = "an adhesive contact jumps from grid to grid, and has no law of refinement"

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    surfaces: Surfaces = 4
    shifts: int = Field(default=SHIFTS, ge=1, description="sub-grid shifts along each axis")
    points_per_wave: Ladder = Field(
        default=(2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0),
        description="grids, as lambda_short/dx, rising; below 3 they are run, labelled and left out of the limit",
    )
    grid_scale_grids: tuple[Annotated[int, Field(ge=8)], ...] = Field(
        default=(64, 128, 256),
        description="points along a side of the same surfaces with roughness down to the grid scale",
    )
    elements: tuple[Element, ...] = Field(
        default=("Hex1", "Hex2"),
        description="finite elements of a block one period deep, reduced to its surface; none to leave them out",
    )
    fem_points_per_wave: RisingOrNone = Field(
        default=(4.0, 8.0, 16.0),
        description="grids of the finite elements, as lambda_short/dx, rising, at least three",
    )
    method_points_per_wave: RisingOrNone = Field(
        default=(4.0, 8.0, 16.0),
        description="grids of any other of the methods, as lambda_short/dx, rising",
    )
    ladders: bool = Field(
        default=True, description="also measure how kappa moves with bandwidth and sample, for the budget"
    )

    @model_validator(mode="after")
    def _limit_of_elements(self) -> Self:
        if self.blocks and len(self.fem_points_per_wave) < 3:
            raise wrong(
                f"fem_points_per_wave = {', '.join(f'{n:g}' for n in self.fem_points_per_wave)}: the limit of the finite "
                "elements needs at least three grids"
            )
        return self

    @property
    def blocks(self) -> tuple[Element, ...]:
        """Finite elements of the study's own blocks."""
        return self.elements if "fem" in self.methods else ()


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the area on every grid, by boundary and by finite elements, and with roughness down to the grid scale.

    Returns
    -------
    xarray.Dataset
        Areas with dimensions (surface, grid), means over the shifts; `limit` per surface; moments of P(sigma) and sizes of
        patches; areas of finite elements with dimensions (element, surface, fem_grid); kappa of the grid-scale protocol
        with dimensions (surface, protocol_grid, slope); areas of other methods with dimensions (case, surface).
    """
    first, pressed = options.first, options.pressed
    others = _others(options)
    cases = {**_boundary_elements(options, pressed), **_finite_elements(options, pressed)}
    cases |= {
        ("other", asked.name, k, g): _beside(asked, grid, own, options)
        for asked in others
        for (k, own), (g, grid) in itertools.product(enumerate(pressed), enumerate(asked.grids))
    }
    climbed = Ladders(
        hursts=(options.hurst,),
        periods=options.periods,
        reduced_pressure=options.reduced_pressure,
        seed=options.seed,
    )
    solved = bench.solve([*cases.values(), *(climbed.cases.values() if options.ladders else ())])
    found = {case: solved[solve] for case, solve in cases.items()}
    data = _of_boundary_elements(found, options)
    gradients = [field.attrs["rms_gradient"] for case, field in found.items() if case[0] == "grids"]
    data["ensemble"] = ensemble_area(
        first.spectrum, [options.reduced_pressure], rms_gradients=gradients
    ).mean()
    data["theory"] = _theory(options)
    if options.blocks:
        node = 1 / grid_for(first, options.fem_points_per_wave[0])[0] ** 2
        data = data.merge(_of_finite_elements(found, options, node=node))
    if options.ladders:
        rungs = {case: solved[solve].assign_attrs(solve=solve.key) for case, solve in climbed.cases.items()}
        data = data.merge(climbed.reduced(rungs))
    if others:
        answers: Any = {case[1:]: answer for case, answer in found.items() if case[0] == "other"}
        data = data.merge(other_methods(answers, others, first=first, surfaces=options.surfaces))
    used = ["fem"] if options.blocks else []
    used += [*(asked.method for asked in others), *(effect.kind for effect in options.effects)]
    return data.assign_attrs(
        study="refinement",
        reduced_pressure=options.reduced_pressure,
        **options.spectrum_words,
        shifts=options.shifts,
        **({} if options.effects else {"bare": 1}),
        methods=" ".join(["theory", "bem", *used, "perimeter"]),
    )


def _others(options: Options) -> tuple[Asked, ...]:
    """List the methods beside boundary elements; on a scene the finite elements as its table has them."""
    own = ("bem",) if options.scene is not None else ("bem", "fem")
    return options.others(options.method_points_per_wave, without=own)


def _beside(asked: Asked, grid: Grid, own: Realised, options: Options) -> ByMethod:
    return ByMethod(
        realised=own, grid=grid, method=asked.method, settings=asked.settings, effects=options.effects
    )


def _theory(options: Options) -> float:
    """A/A0 of Persson's theory with the effects of a scene; NaN where it does not know them."""
    if not options.effects:
        return float(persson_area(options.reduced_pressure))
    known = all(type(effect).has_theory() for effect in options.effects)
    return predict(options.first, options.effects).area if known else float("nan")


def _boundary_elements(options: Options, pressed: Sequence[Realised]) -> dict[_Case, NumbersSolve]:
    """List the solves on resolved grids, one with a smaller residual, and those with roughness to the grid scale."""
    usual = Distributions(
        realised=pressed[0],
        grids=options.grids_for(options.points_per_wave),
        shifts=options.shifts,
        effects=options.effects,
        tolerance=options.tolerance(Distributions.tolerance),
    )
    cases: dict[_Case, NumbersSolve] = {}
    for k, own in enumerate(pressed):
        cases["grids", k] = replace(usual, realised=own)
    cases["strict",] = replace(usual, grids=usual.grids[: _few(options)], tolerance=usual.tolerance / 100)
    for (k, own), n in itertools.product(enumerate(pressed), options.grid_scale_grids):
        cases["grid scale", k, n] = GridRoughness(realised=own, grid=(n, n))
    return cases


def _few(options: Options) -> int:
    """Count the grids of the check of the solver: what its stopping does shows on coarse grids, too."""
    return max(2, sum(n <= _SOLVER_POINTS for n in options.points_per_wave))


def _finite_elements(options: Options, pressed: Sequence[Realised]) -> dict[_Case, NumbersSolve]:
    """List the blocks, and one of each element with a smaller residual."""
    grids = {n: grid_for(pressed[0], n) for n in options.fem_points_per_wave}
    cases: dict[_Case, NumbersSolve] = {}
    for element, (k, own), n in itertools.product(options.blocks, enumerate(pressed), grids):
        cases["fem", element, k, n] = BlockMeasurement(realised=own, grid=grids[n], element=element)
    for element in options.blocks:
        cases["strict fem", element] = BlockMeasurement(
            realised=pressed[0],
            grid=grids[options.fem_points_per_wave[0]],
            element=element,
            tolerance=_STRICT,
        )
    return cases


def _of_boundary_elements(found: Mapping[_Case, xr.Dataset], options: Options) -> xr.Dataset:
    """Return what the boundary elements give."""
    surfaces = range(options.surfaces)
    measured = [found["grids", k] for k in surfaces]
    data = on_grids(measured)
    if options.grid_scale_grids:
        kappa = [[found["grid scale", k, n].kappa.values for n in options.grid_scale_grids] for k in surfaces]
        data["kappa_grid_scale"] = (("surface", "protocol_grid", "slope"), np.array(kappa))
        data = data.assign_coords(
            slope=["spectral", "forward", "central"],
            protocol_points=("protocol_grid", list(options.grid_scale_grids)),
        )
    usual = measured[0].isel(grid=slice(0, _few(options)))
    data["solver_error"] = solver_error(usual, found["strict",])
    return data


def _of_finite_elements(found: Mapping[_Case, xr.Dataset], options: Options, *, node: float) -> xr.Dataset:
    """Return what the finite elements give, and what the stopping of their solver leaves.

    Less than the share `node` of one node on the coarsest grid cannot be seen, and counts as one.
    """
    elements, per_wave = options.blocks, options.fem_points_per_wave
    blocks: Any = {case[1:]: data for case, data in found.items() if case[0] == "fem"}
    data = finite_elements(blocks, elements, per_wave, surfaces=options.surfaces)
    counted = np.array([float(blocks[element, 0, per_wave[0]].pixel) for element in elements])
    strictly = np.array([float(found["strict fem", element].pixel) for element in elements])
    data["fem_solver_error"] = ("element", np.maximum(np.abs(counted - strictly), node) / strictly)
    return data


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each grid, then those of the finite elements and of other methods."""
    rows = [*_grid_rows(dataset)]
    if "element" in dataset.dims:
        rows += _fem_rows(dataset)
    if "case" in dataset.dims:
        rows += _other_rows(dataset)
    return ResultTable.of_rows(rows)


def _grid_rows(dataset: xr.Dataset) -> Iterator[dict[str, float | str]]:
    """Yield the rows of the boundary elements, which have every column."""
    off = dataset.assign({f"{name}_off": overestimate(dataset, name) for name in AREAS})
    for here in each(off, "grid"):
        per_wave = float(here.points_per_wave)
        label = "" if per_wave > 2 * (1 + 1e-9) else " (under-resolved)"
        shares = zip(dataset.part.values, here.cells.transpose("part", ...), strict=True)
        yield {
            "grid": f"{int(here.points)}{label}",
            "lambda_short/dx": per_wave,
            "cells in the median patch": float(here.cells_per_patch.mean()),
            _KAPPA: float(here.pixel.mean() / dataset.attrs["reduced_pressure"]),
            **_from_limit({name: here[f"{name}_off"] for name in AREAS}),
            "first moment / p0": float(here.first_moment.mean()),
            "P(0+) E*h'": float(here.density_at_zero.mean()),
            "patches": float(here.patches.mean()),
            **{
                f"cells at {100 * float(part):g} % of the area": float(cells.mean()) for part, cells in shares
            },
            "seconds": float(here.seconds.mean()),
        }


_KAPPA = "kappa, counted (zeroth moment / p*)"


def _from_limit(off: Mapping[str, xr.DataArray]) -> dict[str, float]:
    """Distances of areas from the limit, means over the surfaces with their intervals, by title."""
    found: dict[str, float] = {}
    for name, values in off.items():
        mean = over_surfaces(values)
        found |= {f"{name} - limit [%]": 100 * mean.value, f"{name} +- (95 %) [%]": 100 * mean.half_width}
    return found


def _fem_rows(dataset: xr.Dataset) -> Iterator[dict[str, float | str]]:
    """Yield the rows of the finite elements, with both countings against the limit of the boundary elements."""
    for here in each(dataset, "element", "fem_grid"):
        yield {
            "grid": f"FEM {here.element.item()}",
            "lambda_short/dx": float(here.fem_points_per_wave),
            _KAPPA: float(here.fem_pixel.mean() / dataset.attrs["reduced_pressure"]),
            **_from_limit({name: here[f"fem_{name}"] / here.limit - 1 for name in ("pixel", "perimeter")}),
        }


def _other_rows(dataset: xr.Dataset) -> Iterator[dict[str, float | str]]:
    """Yield the rows of the other methods, against the limit of the boundary elements."""
    for here in each(dataset, "case"):
        yield {
            "grid": f"{here.other.item()}, {here.other_grid.item()}",
            "lambda_short/dx": float(here.other_points_per_wave),
            _KAPPA: float(here.other_pixel.mean() / dataset.attrs["reduced_pressure"]),
            **_from_limit({name: here[f"other_{name}"] / here.limit - 1 for name in AREAS}),
            "seconds": float(here.other_seconds.mean()),
        }


def budget(dataset: xr.Dataset) -> ResultTable:
    """Return what is uncertain about kappa in the limit, by boundary and by finite elements."""
    pressure = float(dataset.attrs["reduced_pressure"])
    spectral: dict[str, float] = {}
    if "ladder" in dataset.dims:
        told = {name: float(dataset.attrs[name]) for name in ("hurst", "bandwidth", "periods")}
        size, band = (
            float(share) for _, share in sorted(spectral_errors(dataset, **told).items(), reverse=True)
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
    from validation.studies.refinement.sentences import all_of

    return tuple(all_of(dataset))


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw error against resolution, error against cells per patch, and kappa of the grid-scale protocol."""
    from validation.studies.refinement import plots

    errors = {name: overestimate(dataset, name) for name in AREAS}
    theory = float(dataset.theory) / float(dataset.attrs["reduced_pressure"])
    drawings = (
        Drawing(
            name="error-against-resolution",
            figure=plots.error_against_resolution(dataset, errors),
            data=dataset[[*AREAS, "limit", *(n for n in _BESIDE if n in dataset)]],
            caption="Distance of each definition of the area from the limit of its own surface: lines, mean over surfaces; dots, single surfaces; dashed, first order in dx; open, finite elements by element and other methods, counted and with the edge constant of each.",
        ),
        Drawing(
            name="error-against-cells",
            figure=plots.error_against_cells(dataset, errors["pixel"]),
            data=dataset[["pixel", "limit", "cells_per_patch"]],
            caption="Overestimate by counting against the size of the contact patches in cells, the criterion of Persson 2006, Sec. 12; grey, what it asks for.",
        ),
        Drawing(
            name="stress-on-grids",
            figure=plots.stress_on_grids(dataset),
            data=dataset[["density", "first_moment", "pixel"]],
            caption="P(sigma) on every grid, mean over surfaces (left), with Persson's; its first and zeroth moment over those of the limit (right): the load is kept, the area is not.",
        ),
        Drawing(
            name="patches-on-grids",
            figure=plots.patches_on_grids(dataset),
            data=dataset[["patches", "cells"]],
            caption="Number of contact patches against the grid (left), and the cells of the patches that hold 10, 50 and 90 % of the area (right); grey, what Persson 2006, Sec. 12, asks for.",
        ),
    )
    if "kappa_grid_scale" not in dataset:
        return drawings
    protocol = Drawing(
        name="grid-scale-protocol",
        figure=plots.grid_scale_protocol(dataset, theory),
        data=dataset[["kappa_grid_scale"]],
        caption="kappa when the roughness goes down to the grid scale and nodes are counted, by the way the slope is measured; bars, scatter between surfaces.",
    )
    return (*drawings, protocol)
