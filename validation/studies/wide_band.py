"""Does Persson's area become exact as the band of the roughness widens, and how far does one have to go?

Three laws of the distance from the theory in the Nayak parameter are fitted to narrow bands and judged on the wide ones
that they were not shown. The areas are shipped (`validation.reference.wide`); nothing is solved.
"""

from pathlib import Path

import numpy as np
import xarray as xr

from validation import reference
from validation.arrays import Array
from validation.errors import UsageError
from validation.execution.store import read_numbers
from validation.measurements.table_samples import joined
from validation.reference.fit import nayak
from validation.reference.laws import LAWS, fit
from validation.report.estimates import LIMIT, claim, derive, total_error
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding, panels_along
from validation.studies._options import StudyOptions
from validation.studies._study import Bench
from validation.units import Positive

#: Distance from the theory that counts as none.
_CLOSE = 0.05
#: Bandwidths that a law is fitted to, at least.
_LEAST = 4
#: What scatters from one bandwidth to the next; the size of the sample moves all of them alike.
_INDEPENDENT = ("surfaces", "grid", "solver")


class Options(StudyOptions):
    """Areas, and which of them the laws are fitted to."""

    why_no_scene = "it reads areas that are there, of surfaces that a table names"

    table: Path | None = None
    """data.nc of study reference with wide bandwidths; the shipped areas if left out"""
    fitted_to: Positive = 32.0
    """widest bandwidth that the laws are fitted to; they are judged on the others"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Fit every law at each H and p* to the narrow bands, and to all.

    Over (hurst, bandwidth, reduced_pressure): ``area_excess``. Over (law, ...) in addition: ``area_excess_law``, of the law
    through the narrow bands; ``law_miss``, of it on the wide ones; ``law_misfit``, chi^2 per degree of freedom through
    all bands; ``nayak_close``, the Nayak parameter at which a law through all bands is within 5 % of the theory.
    ``area_excess_limit``: where the saturating law through all bands ends.
    """
    tables = [reference.table(), reference.wide()] if options.table is None else [read_numbers(options.table)]
    needed = ("area", "area_error", "area_persson", "hurst", "bandwidth", "reduced_pressure", "amplitudes")
    if lacking := [name for name in needed if name not in tables[-1].variables]:
        raise UsageError(f"table = {options.table}: no {', '.join(lacking)}; give data.nc of study reference")
    data = joined([table[[*needed[:3]]] for table in tables])
    asked = {dim: tables[-1][dim] for dim in ("hurst", "reduced_pressure")} | {"amplitudes": "exact"}
    data = derive(data.sel(asked, drop=True), area_excess="area / area_persson - 1")
    narrow = data.bandwidth.values <= options.fitted_to
    if narrow.sum() < _LEAST or narrow.all():
        raise UsageError(
            f"fitted_to = {options.fitted_to:g}: leaves {narrow.sum()} of {narrow.size} bandwidths, "
            f"needs {_LEAST} to fit to and others to judge by"
        )
    alpha = [[nayak(hurst=h, bandwidth=b) for b in data.bandwidth.values] for h in data.hurst.values]
    data["nayak_by_spectrum"] = ("hurst", "bandwidth"), alpha
    halves = total_error(data, "area_excess", sources=_INDEPENDENT)
    assert halves is not None  # a table has it
    far = np.geomspace(np.max(alpha), 1e12, 400)

    def fitted(law: str, *points_of_cell: Array) -> tuple[Array | float, ...]:
        points = np.array(points_of_cell)
        there = np.isfinite(points).all(axis=0)
        if (narrow & there).sum() < _LEAST:
            return (*np.full((2, narrow.size), np.nan), *[np.nan] * 4)
        seen = fit(law, *points[:, narrow & there], at=np.append(points[0], np.inf))
        whole = fit(law, *points[:, there], at=np.append(far, np.inf))
        end, below = whole.values[-1], far[whole.values[:-1] < _CLOSE]
        end_half = np.hypot(whole.halves[-1], end - seen.values[-1])
        misfit = whole.chi_square / whole.freedom
        return seen.values[:-1], seen.halves[:-1], misfit, min(below, default=np.nan), end, end_half

    along, laws = ["bandwidth"], xr.DataArray([*LAWS], dims="law", coords={"law": [*LAWS]})
    data["area_excess_law"], blind_halves, data["law_misfit"], data["nayak_close"], *limit = xr.apply_ufunc(
        fitted,
        laws,
        data.nayak_by_spectrum,
        data.area_excess,
        halves,
        input_core_dims=[[], along, along, along],
        output_core_dims=[along, along, [], [], [], []],
        vectorize=True,
        keep_attrs=False,
    )
    data["area_excess_limit"], end_halves = (end.sel(law="saturation", drop=True) for end in limit)
    # The size of the sample moves all bandwidths alike, and so the limit.
    size = data.area_excess_error.sel(source="size", drop=True).max("bandwidth").fillna(0.0)
    errors = {"area_excess_law": blind_halves, "area_excess_limit": (end_halves**2 + size**2) ** 0.5}
    for name, half in errors.items():
        data = claim(data, name, bandwidth=half)
        data[f"{name}_error"].attrs[LIMIT] = "bandwidth"
    judged = xr.DataArray(~narrow, dims="bandwidth")
    miss = (data.area_excess_law - data.area_excess).where(judged).drop_attrs()
    joint = (data.area_excess_law_error.sel(source="bandwidth", drop=True) ** 2 + halves**2) ** 0.5
    cells = ("hurst", "bandwidth", "reduced_pressure")
    return data.assign(
        law_miss=miss.transpose(..., "bandwidth"),
        law_miss_rms=(miss**2).mean(cells) ** 0.5,
        cells_within=(abs(miss) <= joint).sum(cells).astype(float),
        cells_scored=miss.notnull().sum(cells).astype(float),
        bandwidth_fitted=float(options.fitted_to),
    )


