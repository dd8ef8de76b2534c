"""Figures of a comparison. They read numbers and stored fields and never solve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from fem_contact.stress import pressure_distribution
from persson import elastic

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fem_contact.contact import ContactResult
    from validation.comparison import Comparison

__all__ = ["area_figure", "cost_figure", "pressure_at_zero_figure", "pressure_maps_figure", "save_figure"]

#: One look for every figure; markers and line styles differ, so that it reads in black and white.
_STYLE: Any = {
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "fem-contact",
}
_LOOK: dict[tuple[str, str], dict[str, Any]] = {
    ("bem", "pixel"): {"color": "#0b5394", "marker": "o", "ls": "-", "label": "BEM, pixel count"},
    ("bem", "perimeter"): {
        "color": "#0b5394",
        "marker": "o",
        "mfc": "white",
        "ls": "--",
        "label": "BEM, perimeter-corrected",
    },
    ("fem", "pixel"): {"color": "#b45f06", "marker": "s", "ls": "-", "label": "FEM, pixel count"},
    ("fem", "perimeter"): {
        "color": "#b45f06",
        "marker": "s",
        "mfc": "white",
        "ls": "--",
        "label": "FEM, perimeter-corrected",
    },
}


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix says the format."""
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, dpi=150, metadata={"Date": None} if path.suffix == ".svg" else None)


def _figure(width: float = 6.4, height: float = 4.2, columns: int = 1) -> tuple[Figure, list[Axes]]:
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
    return figure, list(axes)


def area_figure(comparison: Comparison) -> Figure:
    """Contact area against grid spacing: pixel, corrected, limit and theory, FEM beside BEM."""
    figure, (axes,) = _figure()
    for (method, name), look in _LOOK.items():
        rows = comparison.rows_of(method)
        if rows:
            spacing = [1 / row.points_per_wave for row in rows]
            scatter = [row.pixel_scatter if name == "pixel" else 0.0 for row in rows]
            axes.errorbar(spacing, [getattr(row, name) for row in rows], yerr=scatter, capsize=2, **look)
    limit, theory = comparison.limit, comparison.theory
    if limit is not None:
        axes.axhline(
            limit.value, color="black", lw=1, label=f"limit {limit.value:.4f} $\\pm$ {limit.uncertainty:.4f}"
        )
        axes.axhspan(
            limit.value - limit.uncertainty, limit.value + limit.uncertainty, color="black", alpha=0.12, lw=0
        )
    if theory is not None:
        axes.axhline(
            theory.area,
            color="#38761d",
            ls="-.",
            label=f"Persson, this surface's gradient: {theory.area:.4f}",
        )
        if theory.ensemble_area is not None:
            axes.axhline(
                theory.ensemble_area,
                color="#38761d",
                ls=":",
                label=f"Persson, from C(q): {theory.ensemble_area:.4f}",
            )
    axes.set_xscale("log", base=2)
    _powers_of_two(axes, [1 / row.points_per_wave for row in comparison.rows])
    axes.set_xlabel(r"grid spacing over shortest wavelength, $\Delta x/\lambda_{short}$")
    axes.set_ylabel(r"relative contact area $A/A_0$")
    axes.legend(fontsize=8)
    return figure


def _powers_of_two(axes: Axes, spacings: list[float]) -> None:
    """Label a spacing as 1/n, which is how people name a grid."""
    ticks = sorted({2.0 ** round(np.log2(s)) for s in spacings})
    axes.set_xticks(ticks, [f"1/{round(1 / t)}" if t < 1 else f"{t:g}" for t in ticks])
    axes.minorticks_off()


