"""Figures of the studies. They read a study's dataset and never solve."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
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


def pressure_near_zero(dataset: xr.Dataset, *, window: float, contour: float) -> Figure:
    """P(sigma) below 0.3 E* h' on every grid, mean over surfaces, with the slopes."""
    figure, (axes,) = new_figure()
    shades = np.linspace(0.75, 0.0, dataset.sizes["grid"])
    for k, spacing in enumerate(dataset.spacing.values):
        label = rf"$\lambda_{{short}}/\Delta x$ = {1 / spacing:.0f}"
        axes.plot(
            dataset.stress,
            dataset.density[k],
            color=str(shades[k]),
            ls=("-", "--", "-.", ":")[k % 4],
            label=label,
        )
    top = float(dataset.density.max())
    stress = np.linspace(0, 0.3, 50)
    for slope, label, style in (
        (window, "slope at 0, closing window", {"color": "#0b5394", "ls": "--"}),
        (contour, r"$2 S\langle B^{-2}\rangle\sigma$", {"color": "#b45f06", "ls": ":"}),
        (float(dataset.attrs["persson_slope"]), "Persson's slope", THEORY),
    ):
        axes.plot(stress, slope * stress, label=label, lw=2, **style)
    axes.set_ylim(0, 1.1 * top)
    axes.set_xlim(0, 0.3)
    axes.set_xlabel(r"$\sigma / (E^* h'_{rms})$")
    axes.set_ylabel(r"$P(\sigma)\,E^* h'_{rms}$ per nominal area")
    axes.legend(fontsize=8)
    return figure


def density_at_zero(dataset: xr.Dataset, intercepts: NDArray[np.float64]) -> Figure:
    """P(0+) against dx^(1/2), each surface and the mean, with the extrapolation to dx -> 0."""
    figure, (axes,) = new_figure()
    root = np.sqrt(dataset.spacing.values)
    for k, row in enumerate(dataset.density_at_zero.values):
        axes.plot(root, row, marker=MARKERS[k % 8], ms=4, lw=0.6, color="0.5")
    mean = dataset.density_at_zero.mean("surface").values
    axes.plot(root, mean, marker="o", color="black", lw=1.5, label="mean over surfaces")
    bend = np.polyfit(root, mean, 2 if root.size > 3 else 1)
    dense = np.linspace(0, root[0], 50)
    axes.plot(dense, np.polyval(bend, dense), ls="--", color="black", lw=1, label="polynomial in dx^(1/2)")
    axes.errorbar(
        [0],
        [intercepts.mean()],
        yerr=[intercepts.std(ddof=1)],
        color="#b45f06",
        marker="s",
        capsize=3,
        label="intercept, spread",
    )
    axes.axhline(0, color="black", lw=0.5)
    axes.set_xlabel(r"$(\Delta x/\lambda_{short})^{1/2}$")
    axes.set_ylabel(r"$P(0^+)\,E^* h'_{rms}$")
    axes.legend(fontsize=8)
    return figure


def fem_against_bem(dataset: xr.Dataset, legs: Sequence[str]) -> Figure:
    """Pressure and area differences between finite and boundary elements against the grid, by leg."""
    figure, panels = new_figure(width=9.0, columns=2)
    for axes, name, label in zip(
        panels,
        ("pressure_half_space", "area"),
        (r"$\|p_{FEM}-p_{BEM}\|/\|p_{BEM}\|$ [%]", r"$|A_{FEM}/A_{BEM}-1|$, counted [%]"),
        strict=True,
    ):
        for k, leg in enumerate(legs):
            part = dataset.isel(case=np.flatnonzero(dataset.leg.values == leg))
            axes.plot(part.points_per_wave, 100 * np.abs(part[name].mean("surface")), label=leg, **_plain(k))
            axes.plot(
                part.points_per_wave, 100 * np.abs(part[name]), ls="", marker=".", ms=3, color=COLOURS[k]
            )
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_xlabel(r"$\lambda_{short}/\Delta x$")
        axes.set_ylabel(label)
    panels[0].legend(fontsize=8)
    return figure


