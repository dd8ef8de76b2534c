"""What the study `refinement` shows: error against resolution, and roughness down to the scale of the grid."""

from collections.abc import Iterator
from itertools import cycle

import numpy as np
import xarray as xr

from validation.measurements.grids import SMALL
from validation.report.estimates import total_error
from validation.report.values import value_of
from validation.report.views import (
    Column,
    Figure,
    Findings,
    Level,
    Line,
    Table,
    Views,
    against,
    finding,
    panels_along,
)

#: Of other methods, one after the other.
_COLOURS = ("#0b5394", "#b45f06", "#741b47")


def views(data: xr.Dataset) -> Views:
    """Distance of each definition of the area from the limit, grid by grid; stress and patches there; the protocol."""
    first = int(np.argmax(data.resolution.values == "resolved"))
    names: tuple[str, ...] = ("points", "resolution", "points_per_wave", "cells_per_patch", "kappa_pixel")
    names += ("distance_pixel", "distance_perimeter", "distance_located")
    names += ("first_moment", "density_at_zero", "patches")
    parts = (Column("cells_at_part", {"part": k}) for k in range(data.sizes["part"]))
    areas = ("area_pixel_each", "area_perimeter_each", "area_located_each", "area_each")
    return Views(
        table=Table(("grid",), (*names, *parts, "seconds")),
        more=(
            Table(
                ("grid",),
                ("points", "points_per_wave", *(Column(name, {"surface": 0}) for name in areas)),
                title="The first surface alone, which is that of a scene",
                note="A/A0 on each grid, and its limit with the interval of the grids.",
                file="first-surface",
            ),
        ),
        budget=("kappa", *(("kappa_other",) if "other" in data.dims else ())),
        figures=[*_on_grids(data, first)],
        findings=[*_findings(data, first)],
    )


