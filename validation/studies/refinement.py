"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from validation.effects.base import SlotName
from validation.execution.bench import Bench
from validation.execution.measurement import Call
from validation.measurements.block import block_beside_bem
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import SHIFTS, Ladder, RisingOrNone
from validation.measurements.convergence import Ladders, spectral_errors
from validation.measurements.grid_roughness import down_to_grid, grid_roughness
from validation.measurements.grids import (
    PROTOCOL_METHODS,
    SMALL,
    on_grids,
    protocol,
    protocol_of_solvers,
    with_blocks,
    with_distances,
    with_methods,
)
from validation.measurements.limits import solved, solver_error
from validation.measurements.measurement import TOLERANCE, grid_for, press_on_grids
from validation.measurements.references import beside_published, papers_of
from validation.measurements.theory import ensemble_area
from validation.report.estimates import claim, gather, total_error
from validation.report.findings import Finding, finding
from validation.report.marks import Figure, Level, Line, Panel, against, panels_along
from validation.report.table import Column, Table
from validation.report.values import value_of
from validation.report.views import Views
from validation.solvers.theory import predict
from validation.studies._options import Element, Hurst, Methods, ReducedPressure, Surfaces
from validation.studies._scene import PressedOptions, SolverRequest
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

    off: ClassVar[Mapping[str, Any]] = {
        "grid_scale_grids": (),
        "grid_scale_hursts": (),
        "elements": (),
        "ladders": False,
    }
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
    grid_scale_hursts: tuple[Hurst, ...] = Field(
        default=(0.3, 0.5, 0.8),
        description="Hurst exponents at which full finite elements press them, too, on the finest of these grids of at most 128 points, beside the converged kappa of the same surfaces; none to leave that out",
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
            listed = ", ".join(f"{n:g}" for n in self.fem_points_per_wave)
            raise wrong(
                f"fem_points_per_wave = {listed}: the limit of the finite elements needs at least three grids"
            )
        return self

    @property
    def blocks(self) -> tuple[Element, ...]:
        """Finite elements of the study's own blocks."""
        return self.elements if "fem" in self.methods else ()

    @property
    def protocol_hursts(self) -> tuple[float, ...]:
        """Hurst exponents at which full finite elements press roughness down to the grid."""
        return (
            tuple(sorted(set(self.grid_scale_hursts)))
            if "fem" in self.methods and self.grid_scale_grids
            else ()
        )

    @property
    def protocol_points(self) -> int:
        """Points along a side of the finest grid on which the whole block is affordable, or of the coarsest."""
        grids = self.grid_scale_grids
        return max((n for n in grids if n <= _MOST_POINTS), default=min(grids))

    @property
    def beside(self) -> tuple[SolverRequest, ...]:
        """Methods beside boundary elements; on a scene the finite elements as its table has them."""
        return self.others(self.method_points_per_wave)

    @property
    def climbed(self) -> Ladders:
        """The ladders of this H as `hurst` has them."""
        shared = {name: getattr(self, name) for name in ("periods", "reduced_pressure", "seed")}
        return Ladders(hursts=(self.hurst,), **shared)


def design(options: Options) -> dict[_Case, Call]:
    """Return the solves: grids, blocks, roughness to the grid scale, other methods, one with a smaller residual, ladders."""
    pressed, grids = options.pressed, options.grids_for(options.points_per_wave)
    usual = press_on_grids(
        problem=pressed[0],
        grids=grids,
        shifts=options.shifts,
        effects=options.effects,
        tolerance=options.tolerance(TOLERANCE),
        keep=("distributions",),
    )
    few = max(2, sum(n <= _SOLVER_POINTS for n in options.points_per_wave))
    cases: dict[_Case, Call] = {("grids", k): usual.but(problem=problem) for k, problem in enumerate(pressed)}
    # What the stopping of a solver does shows on coarse grids, too.
    cases["strict",] = usual.but(grids=grids[:few], tolerance=usual["tolerance"] / 100)
    for (k, problem), points in itertools.product(enumerate(pressed), options.grid_scale_grids):
        cases["protocol", k, points] = grid_roughness(problem=problem, grid=(points, points))
    blocks = {n: grid_for(pressed[0], n) for n in options.fem_points_per_wave}
    for hurst, k in itertools.product(options.protocol_hursts, range(options.surfaces)):
        surface = options.first.surface.model_copy(update={"hurst": hurst})
        problem = replace(options.first, surface=surface).further(k)
        points, wide = options.protocol_points, down_to_grid(problem, options.protocol_points)
        for method in PROTOCOL_METHODS:
            cases["scale", method, hurst, k] = grid_roughness(
                problem=problem, grid=(points, points), method=method
            )
        fine = tuple(grid_for(wide, n) for n in _CONVERGED)
        cases["converged", hurst, k] = press_on_grids(problem=wide, grids=fine, shifts=options.shifts)
    for element in options.blocks:
        for (k, problem), (n, grid) in itertools.product(enumerate(pressed), blocks.items()):
            cases["fem", element, k, n] = block_beside_bem(problem=problem, grid=grid, element=element)
        cases["strict", element] = cases["fem", element, 0, min(blocks)].but(tolerance=_STRICT)
    for solver, (k, problem) in itertools.product(options.beside, enumerate(pressed)):
        told: dict[str, Any] = {"settings": solver.settings, "effects": options.effects}
        for g, grid in enumerate(solver.grids):
            cases["other", solver.name, k, g] = beside_bem(
                problem=problem, grid=grid, method=solver.method, **told
            )
    return cases | (dict(options.climbed.cases) if options.ladders else {})


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the area on every grid, by boundary and by finite elements, and with roughness down to the grid scale.

    Areas of each surface (surface, grid), means over the shifts, their limit and distances from it; moments of
    P(sigma) and sizes of patches; areas of finite elements (element, surface, fem_grid) and of other methods; kappa
    of the grid-scale protocol (surface, protocol_grid, slope).
    """
    measured = solved(bench, design(options))
    data = _of_boundary_elements(options, measured)
    shares: dict[str, Any] = {}
    if options.ladders:
        climbed = options.climbed.reduced({case: measured[case] for case in options.climbed.cases})
        data = data.merge(climbed, combine_attrs="override")
        spectrum = {"hurst": options.hurst, "bandwidth": options.bandwidth, "periods": options.periods}
        shares = spectral_errors(climbed, **spectrum)
        data = claim(data, "kappa", **{source: share * data.kappa for source, share in shares.items()})

    def part(name: str) -> dict[_Case, xr.Dataset]:
        return {case[1:]: result for case, result in measured.items() if case[0] == name}

    if options.grid_scale_grids:
        rough = protocol(part("protocol"), options.grid_scale_grids)
        data = beside_published(data.merge(rough, combine_attrs="override"))
    if options.protocol_hursts:
        data = data.merge(
            protocol_of_solvers(part("scale"), part("converged"), data, points=options.protocol_points),
            combine_attrs="override",
        )
    if options.blocks:
        strict = {str(element): measured["strict", element] for element in options.blocks}
        cells = math.prod(grid_for(options.first, options.fem_points_per_wave[0]))
        data = with_blocks(data, part("fem"), strict, cells=cells)
        data = claim(
            data, "kappa_fem", **{source: share * data.kappa_fem for source, share in shares.items()}
        )
    if options.beside:
        grids = {solver.name: solver.grids for solver in options.beside}
        data = with_methods(data, part("other"), grids, options.first)
    used = ["fem"] if options.blocks else []
    used += [*(solver.method for solver in options.beside), *(effect.kind for effect in options.effects)]
    methods = " ".join(["theory", "bem", *used, papers_of("kappa")])
    attributes = {"study": "refinement", "shifts": options.shifts, "methods": methods}
    return data.assign_attrs({**attributes, **options.spectrum_words})


def _of_boundary_elements(options: Options, measured: Mapping[_Case, xr.Dataset]) -> xr.Dataset:
    """Reduce the grids: means, distances from the limit with their orders, what P(sigma) has too much of, the theory."""
    surfaces, load = range(options.surfaces), options.reduced_pressure
    data = gather({k: on_grids(measured["grids", k]) for k in surfaces}, surface=surfaces)
    ensemble = ensemble_area(options.first.spectrum, [load], rms_gradients=data.rms_gradient_each.values)
    data = data.assign(reduced_pressure=load, area_persson=_theory(options))
    data["area_ensemble_each"] = "surface", ensemble[:, 0]
    data = with_distances(data, theory=not options.effects)
    usual = measured["grids", 0].isel(grid=slice(0, measured["strict",].sizes["grid"]))
    return claim(data, "kappa", solver=solver_error(usual, measured["strict",]) * data.kappa)


def _theory(options: Options) -> float:
    """A/A0 of Persson's theory with the effects of a scene; NaN where it does not know them."""
    known = all(type(effect).has_theory() for effect in options.effects)
    return predict(options.first, options.effects).area if known else float("nan")


def views(data: xr.Dataset) -> Views:
    """Distance of each definition of the area from the limit, grid by grid; stress and patches there; the protocol."""
    first = int(np.argmax(data.resolution.values == "resolved"))
    names: tuple[str, ...] = ("points", "resolution", "points_per_wave", "cells_per_patch", "kappa_pixel")
    names += ("distance_pixel", "distance_perimeter", "distance_located")
    names += ("first_moment", "density_at_zero", "patches")
    parts = tuple(Column("cells_at_part", {"part": k}) for k in range(data.sizes["part"]))
    return Views(
        table=Table(rows=("grid",), columns=(*names, *parts, "seconds")),
        budget=("kappa", *(("kappa_fem",) if "element" in data.dims else ())),
        figures=[*_on_grids(data, first)],
        findings=[*_of_areas(data, first), *_of_others(data)],
    )


def _on_grids(data: xr.Dataset, first: int) -> Iterator[Figure]:
    """Draw distances from the limit, P(sigma) and patches against the grid."""
    waves: dict[str, Any] = {"x": "points_per_wave", "log": "xy", "base": 2}
    own = [Line(y=f"distance_{name}_size") for name in ("pixel", "perimeter", "located")]
    panels = [Panel(marks=own, **waves)]
    if "element" in data.dims:
        both = [Line(y=f"distance_fem_{name}_size", by="element") for name in ("pixel", "perimeter")]
        panels.append(Panel(marks=both, **{**waves, "x": "points_per_wave_fem"}))
    caption = "Distance of each definition of the area from the limit of its own surface, mean over surfaces"
    caption += "; right, finite elements." if len(panels) > 1 else "."
    yield Figure(name="error-against-resolution", caption=caption, panels=panels, width=5.0 * len(panels))
    yield Figure(
        name="error-against-cells",
        caption="What counting adds against the size of the contact patches in cells, surface by surface; Persson (2006, "
        "Sec. 12) asks for 100 to 10000 cells.",
        panels=[against("cells_per_patch_each", "distance_pixel_each", by="surface", log="xy")],
    )
    grids = sorted({first, (first + data.sizes["grid"] - 1) // 2, data.sizes["grid"] - 1})
    label = "lambda_short/dx = {points_per_wave}"
    thin = {"marker": "", "lw": 1}
    lines = [Line(y="stress_density", at={"grid": g}, look=thin, label=label) for g in grids]
    yield Figure(
        name="stress-on-grids",
        caption="P(sigma) on a coarse, a middling and the finest grid: the load is kept, the area is not.",
        panels=[Panel(marks=[*lines, Line(y="stress_density_persson")], x="stress", bottom=0.0, right=2.0)],
    )
    caption = "Number of contact patches (left), and cells of the patches that hold parts of the area (right), against the grid."
    parts = Panel(marks=[Line(y="cells_at_part", by="part")], **waves)
    panels = [Panel(marks=[Line(y="patches")], **{**waves, "log": "x"}), parts]
    yield Figure(name="patches-on-grids", caption=caption, panels=panels, width=9.0)
    if "slope" in data.dims:
        caption = "kappa when the roughness goes down to the grid scale and nodes are counted, by how the slope is measured."
        marks = (Line(y="kappa_protocol", by="slope"), Level(y="kappa"), Level(y="kappa_persson"))
        panel = Panel(marks=marks, x="points_protocol", y="kappa", log="x", base=2)
        yield Figure(name="grid-scale-protocol", caption=caption, panels=[panel])
    if "solver" in data.dims:
        caption = "kappa with roughness down to the grid, nodes counted, by how the slope is measured: boundary elements, and "
        caption += "full finite elements as Hyun et al. had them; the converged kappa of the same surfaces."
        rough = Line(y="kappa_protocol_by_solver", by="slope", joined=False)
        smooth = Line(y="kappa_protocol_limit", look={"color": "0.4"})
        hyun = Line(y="kappa_hyun", x="hurst_hyun", look={"color": "black", "marker": "x"})
        marked = (rough, smooth, Level(y="kappa_persson"), hyun)
        panel = Panel(marks=marked, x="hurst_protocol", y="kappa")
        panels = [*panels_along(data, "solver", panel)]
        yield Figure(name="grid-scale-by-solver", caption=caption, panels=panels, width=9.0)


def _of_areas(data: xr.Dataset, first: int) -> Iterator[Finding]:
    """Say what the limit is, what counting adds, and where in P(sigma)."""
    resolved = data.isel(grid=slice(first, None))
    limit = "In the limit kappa is {kappa} at p* = {reduced_pressure}, lambda_long/lambda_short = {bandwidth}"
    values: dict[str, Any] = {"bandwidth": float(data.attrs["bandwidth"])}
    if np.isfinite(data.area_persson):
        form = ": {verdict} Persson's {kappa_persson:~} ({kappa_ensemble:~} from C(q) alone), by {area_excess:+%}. Of what "
        form = limit + form + "counting finds more than the theory the grid makes {each}."
        item = "{grid_part:%} at lambda_short/dx = {points_per_wave}"
        yield finding("comparison", form, resolved, item=item, over="grid", by="area_excess", **values)
    else:
        yield finding("value", limit + "; Persson's theory knows nothing of these effects.", data, **values)
    form = "Counting differs from the limit by {each}; observed order {order_pixel} (corrected {order_perimeter}, located "
    form += "{order_located})."
    if np.isfinite(data.points_per_wave_close):
        form += " It is within 5 % from lambda_short/dx = {points_per_wave_close} on, where half of the area lies in patches "
        form += "of at least {cells_per_patch_close:~} cells (Persson asks for 100 to 10000)."
    yield finding("order", form, resolved, item="{distance_pixel:+%} at {points_per_wave}", over="grid")
    values = {"coarse": float(resolved.points_per_wave[0]), "fine": float(resolved.points_per_wave[-1])}
    form = "The first moment of P(sigma) is p0 on every grid; the zeroth, the area, is {area_pixel_change:+%} on {coarse} "
    form += "against {fine} points per wave. Of that excess {small_stress_part:%} lies at sigma < {small} E* h'_rms, and above "
    form += "it the coarse grid holds {large_stress_change:+%}."
    yield finding("share", form, data, small=SMALL, **values)


_AGREES = {"agree": "agrees", "differ": "does not agree", "?": "can neither be confirmed nor ruled out"}
_APART = {"agree": "not distinguishable from it", "differ": "beyond its intervals"}


def _of_others(data: xr.Dataset) -> Iterator[Finding]:
    """Say what roughness at the grid scale gives beside what was published, and where other methods go."""
    if "slope" in data.dims:
        last = data.isel(protocol_grid=-1)
        slopes = ", ".join(f"{{s{k}}} ({name})" for k, name in enumerate(data.slope.values))
        values: dict[str, Any] = {
            f"s{k}": value_of(last.isel(slope=k), "kappa_protocol") for k in range(data.sizes["slope"])
        }
        form = f"With roughness to the grid scale kappa is {slopes}, a spread of {{kappa_protocol_spread:%}}; beside the "
        form += "converged {kappa} there was published: {each}."
        item = "{kappa_published_range} ({paper_kappa}), which {verdict}"
        values |= {"by": "kappa_difference", "words": _AGREES}
        yield finding("agreement", form, last, item=item, over="paper_kappa", **values)
    if "solver" in data.dims:
        yield from _of_protocol(data.sel(solver="fem"))
    form = "Beside the limit of the boundary elements, those of other methods lie {each}."
    for dim, by in (("element", "distance_fem"), ("other", "distance_other")):
        if dim in data.dims:
            item = f"{{{by}:+%}} ({{{dim}}}): {{verdict}}"
            yield finding("agreement", form, data, item=item, over=dim, by=by, words=_APART)


def _of_protocol(data: xr.Dataset) -> Iterator[Finding]:
    """Say how much of what Hyun et al. found the grid explains, and what it does not."""
    form = "Full finite elements with roughness down to their {points_protocol_by_solver} points, nodes counted, have kappa "
    form += "{each} ({slope})."
    item = "{kappa_protocol_by_solver} at H = {hurst_protocol}, {kappa_excess_protocol:+%} from the converged one of the same "
    item += "surfaces, so that the grid makes {grid_part_protocol:%} of its distance to the theory"
    yield finding("share", form, data.isel(slope=0), item=item, over="hurst_protocol")
    same = np.flatnonzero(np.isclose(data.hurst_protocol, float(data.hurst_hyun)))
    if same.size:
        form = "Beside the converged {kappa_protocol_limit} Hyun's {kappa_hyun} at H = {hurst_hyun} lies {verdict}; the protocol has {each}."
        over: dict[str, Any] = {"item": "{kappa_protocol_by_solver} ({slope})", "over": "slope"}
        at = data.isel(hurst_protocol=int(same[0]))
        half = total_error(at, "kappa_excess_protocol")
        raised = half is not None and bool((at.kappa_excess_protocol > half).any())
        side = " (the grid, which raises kappa, explains none of that)" if raised else ""
        words = {"-": f"below{side}", "+": "above", "0": "within the interval"}
        yield finding("comparison", form, at, by="kappa_hyun_difference", words=words, **over)
