"""Figures of the study of macroasperities: patches, the pressure in them, percolation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import draw_means, means_of
from validation.report.figure import COLOURS, STYLES, look, new_figure, plain_look

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["patches", "percolation", "pressure"]

_ZETA = r"magnification $\zeta = q/q_0$"
_LOAD = r"$p_0 / (E^* h'_\mathrm{rms})$, all waves"
#: Magnifications at which the pressure is followed over the load.
_FIXED = (1.0, 2.0, 4.0)


def patches(dataset: xr.Dataset) -> Figure:
    """Area, number of patches and share of the largest, over the magnification."""
    figure, (left, middle, right) = new_figure(width=12.0, columns=3)
    zeta, loads = dataset.zeta.values, dataset.reduced_pressure.values
    for n, j in enumerate(range(0, loads.size, 2)):
        for axes, name in ((left, "area"), (middle, "patches"), (right, "largest")):
            style = {**look(n), "ls": "" if axes is left else "-"}
            draw_means(axes, zeta, means_of(dataset[name][:, j]), label=f"p* = {loads[j]:g}", **style)
        left.plot(zeta, dataset.theory[:, j].mean("surface"), color=COLOURS[n], lw=0.9)
    for axes, words in (
        (left, r"$A(\zeta)/A_0$; lines: Persson"),
        (middle, r"patches on $\lambda_0^2$"),
        (right, "largest patch / contact"),
    ):
        axes.set_xscale("log", base=2)
        axes.set_xlabel(_ZETA)
        axes.set_ylabel(words)
    left.set_yscale("log")
    middle.set_yscale("log")
    right.legend(fontsize=7)
    return figure


def pressure(dataset: xr.Dataset) -> Figure:
    """Mean pressure in the contact seen at zeta over the load, and what of the load is carried there in the end."""
    figure, (left, right) = new_figure(width=9.0, columns=2)
    loads, zeta = dataset.reduced_pressure.values, dataset.zeta.values
    for n, at in enumerate(_FIXED):
        i = int(np.argmin(np.abs(np.log(zeta / at))))
        style = {**look(n), "ls": "-", "lw": 0.8, "label": rf"$\zeta$ = {zeta[i]:g}"}
        draw_means(left, loads, means_of(loads / dataset.area[:, :, i]), **style)
        draw_means(right, loads, means_of(dataset.load_inside[:, :, i]), **style)
    for n, source in enumerate(dataset.source.values.tolist()):
        left.plot(
            loads,
            dataset.macro_pressure.sel(source=source).mean("surface"),
            color="black",
            marker="*" if source == "bem" else "",
            ls=STYLES[1 + n],
            label=rf"at $\zeta_m$ of the {'simulation' if source == 'bem' else 'theory'}",
        )
    left.plot(loads, loads, color="black", lw=0.6, ls=":", label=r"$p_0$: full contact")
    left.set_yscale("log")
    left.set_ylabel(r"$p_0 A_0/A(\zeta) / (E^* h'_\mathrm{rms})$")
    right.set_ylabel(r"share of the load inside the contact at $\zeta$")
    right.set_ylim(0, 1.05)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel(_LOAD)
        axes.legend(fontsize=7)
    return figure


def percolation(dataset: xr.Dataset, *, paper: float) -> Figure:
    """Thresholds over the magnification where they are met, and their distribution."""
    figure, (left, right) = new_figure(width=9.0, columns=2)
    for n, load in enumerate(dataset.percolating_pressure.values):
        for name in ("contact", "gap"):
            areas = dataset[f"{name}_threshold"][:, n].values.ravel()
            style = plain_look(n) | {"mfc": plain_look(n)["color"] if name == "contact" else "white"}
            label = f"{name}, p* = {load:g}"
            left.plot(dataset[f"{name}_zeta"][:, n].values.ravel(), areas, ls="", label=label, **style)
            met = np.sort(areas[np.isfinite(areas)])
            right.plot(met, (np.arange(met.size) + 0.5) / max(met.size, 1), ls="-", lw=0.6, **style)
    left.axhline(paper, color="black", lw=0.8, ls=":")
    right.axvline(paper, color="black", lw=0.8, ls=":")
    left.set_xscale("log", base=2)
    left.set_xlabel(_ZETA + " at the threshold")
    left.set_ylabel(r"$A/A_0$ at the threshold, located")
    left.legend(fontsize=7)
    right.set_xlabel(r"$A/A_0$ at the threshold, located")
    right.set_ylabel("share of surfaces and directions below")
    return figure
