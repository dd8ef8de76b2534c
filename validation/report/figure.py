"""How figures look, and how they are saved."""

from __future__ import annotations

import itertools
import math
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator, NullFormatter

from validation.errors import harmless
from validation.report.words import mathtext

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis


__all__ = [
    "COLOURS",
    "FILLS",
    "LOOK",
    "MARKERS",
    "STYLE",
    "STYLES",
    "SYMBOLS",
    "embeddable",
    "lines_figure",
    "look",
    "looks",
    "new_figure",
    "readable_ticks",
    "save_figure",
]


#: One look for every figure; markers and line styles differ, so that it reads in black and white.
STYLE: Any = {
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


LOOK: dict[tuple[str, str], dict[str, Any]] = {
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


MARKERS = [("#0b5394", "o"), ("#b45f06", "s"), ("#38761d", "^"), ("#674ea7", "D")]


STYLES = ["-", "--", "-.", ":"]


#: What is told apart by symbol and colour.
SYMBOLS = ("o", "s", "^", "D", "v", "P", "X", "*")
COLOURS = ("#0b5394", "#b45f06", "#38761d", "#741b47", "#134f5c", "#7f6000", "#444444", "#990000")
#: Digits of the labels of a logarithmic axis, most to least.
_TICKS: tuple[tuple[float, ...], ...] = ((1, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))


def looks(labels: Mapping[str, str]) -> dict[tuple[str, str], dict[str, Any]]:
    """Return how the counted and the corrected area of each method are drawn, by name and definition.

    Parameters
    ----------
    labels : mapping of str to str
        What each method is called, by its name; those that have no look of their own take one in turn.
    """
    found: dict[tuple[str, str], dict[str, Any]] = {}
    others = [name for name in labels if (name, "pixel") not in LOOK]
    for name, label in labels.items():
        if name not in others:
            found |= {key: look for key, look in LOOK.items() if key[0] == name}
            continue
        turn = 3 + others.index(name) % (len(COLOURS) - 3)  # the third colour is the theory's
        line = {"color": COLOURS[turn], "marker": SYMBOLS[turn]}
        found[name, "pixel"] = {**line, "ls": "-", "label": f"{label}, pixel count"}
        found[name, "perimeter"] = {
            **line,
            "mfc": "white",
            "ls": "--",
            "label": f"{label}, perimeter-corrected",
        }
    return found


FILLS = [None, None, None, None, "white", "white", "white", "white"]


def save_figure(figure: Figure, path: Path, *, dpi: int = 150) -> None:
    """Write a figure; the suffix says the format, `dpi` the pixels per inch of a PNG."""
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with matplotlib.rc_context(STYLE):
        _lay_out(figure)
        figure.savefig(path, dpi=dpi, metadata=undated.get(path.suffix))


def _lay_out(figure: Figure) -> None:
    """Lay a figure out, once: ticks that can be read, a legend beside the data it would lie over."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            readable_ticks(axis)
    if not any(axes.get_legend() for axes in figure.axes):
        # Nothing can lie over the data: places are found without drawing.
        engine.execute(figure)
        figure.set_layout_engine(None)
        return
    figure.draw_without_rendering()
    over = [axes for axes in figure.axes if axes.get_legend() is not None and _covers_data(axes)]
    if len(over) == 1 and len(figure.legends) == 0:
        _move_below(figure, over[0])
    # For the second format all this would cost as much as drawing.
    figure.set_layout_engine(None)


def _covers_data(axes: Axes) -> bool:
    """Whether the legend of laid-out axes lies over a line, a histogram or an error bar."""
    legend = axes.get_legend()
    assert legend is not None
    box = legend.get_window_extent()
    drawn: list[Any] = [*axes.get_lines(), *(p for p in axes.patches if isinstance(p, StepPatch))]
    paths = [each.get_transform().transform_path(each.get_path()) for each in drawn]
    for bars in axes.collections:
        paths += [bars.get_transform().transform_path(path) for path in bars.get_paths()]
    inside = axes.get_window_extent().overlaps(box)
    return inside and any(path.intersects_bbox(box, filled=False) for path in paths if np.size(path.vertices))


def _move_below(figure: Figure, axes: Axes) -> None:
    """Put the legend of some axes below the figure, which grows by what it needs."""
    legend = axes.get_legend()
    assert legend is not None
    handles, labels = axes.get_legend_handles_labels()
    legend.remove()
    height, room = figure.get_figheight(), figure.get_window_extent().width
    for columns in (4, 3, 2, 1):
        rows = -(-len(labels) // columns)
        figure.set_figheight(height + 0.17 * rows + 0.1)
        below = figure.legend(handles, labels, fontsize=7, ncols=columns, loc="outside lower center")
        figure.draw_without_rendering()
        if below.get_window_extent().width <= room or columns == 1:
            return
        below.remove()


def readable_ticks(axis: Axis) -> None:
    """Label a logarithmic axis of less than three decades with plain numbers: 2, 5, 10 and not 2 x 10^0.

    There are as many as find place along the axis.
    """
    low, high = sorted(axis.get_view_interval())
    standard = isinstance(axis.get_major_formatter(), LogFormatterSciNotation)
    if axis.get_scale() != "log" or not standard:
        return
    if not 1e-4 <= low < high <= 1e5 or high / low > 1e3:
        if getattr(axis.get_transform(), "base", 10) == 10:
            # As plain text: to set each label as a formula takes longer than to draw the figure.
            axis.set_major_formatter(FuncFormatter(_power_of_ten))
            axis.set_minor_formatter(NullFormatter())
        return
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
    if getattr(axis.get_transform(), "base", 10) == 2:
        axis.set_major_locator(LogLocator(base=2))
        return
    figure: Any = axis.axes.figure
    place = axis.axes.get_position()
    along = axis is axis.axes.xaxis
    inches = place.width * figure.get_figwidth() if along else place.height * figure.get_figheight()
    each = math.log10(high / low) * (0.45 if along else 0.3)
    dense = [subs for subs in _TICKS if len(subs) * each <= inches]
    axis.set_major_locator(LogLocator(subs=(dense or _TICKS[-1:])[0]))


def _power_of_ten(value: float, _: int) -> str:
    exponent = str(round(math.log10(value))) if value > 0 else ""
    return "10" + exponent.translate(
        str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
    )


def embeddable(svg: str, name: str, *, words: str) -> str:
    """Return an SVG for an HTML page: named apart from the other figures there, and said in words.

    Parameters
    ----------
    svg : str
    name : str
        Of the figure.
    words : str
        What is seen, for readers who do not see it.
    """
    from markupsafe import escape

    drawing = harmless(svg[svg.index("<svg") :])
    drawing = re.sub(r'\bid="', f'id="{name}-', drawing)
    drawing = re.sub(r'(xlink:href="|href="|url\()#', rf"\1#{name}-", drawing)
    return drawing.replace("<svg", f'<svg role="img" aria-label="{escape(harmless(words))}"', 1)


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
        Second dimension; one line is drawn for each of its values, in one colour for all `lines`.
    logarithmic : str
        "x", "y" or "xy".
    reference : dict of str to float, optional
        Horizontal lines, by words.
    """
    figure, (axes,) = new_figure()
    looks: Iterator[dict[str, Any]] = itertools.cycle(
        {"color": colour, "marker": marker, "ls": style, "mfc": fill}
        for (colour, marker), style, fill in zip(MARKERS * 2, STYLES * 2, FILLS, strict=True)
    )
    paired = along is not None and len(lines) > 1
    for line, name in enumerate(lines):
        values = [None] if along is None else list(data[along].values)
        for k, value in enumerate(values):
            here = data if value is None else data.sel({along: value})
            look = _paired_look(line, k) if paired else next(looks)
            words = str(data[name].attrs.get("long_name", name))
            named = [] if value is None else [_named_value(data, str(along), value)]
            # What all lines have in common stands at the axis.
            label = mathtext(", ".join(named if named and len(lines) == 1 else [words, *named]))
            error = here[f"{name}_error"].values if f"{name}_error" in data else None
            axes.errorbar(here[x].values, here[name].values, yerr=error, capsize=2, label=label, **look)
    for k, (words, level) in enumerate((reference or {}).items()):
        axes.axhline(level, color="black", lw=1, ls=STYLES[k % 4], label=words)
    if "x" in logarithmic:
        axes.set_xscale("log")
    if "y" in logarithmic:
        axes.set_yscale("log")
    axes.set_xlabel(_labelled(data[x], x))
    axes.set_ylabel(_common_label(data, lines))
    axes.legend(fontsize=7)
    return figure


def _paired_look(line: int, value: int) -> dict[str, Any]:
    """Colour and symbol tell the value, style and filling the line, so that those of a value pair up."""
    colour, marker = MARKERS[value % len(MARKERS)]
    return {"color": colour, "marker": marker, "ls": STYLES[line % 4], "mfc": "white" if line else None}


def _named_value(data: xr.Dataset, name: str, value: Any) -> str:
    unit = data[name].attrs.get("units", "1")
    said = str(value) if isinstance(value, str) else f"{value:g}"
    return f"{name} = {said}" + ("" if unit == "1" else f" {unit}")


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
    words, unit = str(variable.attrs.get("long_name", name)), variable.attrs.get("units", "1")
    return mathtext(words) if unit == "1" else f"{mathtext(words)} [{unit}]"


def new_figure(width: float = 5.0, height: float = 3.7, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure in this look, and its axes side by side."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
    return figure, list(axes)


def look(k: int) -> dict[str, Any]:
    """Symbol and colour of the k-th thing compared, with caps for its error bars."""
    return {"marker": SYMBOLS[k % 8], "color": COLOURS[k % 8], "capsize": 2, "ms": 5}
