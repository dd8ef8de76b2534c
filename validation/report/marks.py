"""Figures as lists of marks: each knows the slice of the dataset it shows, and who draws it adds nothing.

Axis labels, units, legends, error bars (95 %), the data file and the end of the caption follow from the
marks. `draw` returns with the figure what was drawn of which slice, so that a test can read the picture back.
"""

from __future__ import annotations

import html
import itertools
import re
import tempfile
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from validation.arrays import Pair
from validation.errors import UsageError
from validation.files import atomic_path
from validation.netcdf import dataset_bytes
from validation.report.estimates import optional, shown_sources, total_error
from validation.report.places import each
from validation.report.quantities import (
    Quantity,
    named_at,
    place_words,
    prefixed_unit,
    quantity,
    quantity_of,
    registry,
    written_unit,
)
from validation.report.table import write_dataset
from validation.report.values import values_of
from validation.report.words import mathtext

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True)
class _Mark:
    """What all marks have: the variable `y`, along `x` (that of the panel if not given).

    One is drawn for each place along the dimensions `by`, at positions `at` of others, where coordinates have
    the values `where`. `look` overrides how it is drawn, `label` the legend, with values in braces as in a
    finding.
    """

    y: str
    _: KW_ONLY
    x: str = ""
    by: tuple[str, ...] | str = ()
    at: Mapping[str, int | Sequence[int]] = field(default_factory=dict)
    where: Mapping[str, Any] = field(default_factory=dict)
    look: Mapping[str, Any] = field(default_factory=dict)
    label: str | None = None

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions `by`."""
        return (self.by,) if isinstance(self.by, str) else self.by


@dataclass(frozen=True, kw_only=True)
class Line(_Mark):
    """Points with their 95 % intervals along `x`; joined or not, or as the ``steps`` of a histogram."""

    joined: bool = True
    steps: bool = False


@dataclass(frozen=True, kw_only=True)
class Level(_Mark):
    """A horizontal line: a number that does not depend on `x`; with an interval it is a band."""


@dataclass(frozen=True, kw_only=True)
class Band(_Mark):
    """A range from `y` to `high` along `x`; a symbol where it is a point."""

    high: str


@dataclass(frozen=True, kw_only=True)
class Image(_Mark):
    """A map over the two dimensions of `y`, with its colour bar; `x` and `rows` are its axes.

    With `symmetric` the colours go as far below zero as above, to the largest number on any panel.
    """

    rows: str = ""
    cmap: str = "viridis"
    symmetric: bool = False


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Axes of `x` and `y` (of the first mark if not given), `log` ones as "xy"; `at` holds for all marks."""

    marks: Sequence[_Mark]
    x: str
    y: str = ""
    log: str = ""
    title: str = ""
    at: Mapping[str, int | Sequence[int]] = field(default_factory=dict)
    bottom: float | None = None
    top: float | None = None
    right: float | None = None

    @property
    def up(self) -> str:
        """The variable along its y."""
        return self.y or self.marks[0].y


@dataclass(frozen=True)
class Figure:
    """Panels side by side, and what is seen in a sentence; what bars mean is added when drawn."""

    name: str
    caption: str
    panels: Sequence[Panel]


@dataclass(frozen=True, eq=False)
class Drawn:
    """One thing that was drawn: artist, axes, mark, and the slice it shows."""

    artist: Any
    axes: Any
    mark: Any
    x: str
    data: xr.Dataset
    _: KW_ONLY
    label: str
    look: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """One figure of a report, called as its files: what is drawn, every number in it, and a caption."""

    name: str
    figure: Canvas
    data: xr.Dataset
    caption: str
    drawn: tuple[Drawn, ...] = ()
    panels: Sequence[Panel] = ()

    def _repr_html_(self) -> str:
        from validation.report.figure import embeddable, save_figure

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "figure.svg"
            save_figure(self.figure, path)
            svg = embeddable(path.read_text(encoding="utf-8"), self.name, words=self.caption)
        return f"<figure>{svg}<figcaption>{html.escape(self.caption)}</figcaption></figure>"


def against(x: str, *marks: _Mark | str, by: tuple[str, ...] | str = (), **axes: Any) -> Panel:
    """Return a panel of marks; a name alone is a line of that variable, or one for each place along `by`."""
    lines = [Line(mark, by=by) if isinstance(mark, str) else mark for mark in marks]
    return Panel(marks=lines, x=x, **axes)


