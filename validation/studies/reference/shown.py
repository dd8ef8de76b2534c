"""How the reference table is shown: rows, sentences, figures."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from validation.measures.common import persson_area
from validation.measures.ensemble import QUANTITIES
from validation.report.drawing import Drawing
from validation.report.table import ResultTable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["figures", "findings", "table"]


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load."""
    rows = []
    for h, b, j in itertools.product(
        *(range(dataset.sizes[name]) for name in ("hurst", "bandwidth", "reduced_pressure"))
    ):
        here = dataset.isel(hurst=h, bandwidth=b, reduced_pressure=j)
        area, load = float(here.area), float(here.reduced_pressure)
        rows.append(
            (
                float(here.hurst),
                float(here.bandwidth),
                load,
                area,
                100 * float(here.area_error) / area,
                100 * float(here.area_half_width) / area,
                100 * float(here.area_grid) / area,
                area / load,
                *(float(here[name]) for name in QUANTITIES if name != "area"),
                area / float(persson_area(load)),
                float(here.saving),
            )
        )
    columns = (
        "H",
        "lambda_long/lambda_short",
        "p*",
        "A/A0",
        "+- total [%]",
        "+- surfaces [%]",
        "+- grid [%]",
        "kappa",
        "gap/h_rms",
        "p0/(K h_rms)",
        "U/U_full",
        "P'(0)",
        "patches",
        "A/Persson",
        "saving",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how sure the table is, what the control saved, and how far the theory is off."""
    share = 100 * (dataset.area_error / dataset.area)
    light = share.sel(reduced_pressure=slice(None, 0.03))
    heavy = share.sel(reduced_pressure=slice(0.03, None))
    sentences = []
    for part, words in ((light, "p* below .03"), (heavy, "p* above .03")):
        if part.size:
            sentences.append(
                f"A/A0 at {words}: half of the 95 % interval is {float(part.median()):.2g} % in the median and "
                f"{float(part.max()):.2g} % at worst (surfaces, grid and solver; L/lambda_long = {dataset.attrs['periods']:g})."
            )
    saving = dataset.saving.median(("hurst", "reduced_pressure"))
    listed = ", ".join(
        f"{float(saving[b]):.3g} at {float(dataset.bandwidth[b]):g}" for b in range(saving.size)
    )
    sentences.append(
        "Plain means over single surfaces on the same grids would cost, for the same intervals, in the median so many times "
        f"what was spent, by lambda_long/lambda_short: {listed}."
    )
    excess = 100 * (dataset.area / persson_area(dataset.reduced_pressure.values) - 1)
    for j in sorted({0, dataset.sizes["reduced_pressure"] // 2, dataset.sizes["reduced_pressure"] - 1}):
        here = excess.isel(reduced_pressure=j)
        sentences.append(
            f"At p* = {float(dataset.reduced_pressure[j]):g} the area lies {float(here.min()):.3g} to {float(here.max()):.3g} % above Persson's, by "
            f"spectrum; +- {float(share.isel(reduced_pressure=j).max()):.2g} % at most."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa over the load, and the theory over the table."""
    return (
        Drawing(
            name="reference",
            figure=_figure(dataset),
            data=dataset,
            caption="Left: kappa over the load for every Hurst exponent at the largest bandwidth, with the total 95 % interval. "
            "Right: Persson's area over that of the table, the mean over Hurst exponents for every bandwidth.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import THEORY, look, new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2)
    load = dataset.reduced_pressure.values
    theory = persson_area(load)
    for h, hurst in enumerate(dataset.hurst.values):
        here = dataset.isel(hurst=h, bandwidth=-1)
        left.errorbar(load, here.area / load, yerr=here.area_error / load, label=f"H = {hurst:g}", **look(h))
    left.plot(load, theory / load, label="Persson", **THEORY)
    for b, bandwidth in enumerate(dataset.bandwidth.values):
        ratio = (theory / dataset.area.isel(bandwidth=b)).mean("hurst")
        label = rf"$\lambda_\mathrm{{long}}/\lambda_\mathrm{{short}}$ = {bandwidth:g}"
        right.plot(load, ratio, label=label, **plain_look(b))
    left.set_ylabel(r"$\kappa = (A/A_0) / p^*$")
    right.set_ylabel("Persson's area / that of the table")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel(r"$p^* = p_0 / (E^* h'_\mathrm{rms})$")
        axes.legend(fontsize=7)
    return figure
