"""Figures of the study of refinement. They read its dataset and never solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from persson.elastic import pressure_distribution, stress_variance
from validation.report.figure import COLOURS, SYMBOLS, THEORY, look, new_figure, plain_look

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "error_against_cells",
    "error_against_resolution",
    "grid_scale_protocol",
    "patches_on_grids",
    "stress_on_grids",
]


def error_against_resolution(dataset: xr.Dataset, errors: Mapping[str, xr.DataArray]) -> Figure:
    """Distance of each area from the limit against points per shortest wave: lines for the mean, dots for surfaces."""
    figure, (axes,) = new_figure()
    for k, (name, error) in enumerate(errors.items()):
        if not np.isfinite(error.values).any():
            continue
        size: NDArray[np.float64] = 100 * np.abs(error.values)
        axes.plot(
            dataset.points_per_wave,
            np.abs(100 * error.mean("surface")),
            label=f"{name}, |mean|",
            **plain_look(k),
        )
        for values in size:
            axes.plot(dataset.points_per_wave, values, ls="", marker=".", ms=3, color=COLOURS[k], alpha=0.5)
    for e in range(dataset.sizes.get("element", 0)):
        for k, name in enumerate(("fem_pixel", "fem_perimeter")):
            error = 100 * np.abs((dataset[name][e] / dataset.limit - 1).mean("surface"))
            style = {**plain_look(4 + e), "mfc": "white", "ls": ("-", ":")[k], "lw": 0.9}
            words = ("nodes", "corrected")[k]
            axes.plot(
                dataset.fem_points_per_wave, error, label=f"FEM {dataset.element.values[e]}, {words}", **style
            )
    for m, name in enumerate(dataset.other_method.values if "case" in dataset.dims else ()):
        own = dataset.isel(case=np.flatnonzero(dataset.other.values == name))
        for k, (area, words) in enumerate((("other_pixel", "counted"), ("other_perimeter", "corrected"))):
            error = 100 * np.abs((own[area] / dataset.limit - 1).mean("surface"))
            style = {**plain_look(4 + dataset.sizes.get("element", 0) + m), "mfc": "white"}
            style |= {"ls": ("-", ":")[k], "lw": 0.9}
            axes.plot(own.other_points_per_wave, error, label=f"{name}, {words}", **style)
    per_wave = dataset.points_per_wave.values
    start = 100 * float(np.abs(errors["pixel"].mean("surface"))[0])
    axes.plot(
        per_wave, start * per_wave[0] / per_wave, color="black", lw=0.8, ls="--", label="first order in dx"
    )
    axes.set_yscale("log")
    _points_per_wave_axis(axes, per_wave)
    axes.set_ylabel("distance of the area from its limit [%]")
    axes.legend(fontsize=8)
    return figure


def error_against_cells(dataset: xr.Dataset, error: xr.DataArray) -> Figure:
    """Overestimate of the pixel count against the cells of the median patch, with the range the paper asks for."""
    figure, (axes,) = new_figure()
    axes.axvspan(1e2, 1e4, color="black", alpha=0.08, lw=0, label="10 x 10 to 100 x 100 cells per patch")
    for k in range(dataset.sizes["surface"]):
        axes.plot(dataset.cells_per_patch[k], 100 * error[k], label=f"surface {k + 1}", **plain_look(k))
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


def stress_on_grids(dataset: xr.Dataset) -> Figure:
    """P(sigma) on every grid beside the theory, and its two lowest moments against the grid."""
    figure, (left, right) = new_figure(width=9.0, height=4.0, columns=2)
    shades = np.linspace(0.8, 0.0, dataset.sizes["grid"])
    for g, per_wave in enumerate(dataset.points_per_wave.values):
        style = ("-", "--", "-.", ":")[g % 4]
        label = rf"$\lambda_{{short}}/\Delta x$ = {per_wave:g}"
        left.plot(dataset.stress, dataset.density[g], color=str(shades[g]), ls=style, lw=1, label=label)
    pressure = float(dataset.attrs["reduced_pressure"])
    if "bare" in dataset.attrs:
        theory = pressure_distribution(
            dataset.stress.values,
            pressure=pressure,
            stress_variance=stress_variance(1.0, contact_modulus=1.0),
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
    _points_per_wave_axis(right, dataset.points_per_wave.values)
    right.legend(fontsize=8)
    return figure


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
            marker=SYMBOLS[m],
            color=COLOURS[m],
        )
    right.set_yscale("log")
    right.set_ylabel("cells of the patch")
    right.legend(fontsize=7)
    for axes in (left, right):
        _points_per_wave_axis(axes, dataset.points_per_wave.values)
    return figure


def _points_per_wave_axis(axes: Axes, per_wave: Sequence[float]) -> None:
    """Lay grids, as lambda_short/dx, along the axis."""
    axes.set_xscale("log", base=2)
    axes.set_xticks(per_wave, [f"{p:g}" for p in per_wave])
    axes.minorticks_off()
    axes.set_xlabel(r"points per shortest wavelength, $\lambda_{short}/\Delta x$")
