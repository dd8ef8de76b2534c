"""What the study `hurst` shows: kappa against H, against the Nayak parameter, and along the ladders."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import xarray as xr

from validation.report.views import (
    MOST_FINDINGS,
    Band,
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

#: A/A0 below which kappa is published, a little more than the authors' 0.1; H of the published alpha(zeta).
_LIGHT, _PUBLISHED = 0.12, 0.8


def views(data: xr.Dataset) -> Views:
    """Kappa against H, against the Nayak parameter, and along the ladders."""
    beside = "solver" in data.dims
    names = ("family", "hurst", "bandwidth", "nayak", "reduced_pressure", "kappa")
    counted = (Column("kappa_pixel", {"grid": -1}), Column("kappa_pixel", {"grid": 0}))
    theories = ("kappa_persson", "kappa_ensemble", "kappa_yang_persson", "kappa_wang_mueser", "kappa_xu")
    return Views(
        table=Table(("family", "hurst", "load"), (*names, *counted, *theories)),
        budget=("kappa", *(("kappa_by_solver",) if beside else ())),
        figures=[*_figures(data)],
        findings=[*_findings(data)][:MOST_FINDINGS],
    )


#: Published ranges and points, told apart by their sources.
_LITERATURE = Band(
    "kappa_published",
    high="kappa_published_high",
    x="hurst_published",
    by="paper_kappa",
    look={"color": "black", "mfc": "white"},
)


def _figures(data: xr.Dataset) -> Iterator[Figure]:
    if "solver" in data.dims:
        reduced_pressure = float(data.reduced_pressure_by_solver)
        same = np.flatnonzero(np.isclose(data.reduced_pressure, reduced_pressure))
        look, label = {"mfc": "white", "ls": ":"}, "boundary elements, {family}"
        wide = [Line("kappa", by="family", at={"load": int(k)}, look=look, label=label) for k in same]
        caption = f"kappa against the Hurst exponent at p* = {reduced_pressure:g}, limits over the grids of each solver on the same "
        caption += (
            f"surfaces of bandwidth {float(data.bandwidth_by_solver):g}; Persson's theory; published values."
        )
        persson = Level("kappa_persson_by_solver", label="Persson")
        panel = against("hurst", "kappa_by_solver", *wide, persson, _LITERATURE, by="solver", bottom=1.5)
        yield Figure("kappa-of-solvers", caption, [panel])
    which = ", {family}" * (data.sizes["family"] > 1)
    marks = (
        Line("kappa", by="family", label=f"limit over grids{which}"),
        Line("kappa_pixel", at={"grid": 0, "family": 0}, label=f"counted, coarsest grid{which}"),
        Level("kappa_persson"),
    )
    panels = panels_along(data, "load", against("hurst", *marks, bottom=1.35))
    area = data.kappa.isel(family=0).mean("hurst") * data.reduced_pressure
    yield Figure(
        "kappa-against-hurst",
        "kappa against the Hurst exponent at each load: the limit over grids, points counted on the coarsest "
        "grid, and Persson's theory; black, published values (light load).",
        [
            replace(panel, marks=(*marks, _LITERATURE)) if float(mean_area) < _LIGHT else panel
            for panel, mean_area in zip(panels, area, strict=True)
        ],
    )

    theories = (Level("kappa_bgt"), Level("kappa_persson_light"))
    yield Figure(
        "kappa-against-nayak",
        "The same kappa against the realised Nayak parameter at each load.",
        panels_along(data, "load", against("nayak", "kappa", *theories, by="family", log="x")),
    )
    if "ladder" not in data.dims:
        return
    limits = []
    for kind, title in (("by_bandwidth", "lambda_short/lambda_long falls"), ("by_size", "the sample grows")):
        end = f"step_{kind}_line"
        lines = (
            Line(f"kappa_{kind}", by="ladder", joined=False, look={"mfc": "white"}),
            Line(f"kappa_{kind}_line", x=end, by="ladder", look={"marker": "", "lw": 0.8}, label=""),
            Line(f"kappa_{kind}_limit", x=end, at={"end": 0}, by="ladder", label=""),
        )
        limits.append(against(f"step_{kind}", *lines, y="kappa", title=title))
    paper, published = "paper_kappa_ratio", "kappa_ratio_published"
    papers = [
        Level(published, at={paper: k}, look={"ls": ls}, label=f"{{{paper}}}")
        for k, ls in enumerate((":", "--", "-"))
    ]
    yield Figure(
        "kappa-of-wider-bands",
        "kappa against the realised Nayak parameter as the bandwidth grows at equal H.",
        [against("nayak_by_bandwidth", "kappa_by_bandwidth", *theories, by="ladder", y="kappa", log="x")],
    )
    yield Figure(
        "kappa-limits",
        "kappa against the step to its order as the bandwidth grows (left) and the sample (right); lines and "
        "filled symbols at 0: the limit where it is determinable.",
        limits,
    )
    yield Figure(
        "alpha-against-magnification",
        "kappa over that of Persson's theory as waves are added; black, published slopes alpha(zeta) of A = alpha F "
        "at light load for H = 0.8, as Persson (2006, Sec. 3.5) quotes them.",
        [against("bandwidth_rung", "kappa_ratio_by_bandwidth", *papers, by="ladder", log="x")],
    )


def _findings(data: xr.Dataset) -> Findings:
    ends = {"first": data.hurst[0], "last": data.hurst[-1]}
    ends |= {"low": data.bandwidth.min(), "high": data.bandwidth.max()}
    if data.sizes["hurst"] > 1:
        form = "From H = {first} to {last} kappa {each}."
        item = "{verdict}, {kappa_change:%}, at p* = {reduced_pressure} with {family}"
        none = {"0": "shows no trend beyond its interval"}
        yield finding("trend", form, data, item=item, by="kappa_change", words=none, **ends)
    form = "Counted kappa, in the mean over H and load, is {each}; over H and load the limit spreads by {kappa_spread:%}, what counting spreads more is a "
    form += "discretisation artefact."
    item = "{verdict} the limit, by {kappa_excess:%}, at lambda_short/dx = {points_per_wave} (spread {kappa_pixel_spread:%})"
    yield finding("comparison", form, data.isel(family=0, hurst=0), item=item, by="kappa_excess")
    wide = "{low}" if ends["low"] == ends["high"] else "{low} to {high}"
    form = (
        f"The limit over Persson's theory is {{each}} (mean over spectra of lambda_long/lambda_short {wide})."
    )
    yield finding("value", form, data, item="{kappa_ratio} at p* = {reduced_pressure}", **ends)
    if "ladder" in data.dims:
        yield from _of_ladders(data)
    form = "By its own limit over grids kappa is, at p* = {reduced_pressure_by_solver} and bandwidth {bandwidth_by_solver}, by "
    form += "{solver}: {each}."
    item = (
        "{kappa_by_solver} at H = {hurst}, {kappa_by_solver_difference:+%} from boundary elements ({verdict})"
    )
    outcomes = {"agree": "not distinguishable", "differ": "beyond the intervals"}
    for k in range(1, data.sizes.get("solver", 0)):
        here = data.isel(solver=k)
        yield finding("agreement", form, here, item=item, by="kappa_by_solver_difference", words=outcomes)


def _of_ladders(data: xr.Dataset) -> Findings:
    if data.sizes["ladder"] > 1:
        first, last = data.hurst_ladder[[0, -1]]
        form = "At the Nayak parameter {nayak_by_bandwidth_equal} kappa at H = {last} is {verdict} that at H = {first}, "
        form += "{kappa_by_bandwidth_equal_change:%}; as the bandwidth grows at equal H it changes by {each}."
        item, by = "{kappa_by_bandwidth_change:%} (H = {hurst_ladder})", "kappa_by_bandwidth_equal_change"
        yield finding("comparison", form, data, item=item, by=by, first=first, last=last)
    form = "As waves are added at p* = {reduced_pressure_ladder}, for which the budget has bandwidth and size, kappa {each}."
    item = "{verdict} at H = {hurst_ladder}, limit {kappa_by_bandwidth_limit}; for an endless sample of the narrowest band "
    item += "{kappa_by_size_limit}"
    outcomes = {"+": "falls", "-": "rises", "0": "shows no trend beyond its interval"}
    yield finding("trend", form, data, item=item, by="kappa_by_bandwidth_slope", words=outcomes)
    close = np.flatnonzero(np.isclose(data.hurst_ladder, _PUBLISHED))
    if close.size:
        last = data.isel(ladder=int(close[0]), bandwidth_rung=-1)
        form = "At D_f = 2.2, zeta = {bandwidth_rung} and p* = {reduced_pressure_ladder} kappa is {kappa_ratio_by_bandwidth} of "
        form += "Persson's; published slopes at light load, mostly for more waves: {each}."
        item, by = "{kappa_ratio_published} ({paper_kappa_ratio}) {verdict}", "kappa_ratio_difference"
        outcomes = {"agree": "agrees within the interval", "differ": "lies outside the interval"}
        yield finding("agreement", form, last, item=item, by=by, words=outcomes)
