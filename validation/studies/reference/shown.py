"""How the reference table is shown: rows, sentences, figures."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from persson.variants import corrected_contact_area
from validation.measures.common import persson_area
from validation.measures.ensemble import QUANTITIES
from validation.measures.theory import VARIANTS
from validation.reference.alpha import at_equal_alpha
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.studies.reference.loads import BY_SPECTRUM

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["figures", "findings", "table"]

_AXES = ("amplitudes", "hurst", "bandwidth", "reduced_pressure")
#: Distance of a theory that is drawn in the strongest colour [%].
_FAR = 35.0
#: Nayak parameters at which Hurst exponents are compared, and the load up to which they are [p*].
_ALPHAS, _MIDDLING = (3.0, 4.0, 6.0, 10.0, 16.0), 0.3


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load, those of exact amplitudes first."""
    rows: list[tuple[float | str, ...]] = []
    for at in itertools.product(*(range(dataset.sizes[name]) for name in _AXES)):
        here = dataset.isel(dict(zip(_AXES, at, strict=True)))
        if not np.isfinite(here.area):
            continue  # not made
        area, load = float(here.area), float(here.reduced_pressure)
        rows.append(
            (
                str(here.amplitudes.values),
                float(here.hurst),
                float(here.bandwidth),
                load,
                area,
                100 * float(here.area_error) / area,
                100 * float(here.area_half_width) / area,
                100 * float(here.area_grid) / area,
                area / load,
                *(float(here[name]) for name in QUANTITIES if name != "area"),
                float(here[BY_SPECTRUM]),
                100 * float(here[f"{BY_SPECTRUM}_error"] / here[BY_SPECTRUM]),
                area / float(persson_area(load)),
                float(here.saving),
            )
        )
    columns = (
        "amplitudes",
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
        "A/A0 at p* by C(q)",
        "+- [%]",
        "A/Persson",
        "saving",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how sure the table is, what the control saved, and how far the theory is off; of exact amplitudes."""
    dataset = dataset.sel(amplitudes="exact")
    share = 100 * (dataset.area_error / dataset.area)
    light = share.sel(reduced_pressure=slice(None, 0.03))
    heavy = share.sel(reduced_pressure=slice(0.03, None))
    size = ", size of the sample" if "area_size" in dataset else ""
    sentences = []
    for part, words in ((light, "p* below .03"), (heavy, "p* above .03")):
        if part.size:
            sentences.append(
                f"A/A0 at {words}: half of the 95 % interval is {float(part.median()):.2g} % in the median and "
                f"{float(part.max()):.2g} % at worst (surfaces, grid, solver{size}; L/lambda_long = {dataset.attrs['periods']:g})."
            )
    saving = dataset.saving.median(("hurst", "reduced_pressure"))
    listed = ", ".join(
        f"{float(saving[b]):.3g} at {float(dataset.bandwidth[b]):g}" for b in range(saving.size)
    )
    sentences.append(
        "Plain means over single surfaces on the same grids would cost, for the same intervals, in the median so many times "
        f"what was spent on a load, by lambda_long/lambda_short: {listed}."
    )
    excess = 100 * (dataset.area / persson_area(dataset.reduced_pressure.values) - 1)
    for j in sorted({0, dataset.sizes["reduced_pressure"] // 2, dataset.sizes["reduced_pressure"] - 1}):
        here = excess.isel(reduced_pressure=j)
        sentences.append(
            f"At p* = {float(dataset.reduced_pressure[j]):g} the area lies {float(here.min()):.3g} to {float(here.max()):.3g} % above Persson's, by "
            f"spectrum; +- {float(share.isel(reduced_pressure=j).max()):.2g} % at most."
        )
    return (*sentences, *_alpha_sentences(dataset))


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa over the load, and the theory over the table; for exact amplitudes."""
    dataset = dataset.sel(amplitudes="exact")
    return (
        Drawing(
            name="reference",
            figure=_figure(dataset),
            data=dataset,
            caption="Left: kappa over the load for every Hurst exponent at the largest bandwidth that all have, with the total 95 % interval. "
            "Right: Persson's area over that of the table, the mean over Hurst exponents for every bandwidth.",
        ),
        Drawing(
            name="reference-verdict",
            figure=_verdict(dataset),
            data=_theories(dataset),
            caption="Area of Persson's theory and of its variants over that of the table less one, in %, for every spectrum "
            "and load. White: cells that were not made.",
        ),
        Drawing(
            name="reference-alpha",
            figure=_alpha_figure(dataset),
            data=at_equal_alpha(dataset, _ALPHAS),
            caption="kappa over the Nayak parameter of C(q) for each Hurst exponent, at three loads, with the total 95 % "
            "interval; interpolated along the bandwidth. Were alpha all that matters, the lines would be one.",
        ),
    )


def _theories(dataset: xr.Dataset) -> xr.Dataset:
    """Return the relative distance of the areas of the theory and its variants from those of the table."""
    import xarray as xr

    load = dataset.reduced_pressure.values
    areas = [corrected_contact_area(load, stress_variance=0.25, variant=variant) for variant in VARIANTS]
    theories = xr.DataArray(
        np.array(areas),
        dims=("theory", "reduced_pressure"),
        coords={"theory": list(VARIANTS.values()), "reduced_pressure": load},
    )
    return xr.Dataset({"distance": theories / dataset.area - 1})


def _verdict(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import new_figure

    distance = 100 * _theories(dataset).distance.stack(spectrum=("hurst", "bandwidth"))
    distance = distance.dropna("spectrum", how="all")
    figure, panels = new_figure(width=12.0, height=1.3 + 0.22 * distance.sizes["spectrum"], columns=4)
    loads = [f"{load:g}" for load in dataset.reduced_pressure.values]
    spectra = [f"{hurst:g}, {bandwidth:g}" for hurst, bandwidth in distance.spectrum.values]
    for axes, name in zip(panels, distance.theory.values, strict=True):
        values = distance.sel(theory=name).transpose("spectrum", "reduced_pressure").values
        axes.imshow(values, vmin=-_FAR, vmax=_FAR, cmap="RdBu_r", aspect="auto")
        for (i, j), value in np.ndenumerate(values):
            dark = abs(value) > 0.6 * _FAR
            axes.text(
                j, i, f"{round(value)}", ha="center", va="center", fontsize=6, color="w" if dark else "k"
            )
        axes.grid(visible=False)
        axes.set_title(name, fontsize=9)
        axes.set_xticks(range(len(loads)), loads, fontsize=7)
        axes.set_yticks(
            range(len(spectra)), spectra if axes is panels[0] else [""] * len(spectra), fontsize=7
        )
        axes.set_xlabel(r"$p^*$")
    panels[0].set_ylabel(r"$H$, $\lambda_\mathrm{long}/\lambda_\mathrm{short}$")
    return figure


def _alpha_figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import look, new_figure

    found = at_equal_alpha(dataset, _ALPHAS)
    loads = _some_loads(dataset)
    figure, panels = new_figure(width=4.0 * len(loads), columns=len(loads))
    for axes, j in zip(panels, loads, strict=True):
        here, load = found.isel(reduced_pressure=j), float(found.reduced_pressure[j])
        for h, hurst in enumerate(here.hurst.values):
            own = here.isel(hurst=h)
            axes.errorbar(
                own.alpha, own.area / load, yerr=own.area_error / load, label=f"H = {hurst:g}", **look(h)
            )
        axes.set_title(f"p* = {load:g}", fontsize=9)
        axes.set_xscale("log")
        axes.set_xticks(_ALPHAS, [f"{alpha:g}" for alpha in _ALPHAS])
        axes.minorticks_off()
        axes.set_xlabel(r"Nayak's $\alpha$ of $C(q)$")
        axes.legend(fontsize=7)
    panels[0].set_ylabel(r"$\kappa = (A/A_0) / p^*$")
    return figure


def _some_loads(dataset: xr.Dataset) -> list[int]:
    """Return three loads, light to middling, or as many as there are."""
    light = np.flatnonzero(dataset.reduced_pressure.values < _MIDDLING)
    return sorted({int(light[0]), int(light[light.size // 2]), int(light[-1])}) if light.size else [0]


def _alpha_sentences(dataset: xr.Dataset) -> Iterator[str]:
    """Say what the Hurst exponent changes at equal Nayak parameter."""
    found = at_equal_alpha(dataset, _ALPHAS).dropna("alpha", how="all", subset=["area"])
    several = found.isel(alpha=(np.isfinite(found.area).sum("hurst") > 1).all("reduced_pressure").values)
    if not several.sizes["alpha"]:
        return
    low, high = several.area.min("hurst"), several.area.max("hurst")
    spread = (100 * (high / low - 1)).max("alpha")
    sure = (100 * (several.area_error / several.area)).max(("alpha", "hurst"))
    listed = "; ".join(
        f"p* = {float(spread.reduced_pressure[j]):g}: {float(spread[j]):.2g} % (+- {float(sure[j]):.2g} % each)"
        for j in _some_loads(dataset)
    )
    alphas = ", ".join(f"{alpha:g}" for alpha in several.alpha.values)
    yield (
        f"At equal Nayak parameter ({alphas}) the areas of the Hurst exponents that have it lie apart by at most: {listed}."
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import THEORY, look, new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2)
    load = dataset.reduced_pressure.values
    theory = persson_area(load)
    widest = int(np.flatnonzero(np.isfinite(dataset.area).all(("hurst", "reduced_pressure")))[-1])
    for h, hurst in enumerate(dataset.hurst.values):
        here = dataset.isel(hurst=h, bandwidth=widest)
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