def _on_grids(data: xr.Dataset, first: int) -> Iterator[Figure]:
    waves = "points_per_wave"
    sizes = [f"distance_{name}_size" for name in ("pixel", "perimeter", "located")]
    panels = [against(waves, *sizes, log="xy")]
    if "other" in data.dims:
        lines = []
        for method, colour in zip(data.other.values, cycle(_COLOURS), strict=False):
            of, hue = {"method_other": method}, {"color": colour}
            lines += [
                Line(f"distance_other_{name}_size", where=of, label=f"{method}, {how}", look=hue)
                for name, how in (("pixel", "counted"), ("perimeter", "corrected"))
            ]
        panels.append(against("points_per_wave_other", *lines, log="xy"))
    caption = "Distance of each definition of the area from the limit of its own surface, mean over surfaces."
    yield Figure("error-against-resolution", caption, panels)
    yield Figure(
        "error-against-cells",
        "What counting adds against the size of the contact patches in cells, surface by surface; Persson (2006, "
        "Sec. 12) asks for 100 to 10000 cells.",
        [against("cells_per_patch_each", "distance_pixel_each", by="surface", log="xy")],
    )
    last = data.sizes["grid"] - 1
    look, label = {"marker": "", "lw": 1}, "lambda_short/dx = {points_per_wave}"
    grids = sorted({first, (first + last) // 2, last})
    lines = [Line("stress_density", at={"grid": g}, look=look, label=label) for g in grids]
    yield Figure(
        "stress-on-grids",
        "P(sigma) on a coarse, a middling and the finest grid: the load is kept, the area is not.",
        [against("stress", *lines, "stress_density_persson", bottom=0.0, right=2.0)],
    )
    yield Figure(
        "patches-on-grids",
        "Number of contact patches (left), and cells of the patches that hold parts of the area (right), against the grid.",
        [against(waves, "patches", log="x"), against(waves, "cells_at_part", by="part", log="xy")],
    )
    if "slope" in data.dims:
        marks = ("kappa_protocol", Level("kappa"), Level("kappa_persson"))
        yield Figure(
            "grid-scale-protocol",
            "kappa when the roughness goes down to the grid scale and nodes are counted, by how the slope is measured.",
            [against("points_protocol", *marks, by="slope", y="kappa", log="x")],
        )
    if "solver" in data.dims:
        caption = "kappa with roughness down to the grid, nodes counted, by how the slope is measured: boundary elements, and "
        caption += "full finite elements as Hyun et al. had them; the converged kappa of the same surfaces."
        rough = Line("kappa_protocol_by_solver", by="slope", joined=False)
        smooth = Line("kappa_protocol_limit", look={"color": "0.4"})
        hyun = Line("kappa_hyun", x="hurst_hyun", look={"color": "black", "marker": "x"})
        marked = (rough, smooth, Level("kappa_persson"), hyun)
        panels_of = panels_along(data, "solver", against("hurst_protocol", *marked, y="kappa"))
        yield Figure("grid-scale-by-solver", caption, panels_of)


def _findings(data: xr.Dataset, first: int) -> Findings:
    """Say what counting is off on the grids from the `first` resolved one on, and which pressures make it."""
    resolved = data.isel(grid=slice(first, None))
    limit = "In the limit kappa is {kappa} at p* = {reduced_pressure}, lambda_long/lambda_short = {bandwidth}"
    if np.isfinite(data.area_persson):
        form = ": {verdict} Persson's {kappa_persson:~} ({kappa_ensemble:~} from C(q) alone), by {area_excess:+%}. "
        form = limit + form + "Of the counted excess over the theory the grid makes {each}."
        item = "{grid_part:%} at lambda_short/dx = {points_per_wave}"
        yield finding("comparison", form, resolved, item=item, by="area_excess")
    else:
        yield finding("value", limit + "; Persson's theory knows nothing of these effects.", data)
    form = "Counting differs from the limit by {each}; observed order {order_pixel} (corrected {order_perimeter}, located "
    form += "{order_located})."
    if np.isfinite(data.points_per_wave_close):
        form += " It is within 5 % from lambda_short/dx = {points_per_wave_close} on, where half of the area lies in patches "
        form += "of at least {cells_per_patch_close:~} cells (Persson asks for 100 to 10000)."
    yield finding("order", form, resolved, item="{distance_pixel:+%} at {points_per_wave}")
    coarse, fine = resolved.points_per_wave[[0, -1]]
    form = "The first moment of P(sigma) is p0 on every grid; the zeroth, the area, is {area_pixel_change:+%} on {coarse} "
    form += "against {fine} points per wave. Pressures below {small} E* h'_rms make {small_stress_part:%} of that excess; of "
    form += "larger ones the coarse grid has {large_stress_change:+%}."
    yield finding("share", form, data, small=SMALL, coarse=coarse, fine=fine)
    if "slope" in data.dims:
        last = data.isel(protocol_grid=-1)
        slopes = ", ".join(f"{{s{k}}} ({name})" for k, name in enumerate(data.slope.values))
        values = {f"s{k}": value_of(last.isel(slope=k), "kappa_protocol") for k in range(data.sizes["slope"])}
        form = f"With roughness to the grid scale kappa is {slopes}, a spread of {{kappa_protocol_spread:%}}; beside the "
        form += "converged {kappa} there was published: {each}."
        item = "{kappa_published_range} ({paper_kappa}), which {verdict}"
        outcomes = {
            "agree": "agrees",
            "differ": "does not agree",
            "?": "can neither be confirmed nor ruled out",
        }
        yield finding("agreement", form, last, item=item, by="kappa_difference", words=outcomes, **values)
    if "solver" in data.dims:
        yield from _of_protocol(data.sel(solver="fem"))
    if "other" in data.dims:
        form = "Beside the limit of the boundary elements, those of other methods lie {each}."
        item = "{distance_other:+%} ({other}): {verdict}"
        outcomes = {"agree": "not distinguishable from it", "differ": "beyond its intervals"}
        yield finding("agreement", form, data, item=item, by="distance_other", words=outcomes)


def _of_protocol(data: xr.Dataset) -> Findings:
    form = "Full finite elements with roughness down to their {points_protocol_by_solver} points, nodes counted, have kappa "
    form += "{each} ({slope})."
    item = "{kappa_protocol_by_solver} at H = {hurst_protocol}, {kappa_excess_protocol:+%} from the converged one of the same "
    item += "surfaces, so that the grid makes {grid_part_protocol:%} of its distance to the theory"
    first = data.isel(slope=0)  # the spectral slope, that of C(q)
    yield finding("share", form, first, item=item)
    same = np.flatnonzero(np.isclose(data.hurst_protocol, float(data.hurst_hyun)))
    if same.size:
        form = "Beside the converged {kappa_protocol_limit} Hyun's {kappa_hyun} at H = {hurst_hyun} lies {verdict}; the protocol has {each}."
        item = "{kappa_protocol_by_solver} ({slope})"
        at = data.isel(hurst_protocol=int(same[0]))
        half = total_error(at, "kappa_excess_protocol")
        # A grid that raises kappa explains no value that lies below.
        raised = half is not None and bool((at.kappa_excess_protocol > half).any())
        side = " (the grid, which raises kappa, explains none of that)" if raised else ""
        outcomes = {"-": f"below{side}", "+": "above", "0": "within the interval"}
        yield finding("comparison", form, at, item=item, by="kappa_hyun_difference", words=outcomes)