def views(data: xr.Dataset) -> Views:
    """Show the distance from the theory over the Nayak parameter, and what the laws said of it."""
    solved = against("nayak_by_spectrum", Line("area_excess", by="hurst", joined=False), log="x")
    middle = {"reduced_pressure": data.sizes["reduced_pressure"] // 2}
    laws = Line("area_excess_law", by="law", look={"marker": ""})
    solved_alone = Line("area_excess", joined=False, look={"color": "black"}, label="solved")
    beside = against("nayak_by_spectrum", solved_alone, laws, log="x", at=middle)
    return Views(
        table=Table(
            ("hurst", "bandwidth", "reduced_pressure"),
            ("hurst", "bandwidth", "reduced_pressure", "nayak_by_spectrum", "area", "area_excess"),
        ),
        budget=("area_excess",),
        figures=[
            Figure(
                "wide-band",
                "Contact area over that of Persson's theory, less one, over the Nayak parameter of C(q), by load.",
                panels_along(data, "reduced_pressure", solved),
            ),
            Figure(
                "wide-band-laws",
                "The same at one load, and the laws as fitted to the narrow bands alone.",
                panels_along(data, "hurst", beside),
            ),
        ],
        findings=[*_findings(data, data.isel(middle))],
    )


def _findings(data: xr.Dataset, at: xr.Dataset) -> Findings:
    widest = at.isel(bandwidth=np.flatnonzero(at.area.notnull().all("hurst"))[-1])
    form = "At infinite bandwidth, p* = {reduced_pressure}, the saturating law through all bands ends {each}."
    item = "{verdict} the theory at H = {hurst}, by {area_excess_limit:%}"
    yield finding("comparison", form, at, item=item, by="area_excess_limit")
    yield finding(
        "share",
        "Fitted to bandwidths up to {bandwidth_fitted}, the laws hold the wider ones within the joint 95 % interval in "
        "{each}.",
        data[["cells_within", "cells_scored", "law_miss_rms", "bandwidth_fitted"]],
        item="{cells_within} of {cells_scored} cells for the {law} (off by {law_miss_rms:%}, rms)",
    )
    form = "At lambda_long/lambda_short = {bandwidth}, p* = {reduced_pressure}, the area lies {each}."
    item = "{verdict} Persson's by {area_excess:+%} at H = {hurst}"
    yield finding("comparison", form, widest, item=item, by="area_excess")
    yield finding(
        "value",
        "Were the area to follow the power law, the theory would be within 5 % of it from a Nayak parameter of {each} on, at p* = "
        "{reduced_pressure}.",
        at.isel(law=LAWS.index("power")),
        item="{nayak_close:.2} at H = {hurst}",
    )