def pressure_at_zero_figure(comparison: Comparison, results: dict[str, list[ContactResult]]) -> Figure:
    """P(sigma) near zero on each grid against Persson's closed form.

    Parameters
    ----------
    comparison : Comparison
    results : dict of str to list of ContactResult
        Solves to show, by label, coarse to fine; the shifts of one grid are averaged.
    """
    figure, (axes,) = _figure()
    unit = comparison.contact_modulus * comparison.rms_gradient
    shades = np.linspace(0.75, 0.0, max(len(results), 2))
    styles = ["-", "--", "-.", ":"]
    for k, (label, solves) in enumerate(results.items()):
        points = sum(np.count_nonzero(result.in_contact) for result in solves)
        bins = min(48, max(8, int(np.sqrt(points) / 2)))
        edges = np.linspace(0, 0.6, bins + 1) * unit
        density = np.mean([pressure_distribution(result, edges).density for result in solves], axis=0)
        colour = "#b45f06" if label.startswith("FEM") else str(shades[k])
        axes.stairs(density * unit, edges / unit, color=colour, ls=styles[k % 4], label=label, baseline=None)
    if comparison.theory is not None:
        stress = np.linspace(0, 0.6, 200)
        density = elastic.pressure_distribution(
            stress * unit, pressure=comparison.pressure, stress_variance=comparison.theory.stress_variance
        )
        axes.plot(stress, density * unit, color="#38761d", lw=2, label="Persson")
    axes.set_xlim(0, 0.6)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"pressure $\sigma / (E^* h'_{rms})$")
    axes.set_ylabel(r"$P(\sigma)\, E^* h'_{rms}$ per nominal area")
    axes.legend(fontsize=8)
    return figure


def cost_figure(comparison: Comparison) -> Figure:
    """Error of the area against seconds for every method and definition, the theory included."""
    figure, (axes,) = _figure()
    limit = comparison.limit
    if limit is None or limit.value == 0:
        axes.text(0.5, 0.5, "no limit: the error is not determinable", ha="center", transform=axes.transAxes)
        return figure
    floor = max(limit.uncertainty / limit.value, 1e-6)
    for (method, name), look in _LOOK.items():
        rows = comparison.rows_of(method)
        if rows:
            errors = [max(abs(getattr(row, name) / limit.value - 1), 1e-6) for row in rows]
            axes.plot([row.seconds for row in rows], errors, **look)
    if comparison.theory is not None:
        distance = max(abs(comparison.theory.area / limit.value - 1), 1e-6)
        axes.axhline(distance, color="#38761d", ls="-.", label="Persson (under a millisecond)")
    axes.axhspan(
        axes.get_ylim()[0], floor, color="black", alpha=0.12, lw=0, label="below the uncertainty of the limit"
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("wall time of the solves behind a point [s]")
    axes.set_ylabel(r"$|A/A_{limit} - 1|$")
    axes.legend(fontsize=8)
    return figure


def pressure_maps_figure(comparison: Comparison, results: dict[str, ContactResult]) -> Figure:
    """Pressure maps of the solvers on the same surface, on one colour scale."""
    figure, axes = _figure(width=4.2 * max(len(results), 1), height=4.0, columns=max(len(results), 1))
    unit = comparison.contact_modulus * comparison.rms_gradient
    top = max((float(result.pressure.max()) for result in results.values()), default=unit) / unit
    image = None
    for panel, (label, result) in zip(axes, results.items(), strict=False):
        pressure = np.where(result.in_contact, result.pressure / unit, np.nan)
        extent = (0, result.lengths[0] * 1e6, 0, result.lengths[1] * 1e6)
        image = panel.imshow(
            pressure.T,
            origin="lower",
            extent=extent,
            vmin=0,
            vmax=top,
            cmap="viridis_r",
            interpolation="nearest",
        )
        panel.set_title(label, fontsize=10)
        panel.set_xlabel(r"x [$\mu$m]")
        panel.grid(visible=False)
    axes[0].set_ylabel(r"y [$\mu$m]")
    if image is not None:
        figure.colorbar(image, ax=axes, label=r"$p / (E^* h'_{rms})$, white: no contact", shrink=0.85)
    return figure
