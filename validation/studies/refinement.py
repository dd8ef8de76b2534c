"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

import itertools
import math
from dataclasses import replace
from typing import Annotated, Any, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from validation.measurements.common import SHIFTS, Ladder, RisingOrNone
from validation.measurements.convergence import Ladders, spectral_errors
from validation.measurements.grids import (
    PROTOCOL_METHODS,
    down_to_grid,
    grid_roughness,
    on_grids,
    protocol,
    protocol_of_solvers,
    with_block_errors,
    with_distances,
    with_methods,
)
from validation.measurements.limits import solver_error
from validation.measurements.measurement import TOLERANCE, grids_for, press_on_grids
from validation.measurements.references import beside_published, papers_of
from validation.measurements.theory import ensemble_area
from validation.report.estimates import claim_shares
from validation.report.places import gather
from validation.studies._options import Element, Hurst, Methods, ReducedPressure, Shifts, Surfaces
from validation.studies._refinement_views import views as views
from validation.studies._scene import PressedOptions, SolverRequest
from validation.studies._study import Bench, Call, Measured, solved
from validation.units import wrong

#: Tolerance of the finite elements that shows what their usual one leaves; finest grid of that check of boundary elements,
#: as lambda_short/dx.
_STRICT, _SOLVER_POINTS = 1e-10, 8.0
#: Grids on which the roughness that went down to the grid converges, as lambda_short/dx.
_CONVERGED = (4.0, 6.0)
#: Points along a side of the largest whole block that presses it.
_MOST_POINTS = 128

#: A part of the study, then what is told apart in it.
_Case = tuple[str | float | int, ...]


class Options(PressedOptions):
    """Surfaces, grids, and what is measured beside them."""

    off = ("ladders", "grid_scale_grids", "grid_scale_hursts", "elements")
    slots = frozenset({"response", "pressure bound"})
    plain = "an adhesive contact jumps from grid to grid, and has no law of refinement"

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    surfaces: Surfaces = 4
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)
    """grids, as lambda_short/dx, rising; below 3 they are run, labelled and left out of the limit"""
    grid_scale_grids: tuple[Annotated[int, Field(ge=8)], ...] = (64, 128, 256)
    """points along a side of the same surfaces with roughness down to the grid scale"""
    grid_scale_hursts: tuple[Hurst, ...] = (0.3, 0.5, 0.8)
    """Hurst exponents at which full finite elements press them, too, on the finest of these grids of at
    most 128 points, beside the converged kappa of the same surfaces; none to leave that out"""
    elements: tuple[Element, ...] = ("Hex1", "Hex2")
    """finite elements of a block one period deep, reduced to its surface; none to leave them out"""
    fem_points_per_wave: RisingOrNone = (4.0, 8.0, 16.0)
    """grids of the finite elements, as lambda_short/dx, rising, at least three"""
    method_points_per_wave: RisingOrNone = (4.0, 8.0, 16.0)
    """grids of any other of the methods, as lambda_short/dx, rising"""
    ladders: bool = True
    """also measure how kappa moves with bandwidth and sample, for the budget"""

    @model_validator(mode="after")
    def _limit_of_elements(self) -> Self:
        if self.blocks and len(self.fem_points_per_wave) < 3:
            listed = ", ".join(f"{n:g}" for n in self.fem_points_per_wave)
            three = "the limit of the finite elements needs at least three grids"
            raise wrong(f"fem_points_per_wave = {listed}: {three}")
        return self

    @property
    def blocks(self) -> tuple[Element, ...]:
        """Finite elements of the study's own blocks."""
        return self.elements if "fem" in self.methods else ()

    @property
    def protocol_hursts(self) -> tuple[float, ...]:
        """Hurst exponents at which full finite elements press roughness down to the grid."""
        pressed = "fem" in self.methods and self.grid_scale_grids
        return tuple(sorted(set(self.grid_scale_hursts))) if pressed else ()

    @property
    def protocol_points(self) -> int:
        """Points along a side of the finest grid on which the whole block is affordable, or of the coarsest."""
        grids = self.grid_scale_grids
        return max((n for n in grids if n <= _MOST_POINTS), default=min(grids))

    @property
    def beside(self) -> tuple[SolverRequest, ...]:
        """Blocks and methods beside boundary elements; on a scene the finite elements as its table has them."""
        blocks = (self.block(element, self.fem_points_per_wave) for element in self.blocks)
        return (*blocks, *self.others(self.method_points_per_wave))

    @property
    def climbed(self) -> Ladders:
        """The ladders of this H as `hurst` has them."""
        return Ladders(
            hursts=(self.hurst,), **self.model_dump(include={"periods", "reduced_pressure", "seed"})
        )


