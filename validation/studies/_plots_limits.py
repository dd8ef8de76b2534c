"""Figures of the studies that compare limits with the theory. They read a study's dataset and never solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from persson.elastic import KAPPA_BGT, persson_kappa, pressure_distribution, stress_variance
from validation.measures.references import KAPPA_LITERATURE
from validation.measures.theory_energy import VARIANTS
from validation.report.figure import COLOURS, THEORY, look, new_figure
from validation.report.figure import SYMBOLS as MARKERS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from validation.measures.ladders import Rungs
    from validation.measures.load_independence import Distance
    from validation.measures.statistics import Estimate

__all__ = [
    "area_against_pressure",
    "gap_and_energy",
    "kappa_against_hurst",
    "kappa_ladders",
    "load_independence",
    "patches_on_grids",
    "slope_at_zero",
    "stress_on_grids",
    "theory_verdict",
]

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
        if np.mean(value) * loads[j] < _LIGHT:
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


_LOAD = r"$p^* = p_0/(E^* h'_{rms})$"
_VARIANT_LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "#38761d", "ls": "-."},
    {"color": "0.4", "ls": "--"},
    {"color": "0.4", "ls": (0, (5, 1, 1, 1))},
    {"color": "0.4", "ls": (0, (1, 1))},
)


def _variants(axes: Axes, dataset: xr.Dataset, name: str, over: NDArray[np.float64] | float = 1.0) -> None:
    """Draw a quantity of every variant that has it; the original also from C(q) alone."""
    for v, variant in enumerate(dataset.variant.values):
        values = dataset[name].sel(mode="conditional", variant=variant).values / over
        if np.isfinite(values).any():
            axes.plot(dataset.reduced_pressure, values, lw=1.2, label=VARIANTS[variant], **_VARIANT_LOOKS[v])
    ensemble = dataset[name].sel(mode="ensemble", variant="persson").values / over
    axes.plot(
        dataset.reduced_pressure,
        ensemble,
        color=THEORY["color"],
        ls="--",
        lw=0.7,
        label="Persson, C(q) alone",
    )


def area_against_pressure(dataset: xr.Dataset) -> Figure:
    """A/A0 against p*, and its ratio to the theory."""
    figure, (left, right) = new_figure(width=9.0, height=4.0, columns=2)
    persson = dataset.theory_area.sel(mode="conditional", variant="persson").values
    for axes, over in ((left, 1.0), (right, persson)):
        area = dataset.area / over
        axes.errorbar(
            dataset.reduced_pressure,
            area.mean("surface"),
            yerr=area.std("surface", ddof=1),
            ls="",
            label="simulation, limit",
            **look(0),
        )
        _variants(axes, dataset, "theory_area", over)
        axes.set_xscale("log")
        axes.set_xlabel(_LOAD)
        axes.legend(fontsize=7)
    left.set_yscale("log")
    left.set_ylabel(r"$A/A_0$")
    right.set_ylabel("area over Persson's, conditional")
    return figure


def gap_and_energy(dataset: xr.Dataset) -> Figure:
    """Mean gap, inverse stiffness and elastic energy against load, with the theory."""
    figure, panels = new_figure(width=11.0, height=3.8, columns=3)
    labels = {
        "gap": r"mean gap $/ h_{rms}$",
        "gamma": r"$p_0 / (K h_{rms})$",
        "energy": "elastic energy over that of full contact",
    }
    for k, (axes, (name, label)) in enumerate(zip(panels, labels.items(), strict=True)):
        axes.errorbar(
            dataset.reduced_pressure,
            dataset[name].mean("surface"),
            yerr=dataset[name].std("surface", ddof=1),
            ls="",
            label="simulation",
            **look(k),
        )
        _variants(axes, dataset, f"theory_{name}")
        axes.set_ylabel(label)
        axes.set_xscale("log")
        axes.set_xlabel(_LOAD)
    panels[2].set_yscale("log")
    panels[0].legend(fontsize=7)
    return figure


def load_independence(
    dataset: xr.Dataset, distances: Mapping[str, Distance], theory: NDArray[np.float64], reference: int
) -> Figure:
    """Draw the distributions per contact area at several loads, and how far they are from that at the reference load."""
    figure, (left, middle, right) = new_figure(width=11.0, height=3.8, columns=3)
    area = dataset.area.mean("surface").values
    last = max(reference + 1, int(np.sum(area < 0.9)))
    shades = np.linspace(0.75, 0.0, max(1, last - reference))
    for k, j in enumerate(range(reference, last)):
        stress = dataset.stress_share[:, j].sum("surface").values
        patches = dataset.patch_area_share[:, j].sum("surface").values
        style: dict[str, Any] = {"color": str(shades[k]), "ls": ("-", "--", "-.", ":")[k % 4], "lw": 1.1}
        width = np.diff(np.concatenate([[0.0], dataset.stress_upper.values]))
        density = (stress / stress.sum() / width).reshape(-1, 4).mean(axis=1)
        left.plot(
            dataset.stress_upper.values.reshape(-1, 4).mean(axis=1),
            density,
            label=f"A/A0 = {area[j]:.2g}",
            **style,
        )
        middle.plot(dataset.patch_upper, np.cumsum(patches) / patches.sum(), **style)
    left.set_xlim(0, 2.5)
    left.set_ylim(bottom=0)
    left.set_xlabel(r"$\sigma / (E^* h'_{rms})$")
    left.set_ylabel(r"$P(\sigma)\,E^* h'_{rms}\,A_0/A$")
    left.legend(fontsize=7)
    middle.set_xscale("log")
    middle.set_xlabel(r"$A_{patch} / \lambda_{short}^2$")
    middle.set_ylabel("share of the contact area in smaller patches")
    for k, (name, distance) in enumerate(distances.items()):
        # A bootstrap interval need not hold the value itself, which is the least of its kind.
        bars = np.maximum([distance.value - distance.low, distance.high - distance.value], 0.0)
        right.errorbar(area, distance.value, yerr=bars, ls="-", label=name, **look(k))
        right.plot(area, distance.noise, color=COLOURS[k], ls=":", lw=0.8)
    right.plot(area, theory, label="pressure, Persson's own", **THEORY)
    right.set_xscale("log")
    right.set_xlabel(r"$A/A_0$")
    right.set_ylabel(f"distance from A/A0 = {area[reference]:.2g}")
    right.set_ylim(0, 0.5)
    right.legend(fontsize=7)
    return figure


def theory_verdict(dataset: xr.Dataset, words: Sequence[str]) -> Figure:
    """Draw simulated over predicted values against the simulated area, one panel for each quantity."""
    figure, panels = new_figure(width=3.2 * len(words), height=4.0, columns=len(words))
    for q, (axes, title) in enumerate(zip(panels, words, strict=True)):
        for v, variant in enumerate(dataset.variant.values):
            ratio, half = dataset.ratio[q, v], dataset.interval[q, v]
            # A ratio of two vanishing gaps is drawn by nobody's eye: leave out what is not known to a factor of two.
            known = np.isfinite(ratio.values) & (half.values < 0.5)
            if known.any():
                axes.errorbar(
                    dataset.area[known],
                    ratio[known],
                    yerr=half[known],
                    label=VARIANTS[variant],
                    lw=1,
                    **look(v),
                )
        axes.axhline(1, color="black", lw=1)
        axes.set_xscale("log")
        axes.set_xlabel(r"simulated $A/A_0$")
        axes.set_title(title, fontsize=9)
    theory = dataset.theory_area.sel(variant="persson")
    ensemble = dataset.ratio[0, 0] * theory.sel(mode="conditional") / theory.sel(mode="ensemble")
    panels[0].plot(dataset.area, ensemble, color=COLOURS[0], ls="--", lw=0.7, label="Persson, C(q) alone")
    panels[0].set_ylabel("simulated over predicted")
    panels[0].legend(fontsize=7)
    return figure


def slope_at_zero(dataset: xr.Dataset, window: Estimate, contour: Estimate) -> Figure:
    """Draw the slope of P(sigma) at zero against the spacing, by both ways, with the limits and the theory."""
    figure, (axes,) = new_figure()
    root = np.sqrt(dataset.spacing.values)
    ways = (
        ("slope", window, "density in a closing window"),
        ("contour_slope", contour, r"$2 S\langle B^{-2}\rangle$"),
    )
    for k, (name, limit, label) in enumerate(ways):
        values = dataset[name]
        error = values.std("surface", ddof=1) / np.sqrt(dataset.sizes["surface"])
        axes.errorbar(root, values.mean("surface"), yerr=error, label=label, **{**look(k), "mfc": "white"})
        axes.errorbar([-0.004 * k], [limit.value], yerr=[limit.half_width], ls="", **look(k))
    axes.axhline(float(dataset.attrs["persson_slope"]), label="Persson", **THEORY)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"$(\Delta x/\lambda_{short})^{1/2}$")
    axes.set_ylabel(r"$P'(0)\,(E^* h'_{rms})^2$")
    axes.legend(fontsize=8)
    return figure
