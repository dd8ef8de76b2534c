"""Figures of a comparison. They read numbers and stored fields and never solve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from validation.report.figure import looks, new_figure
from validation.report.words import significant, with_error

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from fem_contact.contact import ContactResult
    from validation.comparison.compared import Comparison

__all__ = [
    "area_figure",
    "below_figure",
    "cost_figure",
    "pressure_at_zero_figure",
    "pressure_maps_figure",
    "spacings_as_fractions",
]


def _looks(comparison: Comparison) -> dict[tuple[str, str], dict[str, Any]]:
    return looks({name: solver.label for name, solver in comparison.scene.methods.solvers.items()})


def area_figure(comparison: Comparison) -> Figure:
    """Contact area against grid spacing: pixel, corrected, limit and theory, FEM beside BEM."""
    figure, (axes,) = new_figure()
    for (method, name), look in _looks(comparison).items():
        rows = comparison.rows_of(method)
        if rows:
            spacing = [1 / row.points_per_wave for row in rows]
            scatter = [row.pixel_scatter if name == "pixel" else 0.0 for row in rows]
            axes.errorbar(spacing, [getattr(row, name) for row in rows], yerr=scatter, capsize=2, **look)
    limit, theory = comparison.limit, comparison.theory
    if limit is not None:
        axes.axhline(
            limit.value,
            color="black",
            lw=1,
            label=f"limit {with_error(limit.value, limit.uncertainty)}".replace("+-", r"$\pm$"),
        )
        axes.axhspan(
            limit.value - limit.uncertainty, limit.value + limit.uncertainty, color="black", alpha=0.12, lw=0
        )
    if theory is not None and theory.answers:
        axes.axhline(
            theory.area,
            color="#38761d",
            ls="-.",
            label=f"Persson, this surface's gradient: {significant(theory.area)}",
        )
        if theory.ensemble_area is not None:
            axes.axhline(
                theory.ensemble_area,
                color="#38761d",
                ls=":",
                label=f"Persson, from C(q): {significant(theory.ensemble_area)}",
            )
    axes.set_xscale("log", base=2)
    spacings_as_fractions(axes, [1 / row.points_per_wave for row in comparison.rows])
    axes.set_xlabel(r"grid spacing over shortest wavelength, $\Delta x/\lambda_{short}$")
    axes.set_ylabel(r"relative contact area $A/A_0$")
    axes.legend(fontsize=7)
    return figure


def spacings_as_fractions(axes: Axes, spacings: list[float]) -> None:
    """Label a spacing as 1/n, which is how people name a grid."""
    ticks = sorted({2.0 ** round(np.log2(s)) for s in spacings})
    axes.set_xticks(ticks, [f"1/{round(1 / t)}" if t < 1 else f"{t:g}" for t in ticks])
    axes.minorticks_off()


def pressure_at_zero_figure(data: xr.Dataset, *, logarithmic: bool = False) -> Figure:
    """P(sigma) on each grid beside Persson's theory, from `pressure_at_zero_data`."""
    figure, (axes,) = new_figure()
    curve = data["curve"].values
    labels = [label for label in dict.fromkeys(curve) if label != "Persson"]
    grey = [label for label in labels if not label.startswith("FEM")]
    shades = dict(
        zip(grey, np.linspace(0.75, 0.0, max(len(grey), 2))[-len(grey) :], strict=True)
    )  # the finest is black
    styles = ["-", "--", "-.", ":"]
    for k, label in enumerate(labels):
        here = data.isel(bin=curve == label)
        edges = np.append(here["lower"].values, here["upper"].values[-1])
        colour = str(shades[label]) if label in shades else "#b45f06"
        axes.stairs(here["density"].values, edges, color=colour, ls=styles[k % 4], label=label, baseline=None)
    theory = data.isel(bin=curve == "Persson")
    if theory.sizes["bin"]:
        axes.plot(theory["lower"], theory["density"], color="#38761d", lw=2, label="Persson")
    axes.set_xlim(min(0.0, float(data["lower"].min())), float(data["upper"].max()))
    if logarithmic:
        density = data["density"].values[curve != "Persson"]
        axes.set_yscale("log")
        axes.set_ylim(bottom=0.5 * float(np.min(density[density > 0], initial=1.0)))
    else:
        axes.set_ylim(bottom=0)
    axes.set_xlabel(r"pressure $\sigma / (E^* h'_{rms})$")
    axes.set_ylabel(r"$P(\sigma)\, E^* h'_{rms}$ per nominal area")
    axes.legend(fontsize=7)
    return figure