def panels_along(data: xr.Dataset, dim: str, panel: Panel) -> tuple[Panel, ...]:
    """Return the panel once for each place along a dimension, which is its title."""
    return tuple(
        replace(panel, at={**panel.at, dim: k}, title=place_words(data.isel({dim: k}), dim, data))
        for k in range(data.sizes[dim])
    )


def draw(figure: Figure, data: xr.Dataset, *, axes: Any = None) -> Drawing:
    """Draw a figure of a dataset, into axes that are there if they are given, one for each panel."""
    from validation.report.figure import new_figure, readable_ticks

    drawn: list[Drawn] = []
    # What no mark names need not be sliced for each of them.
    words = set(re.findall(r"\w+", repr(figure.panels)))
    whole, data = data, data[[n for n in data.data_vars if str(n).removesuffix("_error") in words]]
    figure = replace(figure, panels=[p for p in figure.panels if _shows(p, data)] or figure.panels[:1])
    if axes is None:
        canvas, places = new_figure(columns=len(figure.panels))
    else:
        places = list(np.ravel(axes))
        if len(places) != len(figure.panels) or not all(hasattr(on, "errorbar") for on in places):
            count = f"{len(figure.panels)} axes of matplotlib, one for each panel"
            raise UsageError(f"ax = {axes!r}: give {count}, or leave it out")
        canvas = places[0].figure
    for panel, on in zip(figure.panels, places, strict=True):
        drawn += _draw_panel(panel, on, data, {one.label: one.look for one in drawn if one.label})
    _align(figure.panels, places)
    images = [line for line in drawn if isinstance(line.mark, Image)]
    # Symmetric images have one scale of colours, and one bar for all panels.
    common = len(images) > 1 and all(line.mark.symmetric for line in images)
    for line in images[:1] if common else images:
        canvas.colorbar(line.artist, ax=places if common else line.axes, label=mathtext(line.label))
    if axes is None:
        _legend(canvas, places)
    else:
        for on in places:
            readable_ticks(on.xaxis)
            readable_ticks(on.yaxis)
            if on.get_legend_handles_labels()[0]:
                on.legend(fontsize=7)
    names = dict.fromkeys(n for one in drawn for n in (one.mark.y, one.x, getattr(one.mark, "high", "")))
    names |= dict.fromkeys(f"{n}_error" for n in names if f"{n}_error" in data)
    part = whole[[n for n in names if n in whole]]
    # What was asked, without attributes of the machine and of the place in the whole.
    part.attrs = {name: value for name, value in data.attrs.items() if name not in ("at", "solves_made")}
    return Drawing(
        name=figure.name,
        figure=canvas,
        data=part,
        caption=_caption(figure.caption, drawn),
        drawn=tuple(drawn),
        panels=figure.panels,
    )


def write_drawing(drawing: Drawing, folder: Path) -> tuple[Path, ...]:
    """Write a figure and its data into a folder; return the files, SVG first."""
    from validation.report.figure import save_figure

    svg, pdf, table, data = (folder / f"{drawing.name}.{suffix}" for suffix in ("svg", "pdf", "csv", "nc"))
    for path in (svg, pdf):
        with atomic_path(path) as draft:
            save_figure(drawing.figure, draft)
    tables = write_dataset(drawing.data, table)
    with atomic_path(data) as draft:
        draft.write_bytes(dataset_bytes(drawing.data))
    return (svg, pdf, *tables, data)


def _shows(panel: Panel, data: xr.Dataset) -> bool:
    """Whether a panel has anything to show; on a logarithmic axis that is a positive number."""
    part = data.isel(panel.at, missing_dims="ignore")
    return any(
        "y" not in panel.log or isinstance(mark, Image) or bool((here[mark.y] > 0).any())
        for mark in panel.marks
        for here in _places(mark, part)
    )


