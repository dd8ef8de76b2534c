"""Figures of the studies. They read a study's dataset and never solve."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from validation.report.figure import COLOURS, THEORY, look, new_figure
from validation.report.figure import SYMBOLS as MARKERS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


__all__ = [
    "error_against_cells",
    "error_against_resolution",
    "grid_scale_protocol",
]


def error_against_resolution(dataset: xr.Dataset, errors: Mapping[str, xr.DataArray]) -> Figure:
    """Distance of each area from the limit against points per shortest wave: lines for the mean, dots for surfaces."""
    figure, (axes,) = new_figure()
    for k, (name, error) in enumerate(errors.items()):
        if not np.isfinite(error.values).any():
            continue
        size: NDArray[np.float64] = 100 * np.abs(error.values)
        axes.plot(
            dataset.points_per_wave, np.abs(100 * error.mean("surface")), label=f"{name}, |mean|", **_plain(k)
        )
        for values in size:
            axes.plot(dataset.points_per_wave, values, ls="", marker=".", ms=3, color=COLOURS[k], alpha=0.5)
    for e in range(dataset.sizes.get("element", 0)):
        for k, name in enumerate(("fem_pixel", "fem_perimeter")):
            error = 100 * np.abs((dataset[name][e] / dataset.limit - 1).mean("surface"))
            style = {**_plain(4 + e), "mfc": "white", "ls": ("-", ":")[k], "lw": 0.9}
            words = ("nodes", "corrected")[k]
            axes.plot(
                dataset.fem_points_per_wave, error, label=f"FEM {dataset.element.values[e]}, {words}", **style
            )
    per_wave = dataset.points_per_wave.values
    start = 100 * float(np.abs(errors["pixel"].mean("surface"))[0])
    axes.plot(
        per_wave, start * per_wave[0] / per_wave, color="black", lw=0.8, ls="--", label="first order in dx"
    )
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(per_wave, [f"{p:g}" for p in per_wave])
    axes.minorticks_off()
    axes.set_xlabel(r"points per shortest wavelength, $\lambda_{short}/\Delta x$")
    axes.set_ylabel("distance of the area from its limit [%]")
    axes.legend(fontsize=8)
    return figure


def _plain(k: int) -> dict[str, Any]:
    return {"marker": MARKERS[k], "color": COLOURS[k], "ms": 5}


def error_against_cells(dataset: xr.Dataset, error: xr.DataArray) -> Figure:
    """Overestimate of the pixel count against the cells of the median patch, with the range the paper asks for."""
    figure, (axes,) = new_figure()
    axes.axvspan(1e2, 1e4, color="black", alpha=0.08, lw=0, label="10 x 10 to 100 x 100 cells per patch")
    for k in range(dataset.sizes["surface"]):
        axes.plot(dataset.cells_per_patch[k], 100 * error[k], label=f"surface {k + 1}", **_plain(k))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("cells of the patch up to which half of the area lies")
    axes.set_ylabel("pixel area above the limit [%]")
    axes.legend(fontsize=8)
    return figure


def grid_scale_protocol(dataset: xr.Dataset, theory: float) -> Figure:
    """Kappa with roughness down to the grid scale against the grid, by the definition of the slope."""
    figure, (axes,) = new_figure()
    for k, slope in enumerate(dataset.slope.values):
        values = dataset.kappa_grid_scale.sel(slope=slope)
        axes.errorbar(
            dataset.protocol_points,
            values.mean("surface"),
            yerr=values.std("surface", ddof=1),
            label=f"slope: {slope}",
            **look(k),
        )
    limit = float(dataset.limit.mean()) / float(dataset.attrs["reduced_pressure"])
    axes.axhline(limit, color="black", lw=1, label=f"converged, resolved surfaces: {limit:.2f}")
    axes.axhline(theory, label=f"Persson at this load: {theory:.2f}", **THEORY)
    axes.set_xscale("log", base=2)
    axes.set_xticks(dataset.protocol_points.values, [str(n) for n in dataset.protocol_points.values])
    axes.set_xlabel("grid points along one side")
    axes.set_ylabel(r"$\kappa$, nodes counted")
    axes.legend(fontsize=8)
    return figure
