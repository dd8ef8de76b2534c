"""The figures of the paper as drawings of a report. They read numbers and never solve."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from validation.paper.figures import PaperFigure
from validation.report.drawing import Drawing
from validation.report.figure import COLOURS, STYLES, new_figure
from validation.report.words import mathtext

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from validation.paper.figures import Panel

__all__ = ["drawn"]


#: How the paper's symbols are typed, longest first, and how they are drawn.
_SYMBOLS = {
    "sigma_0": r"$\sigma_0$",
    "sigma_Y": r"$\sigma_Y$",
    "sigma_a": r"$\sigma_a$",
    "Delta gamma": r"$\Delta\gamma$",
    "gamma_eff": r"$\gamma_{eff}$",
    "zeta_1": r"$\zeta_1$",
    "sigma": r"$\sigma$",
    "zeta": r"$\zeta$",
    "A_0": "$A_0$",
    "A_el": "$A_{el}$",
    "A_pl": "$A_{pl}$",
    "h_0": "$h_0$",
    "E*": "$E^*$",
}


def drawn(figure: PaperFigure) -> Drawing:
    """Draw the panels of a figure side by side, with their numbers."""
    columns = len(figure.panels)
    drawing, axes = new_figure(width=5.2 * columns, height=4.0, columns=columns)
    for panel, place in zip(figure.panels, axes, strict=True):
        _draw(place, panel)
    curves = ", ".join(dict.fromkeys(curve.label for panel in figure.panels for curve in panel.curves))
    against = "; ".join(f"{_words(panel.y)} against {_words(panel.x)}" for panel in figure.panels)
    return Drawing(
        name=figure.name.replace("_", "-"),
        figure=drawing,
        data=_numbers(figure),
        caption=f"{figure.title}. {against}. Curves: {curves}.",
    )


def _draw(axes: Axes, panel: Panel) -> None:
    for k, curve in enumerate(panel.curves):
        look: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)], "ls": STYLES[k % len(STYLES)]}
        axes.plot(curve.x, curve.y, label=_typeset(curve.label), lw=1.6, **look)
    axes.set(xlabel=_typeset(panel.x), ylabel=_typeset(panel.y), xscale=panel.x_scale, yscale=panel.y_scale)
    if len(panel.curves) > 1:
        axes.legend(fontsize=8)


def _words(label: str) -> str:
    """Return an axis as the text names it."""
    return label.replace("sigma_0", "p0").replace("A / A_0", "A/A0")


def _typeset(label: str) -> str:
    """Return an axis with its symbols as in a book."""
    return mathtext(re.sub("|".join(map(re.escape, _SYMBOLS)), lambda typed: _SYMBOLS[typed[0]], label))


def _numbers(figure: PaperFigure) -> xr.Dataset:
    """Return every point of every curve, one after the other."""
    import xarray as xr

    rows = [
        (number, curve.label, float(x), float(y), panel.x, panel.y)
        for number, panel in enumerate(figure.panels, start=1)
        for curve in panel.curves
        for x, y in zip(curve.x, curve.y, strict=True)
    ]
    words = {
        "panel": "panel, from the left",
        "curve": "curve",
        "x": "along the axis that x_axis names",
        "y": "along the axis that y_axis names",
        "x_axis": "horizontal axis, with its unit",
        "y_axis": "vertical axis, with its unit",
    }
    columns = zip(words.items(), zip(*rows, strict=True), strict=True)
    return xr.Dataset(
        {name: ("point", list(values), {"units": "1", "long_name": said}) for (name, said), values in columns}
    )
