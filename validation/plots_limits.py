"""Figures of the studies that compare limits with the theory. They read a study's dataset and never solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from persson.elastic import KAPPA_BGT, persson_kappa, pressure_distribution, stress_variance
from validation.plots import new_figure
from validation.plots_studies import COLOURS, MARKERS, THEORY, look
from validation.references import KAPPA_LITERATURE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from validation.statistics import Estimate
    from validation.studies._ladders import Rungs

__all__ = ["kappa_against_hurst", "kappa_ladders", "patches_on_grids", "stress_on_grids"]

_VARIANT_LINES = ("--", (0, (5, 1, 1, 1)), (0, (1, 1)))


def kappa_against_hurst(
    dataset: xr.Dataset, limits: Sequence[Sequence[Estimate]], variants: Sequence[Mapping[str, float]]
) -> Figure:
    """Kappa against H, one panel for each load: limit, raw counts, theory and its variants, literature."""
    loads = dataset.reduced_pressure.values
    figure, panels = new_figure(width=2.9 * loads.size + 1, height=4.6, columns=loads.size)
    rows = [int(i) for i in np.flatnonzero(dataset.family.values == dataset.family.values[0])]
    rows.sort(key=lambda i: float(dataset.hurst[i]))
    hurst = dataset.hurst.values[rows]
    per_wave = dataset.points_per_wave.values
    for j, axes in enumerate(panels):
        value = [limits[i][j].value for i in rows]
        error = [limits[i][j].half_width for i in rows]
        axes.errorbar(hurst, value, yerr=error, ls="-", label="limit over grids", **look(0))
        for g, style in ((-1, "-"), (0, ":")):
            axes.plot(
                hurst,
                dataset.kappa_pixel[rows, :, g, j].mean("surface"),
                marker=MARKERS[1],
                mfc="white",
                color=COLOURS[1],
                ls=style,
                lw=0.8,
                ms=4,
                label=rf"counted, $\lambda_{{short}}/\Delta x$ = {per_wave[g]:g}",
            )
        _theory_lines(axes, float(loads[j]), variants[j])
        ensemble = dataset.kappa_ensemble[rows, :, j].mean("surface")
        axes.plot(hurst, ensemble, lw=0.7, ls="--", color=THEORY["color"], label="Persson, from C(q) alone")
        _literature(axes)
        axes.set_title(f"p* = {loads[j]:g}", fontsize=9)
        axes.set_xlabel("Hurst exponent H")
    top = max(axes.get_ylim()[1] for axes in panels)
    for axes in panels:
        axes.set_ylim(1.35, top)
    panels[0].set_ylabel(r"$\kappa = (A/A_0)\,/\,p^*$")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, ncols=max(2, loads.size), loc="outside lower center")
    return figure


def _theory_lines(axes: Axes, pressure: float, variants: Mapping[str, float]) -> None:
    axes.axhline(
        KAPPA_BGT, color="black", ls=":", lw=1, label=f"Bush-Gibson-Thomas {KAPPA_BGT:.3f} (light load)"
    )
    for (name, kappa), style in zip(variants.items(), _VARIANT_LINES, strict=True):
        axes.axhline(kappa, color="0.45", ls=style, lw=1, label=name)
    axes.axhline(float(persson_kappa(pressure)), lw=1.2, label="Persson, conditional", **THEORY)


def _literature(axes: Axes) -> None:
    for published in KAPPA_LITERATURE:
        low, high = published.hurst
        if low == high:
            axes.plot(
                low, published.kappa[0], marker="x", color="black", ls="", label=_wrapped(published.source)
            )
        else:
            label = _wrapped(published.source)
            axes.fill_between([low, high], *published.kappa, color="black", alpha=0.1, lw=0, label=label)


def _wrapped(text: str) -> str:
    parts = [part.strip() for part in text.replace(", as read", ";as read").split(";")]
    return "\n".join(parts[:3]) + ("\n..." if len(parts) > 3 else "")


def kappa_ladders(dataset: xr.Dataset, lines: Mapping[str, Sequence[Rungs]]) -> Figure:
    """Kappa on the rungs of each ladder against step^order, with the fixed-order line and its limit."""
    figure, panels = new_figure(width=9.0, height=4.2, columns=len(lines))
    words = {
        "bandwidth": r"$(\lambda_{short}/\lambda_{long})^{2(1-H)}$",
        "size": r"$(\lambda_{long}/L)^2$",
    }
    for axes, (kind, rungs) in zip(panels, lines.items(), strict=True):
        for k, line in enumerate(rungs):
            x = dataset[f"{kind}_step"].values ** line.order
            label = f"H = {float(dataset.ladder_hurst[k]):g}"
            axes.errorbar(
                x,
                dataset[f"{kind}_kappa"][k],
                yerr=dataset[f"{kind}_half_width"][k],
                ls="",
                label=label if line.determinable else f"{label} (limit not determinable)",
                **{**look(k), "mfc": "white"},
            )
            if line.determinable:
                ends = np.array([0.0, x.max()])
                axes.plot(ends, line.limit + line.slope * ends, color=COLOURS[k], lw=0.8)
                axes.errorbar([0.0], [line.limit], yerr=[line.half_width], ls="", **look(k))
        axes.set_xlabel(words[kind])
        axes.set_ylabel(rf"$\kappa$ at p* = {dataset.attrs['ladder_pressure']:g} (limit over grids)")
        axes.legend(fontsize=7)
    return figure


def stress_on_grids(dataset: xr.Dataset) -> Figure:
    """P(sigma) on every grid beside the theory, and its two lowest moments against the grid."""
    figure, (left, right) = new_figure(width=9.0, height=4.0, columns=2)
    shades = np.linspace(0.8, 0.0, dataset.sizes["grid"])
    for g, per_wave in enumerate(dataset.points_per_wave.values):
        style = ("-", "--", "-.", ":")[g % 4]
        label = rf"$\lambda_{{short}}/\Delta x$ = {per_wave:g}"
        left.plot(dataset.stress, dataset.density[g], color=str(shades[g]), ls=style, lw=1, label=label)
    pressure = float(dataset.attrs["reduced_pressure"])
    theory = pressure_distribution(
        dataset.stress.values, pressure=pressure, stress_variance=stress_variance(1.0, contact_modulus=1.0)
    )
    left.plot(dataset.stress, theory, label="Persson", **THEORY)
    left.set_xlim(0, 2)
    left.set_ylim(bottom=0)
    left.set_xlabel(r"$\sigma / (E^* h'_{rms})$")
    left.set_ylabel(r"$P(\sigma)\,E^* h'_{rms}$ per nominal area")
    left.legend(fontsize=7)
    moments = (
        (dataset.pixel / dataset.limit, r"zeroth moment: $A$ over its limit"),
        (dataset.first_moment, r"first moment: load over $p_0$"),
    )
    for k, (values, label) in enumerate(moments):
        spread = values.std("surface", ddof=1)
        right.errorbar(dataset.points_per_wave, values.mean("surface"), yerr=spread, label=label, **look(k))
    _grid_axis(right, dataset)
    right.legend(fontsize=8)
    return figure


def _grid_axis(axes: Axes, dataset: xr.Dataset) -> None:
    per_wave = dataset.points_per_wave.values
    axes.set_xscale("log", base=2)
    axes.set_xticks(per_wave, [f"{p:g}" for p in per_wave])
    axes.minorticks_off()
    axes.set_xlabel(r"points per shortest wavelength, $\lambda_{short}/\Delta x$")


def patches_on_grids(dataset: xr.Dataset) -> Figure:
    """Draw the number of patches, and the cells of those that hold parts of the area, against the grid."""
    figure, (left, right) = new_figure(width=9.0, columns=2)
    for k in range(dataset.sizes["surface"]):
        left.plot(dataset.points_per_wave, dataset.patches[k], marker=".", lw=0.6, color="0.6")
    left.errorbar(dataset.points_per_wave, dataset.patches.mean("surface"), **look(0))
    left.set_ylabel("contact patches per surface")
    right.axhspan(1e2, 1e4, color="black", alpha=0.08, lw=0, label="10 x 10 to 100 x 100 cells")
    for m, part in enumerate(dataset.part.values):
        right.plot(
            dataset.points_per_wave,
            dataset.cells[:, :, m].mean("surface"),
            label=f"{100 * part:g} % of the area lies in smaller patches",
            marker=MARKERS[m],
            color=COLOURS[m],
        )
    right.set_yscale("log")
    right.set_ylabel("cells of the patch")
    right.legend(fontsize=7)
    for axes in (left, right):
        _grid_axis(axes, dataset)
    return figure
