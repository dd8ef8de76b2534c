"""Figures of the studies that compare limits with the theory. They read a study's dataset and never solve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from persson.elastic import pressure_distribution, stress_variance
from validation.report.figure import COLOURS, THEORY, look, new_figure
from validation.report.figure import SYMBOLS as MARKERS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


__all__ = [
    "patches_on_grids",
    "stress_on_grids",
]


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

    return figure
