"""By how much does a grid overestimate the contact area, and what remains of the distance to the theory?"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from persson.elastic import pressure_distribution, stress_variance
from validation.effects.base import SlotName
from validation.measures.block import BlockMeasurement
from validation.measures.common import SHIFTS, Ladder, RisingOrNone, persson_area
from validation.measures.distributions import Distributions
from validation.measures.grid_roughness import GridRoughness
from validation.measures.grids import observed_order, on_grids, protocol, with_blocks, with_methods
from validation.measures.ladders import Ladders, spectral_errors
from validation.measures.limits import solved, solver_error
from validation.measures.measurement import grid_for
from validation.measures.references import papers_of, published
from validation.measures.side_by_side import ByMethod
from validation.measures.theory import ensemble_area
from validation.methods.theory import predict
from validation.report.estimates import change, claim, derive, gather, mean, total_error
from validation.report.findings import Finding, finding
from validation.report.marks import Figure, Level, Line, Panel
from validation.report.table import Column, Table
from validation.report.values import value_of
from validation.report.views import Views
from validation.solves.bench import Bench
from validation.studies._options import Element, Methods, ReducedPressure, Surfaces
from validation.studies._scene import Asked, PressedOptions
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.solves.solve import NumbersSolve

__all__ = ["Options", "design", "run", "views"]

#: Tolerance of the finite elements that shows what their usual one leaves; finest grid of that check of boundary elements,
#: as lambda_short/dx; grids at and below which nothing is resolved; distance from the limit that is close; stress, over
#: E* h'_rms, that is small.
_STRICT, _SOLVER_POINTS, _RESOLVED, _CLOSE, _SMALL = 1e-10, 8.0, 2 * (1 + 1e-9), 0.05, 0.2

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

    @property
    def beside(self) -> tuple[Asked, ...]:
        """Methods beside boundary elements; on a scene the finite elements as its table has them."""
        own = ("bem",) if self.scene is not None else ("bem", "fem")
        return self.others(self.method_points_per_wave, without=own)

    @property
    def climbed(self) -> Ladders:
        """The ladders of this H as `hurst` has them."""
        told: dict[str, Any] = {"reduced_pressure": self.reduced_pressure, "seed": self.seed}
        return Ladders(hursts=(self.hurst,), periods=self.periods, **told)


def design(options: Options) -> dict[_Case, NumbersSolve]:
    """Return the solves: grids, blocks, roughness to the grid scale, other methods, one with a smaller residual, ladders."""
    pressed, grids = options.pressed, options.grids_for(options.points_per_wave)
    usual = Distributions(
        realised=pressed[0],
        grids=grids,
        shifts=options.shifts,
        effects=options.effects,
        tolerance=options.tolerance(Distributions.tolerance),
    )
    few = max(2, sum(n <= _SOLVER_POINTS for n in options.points_per_wave))
    cases: dict[_Case, NumbersSolve] = {
        ("grids", k): replace(usual, realised=own) for k, own in enumerate(pressed)
    }
    # What the stopping of a solver does shows on coarse grids, too.
    cases["strict",] = replace(usual, grids=grids[:few], tolerance=usual.tolerance / 100)
    for (k, own), points in itertools.product(enumerate(pressed), options.grid_scale_grids):
        cases["protocol", k, points] = GridRoughness(realised=own, grid=(points, points))
    blocks = {n: grid_for(pressed[0], n) for n in options.fem_points_per_wave}
    for element in options.blocks:
        for (k, own), (n, grid) in itertools.product(enumerate(pressed), blocks.items()):
            cases["fem", element, k, n] = BlockMeasurement(realised=own, grid=grid, element=element)
        coarse = blocks[options.fem_points_per_wave[0]]
        told: dict[str, Any] = {"element": element, "tolerance": _STRICT}
        cases["strict", element] = BlockMeasurement(realised=pressed[0], grid=coarse, **told)
    for asked, (k, own) in itertools.product(options.beside, enumerate(pressed)):
        told = {"settings": asked.settings, "effects": options.effects}
        for g, grid in enumerate(asked.grids):
            cases["other", asked.name, k, g] = ByMethod(realised=own, grid=grid, method=asked.method, **told)
    return cases | (dict(options.climbed.cases) if options.ladders else {})


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the area on every grid, by boundary and by finite elements, and with roughness down to the grid scale.

    Returns
    -------
    xarray.Dataset
        Areas of each surface (surface, grid), means over the shifts, their limit and distances from it; moments of P(sigma)
        and sizes of patches; areas of finite elements (element, surface, fem_grid) and of other methods; kappa of the
        grid-scale protocol (surface, protocol_grid, slope).
    """
    found = solved(bench, design(options))
    data = _of_boundary_elements(options, found)
    spectral: dict[str, Any] = {}
    if options.ladders:
        climbed = options.climbed.reduced({case: found[case] for case in options.climbed.cases})
        data = data.merge(climbed, combine_attrs="override")
        told = {"hurst": options.hurst, "bandwidth": options.bandwidth, "periods": options.periods}
        spectral = spectral_errors(climbed, **told)
        data = claim(data, "kappa", **{source: share * data.kappa for source, share in spectral.items()})
    if options.grid_scale_grids:
        rough = {case[1:]: one for case, one in found.items() if case[0] == "protocol"}
        data = data.merge(protocol(rough, options.grid_scale_grids), combine_attrs="override")
        data = _beside_published(data)
    if options.blocks:
        blocks = {case[1:]: one for case, one in found.items() if case[0] == "fem"}
        strict = {str(element): found["strict", element] for element in options.blocks}
        cells = math.prod(grid_for(options.first, options.fem_points_per_wave[0]))
        data = with_blocks(data, blocks, strict, cells=cells)
        data = claim(
            data, "kappa_fem", **{source: share * data.kappa_fem for source, share in spectral.items()}
        )
    if options.beside:
        answers = {case[1:]: one for case, one in found.items() if case[0] == "other"}
        points = {
            asked.name: [options.first.points_per_wave(grid) for grid in asked.grids]
            for asked in options.beside
        }
        data = with_methods(data, answers, {asked.name: asked.grids for asked in options.beside}, points)
    used = ["fem"] if options.blocks else []
    used += [*(asked.method for asked in options.beside), *(effect.kind for effect in options.effects)]
    return data.assign_attrs(
        study="refinement",
        **options.spectrum_words,
        shifts=options.shifts,
        methods=" ".join(["theory", "bem", *used, papers_of("kappa")]),
    )