def block_depth(dataset: xr.Dataset) -> Figure:
    """Pressure of the block against half-space and layer, over depth and over growth."""
    figure, panels = new_figure(width=9.0, columns=2)
    for axes, dial, label in zip(
        panels, ("depth", "growth"), ("depth / L", "growth of successive layers"), strict=True
    ):
        for k, element in enumerate(dict.fromkeys(dataset.element.values.tolist())):
            keep = (dataset.element.values == element) & (dataset.varied.values == dial)
            part = dataset.isel(case=np.flatnonzero(keep))
            axes.plot(part[dial], 100 * part.pressure_half_space, label=f"{element}, half-space", **_plain(k))
            axes.plot(
                part[dial],
                100 * part.pressure_layer,
                label=f"{element}, layer",
                mfc="white",
                ls="--",
                **_plain(k),
            )
        axes.set_yscale("log")
        axes.set_xlabel(label)
        axes.set_ylabel("relative L2 difference of pressure [%]")
    panels[0].legend(fontsize=8)
    return figure


def accuracy_cost(
    dataset: xr.Dataset, error: NDArray[np.float64], fronts: Mapping[str, Sequence[int]]
) -> Figure:
    """Error against seconds and against memory for every way, each with its Pareto front."""
    figure, panels = new_figure(width=9.5, columns=2, height=5.6)
    groups: dict[str, list[int]] = {}
    for k, label in enumerate(dataset.label.values.tolist()):
        name = label.split(",")[0] + (", 4 shifts" if label.endswith("shifts") else "")
        groups.setdefault(name, []).append(k)
    floor = 100 * float(np.sqrt((dataset.reference_error**2).mean()))
    for axes, (cost, unit) in zip(panels, (("seconds", 1.0), ("peak_bytes", 2.0**20)), strict=True):
        price = dataset[cost].values / unit
        for g, (name, ways) in enumerate(groups.items()):
            look = {**_plain(g % 8), "mfc": "white" if g >= 8 else COLOURS[g % 8]}
            axes.plot(price[ways], 100 * error[ways], ls="", label=name, **look)
        best = list(fronts[cost])
        axes.plot(price[best], 100 * error[best], color="black", lw=0.8, label="Pareto front")
        axes.axhspan(min(floor, 100 * float(error.min())) / 3, floor, color="black", alpha=0.1, lw=0)
        axes.set_xscale("log")
        axes.set_yscale("log")
    panels[0].set_xlabel("processor time for one surface [s]")
    panels[1].set_xlabel("memory of the largest solve [MiB]")
    panels[0].set_ylabel("rms error of the contact area [%]")
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, fontsize=7, ncols=5, loc="outside lower center")
    return figure


def cost_against_points(dataset: xr.Dataset, lines: Mapping[str, tuple[float, float]]) -> Figure:
    """Seconds, transforms and memory against N, with the powers fitted to them (coefficient, exponent)."""
    figure, panels = new_figure(width=9.5, columns=3, height=3.4)
    labels = {
        "seconds": ("processor time [s]", 1.0),
        "fft_pairs": ("pairs of transforms", 1.0),
        "peak_bytes": ("memory [MiB]", 2.0**20),
    }
    number = dataset.points.values**2.0
    for k, (axes, (name, (label, unit))) in enumerate(zip(panels, labels.items(), strict=True)):
        for column in dataset[name].values.T:
            axes.plot(number, column / unit, ls="", **_plain(k))
        coefficient, exponent = lines[name]
        axes.plot(
            number,
            coefficient * number**exponent / unit,
            color="black",
            lw=0.8,
            label=f"$N^{{{exponent:.2f}}}$",
        )
        axes.set_xscale("log")
        if name != "fft_pairs":
            axes.set_yscale("log")
        axes.set_xlabel("grid points N")
        axes.set_ylabel(label)
        axes.legend(fontsize=8)
    return figure


def multilevel(dataset: xr.Dataset, mean: float) -> Figure:
    """Scatter of the levels against their resolution, and their cost and number of surfaces."""
    figure, (left, right) = new_figure(width=9.0, columns=2, height=3.6)
    level = np.arange(dataset.sizes["level"])
    grids = [f"{n:g}" for n in dataset.points_per_wave.values]
    names = [grids[0], *(f"{b} - {a}" for a, b in itertools.pairwise(grids))]
    left.plot(level, 100 * np.sqrt(dataset.variance.values) / mean, label="term of the sum", **_plain(0))
    alone = 100 * float(np.sqrt(dataset.attrs["finest_variance"])) / mean
    left.axhline(alone, color="black", lw=0.8, label="area on the finest grid")
    left.set_ylabel("scatter between surfaces [%]")
    right.plot(level, dataset.cost.values, label="seconds for one surface", **_plain(1))
    right.plot(level, dataset.surfaces.values, label="surfaces", **_plain(2))
    right.set_ylabel("seconds; surfaces")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xticks(level, names)
        axes.set_xlabel("points per shortest wave")
        axes.legend(fontsize=8)
    return figure
