"""How figures look, and how they are saved."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import matplotlib.figure
import numpy as np
from matplotlib.ticker import (
    FuncFormatter,
    LogFormatterSciNotation,
    LogLocator,
    MaxNLocator,
    NullFormatter,
    StrMethodFormatter,
)

from validation.errors import harmless

if TYPE_CHECKING:
    from matplotlib.axis import Axis


#: One look for every figure; markers and line styles differ, so that it reads in black and white.
STYLE: Any = {
    "font.size": 10,
    "axes.grid": True,
    "axes.formatter.useoffset": False,
    "grid.alpha": 0.25,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    # Letters as shapes: as text, a prime comes out as whatever the reader's font has in its place.
    "svg.fonttype": "path",
    "svg.hashsalt": "fem-contact",
}


#: What is told apart by line, symbol and colour.
STYLES = ("-", "--", "-.", ":")
SYMBOLS = ("o", "s", "^", "D", "v", "P", "X", "*")
COLOURS = ("#0b5394", "#b45f06", "#741b47", "#7f6000", "#134f5c", "#444444", "#990000", "#38761d")
#: Digits of the labels of a logarithmic axis, most to least.
_TICKS: tuple[tuple[float, ...], ...] = ((1, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))


def save_figure(figure: matplotlib.figure.Figure, path: Path, *, dpi: int = 150) -> None:
    """Write a figure; the suffix says the format, `dpi` the pixels per inch of a PNG."""
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with matplotlib.rc_context(STYLE):
        engine = figure.get_layout_engine()
        if engine is not None:
            for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
                readable_ticks(axis)
            # Once: for the second format it would cost as much as drawing.
            engine.execute(figure)
            figure.set_layout_engine(None)
        figure.savefig(path, dpi=dpi, metadata=undated.get(path.suffix))


def readable_ticks(axis: Axis) -> None:
    """Label a logarithmic axis of less than three decades with plain numbers: 2, 5, 10 and not 2 x 10^0.

    There are two at least, and of plain numbers five at most.
    """
    low, high = sorted(axis.get_view_interval())
    standard = isinstance(axis.get_major_formatter(), LogFormatterSciNotation)
    if axis.get_scale() != "log" or not standard:
        return
    plain = 1e-4 <= low < high <= min(1e5, 1e3 * low)
    # As plain text: to set each label as a formula takes longer than to draw the figure.
    axis.set_major_formatter(StrMethodFormatter("{x:g}") if plain else FuncFormatter(_power_of_ten))
    axis.set_minor_formatter(NullFormatter())
    powers = 10.0 ** np.arange(math.floor(math.log10(low)), math.log10(high) + 1)
    for subs in _TICKS if plain else reversed(_TICKS):
        ticks = np.outer(powers, subs)
        if 1 < np.count_nonzero((low <= ticks) & (ticks <= high)) < (6 if plain else math.inf):
            axis.set_major_locator(LogLocator(subs=subs))
            return
    axis.set_major_locator(MaxNLocator(4))


def _power_of_ten(value: float, _: int) -> str:
    if not value > 0:
        return ""
    digits, exponent = f"{value:.2e}".split("e")
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return ("" if float(digits) == 1 else f"{float(digits):g}\u00d7") + f"10{raised}"


def embeddable(svg: str, name: str, *, words: str) -> str:
    """Return an SVG for an HTML page: named apart from the other figures there, and said in `words`."""
    from markupsafe import escape

    drawing = harmless(svg[svg.index("<svg") :])
    drawing = re.sub(r'\bid="', f'id="{name}-', drawing)
    drawing = re.sub(r'(xlink:href="|href="|url\()#', rf"\1#{name}-", drawing)
    return drawing.replace("<svg", f'<svg role="img" aria-label="{escape(harmless(words))}"', 1)


def new_figure(columns: int) -> tuple[matplotlib.figure.Figure, list[Any]]:
    """Return a figure in this look, and its axes side by side."""
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(min(1 + 4 * columns, 13), 3.7), layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
    return figure, list(axes)