def _of_boundary_elements(options: Options, found: Mapping[_Case, xr.Dataset]) -> xr.Dataset:
    """Reduce the grids: means, distances from the limit with their orders, what P(sigma) has too much of, the theory."""
    surfaces, load = range(options.surfaces), options.reduced_pressure
    data = gather({k: on_grids(found["grids", k]) for k in surfaces}, surface=surfaces)
    resolved = data.points_per_wave.values > _RESOLVED
    first = int(np.argmax(resolved))
    ensemble = ensemble_area(options.first.spectrum, [load], rms_gradients=data.rms_gradient_each.values)
    data = data.assign(
        reduced_pressure=load, area_persson=_theory(options), area_ensemble_each=("surface", ensemble[:, 0])
    ).assign_coords(resolution=("grid", np.where(resolved, "resolved", "under-resolved")))
    areas = ("pixel", "perimeter", "located")
    data = derive(
        data,
        kappa_each="area_each / reduced_pressure",
        kappa_pixel_each="area_pixel_each / reduced_pressure",
        kappa_persson="area_persson / reduced_pressure",
        kappa_ensemble_each="area_ensemble_each / reduced_pressure",
        area_excess_each="area_each / area_persson - 1",
        **{f"distance_{name}_each": f"area_{name}_each / area_each - 1" for name in areas},
        stress_density="stress_density_each.mean('surface')",
        grid_part_each="(area_pixel_each - area_each) / (area_pixel_each - area_persson)",
    )
    data = change(data, "area_pixel", along="grid", first=-1, last=first)
    names: tuple[str, ...] = (*(f"area_{name}" for name in areas), *(f"distance_{name}" for name in areas))
    names += (
        "area",
        "kappa",
        "kappa_pixel",
        "kappa_ensemble",
        "area_excess",
        "grid_part",
        "area_pixel_change",
    )
    names += (
        "first_moment",
        "patches",
        "cells_at_part",
        "cells_per_patch",
        "density_at_zero",
    )
    data = mean(data, *names, "residual", "seconds", "edge_fraction")
    for name in areas:
        own = observed_order(data.isel(grid=resolved), f"distance_{name}", to=f"order_{name}")
        data = data.assign({n: own[n] for n in (f"order_{name}", f"order_{name}_error")})
    data = derive(data, **{f"distance_{name}_size": f"abs(distance_{name})" for name in areas})
    # Above the last pressure at which the coarse grid has more, it must have less: the load is the same.
    coarse, fine = (f"stress_density.isel(grid={k})" for k in (first, -1))
    low, high = (f"where(stress {sign} {_SMALL}, 0).sum('stress_bin')" for sign in ("<", ">="))
    bare = derive(
        data[["stress_density"]],
        small_stress_part=f"({coarse} - {fine}).{low} / ({coarse} - {fine}).sum('stress_bin')",
        large_stress_change=f"{coarse}.{high} / {fine}.{high} - 1",
    )
    data = data.assign({name: bare[name] for name in ("small_stress_part", "large_stress_change")})
    variance = stress_variance(1.0, contact_modulus=1.0)
    law = pressure_distribution(data.stress.values, pressure=load, stress_variance=variance)
    close = np.flatnonzero(resolved & (data.distance_pixel_size.values < _CLOSE))
    missing = 1.0 if close.size else np.nan
    enough = data.isel(grid=int(close[0]) if close.size else 0)
    data = data.assign(
        stress_density_persson=("stress_bin", law * (np.nan if options.effects else 1.0)),
        points_per_wave_close=float(enough.points_per_wave) * missing,
        cells_per_patch_close=float(enough.cells_per_patch) * missing,
    )
    usual = found["grids", 0].isel(grid=slice(0, found["strict",].sizes["grid"]))
    return claim(data, "kappa", solver=solver_error(usual, found["strict",]) * data.kappa)


