"""The study `macroasperities`: its instrument is the solver's, its sentences are the numbers'."""

import numpy as np
import pytest

from fem_contact import HalfSpace, bem, contact_areas
from fem_contact.leak import percolates
from validation.measures.measurement import grid_for, without_waves_beyond
from validation.solves.bench import Bench
from validation.studies import macroasperities
from validation.studies.macroasperities import _sharpest_bend, sentences

ZETA = (0.5, 1.0, 2.0, 4.0)


@pytest.fixture(scope="module")
def options():
    return macroasperities.Options(
        reduced_pressures=(0.01, 0.05, 0.2),
        magnifications=ZETA,
        percolating=(0.1,),
        periods=3.0,
        bandwidth=4.0,
        surfaces=3,
        seed=17,
    )


@pytest.fixture(scope="module")
def data(options, tmp_path_factory):
    return macroasperities.run(options, bench=Bench.at(tmp_path_factory.mktemp("solves")))


def pressed(options, k, *, zeta, load):
    """The same state once more, cold."""
    case = options.first.further(k)
    field = case.heights(grid_for(case, options.points_per_wave))
    cut = without_waves_beyond(field, zeta * 2 * np.pi / case.longest)
    pressure = load * case.pressure_scale
    return bem.solve(cut, HalfSpace(solid=case.elastic), mean_pressure=pressure).checked()


def test_areas_and_shares_are_those_of_the_surface_with_its_waves_up_to_zeta(options, data):
    seen, whole = (pressed(options, 2, zeta=zeta, load=0.05) for zeta in (1.0, 4.0))
    area = contact_areas(seen, subcell=True).subcell
    assert float(data.area[2, 1, 1]) == pytest.approx(area, rel=1e-5)
    inside = whole.pressure[seen.in_contact].sum() / whole.pressure.sum()
    assert float(data.load_inside[2, 1, 1]) == pytest.approx(inside, rel=1e-4)
    assert data.load_inside.values[..., -1] == pytest.approx(1.0, abs=1e-12)


def test_the_gradient_of_the_waves_that_are_there_is_what_the_theory_is_told(data):
    # 1 - A/A0 = erfc(sqrt 2 p0 / (E* h'(zeta))): with fewer waves there is more contact.
    assert np.all(np.diff(data.gradient) > 0)
    assert data.gradient.values[:, -1] == pytest.approx(1.0)
    assert np.all(np.diff(data.theory, axis=-1) <= 0)
    light = data.theory[:, 0, -1].values / 0.01
    assert light == pytest.approx(np.sqrt(8 / np.pi), rel=1e-3)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_gap_is_closed_before_its_threshold_and_open_behind_it(options, data, axis):
    at = float(data.gap_zeta.sel(axis=axis)[1, 0])
    before, behind = (pressed(options, 1, zeta=at * by, load=0.1) for by in (0.99, 1.01))
    assert not percolates(~before.in_contact, axis)
    assert percolates(~behind.in_contact, axis)
    areas = [contact_areas(state, subcell=True).subcell for state in (behind, before)]
    assert areas[0] < float(data.gap_threshold.sel(axis=axis)[1, 0]) < areas[1]


def test_the_sharpest_bend_of_a_curve_is_where_it_turns():
    x = np.linspace(-1, 3, 9)
    # d^2 y / dx^2 = sech^2(x - 1.1) is largest at x = 1.1.
    found = _sharpest_bend(np.exp(x), np.exp(np.log(np.cosh(x - 1.1))))
    assert np.log(found) == pytest.approx(1.1, abs=0.05)
    assert np.isnan(_sharpest_bend(np.exp(x), np.exp(-np.cosh(x))))  # bends down everywhere
    assert np.isnan(_sharpest_bend(np.exp(x), np.exp(np.exp(-x))))  # bends most at its beginning


def planted(data, *, power):
    """Contact seen at zeta = 1, and the macroasperities of the simulation, grow with a power of the load."""
    told = data.copy(deep=True)
    loads = told.reduced_pressure.values
    for k, scatter in enumerate((0.99, 1.0, 1.01)):
        told["area"][k, :, 1] = scatter * loads**power
        told["macro_pressure"][k, 1] = loads ** (1 - power)
    return told


def test_a_pressure_that_stays_is_called_independent_and_one_that_rises_is_not(data):
    level, rising = (list(sentences.all_of(planted(data, power=p), paper=0.3)) for p in (1.0, 0.5))
    assert (
        "it rises 1 +- 0 times while the load rises 20 times; it is the same within 10 % at every load"
        in level[-3]
    )
    assert "it rises 4.472 +- 0 times" in rising[-3]
    assert "the same within 10 % up to p* = 0.01, and not at p* =" in rising[-3]
    assert "4.472 +- 0 at p* = 0.2" in rising[-2]
    assert level[-2].endswith("it is the same within 10 % at every load.")


def test_thresholds_are_means_over_surfaces_of_both_directions(data):
    told = data.copy(deep=True)
    told["contact_threshold"][:, 0] = [[0.30, 0.40], [0.36, 0.38], [0.38, 0.40]]
    said = list(sentences.all_of(told, paper=0.3))
    half = 4.302652729911275 * np.std([0.35, 0.37, 0.39], ddof=1) / np.sqrt(3)
    assert f"at A/A0 = 0.37 +- {half:.2g} (located area, 95 % over 3 surfaces)" in said[1]
    assert "The paper's 0.3 lies outside that interval." in said[1]
    assert "The paper's 0.33 lies inside that interval." in list(sentences.all_of(told, paper=0.33))[1]
    told["contact_threshold"][0, 0, 0] = np.nan
    assert "not on every surface" in list(sentences.all_of(told, paper=0.3))[1]


def test_figures_and_table_hold_every_case(options, data):
    names = {drawing.name for drawing in macroasperities.figures(data)}
    assert names == {"patches-over-magnification", "macroasperity-pressure", "percolation"}
    rows = macroasperities.table(data).rows
    assert len(rows) == 3 * len(ZETA)
    assert rows[4][2] == pytest.approx(float(data.area[:, 1, 0].mean()))
    without = options.model_copy(update={"percolating": ()})
    assert not without.percolating