def design(options: Options) -> dict[_Case, Call]:
    """Return the solves: grids, blocks, roughness to the grid scale, other methods, one with a smaller residual, ladders."""
    pressed, grids = options.pressed, options.grids_for(options.points_per_wave)
    cases: dict[_Case, Call] = {}
    for k, problem in enumerate(pressed):
        cases["grids", k] = press_on_grids(
            problem=problem,
            grids=grids,
            shifts=options.shifts,
            effects=options.effects,
            tolerance=options.tolerance(TOLERANCE),
            keep=("distributions",),
        )
        for points in options.grid_scale_grids:
            cases["protocol", k, points] = grid_roughness(problem=problem, grid=(points, points))
    # What the stopping of a solver does shows on coarse grids, too.
    few, usual = max(2, sum(n <= _SOLVER_POINTS for n in options.points_per_wave)), cases["grids", 0]
    cases["strict",] = usual.but(grids=grids[:few], tolerance=usual["tolerance"] / 100)

    for hurst, k in itertools.product(options.protocol_hursts, range(options.surfaces)):
        surface = options.first.surface.model_copy(update={"hurst": hurst})
        problem = replace(options.first, surface=surface).further(k)
        points = options.protocol_points
        for method in PROTOCOL_METHODS:
            rough = grid_roughness(problem=problem, grid=(points, points), method=method)
            cases["scale", method, hurst, k] = rough
        wide = down_to_grid(problem, points)
        fine = grids_for(wide, _CONVERGED)
        cases["converged", hurst, k] = press_on_grids(problem=wide, grids=fine, shifts=options.shifts)
    for solver, (k, problem) in itertools.product(options.beside, enumerate(pressed)):
        layer = True if solver.name in options.blocks else None
        for g, grid in enumerate(solver.grids):
            case = solver.beside_bem(problem, grid, effects=options.effects, layer=layer)
            cases["other", solver.name, k, g] = case
    for element in options.blocks:
        block = cases["other", element, 0, 0]
        cases["strict", element] = block.but(settings=(*block["settings"], ("tolerance", _STRICT)))
    return cases | (dict(options.climbed.cases) if options.ladders else {})


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the area on every grid, by boundary and by finite elements, and with roughness down to the grid scale.

    Areas of each surface (surface, grid), means over the shifts, their limit and distances from it; moments of
    P(sigma) and sizes of patches; areas of finite elements and other methods (other_case, surface); kappa of the
    grid-scale protocol (surface, protocol_grid, slope).
    """
    measured = solved(bench, design(options))
    data = _of_boundary_elements(options, measured)
    shares: dict[str, Any] = {}
    if options.ladders:
        climbed = options.climbed.reduced(measured)
        data = data.merge(climbed, combine_attrs="override")
        shares = spectral_errors(climbed, **options.model_dump(include={"hurst", "bandwidth", "periods"}))
        data = claim_shares(data, "kappa", **shares)

    def part(name: str) -> dict[_Case, xr.Dataset]:
        return {case[1:]: result for case, result in measured.items() if case[0] == name}

    if options.grid_scale_grids:
        rough = protocol(part("protocol"), options.grid_scale_grids)
        data = beside_published(data.merge(rough, combine_attrs="override"))
    if options.protocol_hursts:
        rough = protocol_of_solvers(part("scale"), part("converged"), data, points=options.protocol_points)
        data = data.merge(rough, combine_attrs="override")
    if options.beside:
        grids = {solver.name: solver.grids for solver in options.beside}
        data = with_methods(data, part("other"), grids, options.first)
        data = claim_shares(data, "kappa_other", **shares)
    if options.blocks:
        strict = {str(element): measured["strict", element] for element in options.blocks}
        data = with_block_errors(data, part("other"), strict, options.beside[0].grids)
    used = ["theory", "bem", *(solver.method for solver in options.beside)]
    used += PROTOCOL_METHODS * bool(options.protocol_hursts)
    used += [*(effect.kind for effect in options.effects), papers_of("kappa")]
    methods = " ".join(dict.fromkeys(used))
    return data.assign_attrs(shifts=options.shifts, methods=methods, **options.spectrum_words)


def _of_boundary_elements(options: Options, measured: Measured) -> xr.Dataset:
    surfaces, load = range(options.surfaces), options.reduced_pressure
    share = options.first.shortest**2 / math.prod(options.first.lengths)
    data = gather({k: on_grids(measured["grids", k], wave_share=share) for k in surfaces}, "surface")
    # Persson's theory knows some of the effects of a scene.
    known = all(type(effect).has_theory() for effect in options.effects)
    theory = [options.predicted(problem) for problem in options.pressed] if known else []
    alone = np.array([one.ensemble_area for one in theory] or options.surfaces * [None], dtype=float)
    if not options.effects:
        gradients = data.rms_gradient_each.values
        alone = ensemble_area(options.first.spectrum, [load], rms_gradients=gradients)[:, 0]
    data = data.assign(
        reduced_pressure=load,
        area_persson_each=("surface", [one.area for one in theory] or options.surfaces * [np.nan]),
        area_ensemble_each=("surface", alone),
    )
    data = with_distances(data, theory=not options.effects)
    usual = measured["grids", 0].isel(grid=slice(0, measured["strict",].sizes["grid"]))
    return claim_shares(data, "kappa", solver=solver_error(usual, measured["strict",]))
