"""Figures of a comparison. They read numbers and stored fields and never solve."""

from __future__ import annotations

import itertools
import re
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from validation.figure_data import NEAR_ZERO
from validation.findings import significant, with_error

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from fem_contact.contact import ContactResult
    from validation.comparison import Comparison

__all__ = [
    "area_figure",
    "cost_figure",
    "embeddable",
    "lines_figure",
    "pressure_at_zero_figure",
    "pressure_maps_figure",
    "save_figure",
]

#: One look for every figure; markers and line styles differ, so that it reads in black and white.
_STYLE: Any = {
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    # Letters as shapes: as text, a prime comes out as whatever the reader's font has in its place.
    "svg.fonttype": "path",
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


_MARKERS = [("#0b5394", "o"), ("#b45f06", "s"), ("#38761d", "^"), ("#674ea7", "D")]
_STYLES = ["-", "--", "-.", ":"]
_FILLS = [None, None, None, None, "white", "white", "white", "white"]


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; the suffix says the format."""
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with matplotlib.rc_context(_STYLE):
        figure.savefig(path, dpi=150, metadata=undated.get(path.suffix))


def embeddable(svg: str, name: str) -> str:
    """Return an SVG for an HTML page: without its XML head, and with names that no other figure there has."""
    drawing = svg[svg.index("<svg") :]
    drawing = re.sub(r'\bid="', f'id="{name}-', drawing)
    drawing = re.sub(r'(xlink:href="|href="|url\()#', rf"\1#{name}-", drawing)
    return drawing.replace("<svg", f'<svg role="img" aria-label="{name}"', 1)


def lines_figure(
    data: xr.Dataset,
    *,
    x: str,
    lines: Sequence[str],
    along: str | None = None,
    logarithmic: str = "",
    reference: dict[str, float] | None = None,
) -> Figure:
    """Lines of a dataset with error bars, in markers and styles that read in black and white.

    Parameters
    ----------
    data : xarray.Dataset
        Variables with `units` and `long_name`; a variable `<line>_error` is its standard error.
    x : str
        Coordinate or variable along the axis.
    lines : sequence of str
        Variables to draw; their words are the legend. The axis is what the words of all begin with, or else
        those of the first.
    along : str, optional
        Second dimension; one line is drawn for each of its values.
    logarithmic : str
        "x", "y" or "xy".
    reference : dict of str to float, optional
        Horizontal lines, by words.
    """
    figure, (axes,) = new_figure()
    looks: Iterator[dict[str, Any]] = itertools.cycle(
        {"color": colour, "marker": marker, "ls": style, "mfc": fill}
        for (colour, marker), style, fill in zip(_MARKERS * 2, _STYLES * 2, _FILLS, strict=True)
    )
    for name in lines:
        values = [None] if along is None else list(data[along].values)
        for value in values:
            here = data if value is None else data.sel({along: value})
            look = next(looks)
            words = str(data[name].attrs.get("long_name", name))
            label = words if value is None else f"{words}, {along} = {value:g}"
            error = here[f"{name}_error"].values if f"{name}_error" in data else None
            axes.errorbar(here[x].values, here[name].values, yerr=error, capsize=2, label=label, **look)
    for k, (words, level) in enumerate((reference or {}).items()):
        axes.axhline(level, color="black", lw=1, ls=_STYLES[k % 4], label=words)
    if "x" in logarithmic:
        axes.set_xscale("log")
    if "y" in logarithmic:
        axes.set_yscale("log")
    axes.set_xlabel(_labelled(data[x], x))
    axes.set_ylabel(_common_label(data, lines))
    axes.legend(fontsize=7)
    return figure


def _common_label(data: xr.Dataset, lines: Sequence[str]) -> str:
    """Words that all lines begin with, or else those of the first, wrapped to the height of a figure."""
    each = [str(data[name].attrs.get("long_name", name)).replace(",", " ,").split() for name in lines]
    common = [words[0] for words in itertools.takewhile(lambda w: len(set(w)) == 1, zip(*each, strict=False))]
    words = " ".join(common).replace(" ,", ",").strip(" ,")
    first = data[lines[0]]
    if len(lines) == 1 or not words:
        return textwrap.fill(_labelled(first, lines[0]), 44)
    return _labelled(first.assign_attrs(long_name=words), lines[0])


def _labelled(variable: xr.DataArray, name: str) -> str:
    words, unit = variable.attrs.get("long_name", name), variable.attrs.get("units", "1")
    return f"{words} [{unit}]" if unit != "1" else f"{words} [-]"


def new_figure(width: float = 5.0, height: float = 3.7, columns: int = 1) -> tuple[Figure, list[Axes]]:
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
    return figure, list(axes)


def area_figure(comparison: Comparison) -> Figure:
    """Contact area against grid spacing: pixel, corrected, limit and theory, FEM beside BEM."""
    figure, (axes,) = new_figure()
    for (method, name), look in _LOOK.items():
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
    _powers_of_two(axes, [1 / row.points_per_wave for row in comparison.rows])
    axes.set_xlabel(r"grid spacing over shortest wavelength, $\Delta x/\lambda_{short}$")
    axes.set_ylabel(r"relative contact area $A/A_0$")
    axes.legend(fontsize=7)
    return figure


def _powers_of_two(axes: Axes, spacings: list[float]) -> None:
    """Label a spacing as 1/n, which is how people name a grid."""
    ticks = sorted({2.0 ** round(np.log2(s)) for s in spacings})
    axes.set_xticks(ticks, [f"1/{round(1 / t)}" if t < 1 else f"{t:g}" for t in ticks])
    axes.minorticks_off()


def pressure_at_zero_figure(data: xr.Dataset) -> Figure:
    """P(sigma) near zero on each grid against Persson's closed form, from `pressure_at_zero_data`."""
    figure, (axes,) = new_figure()
    curve = data["curve"].values
    labels = [label for label in dict.fromkeys(curve) if label != "Persson"]
    shades = np.linspace(0.75, 0.0, max(len(labels), 2))
    styles = ["-", "--", "-.", ":"]
    for k, label in enumerate(labels):
        here = data.isel(bin=curve == label)
        edges = np.append(here["lower"].values, here["upper"].values[-1])
        colour = "#b45f06" if label.startswith("FEM") else str(shades[k])
        axes.stairs(here["density"].values, edges, color=colour, ls=styles[k % 4], label=label, baseline=None)
    theory = data.isel(bin=curve == "Persson")
    if theory.sizes["bin"]:
        axes.plot(theory["lower"], theory["density"], color="#38761d", lw=2, label="Persson")
    axes.set_xlim(min(0.0, float(data["lower"].min())), NEAR_ZERO)
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
    for (method, name), look in _LOOK.items():
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
    figure, axes = new_figure(width=3.3 * max(len(results), 1), height=3.1, columns=max(len(results), 1))
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
        figure.colorbar(image, ax=axes, label=r"$p / (E^* h'_{rms})$, white: no contact", shrink=0.85)
    return figure
