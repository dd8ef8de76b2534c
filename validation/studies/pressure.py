"""How do area, mean gap, stiffness, elastic energy and patches change from light load to full contact?

`energy` and `theory-verdict` ask of the same path of loads: with the same options the three share its solves.
"""

import numpy as np
import xarray as xr

from validation.measurements.common import SHIFTS, Ladder, Rising
from validation.measurements.limits import SHARES, moved_shares, pooled_shares, reduced_path
from validation.measurements.measurement import TOLERANCE, press_on_grids
from validation.measurements.statistics import kolmogorov_smirnov
from validation.measurements.theory import RANKED, modes_finding
from validation.report.estimates import change, derive, mean, ratio_of_means
from validation.report.findings import note
from validation.report.values import value_of
from validation.report.views import Column, Figure, Findings, Level, Line, Table, Views, against, finding
from validation.studies._options import Shifts
from validation.studies._scene import PressedOptions
from validation.studies._study import Bench, Call, gathered
from validation.theories.persson_variants import persson_variants
from validation.theories.predicted import COMPARED, beside, stress_shares

#: Reduced pressures from light load to full contact.
LOADS = (0.001, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
#: Relative area below which contact is light.
_LIGHT = 0.1
#: Relative area from which on contact is nearly full.
_NEARLY_FULL = 0.9
#: How findings call what is compared with theories.
TITLES = {
    "area": "Contact area",
    "gap": "Mean gap",
    "compliance": "Compliance",
    "energy_ratio": "Elastic energy",
}
#: Where simulation and theory agree.
AGREEMENT = Level("agreement", look={"color": "black", "lw": 0.8})


class Options(PressedOptions):
    """What is pressed, along which path of loads, on which grids."""

    plain = "gap, stiffness and energy are compared with the theory of the elastic half-space; `area` takes all effects"

    reduced_pressures: Rising = LOADS
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising: one warm path of loads"""
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = (4.0, 8.0, 16.0)
    """grids, as lambda_short/dx, rising"""


def design(options: Options) -> dict[int, Call]:
    """Return the path of each surface."""
    return {
        k: press_on_grids(
            problem=problem,
            reduced_pressures=options.reduced_pressures,
            grids=options.grids_for(options.points_per_wave),
            shifts=options.shifts,
            tolerance=options.tolerance(TOLERANCE),
            keep=("distributions", "stiffness"),
        )
        for k, problem in enumerate(options.pressed)
    }


def measured_path(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface along the path of loads: `reduced_path` over (surface, load), and means."""
    shortest = options.first.shortest
    data = gathered(bench, design(options), lambda d, _: reduced_path(d, shortest=shortest), "surface")
    data = data.assign_attrs(options.spectrum_words)
    data = mean(data, "area", "patches", "patch_size")
    # Grids of second order are off to the same side on all surfaces: their error does not average out.
    return mean(data, "gap", "compliance", "energy_ratio", alike=True)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the path, what of light contact changes with load, and how far its distributions move."""
    theories = persson_variants()
    data = beside(measured_path(options, bench=bench), theories, options.pressed)
    data = derive(data, kappa="area / reduced_pressure", area_excess="area / area_persson - 1")
    light = np.flatnonzero(data.area.values < _LIGHT)
    if light.size > 1:
        data = derive(data, kappa_each="area_each / reduced_pressure")
        first, last = map(int, light[[0, -1]])
        for name in ("kappa", "area"):
            data = change(data, name, along="load", first=first, last=last)
        for name in ("patches", "patch_size"):  # of which one surface may have few
            end, start = (f"{name}_each.isel(load={k})" for k in (last, first))
            ratio = ratio_of_means(end, start, "surface")
            data = derive(data, **{f"{name}_change_each": f"{ratio} - 1"})
        data = mean(data, *(f"{name}_change" for name in ("kappa", "area", "patches", "patch_size")))
        data.attrs["light"] = light[[0, -1]]
    data = pooled_shares(moved_shares(data)).assign_attrs(methods=RANKED)
    shares = stress_shares(theories[0], options.first, options.reduced_pressures)
    moved = kolmogorov_smirnov(shares, shares[data.attrs["reference_load"]])
    return data.assign(moved_stress_persson=("load", moved))


def picked_loads(data: xr.Dataset) -> list[int]:
    """Return at most four loads from the lightest towards full contact, where there is a limit of the area."""
    known = np.flatnonzero((data.area.values < _NEARLY_FULL) & np.isfinite(data.area.values))
    return [int(k) for k in known[:: max(1, -(-known.size // 4))]]


def views(data: xr.Dataset) -> Views:
    """Everything against load, beside the theory; and how far distributions move."""
    columns: list[str | Column] = ["reduced_pressure", "area", "kappa", "area_persson", "area_ensemble"]
    for name in COMPARED[1:]:
        columns += [name, Column(f"{name}_predicted", {"theory": 0})]
    columns += ["patches", "patch_size", *(f"moved_{name}" for name in SHARES)]
    return Views(
        table=Table(("load",), tuple(columns)),
        budget=COMPARED,
        figures=_figures(data),
        findings=[*_findings(data), modes_finding(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    some = data.isel(theory=0, load=picked_loads(data))
    if not some.sizes["load"]:
        yield note("All loads are of nearly full contact.")
        return
    form = "The contact area is {each} (lambda_long/lambda_short = {bandwidth})."
    item = "{verdict} Persson's, {area_excess:+%}, at A/A0 = {area:~}"
    yield finding("comparison", form, some, item=item, by="area_excess")
    form = "Over those of Persson's theory: {each}."
    item = "gap {gap_over}, compliance {compliance_over} and energy {energy_ratio_over} at A/A0 = {area:~}"
    yield finding("value", form, some, item=item)
    if "light" in data.attrs:
        start, end = (data.isel(load=int(k)) for k in data.attrs["light"])
        form = "Between A/A0 = {start:~} and {area:~} kappa {verdict}, {kappa_change:+%}, the number of patches changes by "
        form += "{patches_change:+%} and their mean size by {patch_size_change:+%}; independent patches would keep kappa and "
        form += "their size, and grow in number with the area, by {area_change:+%}."
        yield finding("trend", form, end, by="kappa_change", start=value_of(start, "area"))
    reference = data.attrs["reference_load"]
    heavier = data.isel(load=slice(reference + 1, reference + 4))
    at = value_of(data.isel(load=reference), "area")
    for name, claimed in _CLAIMED.items():
        if heavier.sizes["load"]:
            yield finding(
                "comparison",
                claimed + " from A/A0 = {at:~} on: {each}.",
                heavier,
                item=f"{{moved_{name}}}, {{verdict}}, at {{area:~}}",
                by=f"moved_{name}_beyond",
                words=_MOVED,
                at=at,
            )


#: Claims of load independence (Persson 2006, Secs. 3.3 and 13), and the outcomes of what exceeds the scatter.
_CLAIMED = {
    "stress": "P(sigma) A0/A, largest change of the cumulated share",
    "patch_area": "Sizes of the patches by area, largest change of the cumulated share",
}
_MOVED = dict.fromkeys("0-", "no more than two sets of surfaces differ by") | {
    "+": "a change beyond the scatter of the surfaces",
    "?": "of unknown significance",
}


def _figures(data: xr.Dataset) -> list[Figure]:
    load = "reduced_pressure"
    spectral = Line("area_spectral", at={"theory": 0}, label="Persson, C(q) alone")
    others = [
        against(load, Line(name, joined=False), *by_theory("_predicted", data, name), log="x")
        for name in COMPARED[1:]
    ]
    reference = data.attrs["reference_load"]
    heavier = [k for k in range(reference, data.sizes["load"]) if data.area[k] < _NEARLY_FULL][:5]
    shares = [
        against(x, *[Line(y, at={"load": k}, label="A/A0 = {area:~}", steps=True) for k in heavier], log=log)
        for y, x, log in (("contact_stress_density", "stress", ""), ("patch_cumulated", "patch_upper", "x"))
    ]
    moved = [f"moved_{name}" for name in (*SHARES, "stress_noise", "stress_persson")]
    return [
        Figure(
            "area-against-pressure",
            "Contact area against load, and over that of the theory and its variants, told the realised surface.",
            [
                against(load, Line("area", joined=False), *by_theory("_predicted", data), spectral, log="xy"),
                against(load, *by_theory("_over", data), AGREEMENT, log="x"),
            ],
        ),
        Figure(
            "gap-and-energy",
            "Mean gap, compliance and elastic energy against load, with the theory and its variants.",
            others,
        ),
        Figure(
            "load-independence",
            "P(sigma) per contact area, share of the contact in smaller patches, and how far both are from those "
            "at the lightest of these loads; surfaces are pooled.",
            [*shares, against("area", *moved, log="x")],
        ),
    ]


def by_theory(ending: str, data: xr.Dataset, name: str = "area") -> list[Line]:
    """Return a line for each theory that says something."""
    known = data[f"{name}{ending}"].notnull().any("load").values
    return [Line(f"{name}{ending}", at={"theory": int(t)}, label="{theory}") for t in np.flatnonzero(known)]