def _align(panels: Sequence[Panel], places: Sequence[Axes]) -> None:
    """Give panels of the same quantities the same limits; the first alone says what their y is."""
    if len({panel.x for panel in panels}) == 1 == len({on.get_xlabel() for on in places}):
        low, high = np.array([on.get_xlim() for on in places]).T
        for on in places:
            on.set_xlim(low.min(), high.max())
    if len({panel.up for panel in panels}) == 1 == len({on.get_ylabel() for on in places}):
        low, high = np.array([on.get_ylim() for on in places]).T
        if places[0].get_yscale() == "log":  # where the margin of a panel's own range is too narrow
            high *= (high.max() / low.min()) ** 0.03
        for on, panel in zip(places, panels, strict=True):
            bottom = low.min() if panel.bottom is None else panel.bottom
            on.set_ylim(bottom, high.max() if panel.top is None else panel.top)
            on.yaxis.label.set_visible(on is places[0])


def _draw_panel(
    panel: Panel, axes: Axes, data: xr.Dataset, beside: Mapping[str, Mapping[str, Any]]
) -> list[Drawn]:
    """Draw every place of every mark, then scales, names and limits of the axes.

    A mark's places along `by` have the colours of their numbers; other marks take the next colour, but for
    bands and quantities that have a colour of their own. What is called as something in a panel `beside` has
    its colour, and what is called otherwise another.
    """
    from validation.report.figure import COLOURS

    part = data.isel(panel.at, missing_dims="ignore")
    places = [(mark, here, k) for mark in panel.marks for k, here in enumerate(_places(mark, part))]
    along = [here[m.x or panel.x] for m, here, _ in places if (m.x or panel.x) in here]
    name_x, name_y = quantity_of(data, panel.x), quantity(panel.up)
    scale_x, scale_y = _scale(name_x, along), _scale(name_y, [here[m.y] for m, here, _ in places])
    colours = itertools.count()
    many = {id(mark) for mark, _, k in places if k}
    taken, turns = {one["color"] for one in beside.values()}, dict[int, int]()
    drawn: list[Drawn] = []
    for mark, here, k in places:
        image, what = isinstance(mark, Image), quantity(mark.y)
        label = _axis_label(what, scale_y[1]) if image else _label(mark, here, data)
        # A band has the colour of the first line, which it is about.
        turn = k if mark.by else 0 if what.look or isinstance(mark, Band) else next(colours)
        free = (k % 8 for k in range(turn, turn + 8) if COLOURS[k % 8] not in taken)
        turns.setdefault(turn, next((k for k in free if k not in turns.values()), turn))
        look = _look(mark, here, turns[turn], several=id(mark) in many)
        look |= {name: beside[label][name] for name in ("color", "marker") if label in beside}
        look |= mark.look
        if isinstance(mark, Image) and mark.symmetric:
            look["most"] = float(np.nanmax(abs(data[mark.y]))) * scale_y[0]
        if isinstance(mark, Line):
            # Bars of one colour lie over each other: later ones are thinner, and their ends longer.
            before = sum(other.mark is not mark and other.look["color"] == look["color"] for other in drawn)
            look = {"capsize": 2 + 2 * before, "elinewidth": 1.5 / (1 + before), **look}
        x = mark.x or panel.x
        artist = _put(mark, axes, here, x, (scale_x[0], scale_y[0]), {**look, "label": mathtext(label)})
        drawn.append(Drawn(artist, axes, mark, x, here, label=label, look=look))
    for axis in panel.log:
        getattr(axes, f"set_{axis}scale")("log")
    if "x" in panel.log and (ticks := _few_whole([values * scale_x[0] for values in along])):
        axes.set_xticks(ticks, map(str, ticks))
        axes.set_xticks([], minor=True)
    mark, bottom = panel.marks[0], panel.bottom
    if isinstance(mark, Image):
        name_y = quantity(mark.rows)
        scale_y = _scale(name_y, [data[mark.rows]])
    axes.set_xlabel(_axis_label(name_x, scale_x[1]))
    axes.set_ylabel(_axis_label(name_y, scale_y[1]))
    axes.set_title(mathtext(panel.title), fontsize=9)
    if "y" in panel.log and bottom is None and not isinstance(mark, Image):
        # Bars that reach beyond zero have no lower end on a logarithmic axis, nor points at zero a place.
        ups = [(one.data[one.mark.y], one.data.get(one.x) if "x" in panel.log else None) for one in drawn]
        seen = np.concatenate([[], *(np.ravel(up if x is None else up.where(x > 0)) for up, x in ups)])
        positive = seen[np.isfinite(seen) & (seen > 0)] * scale_y[0]
        bottom = positive.min() / 1.5 if positive.size else None
    axes.set_ylim(bottom=bottom, top=panel.top)
    if panel.right is not None:
        axes.set_xlim(right=panel.right)
    return drawn