def _theory(options: Options) -> float:
    """A/A0 of Persson's theory with the effects of a scene; NaN where it does not know them."""
    if not options.effects:
        return float(persson_area(options.reduced_pressure))
    known = all(type(effect).has_theory() for effect in options.effects)
    return predict(options.first, options.effects).area if known else float("nan")


def _beside_published(data: xr.Dataset) -> xr.Dataset:
    """Add how far kappa is from each published range; NaN where its interval is wider than that range."""
    data = data.merge(published("kappa").isel(end=0, drop=True))
    inside = "minimum(maximum(kappa, kappa_published), kappa_published_high)"
    half, width = total_error(data, "kappa"), data.kappa_published_high - data.kappa_published
    data["kappa_comparable"] = (1.0 + 0.0 * width).where((width == 0) | (half <= width / 2))
    return derive(data, kappa_difference=f"kappa_comparable * (kappa - {inside})")


def views(data: xr.Dataset) -> Views:
    """Distance of each definition of the area from the limit, grid by grid; stress and patches there; the protocol."""
    first = int(np.argmax(data.resolution.values == "resolved"))
    names: tuple[str, ...] = ("points", "resolution", "points_per_wave", "cells_per_patch", "kappa_pixel")
    names += (
        "distance_pixel",
        "distance_perimeter",
        "distance_located",
        "first_moment",
        "density_at_zero",
        "patches",
    )
    parts = tuple(Column("cells_at_part", {"part": k}) for k in range(data.sizes["part"]))
    return Views(
        table=Table(rows=("grid",), columns=(*names, *parts, "seconds")),
        budget=("kappa", *(("kappa_fem",) if "element" in data.dims else ())),
        figures=[*_on_grids(data, first), *(_protocol_figure() if "slope" in data.dims else ())],
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
        panels=[
            Panel(marks=[Line(y="distance_pixel_each", by="surface")], x="cells_per_patch_each", log="xy")
        ],
    )
    grids = sorted({first, (first + data.sizes["grid"] - 1) // 2, data.sizes["grid"] - 1})
    label = "lambda_short/dx = {points_per_wave}"
    lines = [
        Line(y="stress_density", at={"grid": g}, look={"marker": "", "lw": 1}, label=label) for g in grids
    ]
    yield Figure(
        name="stress-on-grids",
        caption="P(sigma) on a coarse, a middling and the finest grid: the load is kept, the area is not.",
        panels=[Panel(marks=[*lines, Line(y="stress_density_persson")], x="stress", bottom=0.0, right=2.0)],
    )
    caption = "Number of contact patches (left), and cells of the patches that hold parts of the area (right), against the grid."
    panels = [
        Panel(marks=[Line(y="patches")], **{**waves, "log": "x"}),
        Panel(marks=[Line(y="cells_at_part", by="part")], **waves),
    ]
    yield Figure(name="patches-on-grids", caption=caption, panels=panels, width=9.0)


def _protocol_figure() -> Iterator[Figure]:
    marks = (Line(y="kappa_protocol", by="slope"), Level(y="kappa"), Level(y="kappa_persson"))
    caption = "kappa when the roughness goes down to the grid scale and nodes are counted, by the way the slope is measured."
    panel = Panel(marks=marks, x="points_protocol", y="kappa", log="x", base=2)
    yield Figure(name="grid-scale-protocol", caption=caption, panels=[panel])


def _of_areas(data: xr.Dataset, first: int) -> Iterator[Finding]:
    """Say what the limit is, what counting adds, and where in P(sigma)."""
    resolved = data.isel(grid=slice(first, None))
    limit = "In the limit kappa is {kappa} at p* = {reduced_pressure}, lambda_long/lambda_short = {bandwidth}"
    told: dict[str, Any] = {"bandwidth": float(data.attrs["bandwidth"])}
    if np.isfinite(data.area_persson):
        form = (
            limit
            + ": {verdict} Persson's {kappa_persson:~} ({kappa_ensemble:~} from C(q) alone), by {area_excess:+%}. Of "
        )
        form += "what counting finds more than the theory the grid makes {each}."
        item = "{grid_part:%} at lambda_short/dx = {points_per_wave}"
        yield finding("comparison", form, resolved, item=item, over="grid", by="area_excess", **told)
    else:
        yield finding("value", limit + "; Persson's theory knows nothing of these effects.", data, **told)
    form = "Counting differs from the limit by {each}; observed order {order_pixel} (corrected {order_perimeter}, located "
    form += "{order_located})."
    if np.isfinite(data.points_per_wave_close):
        form += " It is within 5 % from lambda_short/dx = {points_per_wave_close} on, where half of the area lies in patches "
        form += "of at least {cells_per_patch_close:~} cells (Persson asks for 100 to 10000)."
    item = "{distance_pixel:+%} at {points_per_wave}"
    yield finding("order", form, resolved, item=item, over="grid")
    ends: dict[str, Any] = {
        "coarse": float(resolved.points_per_wave[0]),
        "fine": float(resolved.points_per_wave[-1]),
    }
    form = "The first moment of P(sigma) is p0 on every grid; the zeroth, the area, is {area_pixel_change:+%} on {coarse} "
    form += "against {fine} points per wave. Of that excess {small_stress_part:%} lies at sigma < {small} E* h'_rms, and above "
    form += "it the coarse grid holds {large_stress_change:+%}."
    yield finding("share", form, data, small=_SMALL, **ends)


def _of_others(data: xr.Dataset) -> Iterator[Finding]:
    """Say what roughness at the grid scale gives beside what was published, and where other methods go."""
    apart = {"agree": "not distinguishable from it", "differ": "beyond its intervals"}
    if "slope" in data.dims:
        last = data.isel(protocol_grid=-1)
        over = {"with": ", ".join(f"{{s{k}}} ({name})" for k, name in enumerate(data.slope.values))}
        told = {f"s{k}": value_of(last.isel(slope=k), "kappa_protocol") for k in range(data.sizes["slope"])}
        form = "With roughness to the grid scale kappa is " + over["with"] + ", a spread of "
        form += "{kappa_protocol_spread:%}; published kappa {each} the converged {kappa}."
        item = "{kappa_published} to {kappa_published_high} ({paper_kappa}) {verdict}"
        words = {
            "agree": "agrees with",
            "differ": "does not agree with",
            "?": "can neither be confirmed nor ruled out by",
        }
        yield finding(
            "agreement", form, last, item=item, over="paper_kappa", by="kappa_difference", words=words, **told
        )
    for dim, what in (("element", "fem"), ("other", "other")):
        if dim in data.dims:
            form = "Beside the limit of the boundary elements, those of other methods lie {each}."
            item = f"{{distance_{what}:+%}} ({{{dim}}}): {{verdict}}"
            yield finding("agreement", form, data, item=item, over=dim, by=f"distance_{what}", words=apart)
