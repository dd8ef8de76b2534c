"""What is shown of a run: cards, tables, figures and findings of its dataset."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from validation.comparison.reductions import DIFFERENCES
from validation.comparison.treatment import STATISTICS, treatment_findings, treatment_table
from validation.report.estimates import derive, sources_of, total_error
from validation.report.findings import Finding, finding, note
from validation.report.marks import Image, Level, Line, against
from validation.report.places import each
from validation.report.quantities import quantity
from validation.report.values import Value, value_of
from validation.report.views import MOST_FINDINGS, Card, Figure, Listing, Table, Views
from validation.solvers import find_method

_NUMBERS = (
    *("area", "area_own", "area_lowest", "area_highest", "contact_area", "nominal_area", "kappa"),
    *("area_persson", "area_ensemble", "area_other_energy", "area_ratio", "kappa_persson"),
    *("area_plastic", "area_plastic_persson", "scatter", "mean_gap", "gap", "approach"),
    *("ball_radius", "hertz_radius", "hertz_approach", "hertz_pressure", "hertz_share"),
    *("stiffness", "largest_pressure", "patches", "density_at_zero_order"),
    *(f"{name}{by}" for name in ("electrical_conductance", "thermal_conductance") for by in ("", "_persson")),
    *(f"leak_rate_{axis}{by}" for axis in "xy" for by in ("", "_bruggeman")),
    *("pressure", "reduced_pressure", "contact_modulus", "surface_modulus", "felt_modulus"),
    *("rms_height", "rms_height_spectrum", "rms_gradient", "rms_gradient_spectrum", "nayak"),
    *STATISTICS,
)
_NOTE = (
    "Of the scene's own surface, on the finest grid that resolves it. What follows from fields has an "
    "interval of Student's, from how far coarser grids are from it, times (dx/dx_coarse)^(3/2), of the "
    "largest pressure and patches dx/dx_coarse. A/A0, conductances and leaks are means over the surfaces "
    "of an ensemble."
)
#: Questions that cards of runs, sweeps and the theory alone answer.
HOW_LARGE, HOW_YIELDED = "How large is the contact? A/A0", "How much has yielded? A_pl/A0"
HOW_FAR = "How far from Persson's theory?"
_GRIDS = (
    "Counted: points of the contact set, mean over sub-grid positions; corrected: less the method's edge "
    "constant times edge length times dx; located: the edge placed inside the cells. kappa is the corrected "
    "area over p*. The residual is the largest of penetration/h_rms, tension/(E* h'_rms) with E* at the "
    "surface, complementarity and load error; a tolerance bounds complementarity, and the others by ten "
    "times that."
)


def run_views(data: xr.Dataset) -> Views:
    """Return what is shown of the dataset of a run."""
    return Views(
        table=_on_grids(
            # The best first: the last leave where there is no room for all.
            *("area_located", "area_perimeter", "area_pixel", "kappa_perimeter", "area_plastic_pixel"),
            *("density_at_zero", "points_per_wave", "residual", "shifts", "unknowns", "seconds", "failure"),
            title="Every grid",
            note=_GRIDS,
        ),
        more=tuple(_tables(data)),
        budget=("area", "area_own", "kappa") if data.surfaces > 1 else ("area", "kappa"),
        figures=tuple(_figures(data)),
        findings=tuple(_findings(data))[:MOST_FINDINGS],
        cards=tuple(_cards(data)),
    )


def _on_grids(*names: str, **about: str) -> Table:
    rows = ("solver", "grid")
    return Table(rows, (*rows, *names), sparse=True, **about)


def _tables(data: xr.Dataset) -> Iterator[Table | Listing]:
    # What another number says again.
    again = {"area_own": "area"} | dict.fromkeys(("surface_modulus", "felt_modulus"), "contact_modulus")
    repeated = {a for a, b in again.items() if a in data and np.isclose(data[a], data[b])}
    if "ball_radius" not in data and np.isclose(data.approach, -data.mean_gap):
        repeated.add("approach")
    names = tuple(name for name in _NUMBERS if name not in repeated)
    yield Listing(names=names, title="Contact in numbers", note=_NOTE)
    yield from treatment_table(data)
    if "pressure_difference" in data:
        others = map(find_method, map(str, data.solver.values[1:]))
        apart = " and ".join(method.label for method in others if method.independent)
        agreement = "They share a contact algorithm, so that agreement tests the discretisation alone."
        if apart:
            agreement = f"{apart} has a contact algorithm of its own, so agreement tests both codes; the "
            agreement += "differences include that of the discretisations."
        yield _on_grids(
            *DIFFERENCES,
            title=f"Beside {_label(data, 0)} on the same grid",
            note="Same surface, same points, same load or held distance; of the pressure the relative L2 "
            f"norm of the difference. {agreement}",
            file="methods",
        )
    if "von_mises" in data:
        yield _on_grids(
            *("von_mises_reduced", "von_mises", "von_mises_depth_reduced", "von_mises_depth"),
            title="Below the surface",
            note="The surface itself is left out, where the edges of the contact ring. The solid is "
            "elastic whatever its hardness.",
            file="below",
        )
    if "area_each" in data:
        each_of = [
            f"{name}_each" for name in ("area", "area_persson", "area_ratio", "rms_gradient", "failure")
        ]
        yield Table(("surface",), ("surface", *each_of), title="Every surface", file="surfaces")


def _label(data: xr.Dataset, k: int) -> str:
    return find_method(str(data.solver.values[k])).label


def _cards(data: xr.Dataset) -> Iterator[Card]:
    several = float(data.surfaces) > 1
    basis = "mean over {surfaces} surfaces; this one {area_own}" if several else "{area_basis}"
    yield _card(HOW_LARGE, "{area}", basis + "; kappa = {kappa}", data)
    answer, held = how_sure(data)
    scatter = "{scatter:.2%}" if several else ""
    scatter = (
        f"single surfaces scatter by {scatter}" if scatter else "the scatter between surfaces is unknown"
    )
    yield Card("How sure?", answer, finding("value", "; ".join(filter(None, (held, scatter))), data))
    if "area_excess" in data and np.isfinite(data.area_persson_own):
        basis = "theory: A/A0 = {area_persson:.4} with the realised gradient; p* = {reduced_pressure:.4}, "
        basis += "lambda_long/lambda_short = {bandwidth:.3}"
        basis += "; the +- leaves out the treatment of the map" * ("treatment_spread" in data)
        bandwidth = data.assign_attrs(bandwidth=float(data.wave_long / data.wave_short))
        yield _card(HOW_FAR, "{area_excess:+%}", basis, bandwidth)
    if "hertz_radius" in data:
        basis = "R = {ball_radius:u}: Hertz a = {hertz_radius:u}, approach {hertz_approach:u}; "
        basis += "here {approach:u}"
        yield _card("Beside a smooth ball (Hertz)", "{hertz_share} of its area", basis, data)
    if "area_plastic" in data:
        basis = "{solver} on {grid}, points counted[; theory: {area_plastic_persson:.4}]"
        yield _card(HOW_YIELDED, "{area_plastic}", basis, _finest(data))
    spent, basis = "{wall_seconds:u}", "with all that was tried; {seconds_total:u} for this one"
    if "wall_seconds" not in data:
        spent, basis = "{seconds_total:u}", "solves of this surface: {solves}, largest {unknowns_largest} "
        basis += "unknowns; without those of the mean" if several else "unknowns"
    yield _card("What did it cost?", spent, basis, data.assign_attrs(solves=float(data.shifts.sum())))


def _card(question: str, answer: str, basis: str, data: xr.Dataset) -> Card:
    return Card(question, *(finding("value", form, data) for form in (answer, basis)))


def how_sure(data: xr.Dataset, *cases: str) -> tuple[Finding, str]:
    """Half of the interval of the area, or how far treatments move it where that is more, and its sources."""
    errors = total_error(data, "area")
    assert errors is not None
    share = errors / data.area
    answer, held = note("not measured"), ""
    if share.notnull().any():
        sources = dict.fromkeys(sources_of(here.area_error) for here in each(data, *cases))
        answer = ends("+- {low:.2%}[ to {high:.2%}]", share)
        held = f"95 %: {' or '.join(filter(None, sources)) or 'all sources of this spectrum and period'}"
    if "accuracy_asked" in data:
        answer = finding("value", "asked {accuracy_asked:%}, reached {accuracy_reached:%~}", data)
    if "treatment_spread" in data and data.treatment_spread.max() <= share.max():
        held += "; treatment of the map: {treatment_spread:.2%}" * (not cases)
    elif "treatment_spread" in data:
        held = f"{answer} ({held}); " * bool(held) + "other treatments of the map move the area so far"
        answer = ends("{low:.2%}[ to {high:.2%}] by treatment", data.treatment_spread)
    return answer, held


def ends(form: str, values: xr.DataArray, **more: Any) -> Finding:
    """Say the least and the largest of some values, `low` and `high`; the latter only where it is another."""
    low, high = float(values.min()), float(values.max())
    return finding("value", form, low=low, high=math.nan if high == low else high, **more)


def _finest(data: xr.Dataset) -> xr.Dataset:
    first = data.isel(solver=int(data.area_pixel_finest.notnull().values.argmax()))
    return first.sel(grid=str(first.grid_finest.item()))


def _findings(data: xr.Dataset) -> Iterator[Finding]:
    """Say what was found, the most asked-for first; what finds no place among six stands in the tables."""
    if "failures" in data:
        yield finding("refusal", "Not all solves succeeded: {failures}.", data)
    yield from _area(data)
    yield from treatment_findings(data)
    yield from _theory(data)
    if warnings := " ".join(_warnings(data)):  # one of several sentences, so that none is lost
        yield finding("note", warnings, data)
    if "area_plastic" in data:
        text = "Yielded, A_pl/A0 = {area_plastic} by {solver} on {grid} (points counted)"
        text += "[; {area_plastic_persson:.4} by the theory]."
        yield finding("share", text, _finest(data))
    if passing := " ".join(_what_passes(data)):
        yield finding("value", passing, data)
    if "von_mises" in data:
        text = "The largest von Mises stress below the surface is {von_mises_reduced:.4} E* h'_rms "
        text += "({von_mises:u}), at a depth of {von_mises_depth_reduced:.3} lambda_short "
        text += "({von_mises_depth:u}; {solver} on {grid}): there a homogeneous solid yields first. "
        text += "From the grid before it changed by {von_mises_change:+.2%}."
        yield finding("value", text, _finest(data))
    yield from _methods(data)
    yield from _edges(data)
    limit = value_of(data, "area_own")
    if not limit.error or not limit.error < 0.01 * float(limit.value):  # none can be told within 1 % of it
        return
    if "cheapest" in data:
        text = "The cheapest way to within 1 % of the limit was {cheapest}: "
        text += "{seconds_cheapest:u}, off by {area_cheapest_off:+.2%}."
        yield finding("cost", text, data)
    elif "accuracy_asked" not in data and data.deviation_pixel.notnull().any():
        yield note("No solve of this run is within 1 % of the limit.")


def _area(data: xr.Dataset) -> Iterator[Finding]:
    if data.area_own >= 1 - 1e-12:
        yield note("Contact is complete: A/A0 = 1 on the resolved grids, and refinement changes nothing.")
        return
    text = "A/A0 = {area_own} for this surface ({area_basis}), kappa = {kappa_own} at p* = "
    text += "{reduced_pressure:.4}.[ No limit over the grids: {no_limit}.]"
    yield finding("value", text, derive(data, kappa_own="area_own / reduced_pressure"))
    if data.surfaces > 1:
        which = "maps" if data.attrs.get("treatment") else "surfaces of this spectrum"
        text = f"Over {{surfaces}} {which} the mean is A/A0 = {{area}}; single ones scatter by "
        yield finding("value", text + "{scatter:.2%}.", data)
    elif "treatment" in data.attrs and not data.attrs["treatment"]:
        yield note("One surface: without an ensemble the scatter between surfaces is unknown.")


def _theory(data: xr.Dataset) -> Iterator[Finding]:
    if "area_persson_own" not in data:
        return
    if not np.isfinite(data.area_persson_own):
        yield finding("refusal", "Persson's theory gives {theory_note}.", data)
        return
    form = "The area is {verdict} Persson's theory: {area_excess:+%} of A/A0 = {area_persson:.4} with the "
    form += f"realised gradient{'s' * ('area_persson_each' in data)}"
    form += "[, {area_ensemble:.4} from C(q) alone]"
    form += "[, {area_other_energy:.4} with another elastic energy][ ({theory_note})]."
    yield finding("comparison", form, data, by="area_excess")


def _methods(data: xr.Dataset) -> Iterator[Finding]:
    if "pressure_difference" not in data:
        return
    for k in range(1, data.sizes["solver"]):
        here, both = data.isel(solver=k), f"{_label(data, k)} and {_label(data, 0)}"
        if (shared := np.flatnonzero(here.pressure_difference.notnull().values)).size:
            form = f"{both} on {{grid}} differ by {{pressure_difference:.2%}} in pressure (relative L2) and "
            form += "{area_pixel_difference:.2%} in counted area[; these shrink like "
            form += "dx^{pressure_difference_order:.3} and dx^{area_pixel_difference_order:.3}]."
            yield finding("order", form, here.isel(grid=int(shared[-1])))
        elif "failures" not in data:  # which may be of the grid they share
            yield note(f"{both} share no grid: their pressures are not compared.")


def _edges(data: xr.Dataset) -> Iterator[Finding]:
    rows = []
    for k, here in enumerate(each(data, "solver")):
        good = np.flatnonzero((here.resolved.values > 0) & here.area_pixel_off.notnull().values)
        if good.size > 1:
            first, last = (here.isel(grid=int(g)) for g in (good[0], good[-1]))
            row = {n: value_of(first, n) for n in ("grid", "area_pixel_off", "area_perimeter_off")}
            row |= {"last": Value(value=float(last.area_pixel_off)), "method": Value(value=_label(data, k))}
            rows.append(row)
    if rows:
        yield Finding(
            kind="value",
            form="Counted points are off the limit by {each}.",
            item="{area_pixel_off:+.2%} on {grid} (corrected at the edge {area_perimeter_off:+.2%}) and "
            "{last:+.2%} on the finest grid ({method})",
            rows=tuple(rows),
        )


def _warnings(data: xr.Dataset) -> Iterator[str]:
    coarse = data.grid.values[data.area_pixel.notnull().any("solver").values & (data.resolved.values == 0)]
    if coarse.size:
        names = ", ".join(map(str, coarse))
        yield f"Under-resolved (lambda_short <= 2 dx) and left out of every limit: {names}."
    if data.rms_gradient > 0.3:
        yield "The gradient h'_rms = {rms_gradient:.3} is not small; all methods here assume small slopes."
    if not np.isclose(data.contact_modulus, data.surface_modulus, rtol=1e-9):
        yield (
            "p* and kappa stand on E* = {contact_modulus:u} of the solid below the coating, and are no "
            "numbers of a homogeneous solid; at the surface E* = {surface_modulus:u}"
            "[, and what the roughness feels is {felt_modulus:u}]."
        )
    if "passing_note" in data:
        yield "What passes: {passing_note}."


def _what_passes(data: xr.Dataset) -> Iterator[str]:
    for name in ("electrical_conductance", "thermal_conductance"):
        if name in data:
            form = f"{{{name}:p}}[, by Persson's theory {{{name}_persson:p}}]."
            yield f"{quantity(name).meaning.capitalize()}: {form}"
    if "leak_rate_x" in data:
        form = "Leak: {leak_rate_x:p} along x and {leak_rate_y:p} along y[, by Bruggeman's effective medium "
        yield form + "{leak_rate_x_bruggeman:p} and {leak_rate_y_bruggeman:p}]."


def _figures(data: xr.Dataset) -> Iterator[Figure]:
    yield area_figure()
    if "heights" in data:
        told = "of the map, windowed: what the theory is given" if "pixel" in data else None
        ring, given = Line("power_spectrum", joined=False, label="this surface"), "power_spectrum_told"
        heights = against("x", Image("heights", rows="y", cmap="gray"))
        spectra = against("wavevector", ring, Line(given, label=told), log="xy")
        yield Figure(
            "surface", "The rough surface, and its power spectrum, ring by ring.", [heights, spectra]
        )
        yield maps_figure(data)
    if "density_near" in data:
        yield pressure_figure(data)
    ways = ("deviation_pixel", "deviation_perimeter", "deviation_located", Level("deviation_persson"))
    panel = against("seconds", *ways, by="solver", y="deviation", log="xy")
    yield Figure("cost", "Distance of the area from its limit over the time of the solves.", [panel])
    if "plane_depth" in data:
        of = ", {solver}" * (data.sizes["solver"] > 1)
        lines = [
            Line(f"plane_stress_{which}", by="solver", look={"marker": "", "ls": ls}, label=f"{words}{of}")
            for which, words, ls in (("largest", "largest", "-"), ("rms", "root mean square", "--"))
        ]
        words = "Von Mises stress over depth on the finest grid: the largest on each plane, and the rms."
        yield Figure("below", words, [against("plane_depth", *lines, y="plane_stress", log="xy")])


def area_figure() -> Figure:
    """Declare area against grid spacing: counted, corrected, located, their limit and the theory."""
    own = Level("area_own", look={"color": "black"}, label="this surface")
    marks = ("area_pixel", "area_perimeter", "area_located", own, Level("area_persson_own"))
    panel = against("spacing", *marks, Level("area_ensemble"), by="solver", y="area", log="x")
    return Figure("area", "Contact area against grid spacing; coarse grids are on the right.", [panel])


def pressure_figure(data: xr.Dataset) -> Figure:
    """Declare P(sigma) near zero on the coarsest and the finest grid, and on the finest to its end."""
    panels = []
    for name in ("near", "wide"):
        marks = []
        for k in range(data.sizes["solver"]):
            there = np.flatnonzero(data[f"density_{name}"][k].notnull().any(name).values).tolist()
            # A line looks alike on both panels.
            for grid in sorted({there[0], there[-1]} if there else ()):
                look, at = {"ls": "-" if grid == there[-1] else "--"}, {"solver": [k], "grid": [grid]}
                marks.append(Line(f"density_{name}", by=("solver", "grid"), at=at, steps=True, look=look))
        theory = f"density_{name}_persson"
        marks.append(Line(theory, x=f"stress_{name}_exact", look={"lw": 2, "ls": "-"}))
        if name == "near":
            panels.append(against(f"stress_{name}", *marks))
            continue
        # The tail of the theory may end hundreds of decades below what a simulation counts.
        counted, limits = data.density_wide.where(data.density_wide > 0), dict[str, Any]()
        if counted.notnull().any():
            most = max(float(data[y].max()) for y in ("density_wide", theory) if y in data)
            limits = {"bottom": float(counted.min()) / 10, "top": 3 * most}
        panels.append(against(f"stress_{name}", *marks, log="y", **limits))
    return Figure(
        "pressure-distribution",
        "Distribution of contact pressure: left near zero on the coarsest and the finest grid, where "
        "what remains at zero is the grid's; right to the largest pressure, on the finest.",
        panels,
    )


def maps_figure(data: xr.Dataset) -> Figure:
    """Declare the pressure of every method on one grid, and their difference."""
    there = [k for k in range(data.sizes["solver"]) if data.pressure_map[k].notnull().any()]
    pressure = Image("pressure_map", rows="y", cmap="viridis_r")
    panels = [against("x", pressure, at={"solver": k}, title=_label(data, k)) for k in there]
    if "pressure_map_difference" in data:
        difference = Image("pressure_map_difference", rows="y", cmap="RdBu_r", symmetric=True)
        title = f"{_label(data, there[1])} - {_label(data, there[0])}"
        panels.append(against("x", difference, title=title))
    caption = f"Contact pressure on {data.attrs['map_grid']} points; white: no contact."
    return Figure("pressure-maps", caption, panels)
