"""Figures read back: each line, bar, band and image shows the numbers of the slice that its label names.

It knows the registry by its file and the dataset by its names, and nothing of the code that draws but how
it sets symbols.
"""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pint
from matplotlib.colors import same_color, to_hex

import validation.report
from validation.report.words import mathtext

UNITS = pint.UnitRegistry()
REGISTRY = tomllib.loads((Path(validation.report.__file__).parent / "quantities.toml").read_text())
FACTORS = {"p": 1e12, "n": 1e9, "u": 1e6, "m": 1e3, "": 1.0, "k": 1e-3, "M": 1e-6, "G": 1e-9}
#: What SI is multiplied by on an axis at least and at most, of units that take prefixes.
PREFIXED = {"m": (1e-9, 1e12), "Pa": (1e-9, 1e12), "1/m": (1e-9, 1.0)}
#: Errors that belong to the step to any spectrum and period.
SPECTRAL = ("size", "bandwidth")


def known(name):
    """Entry of the quantity that a name begins with, longest first, and the rest of the name."""
    parts = name.split("_")
    for cut in range(len(parts), 0, -1):
        start = "_".join(parts[:cut])
        if start in REGISTRY["quantities"]:
            return REGISTRY["quantities"][start], "_".join(parts[cut:])
    raise KeyError(name)


def misdrawn(drawing, data):
    """Yield what a figure shows otherwise than the dataset has it."""
    for one in drawing.drawn:
        for problem in _mark(one, data, drawing):
            yield f"{drawing.name}, {one.label!r}: {problem}"
    yield from _beyond(drawing)
    yield from _side_by_side(drawing)
    for axes in {id(one.axes): one.axes for one in drawing.drawn}.values():
        marks = [one for one in drawing.drawn if one.axes is axes]
        names = {one.mark.y for one in marks}
        yield from _confused(drawing, [one for one in marks if type(one.mark).__name__ == "Line"])
        for axis in (axes.xaxis, axes.yaxis):
            yield from _misplaced(drawing, axis)
        if not axes.get_xlabel() or not axes.get_ylabel():
            yield f"{drawing.name}: an axis of {names} has no label"
        if type(marks[0].mark).__name__ != "Image":
            along = [(one.x, one.data[one.x]) for one in marks if one.x in one.data]
            yield from _unread(drawing, axes.get_xlabel(), along)
            yield from _unread(drawing, axes.get_ylabel(), [(m.mark.y, m.data[m.mark.y]) for m in marks])
    yield from _scales_of_colour(
        drawing, [one for one in drawing.drawn if type(one.mark).__name__ == "Image"]
    )


def _side_by_side(drawing):
    """Say so where panels of the same quantities differ in their ends, or not the first alone names its y."""
    axes = list(dict.fromkeys(one.axes for one in drawing.drawn))
    shown = [
        (on, panel.x, panel.y or panel.marks[0].y) for on, panel in zip(axes, drawing.panels, strict=True)
    ]
    along, up = (
        {(part[k], getattr(part[0], f"get_{axis}label")()) for part in shown}
        for k, axis in ((1, "x"), (2, "y"))
    )
    if len(along) == 1 < len({on.get_xlim() for on in axes}):
        yield f"{drawing.name}: panels along {along} have other ends"
    if len(up) == 1 < len({on.get_ylim()[1] for on in axes}):
        yield f"{drawing.name}: panels of {up} have other ends"
    for on in axes:
        if on.yaxis.label.get_visible() != (on is axes[0] or len(up) > 1):
            yield f"{drawing.name}: {on.get_ylabel()!r} is named again, or not at all"


def _confused(drawing, lines):
    """Say so where two lines of one panel that are called apart look alike."""
    seen = {}
    for one in lines:
        line = one.artist.lines[0]
        parts = (line.get_color(), line.get_markerfacecolor())
        look = (*map(to_hex, parts), line.get_marker(), line.get_linestyle(), line.get_linewidth())
        if seen.setdefault(look, one.label) != one.label:
            yield f"{drawing.name}: {one.label!r} looks as {seen[look]!r} does"