def _few_whole(along: Sequence[xr.DataArray]) -> list[int]:
    """Return places on a logarithmic axis that are few whole numbers, such as points per wave."""
    places = np.unique([place for values in along for place in np.ravel(values)])
    if not 1 < places.size < 9 or not np.all((places > 0) & (places == np.rint(places))):
        return []
    steps = np.diff(np.log(places))
    return [int(place) for place in places] if steps.min() > 0.06 * steps.sum() else []


def _places(mark: _Mark, data: xr.Dataset) -> Iterable[xr.Dataset]:
    """Return a slice of the dataset for each line or bar of a mark; none where all of it is NaN."""
    if mark.y not in data:
        quantity(mark.y)  # what is no quantity at all is refused
        return ()
    data = data.isel(mark.at, missing_dims="ignore")
    for name, value in mark.where.items():
        data = data.isel({data[name].dims[0]: np.flatnonzero(data[name].values == value)})
    # Where nothing was solved, nothing is drawn.
    return (here for here in each(data, *mark.dims) if bool(here[mark.y].notnull().any()))


def _put(mark: _Mark, axes: Axes, here: xr.Dataset, x: str, factors: Pair, look: dict[str, Any]) -> Any:
    values, error = here[mark.y], total_error(here, mark.y)
    along: Any = here[x].values if x in here.variables else None
    if along is not None and along.dtype.kind not in "OU":
        along = along * factors[0]
    if isinstance(mark, Image):
        rows = here[mark.rows]
        up = rows.values * _scale(quantity(mark.rows), [rows])[0]
        colours = values.transpose(*rows.dims, *here[x].dims).values * factors[1]
        ends = {"vmin": -look["most"], "vmax": look["most"]} if mark.symmetric else {}
        image = axes.pcolormesh(along, up, colours, cmap=mark.cmap, rasterized=True, **ends)
        if quantity(mark.rows).name == "y":  # a place, not a parameter
            axes.set_aspect("equal")
        return image
    if isinstance(mark, Level):
        plain = {k: v for k, v in look.items() if k in ("color", "ls", "lw", "label")}
        level, half = (float(one) * factors[1] for one in (values, 0.0 if error is None else error))
        line = axes.axhline(level, **{"lw": 1, **plain})
        if 0 < half < np.inf:
            axes.axhspan(level - half, level + half, color=look["color"], alpha=0.12, lw=0)
        return line
    if along is None or along.size not in (1, values.size):
        other = set(values.dims) - set(here[x].dims if x in here.variables else ())
        named = ", ".join(str(dim) for dim in values.dims if dim in other)
        raise UsageError(f"{mark.y!r} along {x!r}: name {named} in 'by' or 'at', or another x")
    along, y = np.ravel(along), np.ravel(values) * factors[1]
    if isinstance(mark, Band):
        colour = look["color"]
        if np.all(along == along[0]):
            point = {k: look[k] for k in ("marker", "mfc", "label") if k in look}
            return axes.plot(along[:1], y[:1], color=colour, ls="", **point)[0]
        high = np.ravel(here[mark.high]) * factors[1]
        return axes.fill_between(along, y, high, color=colour, alpha=0.12, lw=0, label=look["label"])
    assert isinstance(mark, Line)
    if not mark.joined:
        look = {**look, "ls": ""}
    if mark.steps:
        look = {**look, "drawstyle": "steps-mid", "marker": ""}
    # What was not measured there does not break the line.
    there, bars = np.isfinite(y), None
    if error is not None and np.nansum(error) > 0:
        bars = np.ravel(error)[there] * factors[1]
    return axes.errorbar(along[there], y[there], yerr=bars, **{"ms": 5, **look})


def _look(mark: _Mark, here: xr.Dataset, k: int, *, several: bool) -> dict[str, Any]:
    """Colour and symbol of the place, one of several; line and filling of what tells the quantity apart.

    A place that is called as a qualifier is, such as a theory, is drawn as that is everywhere.
    """
    from validation.report.figure import COLOURS, STYLES, SYMBOLS

    options: dict[str, Any] = {}
    for dim in mark.dims:
        if dim in here.coords and here[dim].ndim == 0:
            options |= named_at(here, dim).get("look", {})
    if options and len(mark.dims) > 1:
        options["ls"] = STYLES[k % 4]
    fixed = {n: v for n, v in quantity(mark.y).look.items() if not (several and n == "color")}
    named = [c.item() for c in here.coords.values() if c.ndim == 0 and c.dtype.kind in "OU"]
    looks = (q.get("look", {}) for q in registry()["qualifiers"].values() if q["words"] in named)
    place = {key: value for look in looks for key, value in look.items()}
    return {"color": COLOURS[k % 8], "marker": SYMBOLS[k % 8], **place, **options, **fixed}


