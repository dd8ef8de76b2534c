"""The study of large slopes, and what `explain` says from it."""

import numpy as np
import pytest
import xarray as xr

from fem_contact import block
from validation.comparison.finite_slopes import finite_slopes
from validation.effects.base import Roughness
from validation.measures.common import base_case, base_surface
from validation.measures.measurement import grid_for
from validation.solves.bench import Bench
from validation.studies import large_slope


def small_options():
    return large_slope.Options(
        slopes=(0.1, 0.2),
        reduced_pressures=(0.1,),
        poissons=(0.3,),
        surfaces=2,
        points_per_wave=(4.0, 5.0),
        seed=17,
    )


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return large_slope.run(small_options(), bench=Bench.at(tmp_path_factory.mktemp("slopes")))


def test_the_differences_are_those_of_the_block_from_the_linear_one(small):
    surface = base_surface(hurst=0.8, periods=1.0, bandwidth=2.0, seed=17)
    case = base_case(surface, reduced_pressure=0.1).further(1)
    field, solid = case.heights(grid_for(case, 5.0)), case.elastic
    load = 0.1 * solid.contact_modulus * field.rms_gradient
    mesh = {"depth": field.lengths[0], "growth": 1.3}
    linear = block.solve(field, solid, mean_pressure=load, method="full", **mesh).contact
    *_, steep = block.solve_slopes(field, solid, mean_pressure=load, slopes=(0.1, 0.2), **mesh)
    found = small.isel(nu=0, load=0, surface=1, grid=-1, slope=-1)
    assert float(found.projected_area) == pytest.approx(steep.area / np.mean(linear.in_contact) - 1)
    square = np.mean(steep.shares * steep.pressure**2) / steep.mean_pressure**2
    expected = square / (np.mean(linear.pressure**2) / load**2) - 1
    assert float(found.square_pressure) == pytest.approx(expected, abs=1e-6)
    assert float(small.residual.max()) < 1e-8
    assert not small.ended.any()


def planted(rate, *, scatter=0.0, ended=0):
    """A dataset whose area falls by `rate` h' and whose square pressure rises by twice that."""
    slopes = np.array([0.1, 0.2, 0.4, 0.8])
    factors = 1 + scatter * np.array([-1.0, 1.0, -1.0, 1.0])
    each = -rate * np.outer(factors, slopes)
    falls = np.broadcast_to(each[None, None, :, None], (1, 1, 4, 2, 4)).copy()
    if ended:
        falls[:, :, :ended, :, -1] = np.nan
    dims = ("nu", "load", "surface", "grid", "slope")
    many = np.zeros((1, 1, 4, 2), dtype=int)
    many[:, :, :ended] = 1
    values = {
        "projected_area": falls,
        "square_pressure": -2 * falls,
        "true_area": falls,
        "material_area": falls,
    }
    return xr.Dataset(
        {name: (dims, array) for name, array in values.items()} | {"ended": (dims[:-1], many)},
        coords={
            "poisson": ("nu", [0.3]),
            "reduced_pressure": ("load", [0.1]),
            "points_per_wave": ("grid", [8.0, 12.0]),
            "slope": slopes,
        },
    )


def test_sentences_name_the_slopes_at_which_the_difference_passes_one_and_five_per_cent():
    area, square = large_slope.findings(planted(0.1))
    assert "area projected on the plane differs from the linear one by 1 % from h'_rms = 0.1 on" in area
    assert "5 % from h'_rms = 0.5 on" in area
    assert "by the part -0.1 +- 0 times h'_rms" in area
    assert "1 % from h'_rms = 0.05 on" in square
    assert "5 % from h'_rms = 0.25 on" in square
    assert "5 % nowhere up to h'_rms = 0.8" in large_slope.findings(planted(0.01))[0]


def test_scatter_between_surfaces_widens_the_interval_of_the_slope():
    # Half width of 4 surfaces that scatter by .1: 3.182 * .1 * sqrt(4/3) / 2 = .1837 of the mean.
    area = large_slope.findings(planted(0.1, scatter=0.1))[0]
    assert "5 % from h'_rms = 0.5 on (0.42 to 0.61" in area


def test_paths_that_end_are_counted_and_their_slopes_left_out_for_all():
    data = planted(0.1, ended=2)
    *_, last = large_slope.findings(data)
    assert last.startswith("2 of 4 paths on the finest grid end before h'_rms = 0.8")
    assert "nowhere up to h'_rms = 0.4" in large_slope.findings(planted(0.01, ended=2))[0]
    assert np.isnan(large_slope.table(data).rows[-1][3])


def test_the_figure_shows_both_differences(small):
    (drawing,) = large_slope.figures(small)
    left, right = drawing.figure.axes
    assert "A over that of the linear block" in left.get_ylabel()
    assert "p^2" in right.get_ylabel()


def rough(slope):
    return Roughness(modulus=1.0, gradient=slope, curvature=1.0, longest=1.0, shortest=0.1, full_energy=1.0)


@pytest.mark.parametrize(
    ("slope", "poisson", "matters"),
    [
        (0.03, 0.0, False),
        (0.08, 0.0, True),
        (0.1, 0.3, False),
        (0.2, 0.3, True),
        (0.3, 0.49, False),
        (0.6, 0.49, True),
    ],
)
def test_explain_judges_slopes_by_what_was_measured(slope, poisson, matters):
    found = finite_slopes(rough(slope), poisson=poisson)
    assert found.matters is matters
    assert found.negligible is not matters


def test_explain_says_the_measured_change():
    found = finite_slopes(rough(0.2), poisson=0.3)
    assert "contact area by about -2 %" in found.number
    assert "rms pressure by +2 %" in found.number


@pytest.mark.parametrize("name", ["slopes", "points_per_wave"])
def test_one_value_is_refused_where_two_are_needed(name):
    with pytest.raises(ValueError, match="at least 2"):
        large_slope.Options(**{name: (0.1,)})
    with pytest.raises(ValueError, match="at least"):
        large_slope.Options(reduced_pressures=())
