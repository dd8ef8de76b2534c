"""What reading figures back notices: each kind of mistake in a picture, planted."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from reading_back import misdrawn

from validation.report.estimates import claim
from validation.report.marks import Figure, Image, Line, Panel, draw, panels_along


@pytest.fixture
def data():
    kappa = xr.DataArray([[2.0, 2.1, 2.3], [1.9, 1.8, 1.7]], dims=("spectrum", "load"))
    found = xr.Dataset(
        {
            "kappa": kappa,
            "kappa_persson": ("load", [1.6, 1.59, 1.58]),
            "mean_gap": ("load", [3e-6, 2e-6, 1e-6]),
        },
        coords={"reduced_pressure": ("load", [0.01, 0.05, 0.1]), "hurst": ("spectrum", [0.3, 0.8])},
    )
    return claim(found, "kappa", surfaces=0.1 * kappa, grid=0.05 * kappa)


@pytest.fixture
def drawing(data):
    lines = [Line(y="kappa", by="spectrum"), Line(y="kappa_persson")]
    gap = Panel(marks=[Line(y="mean_gap")], x="reduced_pressure")
    return draw(
        Figure(name="f", caption="c", panels=[Panel(marks=lines, x="reduced_pressure", log="x"), gap]), data
    )


def line(drawing, k):
    return drawing.drawn[k].artist.lines[0]


def moved(drawing):
    line(drawing, 0).set_ydata(1.001 * line(drawing, 0).get_ydata())


def swapped_lines(drawing):
    first, second = line(drawing, 0), line(drawing, 1)
    a, b = first.get_ydata(), second.get_ydata()
    first.set_ydata(b)
    second.set_ydata(a)


def theory_under_another_name(drawing):
    object.__setattr__(drawing.drawn[2], "label", "Xu et al. 2024")


def reversed_labels(drawing):
    labels = [drawing.drawn[k].label for k in (1, 0)]
    for k, label in enumerate(labels):
        object.__setattr__(drawing.drawn[k], "label", label)


def no_bars(drawing):
    artist = drawing.drawn[0].artist
    artist.lines = (artist.lines[0], (), ())


def standard_errors_for_intervals(drawing):
    (bars,) = drawing.drawn[0].artist.lines[2]
    bars.set_segments([(seg.mean(axis=0) + (seg - seg.mean(axis=0)) / 1.96) for seg in bars.get_segments()])


def metres_under_micrometres(drawing):
    line(drawing, 3).set_ydata(np.array([3e-6, 2e-6, 1e-6]))


def another_unit(drawing):
    axes = drawing.drawn[3].axes
    axes.set_ylabel(axes.get_ylabel().replace("[um]", "[nm]"))


def axis_without_a_name(drawing):
    drawing.drawn[0].axes.set_xlabel("")


def test_a_figure_of_the_kit_shows_what_it_says(drawing, data):
    assert list(misdrawn(drawing, data)) == []


@pytest.mark.parametrize(
    "mistake",
    [
        moved,
        swapped_lines,
        theory_under_another_name,
        reversed_labels,
        no_bars,
        standard_errors_for_intervals,
        metres_under_micrometres,
        another_unit,
        axis_without_a_name,
    ],
)
def test_a_mistake_in_a_picture_is_noticed(drawing, data, mistake):
    mistake(drawing)
    assert list(misdrawn(drawing, data))


@pytest.fixture
def map_drawing():
    x, y = 1e-6 * np.arange(3), 1e-6 * np.arange(3)
    pressure = xr.DataArray(np.arange(18.0).reshape(2, 3, 3), dims=("solver", "x", "y"))
    data = xr.Dataset({"pressure_map": 1e6 * pressure}, {"x": x, "y": y, "solver": ["bem", "fem"]})
    image = Image(y="pressure_map", rows="y", at={"solver": 0})
    return draw(Figure(name="f", caption="c", panels=[Panel(marks=[image], x="x")]), data), data


def test_a_map_of_the_kit_shows_what_it_says(map_drawing):
    assert list(misdrawn(*map_drawing)) == []


@pytest.mark.parametrize("mistake", ["transposed", "of another solver", "in another unit", "rows in another"])
def test_a_mistake_in_a_map_is_noticed(map_drawing, mistake):
    drawing, data = map_drawing
    (one,) = drawing.drawn
    if mistake == "transposed":
        one.artist.set_array(one.artist.get_array().T)
    elif mistake == "of another solver":
        one.artist.set_array(one.artist.get_array() + 9)
    elif mistake == "rows in another":
        one.axes.set_ylabel(one.axes.get_ylabel().replace("[um]", "[nm]"))
    else:
        object.__setattr__(one, "label", one.label.replace("MPa", "GPa"))
    assert list(misdrawn(drawing, data))


def test_panels_of_the_same_quantities_have_the_same_limits_and_say_them_once(data):
    panel = Panel(marks=[Line(y="kappa")], x="reduced_pressure")
    panels = panels_along(data, "spectrum", panel)
    drawing = draw(Figure(name="f", caption="c", panels=panels), data)
    first, second = drawing.figure.axes
    assert (first.get_xlim(), first.get_ylim()) == (second.get_xlim(), second.get_ylim())
    assert [axes.yaxis.label.get_visible() for axes in (first, second)] == [True, False]
    other = replace(panels[1], marks=[Line(y="mean_gap")])
    apart = draw(Figure(name="f", caption="c", panels=[panels[0], other]), data).figure.axes
    assert all(axes.yaxis.label.get_visible() for axes in apart)
