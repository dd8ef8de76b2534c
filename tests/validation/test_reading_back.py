"""What reading figures back notices: each kind of mistake in a picture, planted."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from reading_back import misdrawn

from validation.report.estimates import claim
from validation.report.marks import Band, Figure, Image, Line, Panel, draw, panels_along


@pytest.fixture
def data():
    kappa = xr.DataArray([[2.0, 2.1, 2.3], [1.9, 1.8, 1.7]], dims=("spectrum", "load"))
    theory, gap = ("load", [1.6, 1.59, 1.58]), ("load", [3e-6, 2e-6, 1e-6])
    found = xr.Dataset(
        {"kappa": kappa, "kappa_persson": theory, "mean_gap": gap},
        coords={"reduced_pressure": ("load", [0.01, 0.05, 0.1]), "hurst": ("spectrum", [0.3, 0.8])},
    )
    return claim(found, "kappa", surfaces=0.1 * kappa, grid=0.05 * kappa)


@pytest.fixture
def drawing(data):
    lines = [Line(y="kappa", by="spectrum"), Line(y="kappa_persson")]
    gaps = [Line(y="mean_gap"), Band(y="mean_gap", high="mean_gap", label="range")]
    panels = [Panel(marks=lines, x="reduced_pressure", log="x"), Panel(marks=gaps, x="reduced_pressure")]
    return draw(Figure(name="f", caption="c", panels=panels), data)


def line(drawing, k):
    return drawing.drawn[k].artist.lines[0]


def label(drawing, labels):
    """Say other labels of some marks."""
    for k, words in labels.items():
        object.__setattr__(drawing.drawn[k], "label", words)


def in_nanometres(words):
    return words.replace("[um]", "[nm]")


def swap_lines(drawing):
    first, second = line(drawing, 0), line(drawing, 1)
    a, b = first.get_ydata(), second.get_ydata()
    first.set_ydata(b)
    second.set_ydata(a)


def draw_standard_errors(drawing):
    (bars,) = drawing.drawn[0].artist.lines[2]
    bars.set_segments([(seg.mean(axis=0) + (seg - seg.mean(axis=0)) / 1.96) for seg in bars.get_segments()])


MISTAKES = {
    "moved": lambda f: line(f, 0).set_ydata(1.001 * line(f, 0).get_ydata()),
    "lines swapped": swap_lines,
    "theory under another name": lambda f: label(f, {2: "Xu et al. 2024"}),
    "labels reversed": lambda f: label(f, {0: f.drawn[1].label, 1: f.drawn[0].label}),
    "no bars": lambda f: setattr(f.drawn[0].artist, "lines", (line(f, 0), (), ())),
    "standard errors for intervals": draw_standard_errors,
    "metres under micrometres": lambda f: line(f, 3).set_ydata(np.array([3e-6, 2e-6, 1e-6])),
    "another unit": lambda f: f.drawn[3].axes.set_ylabel(in_nanometres(f.drawn[3].axes.get_ylabel())),
    "axis without a name": lambda f: f.drawn[0].axes.set_xlabel(""),
    "legend of another": lambda f: f.drawn[0].artist.set_label(f.drawn[1].label),
    "colour of none": lambda f: line(f, 0).set_color("red"),
    "symbol of another": lambda f: line(f, 2).set_marker("o"),
    "steps where none are": lambda f: line(f, 3).set_drawstyle("steps-mid"),
    "without a part": lambda f: f.drawn[3].axes.yaxis.get_major_formatter().set_useOffset(1.5),
    "beside its place": lambda f: f.drawn[3].axes.yaxis.set_major_formatter("{x:.0f}"),
    "cut off": lambda f: f.drawn[3].axes.set_ylim(bottom=1.5),
    "band elsewhere": lambda f: f.drawn[4].artist.set_verts([[(0.01, 1.7), (0.05, 1.5), (0.1, 1.5)]]),
}


def test_a_figure_of_the_kit_shows_what_it_says(drawing, data):
    assert list(misdrawn(drawing, data)) == []


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_picture_is_noticed(drawing, data, mistake):
    MISTAKES[mistake](drawing)
    assert list(misdrawn(drawing, data))


def test_what_is_nearly_one_is_drawn_whole(data):
    near = data.assign(kappa_persson=1 + 1e-6 * data.kappa_persson)
    panel = Panel(marks=[Line(y="kappa_persson")], x="reduced_pressure")
    assert list(misdrawn(draw(Figure(name="f", caption="c", panels=[panel]), near), near)) == []


@pytest.fixture
def map_drawing():
    x, y = 1e-6 * np.arange(3), 1e-6 * np.arange(3)
    pressure = xr.DataArray(np.arange(18.0).reshape(2, 3, 3), dims=("solver", "x", "y"))
    data = xr.Dataset({"pressure_map": 1e6 * pressure}, {"x": x, "y": y, "solver": ["bem", "fem"]})
    image = Image(y="pressure_map", rows="y", at={"solver": 0})
    return draw(Figure(name="f", caption="c", panels=[Panel(marks=[image], x="x")]), data), data


def test_a_map_of_the_kit_shows_what_it_says(map_drawing):
    assert list(misdrawn(*map_drawing)) == []


MISTAKES_IN_A_MAP = {
    "transposed": lambda one: one.artist.set_array(one.artist.get_array().T),
    "of another solver": lambda one: one.artist.set_array(one.artist.get_array() + 9),
    "in another unit": lambda one: object.__setattr__(one, "label", one.label.replace("MPa", "GPa")),
    "rows in another": lambda one: one.axes.set_ylabel(in_nanometres(one.axes.get_ylabel())),
    "distorted": lambda one: one.axes.set_aspect("auto"),
    "parted beside zero": lambda one: one.artist.set_cmap("RdBu_r"),
}


@pytest.mark.parametrize("mistake", MISTAKES_IN_A_MAP)
def test_a_mistake_in_a_map_is_noticed(map_drawing, mistake):
    drawing, data = map_drawing
    MISTAKES_IN_A_MAP[mistake](*drawing.drawn)
    assert list(misdrawn(drawing, data))


def test_panels_of_the_same_quantities_have_the_same_limits_and_say_them_once(data):
    panel = Panel(marks=[Line(y="kappa")], x="reduced_pressure")
    data = data.assign(kappa=data.kappa.where((data.hurst < 0.5) | (data.reduced_pressure < 0.1)))
    panels = panels_along(data, "spectrum", panel)
    drawing = draw(Figure(name="f", caption="c", panels=panels), data)
    first, second = drawing.figure.axes
    assert (first.get_xlim(), first.get_ylim()) == (second.get_xlim(), second.get_ylim())
    assert [axes.yaxis.label.get_visible() for axes in (first, second)] == [True, False]
    other = replace(panels[1], marks=[Line(y="mean_gap")])
    apart = draw(Figure(name="f", caption="c", panels=[panels[0], other]), data).figure.axes
    assert all(axes.yaxis.label.get_visible() for axes in apart)
