"""What are the macroasperities, do they carry the same pressure at every load, and at which area does contact percolate?

One surface with a roll-off is pressed with its waves up to rising magnifications (Persson 2006, Secs. 3.6, 3.7): patches
of contact break up, contact and gap join up, and the regions seen where ln A bends most are the macroasperities.
"""

from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from persson.errors import OutsideTheory
from persson.percolation import SITE_THRESHOLD
from persson.separation import macroasperity_magnification
from validation.measurements.common import Rising, RisingOrNone, RisingSeveral, base_case
from validation.measurements.flow import magnified
from validation.measurements.measurement import grid_for
from validation.report.estimates import claim, derive, mean, ratio_of_means
from validation.report.findings import note
from validation.report.places import gather, nearest
from validation.report.views import Figure, Finding, Findings, Level, Line, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.studies._options import Bandwidth, Periods, SurfaceOptions, Surfaces
from validation.studies._study import ABSENT, Bench, Call, solved, stored_variables


class Options(SurfaceOptions):
    """What is pressed, with which of its waves."""

    why_no_scene = "it asks about spectra with a roll-off, and makes a surface for each"

    reduced_pressures: RisingSeveral = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
    """p* = p0 / (E* h'_rms) with the gradient of all waves, rising"""
    magnifications: Annotated[Rising, Field(min_length=3)] = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.7, 8.0)
    """zeta = q/q_0 of the last wave there is, rising; the last is at most the bandwidth"""
    percolating: RisingOrNone = (0.05, 0.1, 0.15)
    """p* at which contact and gap are followed to their thresholds"""
    periods: Periods = 8.0
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=4.0, ge=2)
    """grid, as lambda_short/dx"""

    @property
    def first(self) -> ContactProblem:
        """The first surface: one C(q) up to q_0 = 2 pi / lambda_long, self-affine beyond."""
        surface = self.self_affine().model_copy(update={"rolloff": "smooth"})
        return base_case(surface, reduced_pressure=self.reduced_pressures[0])


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface with its waves up to each magnification.

    Area, patches and what lies in the contact seen at zeta over (surface, load, magnification); thresholds over
    (surface, phase, percolating, axis); ``macro_magnification`` where ln A of the theory bends most, and area and
    pressure of simulation and theory (``_persson``) there (surface, load).
    """
    first, points = options.first, options.points_per_wave
    bends = {p: _bend(options, p) for p in options.reduced_pressures}
    asked: dict[str, Any] = {
        "reduced_pressures": options.reduced_pressures,
        "magnifications": options.magnifications,
        "bends": tuple((p, zeta) for p, zeta in bends.items() if np.isfinite(zeta)),
    }
    cases: dict[Any, Call] = {"finer": magnified(problem=first, grid=grid_for(first, 2 * points), **asked)}
    asked |= {"grid": grid_for(first, points), "percolating": options.percolating}
    cases |= {k: magnified(problem=first.further(k), **asked) for k in range(options.surfaces)}
    measured = {k: stored_variables(d) for k, d in solved(bench, cases).items()}
    finer = {0: measured.pop("finer")}
    loads, zetas = ("load", list(options.reduced_pressures)), ("load", [*bends.values()])
    data, coarse, fine = (
        _of_surfaces(
            gather(some, "surface").assign_coords(reduced_pressure=loads).assign(macro_magnification=zetas)
        )
        for some in (measured, {0: measured[0]}, finer)
    )
    data = data.assign_coords(
        magnification=list(options.magnifications),
        percolating_pressure=("percolating", list(options.percolating)),
    )
    simulated = (*_COUNTED, "contact_pressure_ratio", "macro_area", "macro_pressure_ratio")
    data = mean(data, "area_persson", "macro_area_persson", "macro_pressure_ratio_persson", *simulated)
    # Errors of order dx, or smaller, are at most twice what half of dx changes.
    for name in simulated:
        change = fine[f"{name}_each"] - coarse[f"{name}_each"]
        data = claim(data, name, grid=2 * abs(change.isel(surface=0, drop=True)))
    data = claim(data, "area", "load_inside", **ABSENT)
    data = derive(
        data,
        **{f"macro_pressure{which}": f"reduced_pressure / macro_area{which}" for which in _BOTH},
        **{f"macro_pressure_shift{w}": f"(macro_pressure_ratio{w} - 1) / {_SAME}" for w in _BOTH},
        contact_pressure="reduced_pressure / area",
        contact_pressure_shift=f"(contact_pressure_ratio - 1) / {_SAME}",
        load_inside_excess=f"load_inside - {_DOMINANT}",
    )
    if options.percolating:
        data = _with_thresholds(data)
    spectrum = options.model_dump(include={"hurst", "periods", "bandwidth", "points_per_wave"})
    return data.assign_attrs(methods="theory bem", **spectrum)


#: Endings of what the simulation gives, and the theory.
_BOTH = ("", "_persson")
#: What is read off a contact.
_COUNTED = ("area", "patch_density", "relative_patch_size", "largest_patch", "area_inside", "load_inside")


def _of_surfaces(data: xr.Dataset) -> xr.Dataset:
    """Add the areas of the theory, and pressures over those at the lightest load, and the lightest with a zeta_m."""
    data = derive(
        data,
        area_persson_each="erf(2**.5 * reduced_pressure / gradient_share_each)",
        macro_area_persson_each="erf(2**.5 * reduced_pressure / macro_gradient_share_each)",
        contact_pressure_each="reduced_pressure / area_each",
        contact_pressure_ratio_each="contact_pressure_each / contact_pressure_each.isel(load=0)",
    )
    lightest = int(np.argmax(np.isfinite(data.macro_magnification.values)))
    for which in _BOTH:
        area = f"macro_area{which}_each"
        areas = ratio_of_means(f"{area}.isel(load={lightest})", area, "surface")
        ratio = f"({areas}) * reduced_pressure / reduced_pressure.isel(load={lightest})"
        data = derive(data, **{f"macro_pressure_ratio{which}_each": ratio})
    return data


#: How far a pressure may move and still be called the same.
_SAME = 0.1
#: Share of the load from which on most of it is carried.
_DOMINANT = 0.5


def _with_thresholds(data: xr.Dataset) -> xr.Dataset:
    data = derive(
        data,
        percolation_area_each="percolation_area_axis_each.mean('axis', skipna=False)",
        percolation_magnification_each="percolation_magnification_axis_each.mean('axis', skipna=False)",
        percolation_area_pooled_each="percolation_area_each.mean('percolating', skipna=False)",
    )
    data = mean(data, "percolation_area", "percolation_magnification", "percolation_area_pooled")
    data = claim(data, "percolation_area_pooled", **ABSENT)
    data["percolation_area_paper"] = SITE_THRESHOLD
    return derive(data, percolation_area_excess="percolation_area_pooled - percolation_area_paper")


def _bend(options: Options, reduced: float) -> float:
    """Return zeta_m of the theory at p*; NaN beyond the magnifications that are looked at."""
    first, (low, *_, high) = options.first, options.magnifications
    try:
        found = macroasperity_magnification(
            first.own_spectrum,
            pressure=reduced * first.pressure_scale,
            contact_modulus=first.contact_modulus,
            q_reference=2 * np.pi / first.longest,
        )
    except OutsideTheory:
        return float("nan")
    return found if low <= found <= high else float("nan")


def views(data: xr.Dataset) -> Views:
    """Patches over zeta, the pressure in them over the load, and both thresholds."""
    seen = {"magnification": sorted({nearest(data.magnification, zeta) for zeta in (1.0, 2.0, 4.0)})}
    few = {"load": sorted({round(j) for j in np.linspace(0, data.sizes["load"] - 1, 5)})}
    persson_line = Line("area_persson", by="load", label="")
    patches = [
        against("magnification", *marks, by="load", log=log, at=few)
        for log, *marks in (("xy", "area", persson_line), ("xy", "patch_density"), ("x", "largest_patch"))
    ]
    plain = {"color": "black", "lw": 0.6, "ls": ":", "marker": ""}
    pressures = [
        Line("contact_pressure", by="magnification", at=seen),
        Line("macro_pressure", label="at zeta_m", look={"color": "black", "marker": "*"}),
        Line("macro_pressure_persson", label="at zeta_m, Persson", look={"color": "black"}),
        Line("reduced_pressure", label="p*: full contact", look=plain),
    ]
    percolates = "percolation_area" in data
    columns = ("reduced_pressure", "magnification", "area", "area_persson", "contact_pressure")
    return Views(
        table=Table(("load", "magnification"), (*columns, *_COUNTED[1:])),
        budget=("percolation_area_pooled" if percolates else "load_inside",),
        figures=[
            Figure(
                "patches-over-magnification",
                "Contact area, patches and the share of the largest patch as waves up to zeta are added.",
                patches,
            ),
            Figure(
                "macroasperity-pressure",
                "Mean pressure in the contact at fixed zeta and at zeta_m, and the load carried there in the end.",
                [
                    against("reduced_pressure", *pressures, log="xy"),
                    against(
                        "reduced_pressure", "load_inside", by="magnification", at=seen, log="x", bottom=0.0
                    ),
                ],
            ),
            *([_percolation()] if percolates else []),
        ],
        findings=[*_findings(data)],
    )


def _percolation() -> Figure:
    paper = Level("percolation_area_paper")
    scatter = Line(
        "percolation_area_axis_each",
        x="percolation_magnification_axis_each",
        by=("phase", "percolating"),
        label="{phase}, p* = {percolating_pressure}",
        joined=False,
    )
    return Figure(
        "percolation",
        "Areas at which, as waves are added, the contact comes apart and the gap opens. Left: by surface and axis "
        "over the magnification where it happens. Right: means over the load.",
        [
            against("percolation_magnification", scatter, paper, log="x"),
            against("percolating_pressure", "percolation_area", paper, by="phase"),
        ],
    )


_STAYS = {
    "within": "within 10 %",
    "beyond": "not within 10 %",
    "undecided": "within 10 % or not: not decided",
}


def _macroasperities(data: xr.Dataset, which: str, of: str) -> Finding:
    return finding(
        "equivalence",
        "Pressure in the macroasperities of {of} over E* h'_rms, and whether it is that at the lightest load: {each}.",
        data.isel(load=np.flatnonzero(data[f"macro_pressure{which}"].notnull().values)),
        item=f"{{macro_pressure{which}}} at p* = {{reduced_pressure}} ({{verdict}}; "
        f"zeta_m = {{macro_magnification:~}}, A/A0 = {{macro_area{which}:~}})",
        by=f"macro_pressure_shift{which}",
        words=_STAYS,
        of=of,
    )


def _findings(data: xr.Dataset) -> Findings:
    roll_off = data.isel(magnification=nearest(data.magnification, 1.0))
    if "percolation_area" in data:
        form = "As waves are added the contact comes apart and the gap opens (the same event along the other axis, but for "
        form += "single cells) at these areas A/A0: {each}."
        item = "{phase} {percolation_area_pooled} ({verdict} the {percolation_area_paper} of the paper)"
        yield finding("comparison", form, data, item=item, by="percolation_area_excess")
    if data.macro_magnification.notnull().any():
        yield _macroasperities(data, "", "the simulation")
        yield _macroasperities(data, "_persson", "the theory")
    else:
        yield note("No load has a zeta_m: the area of the theory bends at none of these magnifications.")
    yield finding(
        "equivalence",
        "In the contact seen at zeta = {magnification} the mean pressure, over that at the lightest load, is {each}.",
        roll_off.isel(load=slice(1, None)),
        item="{contact_pressure_ratio} at p* = {reduced_pressure} ({verdict}; A/A0 = {area:~})",
        by="contact_pressure_shift",
        words=_STAYS,
    )
    yield finding(
        "comparison",
        "With all waves there, the contact seen at zeta = {magnification} carries of the load {each}; if regions only "
        "broke up it would be 1.",
        roll_off,
        item="{load_inside} at p* = {reduced_pressure} ({verdict})",
        by="load_inside_excess",
        words={"+": "most", "-": "less than half", "0": "half or not: not decided"},
    )
    yield finding(
        "value",
        "At p* = {reduced_pressure}, with patches on and over the square of the roll-off wavelength: {each}.",
        data.isel(load=data.sizes["load"] // 2, magnification=[0, -1]),
        item="at zeta = {magnification} A/A0 = {area}, {patch_density} patches of the mean size {relative_patch_size}",
    )