def cost_figure(comparison: Comparison) -> Figure:
    """Error of the area against seconds for every method and definition, the theory included."""
    figure, (axes,) = new_figure()
    limit = comparison.limit
    if limit is None or limit.value == 0:
        axes.text(0.5, 0.5, "no limit: the error is not determinable", ha="center", transform=axes.transAxes)
        return figure
    floor = max(limit.uncertainty / limit.value, 1e-6)
    for (method, name), look in _looks(comparison).items():
        rows = comparison.rows_of(method)
        if rows:
            errors = [max(abs(getattr(row, name) / limit.value - 1), 1e-6) for row in rows]
            axes.plot([row.seconds for row in rows], errors, **look)
    if comparison.theory is not None and comparison.theory.answers:
        distance = max(abs(comparison.theory.area / limit.value - 1), 1e-6)
        axes.axhline(distance, color="#38761d", ls="-.", label="Persson")
    axes.axhspan(
        axes.get_ylim()[0], floor, color="black", alpha=0.12, lw=0, label="below the uncertainty of the limit"
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("wall time of the solves behind a point [s]")
    axes.set_ylabel(r"$|A/A_{limit} - 1|$")
    axes.legend(fontsize=7)
    return figure


def pressure_maps_figure(comparison: Comparison, results: dict[str, ContactResult]) -> Figure:
    """Pressure maps of the solvers on the same surface, on one colour scale."""
    pair = _same_points(results)
    columns = max(len(results), 1) + bool(pair)
    figure, axes = new_figure(width=3.4 * columns, height=3.1, columns=columns)
    unit = comparison.contact_modulus * comparison.rms_gradient
    top = max((float(result.pressure.max()) for result in results.values()), default=unit) / unit
    pulled = [float(result.pressure[result.in_contact].min(initial=0.0)) for result in results.values()]
    image = None
    for panel, (label, result) in zip(axes, results.items(), strict=False):
        pressure = np.where(result.in_contact, result.pressure / unit, np.nan)
        extent = (0, result.lengths[0] * 1e6, 0, result.lengths[1] * 1e6)
        image = panel.imshow(
            pressure.T,
            origin="lower",
            extent=extent,
            vmin=min([0.0, *pulled]) / unit,
            vmax=top,
            cmap="viridis_r",
            interpolation="nearest",
        )
        panel.set_title(label, fontsize=10)
        panel.set_xlabel(r"x [$\mu$m]")
        panel.grid(visible=False)
    axes[0].set_ylabel(r"y [$\mu$m]")
    if image is not None:
        maps = axes[: len(results)]
        figure.colorbar(image, ax=maps, label=r"$p / (E^* h'_{rms})$, white: no contact", shrink=0.85)
    if pair:
        _difference_map(axes[-1], *pair, unit=unit)
    return figure


def _same_points(results: dict[str, ContactResult]) -> tuple[ContactResult, ...]:
    """Return the boundary and the finite elements of one grid, or nothing."""
    pair = tuple(result for _, result in sorted(results.items()))
    return pair if len(pair) == 2 and pair[0].shape == pair[1].shape else ()


def _difference_map(axes: Axes, bem: ContactResult, fem: ContactResult, *, unit: float) -> None:
    """Draw the pressure of the finite less that of the boundary elements, point by point."""
    touched = bem.in_contact | fem.in_contact
    difference = np.where(touched, (fem.pressure - bem.pressure) / unit, np.nan)
    top = float(np.abs(difference[touched]).max(initial=0.0)) or 1.0
    extent = (0, bem.lengths[0] * 1e6, 0, bem.lengths[1] * 1e6)
    look: dict[str, Any] = {"origin": "lower", "extent": extent, "interpolation": "nearest"}
    image = axes.imshow(difference.T, vmin=-top, vmax=top, cmap="RdBu_r", **look)
    axes.set_title("FEM - BEM", fontsize=10)
    axes.set_xlabel(r"x [$\mu$m]")
    axes.grid(visible=False)
    axes.figure.colorbar(image, ax=axes, label=r"$\Delta p / (E^* h'_{rms})$", shrink=0.85)


def below_figure(data: xr.Dataset) -> Figure:
    """Von Mises stress over depth: the largest on each plane, and the root mean square."""
    figure, (axes,) = new_figure()
    for k, solver in enumerate(dict.fromkeys(data.solver.values)):
        at = data.isel(plane=data.solver.values == solver)
        # A logarithmic axis has no surface.
        depth = np.where(at.depth > 0, at.depth, np.nan) / data.attrs["lambda_short"]
        for name, style, words in (("largest", "-", "largest"), ("rms", "--", "root mean square")):
            axes.plot(depth, at[name] / data.attrs["unit"], style, color=f"C{k}", label=f"{solver}, {words}")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(r"depth over shortest wavelength, $z/\lambda_{short}$")
    axes.set_ylabel(r"von Mises stress $\sigma_v / (E^* h'_{rms})$")
    axes.legend(loc="upper right")
    return figure