def _misplaced(drawing, axis):
    """Say so where a number beside an axis, by the power of ten at its end, is not that of its place."""
    formatter, places = axis.get_major_formatter(), axis.get_majorticklocs()
    if type(formatter).__name__ == "StrCategoryFormatter":
        return
    plain = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", "$") | {ord("\N{MINUS SIGN}"): "-"}
    texts = formatter.format_ticks(places)
    power = formatter.get_offset().translate(plain)
    if not re.fullmatch(r"(1e-?\d+)?", power):
        yield f"{drawing.name}: beside {axis.get_label_text()!r} stands {power!r}"
        return
    for place, text in zip(places / float(power or 1), texts, strict=True):
        number = re.sub(r"\\mathdefault|[{}]", "", text)
        number = re.sub(r"(?:(.*)(?:×|\\times))?10\^?(?=[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]|(?<=\^))", r"\1e", number)
        number = re.sub(r"^(-?)e", r"\g<1>1e", number.translate(plain))
        if number and not math.isclose(float(number), place, rel_tol=1e-9, abs_tol=1e-9 * np.ptp(places)):
            yield f"{drawing.name}: {text!r} stands at {place:g} of {axis.get_label_text()!r}"


def _scales_of_colour(drawing, images):
    """Say so where a map lacks its bar of colours: its own, or that of all where all are symmetric.

    Colours that part at white part at zero.
    """
    shared = len(images) > 1 and all(one.mark.symmetric for one in images)
    for one in images[:1] if shared else images:
        low, high = one.artist.get_clim()
        if one.artist.get_cmap().name == "RdBu_r" and low != -high:
            yield f"{drawing.name}: the white of {one.label!r} is not zero"
        beside = [one.axes for one in images] if shared else [one.axes]
        if one.artist.colorbar.ax._colorbar_info["parents"] != beside:
            yield f"{drawing.name}: the colours of {one.label!r} are told beside another panel"


def _unread(drawing, label, parts):
    """Say so where the largest number of an axis is not 1 to 1000, in a unit whose prefixes go so far."""
    ends = next((PREFIXED.get(known(name)[0].get("unit"), ()) for name, _ in parts), ())
    if not ends or any("written_in" in part.attrs for _, part in parts):
        return
    largest, factor = max(float(abs(part).max()) for _, part in parts), _factor(parts[0][0], label)
    least, most = (np.isclose(factor, end, rtol=1e-9, atol=0) for end in ends)
    if largest > 0 and not ((most or largest * factor > 1 - 1e-9) and (least or largest * factor < 1000)):
        yield f"{drawing.name}: {label!r} goes to {largest * factor:g}"


def _mark(one, data, drawing):
    kind = type(one.mark).__name__
    if kind == "Image":
        factor, shown = _factor(one.mark.y, one.label), np.asarray(one.artist.get_array())
        if math.isnan(factor):
            yield f"its colours have a unit that is none of {one.mark.y}"
            return
        numbers = data[one.mark.y].isel(dict(one.mark.at))
        place = [dim for dim in numbers.dims if dim not in one.data[one.mark.y].dims]
        numbers = numbers.sel({dim: one.data[dim].item() for dim in place if dim in data.coords})
        numbers = numbers.transpose(*one.data[one.mark.rows].dims, *one.data[one.x].dims)
        if not _same(shown, numbers.values * factor):
            yield "the map is not that of its variable"
        if (one.mark.rows == "y") != (one.axes.get_aspect() == 1):
            yield "a map of places is as wide as they are, and no other"
        for k, name, label in ((0, one.x, one.axes.get_xlabel()), (1, one.mark.rows, one.axes.get_ylabel())):
            edges, places = one.artist.get_coordinates()[..., k], np.asarray(one.data[name].values)
            edges = edges[:, 0] if k else edges[0]
            if places.dtype.kind == "f":
                middles = (places[1:] + places[:-1]) / 2
                ends = np.array(
                    [*(2 * places[:1] - middles[:1]), *middles, *(2 * places[-1:] - middles[-1:])]
                )
                away = abs(edges - ends * np.nan_to_num(_factor(name, label)))  # an end may be rounding of 0
                if away.max() > 1e-9 * np.ptp(edges):
                    yield f"the map lies elsewhere along {name}"
        return
    factor_x, factor_y = _factor(one.x, one.axes.get_xlabel()), _factor(one.mark.y, one.axes.get_ylabel())
    if math.isnan(factor_x) or math.isnan(factor_y):
        yield f"an axis has a unit that is none of {one.x}, {one.mark.y}"
        return
    yield from _words(one)
    yield from _look(one, kind, sum(other.mark is one.mark for other in drawing.drawn) > 1)
    if kind == "Band":
        yield from _band(one, (factor_x, factor_y))
        return
    if kind == "Line" and not one.mark.joined and one.artist.lines[0].get_linestyle() != "None":
        yield "its points are joined"
    x, y, bars = _drawn(one, kind)
    slices = list(_slices(one, data, kind))
    fitting = [
        (place, error)
        for place, along, values, error in slices
        if _same(y, values * factor_y) and (kind == "Level" or _same_x(x, along, factor_x))
    ]
    if not fitting:
        yield "shows no slice of its variable"
        return
    named = [(place, error) for place, error in fitting if _named(one, place, data)]
    if not named:
        yield f"shows {[place for place, _ in fitting]}, which its label does not name"
        return
    if not any(_bars(bars, error, factor_y, (x, y)) for _, error in named):
        yield "its bars are not the 95 % of its slice"