def _label(mark: _Mark, here: xr.Dataset, data: xr.Dataset) -> str:
    if mark.label is not None:
        form = mark.label
        return form.format(**dict(values_of(here, lambda name: f"{{{name}" in form)))
    where = [words for dim in mark.dims if (words := place_words(here, dim, data))]
    what = quantity(mark.y)
    return ", ".join([what.which] * bool(what.which) + where) or what.words


def _scale(what: Quantity, values: Iterable[xr.DataArray]) -> tuple[float, str]:
    numbers = [np.abs(v.values.astype(float)) for v in values if v.dtype.kind in "fiu"]
    finite = [float(n[np.isfinite(n)].max()) for n in numbers if np.isfinite(n).any()]
    written = (unit for v in values if (unit := written_unit(v)))
    return next(written, None) or prefixed_unit(what.unit, max(finite, default=0.0))


#: Letters in a line of the name of an axis.
_LINE = 36


def _axis_label(what: Quantity, unit: str) -> str:
    unit = "" if unit == "1" else f" [{unit}]"
    lines = textwrap.wrap(what.words, _LINE, break_on_hyphens=False) or [""]
    if what.symbol in what.words:
        return "\n".join(map(mathtext, lines)) + unit
    whole = f"{lines[-1]}, {what.symbol}{unit}"
    # A symbol is not broken.
    lines[-1:] = [whole] if len(whole) <= _LINE + 4 else [f"{lines[-1]},", what.symbol + unit]
    return "\n".join(map(mathtext, lines))


def _legend(canvas: Any, axes: Sequence[Axes]) -> None:
    """Put one legend of all axes below them; none where a title or an axis says it all."""
    legends = [on.get_legend_handles_labels() for on in axes]
    options = {name: handle for legend in legends for handle, name in zip(*legend, strict=True)}
    if not options or (len(axes) > 1 and all(len(names) < 2 for _, names in legends)):
        return
    if len(options) == 1 and next(iter(options)) in " ".join(axes[0].get_ylabel().split()):
        return
    # Of letters of 7 points, behind a sample of the line [inch].
    widest = 0.051 * max(map(len, options)) + 0.45
    columns = min(len(options), max(1, int(canvas.get_figwidth() / widest)))
    canvas.set_figheight(canvas.get_figheight() + 0.17 * -(-len(options) // columns) + 0.1)
    style: dict[str, Any] = {"loc": "outside lower center", "fontsize": 7, "frameon": False}
    canvas.legend(options.values(), options, ncols=columns, **style)


def _caption(text: str, drawn: Sequence[Drawn]) -> str:
    """Return what is seen, what its bars mean, and how much lies beyond the axes."""
    points = [(line.artist.lines[0].get_xydata(), line.axes) for line in drawn if isinstance(line.mark, Line)]
    inside = [np.all((p >= on.viewLim.min) & (p <= on.viewLim.max), axis=1) for p, on in points]
    seen = np.concatenate([*inside, [True]])
    cut = "" if seen.all() else f" {np.sum(~seen)} of {seen.size - 1} points lie beyond the axes."
    labels: dict[str, list[str]] = {}
    for line in drawn:
        errors = optional(line.data, f"{line.mark.y}_error")
        if errors is not None and not isinstance(line.mark, Image):
            shown = (s for s in shown_sources(errors) if bool((errors.sel(source=s) > 0).any()))
            labels.setdefault(", ".join(shown), []).append(line.label)
    labels.pop("", None)
    if len(labels) < 2:
        return "".join([text, *(f" Bars: 95 % ({names})." for names in labels), cut])
    named = {names: [*filter(None, dict.fromkeys(which))] for names, which in labels.items()}
    parts = (f"{names} ({', '.join(which)})" for names, which in named.items() if which)
    return f"{text} Bars: 95 %, {'; '.join(parts)}.{cut}"
