"""The study of large slopes, and what `explain` says from it."""

import numpy as np
import pytest
import xarray as xr

from fem_contact import block
from validation.comparison.explain import finite_slopes
from validation.effects.base import Roughness
from validation.measurements.common import base_case, base_surface
from validation.measurements.measurement import grid_for
from validation.studies import large_slope
from validation.studies.large_slope import CHANGES, with_differences


@pytest.fixture(scope="module")
def small(numbers):
    return numbers("large-slope")


def test_the_differences_are_those_of_the_block_from_the_linear_one(small):
    surface = base_surface(hurst=0.8, periods=1.25, bandwidth=1.6, seed=17)
    case = base_case(surface, reduced_pressure=0.1).further(1)
    field, solid = case.heights(grid_for(case, 5.0)), case.elastic
    load = 0.1 * solid.contact_modulus * field.rms_gradient
    mesh = {"depth": field.lengths[0] / 1.25, "growth": 1.3}
    linear = block.solve(field, solid, mean_pressure=load, method="full", **mesh).contact
    *_, steep = block.solve_slopes(field, solid, mean_pressure=load, slopes=(0.1, 0.2), **mesh)
    found = small.isel(nu=0, load=0, surface=1, grid=-1, slope=-1)
    assert float(found.area_finite_each) == pytest.approx(steep.area / np.mean(linear.in_contact) - 1)
    square = np.mean(steep.shares * steep.pressure**2) / steep.mean_pressure**2
    expected = square / (np.mean(linear.pressure**2) / load**2) - 1
    assert float(found.square_finite_each) == pytest.approx(expected, abs=1e-6)
    assert float(small.residual_each.max()) < 1e-8
    assert not small.path_ended_each.any()


def planted(rate, *, scatter=0.0, ended=0, grid=0.0):
    """A dataset whose area falls by `rate` h' and whose square pressure rises by twice that."""
    slopes = np.array([0.1, 0.2, 0.4, 0.8])
    factors = 1 + scatter * np.array([-1.0, 1.0, -1.0, 1.0])
    each = -rate * np.outer(factors, slopes)
    falls = np.stack([each + grid * rate * slopes, each], axis=1)[None, None]
    if ended:
        falls[:, :, :ended, :, -1] = np.nan
    dims = ("nu", "load", "surface", "grid", "slope")
    many = np.zeros((1, 1, 4, 2))
    many[:, :, :ended] = 1
    changes = {name: falls if name != "square_finite" else -2 * falls for name in CHANGES}
    data = xr.Dataset(
        {f"{name}_grid_each": (dims, array) for name, array in changes.items()}
        | {"path_ended_each": (dims[:-1], many), "paths_ended": float(ended)},
        coords={"poisson": ("nu", [0.3]), "reduced_pressure": ("load", [0.1])}
        | {"points_per_wave": ("grid", [8.0, 12.0]), "rms_gradient": ("slope", slopes)},
    )
    return with_differences(data, differences=large_slope.DIFFERENCES, straight=large_slope.STRAIGHT)


def test_differences_are_passed_at_the_planted_slopes():
    found = planted(0.1).isel(nu=0, load=0)
    assert found.area_finite_crossing.values == pytest.approx([0.1, 0.5])
    assert found.square_finite_crossing.values == pytest.approx([0.05, 0.25])
    assert float(found.area_finite_rate) == pytest.approx(-0.1)
    assert np.isnan(planted(0.01).area_finite_crossing.values.ravel()[1])
    area, _, area_rate, square_rate = large_slope.views(planted(0.1, scatter=0.1)).findings
    assert "by 5 % 0.500 (0.42" in area.text
    assert area_rate.outcomes == ("-",)
    assert square_rate.outcomes == ("+",)
    assert "by 5 % not determinable" in large_slope.views(planted(0.01)).findings[0].text


def test_scatter_between_surfaces_and_the_step_between_grids_widen_the_interval_of_the_slope():
    # Half width of 4 surfaces that scatter by .1: 3.182 * .1 * sqrt(4/3) / 2 = .1837 of the mean.
    found = planted(0.1, scatter=0.1).isel(nu=0, load=0)
    half = 3.182446305284263 * 0.1 * (4 / 3) ** 0.5 / 2
    assert float(found.area_finite_crossing_lower[1]) == pytest.approx(0.5 / (1 + half))
    assert float(found.area_finite_crossing_upper[1]) == pytest.approx(0.5 / (1 - half))
    coarse = planted(0.1, grid=0.2).isel(nu=0, load=0)
    # All four drift alike, by 0.2, with the error that their mean has by that size.
    assert float(coarse.area_finite_crossing_lower[1]) == pytest.approx(0.5 / (1 + 0.2 * (1 + 1 / 4) ** 0.5))


def test_paths_that_end_are_counted_and_their_slopes_left_out_for_all():
    data = planted(0.1, ended=2)
    *_, last = large_slope.views(data).findings
    assert last.text.startswith("2 of 4 paths on the finest grid end before h'_rms = 0.8")
    assert np.isnan(planted(0.01, ended=2).area_finite_crossing.values.ravel()[1])
    assert np.isnan(data.area_finite[0, 0, -1])
    assert np.isfinite(data.area_finite[0, 0, -2])


def rough(slope):
    return Roughness(modulus=1.0, gradient=slope, curvature=1.0, longest=1.0, shortest=0.1, full_energy=1.0)


@pytest.mark.parametrize(("least", "most", "poisson"), [(0.03, 0.08, 0.0), (0.1, 0.2, 0.3), (0.3, 0.6, 0.49)])
def test_explain_judges_slopes_by_what_was_measured(least, most, poisson):
    for slope, matters in ((least, False), (most, True)):
        found = finite_slopes(rough(slope), poisson=poisson)
        assert found.verdict.startswith("matters") is matters
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
