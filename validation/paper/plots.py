"""Draw the figures of the paper. They read numbers and never solve."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from validation.paper.figures import PaperFigure

__all__ = ["draw", "save"]

#: Line styles differ besides colours, so that figures read in black and white.
_LINES: tuple[dict[str, Any], ...] = (
    {"color": "#0b5394", "ls": "-"},
    {"color": "#b45f06", "ls": "--"},
    {"color": "#38761d", "ls": "-."},
    {"color": "#741b47", "ls": ":"},
)
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "fem-contact",
}


def draw(figure: PaperFigure) -> Figure:
    """Draw the panels of a figure side by side."""
    columns = len(figure.panels)
    with matplotlib.rc_context(STYLE):
        drawing = Figure(figsize=(5.2 * columns, 4.0), layout="constrained")
        drawing.suptitle(figure.title, fontsize=11)
        for index, panel in enumerate(figure.panels):
            axes = drawing.add_subplot(1, columns, index + 1)
            for curve, line in zip(panel.curves, _LINES * 2, strict=False):
                axes.plot(curve.x, curve.y, label=curve.label, lw=1.6, **line)
            axes.set(xlabel=panel.x, ylabel=panel.y, xscale=panel.x_scale, yscale=panel.y_scale)
            if len(panel.curves) > 1:
                axes.legend(fontsize=8)
    return drawing


def save(figure: PaperFigure, folder: Path) -> tuple[Path, Path]:
    """Write a figure as PNG and SVG; the same numbers give the same bytes."""
    drawing = draw(figure)
    paths = folder / f"{figure.name}.png", folder / f"{figure.name}.svg"
    with matplotlib.rc_context(STYLE):
        drawing.savefig(paths[0], dpi=140)
        drawing.savefig(paths[1], metadata={"Date": None})
    return paths
