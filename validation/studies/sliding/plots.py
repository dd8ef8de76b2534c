"""Figure of the study of sliding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import draw_means, means_of
from validation.measures.theory import VARIANTS
from validation.studies.sliding.slides import REMEMBERED, SHARES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["figure"]


def figure(dataset: xr.Dataset) -> Figure:
    """Friction, area, and the difference of both frictions."""
    from validation.report.figure import new_figure

    drawn, (left, middle, right) = new_figure(width=13.0, columns=3)
    _friction(left, dataset)
    _area(middle, dataset)
    _agreement(right, dataset)
    for axes in (left, middle):
        axes.set_xscale("log")
        axes.set_xlabel("velocity [m/s]")
        _mark_memory(axes, dataset)
    for axes in (left, middle, right):
        axes.legend(fontsize=7)
    return drawn


def _mark_memory(axes: Axes, dataset: xr.Dataset) -> None:
    """Shade the velocities at which the solid has not relaxed when the period comes round."""
    v = dataset.v.values
    late = np.flatnonzero(dataset.memory.values > REMEMBERED)
    axes.set_xlim(v[0] / 1.5, v[-1] * 1.5)
    if late.size:
        low = np.sqrt(v[late[0] - 1] * v[late[0]]) if late[0] else v[0] / 1.5
        axes.axvspan(low, v[-1] * 1.5, color="0.9", zorder=0)


def _friction(axes: Axes, dataset: xr.Dataset) -> None:
    from validation.report.figure import STYLES, look, plain_look

    fine = dataset.isel(grid=-1)
    means = means_of(fine.friction)
    lost = fine.dissipation.mean("surface").values
    values = np.array([mean.value for mean in means])
    sure = np.hypot([mean.half_width for mean in means], values - lost)
    axes.errorbar(dataset.v, values, yerr=sure, ls="", label="pressure on slopes", **look(0))
    axes.plot(dataset.v, lost, ls="", mfc="white", label="losses of the solid", **plain_look(0))
    for j, name in enumerate(SHARES.values()):
        axes.plot(dataset.v, dataset.theory[j].mean("surface"), color="black", lw=1, ls=STYLES[j], label=name)
    axes.set_ylabel(r"$\mu / h'_\mathrm{rms}$")
    axes.set_ylim(bottom=0)


def _area(axes: Axes, dataset: xr.Dataset) -> None:
    from validation.report.figure import STYLES, look

    fine = dataset.isel(grid=-1)
    draw_means(axes, dataset.v, means_of(fine.area), ls="", label="boundary elements", **look(0))
    for j, name in enumerate(VARIANTS):
        values = dataset.theory_area[j].mean("surface")
        axes.plot(dataset.v, values, color="black", lw=1, ls=STYLES[j % 4], label=VARIANTS[name])
    axes.set_yscale("log")
    axes.set_ylabel(r"$A/A_0$")


def _agreement(axes: Axes, dataset: xr.Dataset) -> None:
    from validation.report.figure import plain_look

    apart = np.sqrt(((dataset.friction / dataset.dissipation - 1) ** 2).mean("surface"))
    count = dataset.sizes["velocity"]
    for line, k in enumerate(sorted({0, count // 3, 2 * count // 3, count - 1})):
        label = f"v = {float(dataset.v[k]):g} m/s"
        axes.plot(dataset.points_per_wave, 100 * apart[:, k], label=label, **plain_look(line))
    axes.axhline(0.5, color="black", lw=0.8)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xlabel(r"$\lambda_\mathrm{short}/\Delta x$")
    axes.set_ylabel("difference of both frictions [%]")