def _band(one, factors):
    """Say so where a band goes elsewhere than from its lower to its upper numbers."""
    along, low, high = (np.ravel(one.data[name].values) for name in (one.x, one.mark.y, one.mark.high))
    if hasattr(one.artist, "get_paths"):
        ends = [(x, y) for numbers in (low, high) for x, y in zip(along, numbers, strict=True)]
        found = [tuple(point) for path in one.artist.get_paths() for point in path.vertices]
    else:  # all at one place: a point
        ends, found = [(along[0], low[0])], [(one.artist.get_xdata()[0], one.artist.get_ydata()[0])]
    found, expected = (
        np.unique(np.round(points, 12), axis=0) for points in (found, ends * np.array(factors))
    )
    if not _same(found, expected):
        yield "the band is not that of its variables"


def _beyond(drawing):
    """Say so where points cannot be seen and the caption does not tell how many."""
    lines = [(one.artist.lines[0], one.axes) for one in drawing.drawn if type(one.mark).__name__ == "Line"]
    points, hidden = 0, 0
    for line, axes in lines:
        x, y = (np.asarray(v, dtype=float) for v in line.get_data(orig=False))
        (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
        points += x.size
        hidden += x.size - sum(left <= a <= right and low <= b <= high for a, b in zip(x, y, strict=True))
    told = f"{hidden} of {points} points lie beyond the axes."
    if (hidden > 0) != ("points lie beyond" in drawing.caption) or (hidden and told not in drawing.caption):
        yield f"{drawing.name}: its caption does not end with {told!r}"


def _spans(one):
    """Return the bands around a level."""
    y = one.artist.get_ydata()[0]
    return [p for p in one.axes.patches if np.isclose(p.get_y() + p.get_height() / 2, y)]


def _drawn(one, kind):
    """Abscissae, ordinates and half lengths of the bars of an artist."""
    if kind == "Level":
        spans = [p.get_height() / 2 for p in _spans(one)]
        y = np.asarray(one.artist.get_ydata(), dtype=float)[:1]
        return None, y, np.array(spans[:1]) if spans else None
    line, _, collections = one.artist.lines
    x, y = line.get_xdata(), np.asarray(line.get_ydata(), dtype=float)
    if not collections:
        return x, y, None
    halves = [(seg[1][1] - seg[0][1]) / 2 if len(seg) else math.nan for seg in collections[0].get_segments()]
    return x, y, np.array(halves)


def _slices(one, data, kind):
    """Yield every slice of a variable that the mark could be of: place, abscissae, ordinates, 95 %."""
    values = data[one.mark.y]
    along = data[one.x] if kind != "Level" and one.x in data.variables else None
    kept = set(one.data[one.mark.y].dims)
    sliced = [dim for dim in values.dims if dim not in kept]
    where = dict(one.mark.where)
    shown = {one.mark.y, f"{one.mark.y}_error", one.x, *where}
    data = data[[name for name in data.variables if name in shown or name in data.coords]]
    for index in np.ndindex(*(data.sizes[dim] for dim in sliced)):
        place = dict(zip(sliced, index, strict=True))
        here = data.isel(place)
        for name, value in where.items():
            if here[name].ndim:
                here = here.isel({here[name].dims[0]: np.flatnonzero(here[name].values == value)})
        for dim, position in one.mark.at.items():
            if dim in here.dims:
                here = here.isel({dim: position})
        numbers = np.ravel(here[one.mark.y].values).astype(float)
        there = np.isfinite(numbers)
        x = None if along is None or one.x not in here.variables else np.ravel(here[one.x].values)
        if x is not None and x.size == there.size:
            x = x[there]
        error = _total(here, one.mark.y)
        yield place, x, numbers[there], None if error is None else np.ravel(error)[there]


def _total(data, name):
    if f"{name}_error" not in data.variables:
        return None
    errors = data[f"{name}_error"]
    limit = errors.attrs.get("limit_in")
    kept = errors.sel(source=[s for s in errors.source.values if s not in SPECTRAL or s == limit])
    squares = kept.transpose("source", ...).values.astype(float) ** 2
    known = np.isfinite(squares)
    return np.where(known.any(axis=0), np.sqrt(np.where(known, squares, 0.0).sum(axis=0)), np.nan)


def _same(found, expected):
    found, expected = np.ravel(found), np.ravel(expected)
    return found.shape == expected.shape and np.allclose(found, expected, rtol=1e-9, atol=0, equal_nan=True)


def _same_x(found, expected, factor):
    if expected is None:
        return True
    if expected.dtype.kind in "OU":
        return [str(v) for v in found] == [str(v) for v in expected]
    return _same(np.asarray(found, dtype=float), expected.astype(float) * factor)


def _bars(bars, error, factor, points):
    x, values = points
    if error is None or not np.nansum(error) > 0:
        return bars is None or not np.size(bars)
    expected = np.where(np.isfinite(error), error * factor, np.nan)
    if x is not None and np.asarray(x).dtype.kind == "f":  # a point that has no place has no bar
        expected = np.where(np.isfinite(x), expected, np.nan)
    # Half lengths are differences of the values: they round as these do.
    floor = 1e-12 * float(np.abs(values).max())
    return (
        bars is not None
        and bars.shape == expected.shape
        and np.allclose(bars, expected, rtol=1e-9, atol=floor, equal_nan=True)
    )


def _named(one, place, data):
    """Whether each coordinate of a place along which marks are repeated stands in the label or the title."""
    text = f"{one.label} {one.axes.get_title()}"
    by = (one.mark.by,) if isinstance(one.mark.by, str) else one.mark.by
    for dim in by:
        names = [dim] if dim in data.coords else [n for n, c in data.coords.items() if c.dims == (dim,)]
        if dim not in place or not names or one.mark.label is not None:
            continue
        value = data[names[0]].values[place[dim]]
        if isinstance(value, str | np.str_):
            # A solver or a theory is called by its words.
            words = REGISTRY["qualifiers"].get(str(value), {"words": value})["words"]
            if value not in text and words not in text:
                return False
            continue
        numbers = [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", text)]
        scales = FACTORS.values() if known(str(names[0]))[0].get("unit", "1") != "1" else (1.0,)
        if not any(np.isclose(n, float(value) * s, rtol=1e-3) for n in numbers for s in scales):
            return False
    return True


def _words(one):
    """What tells the variable from its like stands in the legend, if the legend is not the author's own."""
    _, rest = known(one.mark.y)
    for name, entry in REGISTRY["qualifiers"].items():
        if one.mark.label is None and rest == name and entry["words"] not in one.label:
            yield f"its label lacks {entry['words']!r}"


def _look(one, kind, several):
    """Say so where what is drawn has another label or colour than its mark was given, or another look than
    what is called so has on every figure; a mark of several places has a colour for each."""
    said = one.artist.get_label()
    if said != mathtext(one.label) and (one.label or not said.startswith("_")):
        yield f"its legend says {said!r}"
    line = getattr(one.artist, "lines", [one.artist])[0]
    if kind == "Band":
        return
    if not same_color(line.get_color(), one.look["color"]):
        yield f"its colour is not {one.look['color']}"
    if kind == "Level" and not all(
        same_color(p.get_facecolor()[:3], line.get_color()) for p in _spans(one)[:1]
    ):
        yield "its band has another colour"
    steps = kind == "Line" and one.mark.steps
    if steps != (line.get_drawstyle() == "steps-mid"):
        yield "a histogram has steps, and what is none has not"
    entries = REGISTRY["qualifiers"].values()
    called = [entry for entry in entries if f"{one.label}, ".startswith(f"{entry['words']}, ")]
    if one.mark.label is not None or not called:
        return
    drawn = {"color": line.get_color(), "marker": line.get_marker(), "ls": line.get_linestyle()}
    for name in dict.fromkeys(("marker",) * steps + ("color",) * several) | dict(one.mark.look):
        drawn.pop(name, None)
    of = max(called, key=lambda entry: len(entry["words"]))
    further = one.label.removeprefix(of["words"]).removeprefix(", ")
    if any(further.startswith(entry["words"]) for entry in entries):  # a theory of one kind of contact
        return
    elsewhere = of.get("look", {})
    for name in drawn.keys() & elsewhere.keys():
        if drawn[name] not in (elsewhere[name], elsewhere[name] or "None"):
            yield f"{name} = {drawn[name]!r}, elsewhere {elsewhere[name]!r}"


def _factor(name, axis):
    """What SI is multiplied by on an axis, from the unit that its label names; NaN for another unit."""
    unit = known(name)[0].get("unit", "1")
    told = re.search(r"\[([^\]]*)\]\s*$", axis.replace("\n", " "))
    if told is None:
        return 1.0 if unit == "1" or not axis else math.nan
    shown = re.sub(r"[${}]", "", told[1])
    try:
        return float(UNITS.Quantity(1.0, unit.replace("^", "**")).to(shown.replace("^", "**")).magnitude)
    except pint.PintError:
        return math.nan
