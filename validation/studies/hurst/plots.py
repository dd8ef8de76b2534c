"""Figures of the study of the Hurst exponent: kappa against H, against the Nayak parameter, along the ladders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from persson.elastic import KAPPA_BGT, KAPPA_PERSSON, persson_kappa
from validation.measures.common import draw_means
from validation.measures.references import ALPHA_LITERATURE, KAPPA_LITERATURE
from validation.report.figure import COLOURS, STYLES, SYMBOLS, THEORY, look, new_figure
from validation.studies.hurst.sentences import alpha_ratio

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from validation.measures.ladders import Rungs
    from validation.measures.statistics import Estimate

__all__ = ["alpha_against_magnification", "kappa_against_hurst", "kappa_against_nayak", "kappa_ladders"]

#: Relative area below which kappa is published; a little more than the authors' 0.1.
_LIGHT = 0.12

_VARIANT_LINES = ("--", (0, (5, 1, 1, 1)), (0, (1, 1)))


def kappa_against_hurst(
    dataset: xr.Dataset, limits: Sequence[Sequence[Estimate]], variants: Sequence[Mapping[str, float]]
) -> Figure:
    """Kappa against H, one panel for each load: limit, raw counts, theory and its variants, literature."""
    loads = dataset.reduced_pressure.values
    # The legend below takes two columns of words at least, and more rows the fewer columns there are.
    columns = max(2, loads.size)
    figure, panels = new_figure(width=2.9 * columns + 1, height=4.2 + 1.6 / columns, columns=loads.size)
    rows = [int(i) for i in np.flatnonzero(dataset.family.values == dataset.family.values[0])]
    rows.sort(key=lambda i: float(dataset.hurst[i]))
    hurst = dataset.hurst.values[rows]
    per_wave = dataset.points_per_wave.values
    for j, axes in enumerate(panels):
        found = [limits[i][j] for i in rows]
        draw_means(axes, hurst, found, ls="-", label="limit over grids", **look(0))
        for g, style in ((-1, "-"), (0, ":")):
            axes.plot(
                hurst,
                dataset.kappa_pixel[rows, :, g, j].mean("surface"),
                marker=SYMBOLS[1],
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
        if np.mean([one.value for one in found]) * loads[j] < _LIGHT:
            _literature(axes)
        axes.set_title(f"p* = {loads[j]:g}", fontsize=9)
        axes.set_xlabel("Hurst exponent H")
    top = max(axes.get_ylim()[1] for axes in panels)
    for axes in panels:
        axes.set_ylim(1.35, top)
    panels[0].set_ylabel(r"$\kappa = (A/A_0)\,/\,p^*$")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, ncols=columns, loc="outside lower center", frameon=False)
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


def _kappa_lines(axes: Axes) -> None:
    axes.axhline(KAPPA_BGT, color="black", ls=":", lw=1, label=f"Bush-Gibson-Thomas {KAPPA_BGT:.3f}")
    axes.axhline(KAPPA_PERSSON, lw=1, label=f"Persson {KAPPA_PERSSON:.3f} (light load)", **THEORY)


def kappa_against_nayak(dataset: xr.Dataset, limits: Sequence[Sequence[Estimate]]) -> Figure:
    """Kappa against the realised Nayak parameter; families of spectra by marker, loads by colour."""
    figure, (axes,) = new_figure(height=4.8)
    families = list(dict.fromkeys(dataset.family.values.tolist()))
    alpha = dataset.nayak.mean("surface").values
    for f, family in enumerate(families):
        rows = [int(i) for i in np.flatnonzero(dataset.family.values == family)]
        for j, pressure in enumerate(dataset.reduced_pressure.values):
            shape = {**look(j), "marker": SYMBOLS[f]}
            label = f"{family}, p* = {pressure:g}"
            draw_means(axes, alpha[rows], [limits[i][j] for i in rows], ls="-", lw=0.7, label=label, **shape)
    for k in range(dataset.sizes.get("ladder", 0)):
        label = f"bandwidth at equal H = {float(dataset.ladder_hurst[k]):g}, p* = {dataset.attrs['ladder_reduced_pressure']:g}"
        style: dict[str, Any] = {
            "color": str(0.75 - 0.15 * (k % 5)),
            "ls": "--",
            "lw": 0.8,
            "marker": ".",
            "ms": 4,
        }
        axes.plot(dataset.bandwidth_nayak[k], dataset.bandwidth_kappa[k], label=label, **style)
    _kappa_lines(axes)
    axes.set_xscale("log")
    ticks = [
        tick for tick in (2, 3, 5, 10, 20, 30, 50, 100) if axes.get_xlim()[0] <= tick <= axes.get_xlim()[1]
    ]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel(r"Nayak parameter $\alpha = \frac{3}{2} m_0 m_4/m_2^2$ (realised)")
    axes.set_ylabel(r"$\kappa$ (limit over grids)")
    axes.legend(fontsize=7, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure


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
        axes.set_ylabel(rf"$\kappa$ at p* = {dataset.attrs['ladder_reduced_pressure']:g} (limit over grids)")
        axes.legend(fontsize=7)
    return figure


def alpha_against_magnification(dataset: xr.Dataset) -> Figure:
    """Alpha(zeta) over Persson's for each fractal dimension, beside what was published."""
    figure, (axes,) = new_figure()
    for k, hurst in enumerate(dataset.ladder_hurst.values):
        zeta, ratio, half = alpha_ratio(dataset, k)
        axes.errorbar(zeta, ratio, yerr=half, ls="-", lw=0.8, label=rf"$D_f$ = {3 - hurst:.2f}", **look(k))
    for k, (source, value) in enumerate(ALPHA_LITERATURE.items()):
        axes.axhline(value, color="black", lw=0.9, ls=STYLES[1 + k % 3], label=source)
    axes.axhline(1.0, **THEORY, lw=0.9, label="Persson")
    axes.set_xscale("log", base=2)
    axes.set_xlabel(r"magnification $\zeta = q/q_0$ of the last wave")
    axes.set_ylabel(r"$\alpha(\zeta)$ / Persson's")
    axes.legend(fontsize=7)
    return figure
