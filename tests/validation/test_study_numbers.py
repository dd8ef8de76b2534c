"""Numbers of single studies and of what they press, on inputs whose answer is known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from planted import STUDENT, PlantedBench, measurement
from scipy.special import erf

from fem_contact import HalfSpace, HeightField, Solid, bem, yielded
from persson import constant_hardness
from validation.effects.base import full_contact_energy
from validation.measurements.common import base_case, base_surface
from validation.measurements.convergence import at_equal, fitted_line, spectral_errors
from validation.measurements.edge import edge_limits, start_of_pressure
from validation.measurements.grids import observed_order, rms_slopes
from validation.measurements.measurement import press_on_grids, pressed_path, truncated_heights
from validation.measurements.statistics import kolmogorov_smirnov, order_of_convergence, weighted_percentile
from validation.measurements.theory import Waves, ensemble_area
from validation.report.estimates import claim, error_of, total_error
from validation.scenes.surfaces import spectrum_of
from validation.scenes.tables import SelfAffineSurface
from validation.studies import graded, magnification
from validation.studies.hardness import remaining_by_theory

SOFT = Solid(young=1.0, poisson=0.0)


def wave(n=32, amplitude=0.01):
    x = np.cos(2 * np.pi * np.arange(n) / n)
    return HeightField(heights=amplitude * x[:, None] * np.ones(n), lengths=(1.0, 1.0))


def pressed(surface, mean_pressure, **settings):
    return bem.solve(surface, HalfSpace(solid=SOFT), mean_pressure=mean_pressure, **settings).checked()


# Studies, one by one.


def test_smoothing_in_the_theory_is_what_has_not_yielded_over_what_will():
    surface = base_surface(hurst=0.7, periods=2.0, bandwidth=8.0, seed=83)
    problem = base_case(surface, reduced_pressure=0.2)
    limit = 0.8 * problem.pressure_scale
    q = spectrum_of(surface).q_long * np.array([1.5, 3.0, 6.0])
    spectrum = problem.spectrum_shape
    factor = problem.field.moments[1] / float(spectrum.m2())
    variance = problem.contact_modulus**2 / 4 * factor * np.asarray(spectrum.m2(q))
    plastic = constant_hardness(problem.pressure, stress_variance=variance, yield_stress=limit).plastic
    # Of the whole area p0 / H yields in the end. The table is joined by power laws over 400 points.
    exact = 1 - plastic * limit / problem.pressure
    assert_allclose(remaining_by_theory(problem, limit, q), exact, atol=2e-3)
    assert exact[-1] < 0.9


def test_the_slope_from_the_contour_is_twice_contour_over_the_squared_edge_coefficient():
    upper = np.linspace(0.005, 0.6, 120)
    # P = 3 sigma above an excess of .001 that is counted at once.
    density = 3.0 * (upper - 0.0025)
    density[0] += 0.001 / 0.005
    data = xr.Dataset(
        {"density": ("bin", density), "excess": 0.001, "contour": 2.0, "inverse_square": 0.7, "patches": 5.0},
        coords={"upper": ("bin", upper)},
    )
    found = start_of_pressure(data, spacing=0.25, window=0.4, slope_window=1.2)
    window = 1.2 * 0.5
    assert_allclose(found.contour_slope_each, 2 * 2.0 * 0.7, rtol=1e-12)
    # The share below the window is read between bins of .005: half a bin, squared, over the window, squared.
    assert_allclose(found.window_slope_each, 3.0, rtol=(0.005 / window) ** 2)
    narrow = 0.4 * 0.5
    exact = (0.001 + 1.5 * narrow**2) / narrow
    assert_allclose(found.density_at_zero_each, exact, rtol=0.02)
    # Beyond the last bin nothing was counted.
    assert start_of_pressure(data, spacing=0.3, window=0.4, slope_window=1.2).window_slope_each.isnull()


def test_densities_and_slopes_at_zero_are_extrapolated_in_their_own_powers_of_the_spacing():
    spacing = np.array([0.16, 0.08, 0.04, 0.02, 0.01])
    root = np.sqrt(spacing)
    rows = {"density_at_zero": 0.02 + 0.4 * root - 0.3 * spacing, "contour_slope": 2.1 + 0.7 * spacing}
    rows["window_slope"] = 2.0 - 0.5 * root + 0.1 * spacing
    each = {name: (("surface", "grid"), np.array([row - 0.01, row + 0.01])) for name, row in rows.items()}
    data = xr.Dataset({f"{name}_each": rows for name, rows in each.items()})
    data = edge_limits(data.assign_coords(spacing=("grid", spacing)))
    for name, value in (("density", 0.02), ("slope_window", 2.0), ("slope_contour", 2.1)):
        limit, drift = data[f"initial_{name}_each"], data[f"initial_{name}_each_drift"]
        assert limit.values == pytest.approx([value - 0.01, value + 0.01], abs=1e-10)
        assert drift.values == pytest.approx([0.0, 0.0], abs=1e-10)


def test_waves_left_out_raise_the_reduced_pressure_of_the_rest():
    """One nominal pressure, theory erf(p / (2 V)^(1/2)) with the gradient of the waves that are there."""
    asked = {"magnifications": (2.0, 4.0), "points_per_wave": (3.0, 4.0), "reduced_pressures": (0.1,)}
    options = magnification.Options(surfaces=2, bandwidth=4.0, periods=2.0, seed=71, **asked)
    cases = magnification.design(options)

    def gradient(one):
        return truncated_heights(one["problem"], one["grids"][0], truncation=one["truncation"]).rms_gradient

    part, whole = gradient(cases[0, 2.0]), gradient(cases[0, 4.0])
    assert part < 0.9 * whole

    def planted(solve):
        rough = solve["problem"].field.rms_gradient
        return measurement(solve, lambda p: 0.2).assign_attrs(rms_gradient=rough)

    data = magnification.run(options, bench=PlantedBench(planted))
    exact = [math.erf(math.sqrt(2) * 0.1 * whole / slope) for slope in (part, whole)]
    assert_allclose(data.area_persson_each[0, :, 0], exact, rtol=1e-9)
    spectrum = options.first.spectrum
    slopes = [math.sqrt(float(spectrum.m2(zeta * spectrum.q_long))) for zeta in (2.0, 4.0)]
    exact = [math.erf(math.sqrt(2) * 0.1 * whole / slope) for slope in slopes]
    assert_allclose(data.area_ensemble_each[0, :, 0], exact, rtol=1e-9)


def test_felt_over_exact_is_one_without_grading_and_grading_is_largest_where_the_profile_is_steepest():
    q = np.array([0.1, 1.0, 10.0])
    solid = Solid(young=3.0, poisson=0.3)
    share = graded._share(lambda wave: np.full(wave.shape, 3.0 / 0.91), HalfSpace(solid=solid), q)
    assert_allclose(share, 1.0, rtol=1e-12)
    # E = r + (1 - r) e^-z: at the surface |1 - r|, and for r < 1 largest far below, where E = r.
    assert_allclose(graded._grading(3.0, q), 2.0 / q, rtol=1e-12)


def test_an_order_is_that_of_the_mean_error_with_the_jackknife_of_the_surfaces():
    points = np.array([4.0, 8.0, 16.0])
    exact = np.stack([a * points**-1.5 for a in (0.9, 1.0, 1.1)])
    coords = {"points_per_wave": ("grid", points)}
    data = xr.Dataset({"distance_each": (("surface", "grid"), exact)}, coords)
    found = observed_order(data, "distance", to="order")
    assert_allclose(found.order, 1.5, rtol=1e-12)
    assert float(total_error(found, "order")) < 1e-9
    two = observed_order(data.isel(grid=slice(1, 3)), "distance", to="order")
    assert_allclose(two.order, 1.5, rtol=1e-12)
    # Orders 1 and 2: without one of them it is the other's.
    data["distance_each"] = (("surface", "grid"), np.array([points**-1.0, points**-2.0, points**-1.5]))
    means = [np.delete(data.distance_each.values, k, 0).mean(0) for k in range(3)]
    left = [order_of_convergence(1 / points, mean) for mean in means]
    half = STUDENT[3] * math.sqrt(2 / 3 * np.var(left) * 3)
    found = observed_order(data, "distance", to="order")
    assert_allclose(total_error(found, "order"), half, rtol=1e-9)
    assert np.isnan(observed_order(data * np.nan, "distance", to="order").order)


def test_forward_and_central_slopes_of_a_wave_are_those_of_its_differences():
    n = 16
    slopes = rms_slopes(wave(n))
    exact = 2 * math.pi * 0.01 / math.sqrt(2)
    step = math.pi / n
    assert slopes["spectral"] == pytest.approx(exact, rel=1e-12)
    assert slopes["forward"] == pytest.approx(exact * math.sin(step) / step, rel=1e-12)
    assert slopes["central"] == pytest.approx(exact * math.sin(2 * step) / (2 * step), rel=1e-12)


# What studies measure with.


@pytest.fixture(scope="module")
def flattened():
    """A surface in full contact, measured along two loads."""
    case = base_case(base_surface(hurst=0.8, periods=1.6, bandwidth=2.5, seed=89), reduced_pressure=6.0)
    asked = {"reduced_pressures": (5.0, 6.0), "grids": ((16, 16), (24, 24)), "shifts": 1}
    return case, press_on_grids(problem=case, **asked)


def test_the_energy_of_a_measurement_at_full_contact_is_the_sum_over_waves(flattened):
    case, solve = flattened
    data = solve.do()
    exact = full_contact_energy(case.field, modulus=case.contact_modulus)
    assert_allclose(data.energy.values, exact, rtol=1e-8)
    assert data.attrs["full_contact_energy"] == pytest.approx(exact, rel=1e-12)


def test_distances_of_distributions_do_not_depend_on_how_many_were_counted():
    one, two = np.array([1.0, 1.0, 2.0]), np.array([1.0, 2.0, 1.0])
    assert kolmogorov_smirnov(one, two) == pytest.approx(0.25, rel=1e-12)
    assert kolmogorov_smirnov(7 * one, two) == pytest.approx(0.25, rel=1e-12)
    edges = np.array([1.0, 10.0, 100.0, 1000.0])
    assert weighted_percentile(9 * one, edges, 0.5) == pytest.approx(100.0, rel=1e-12)


def test_energy_and_variance_of_the_waves_of_a_field_are_those_of_its_spectrum():
    field = wave()
    waves = Waves.of_field(field)
    q = 2 * math.pi
    assert waves.full_energy == pytest.approx(q * 0.01**2 / 8, rel=1e-12)
    assert waves.variance.mean() == pytest.approx((q * 0.01) ** 2 / 2 / 4 / 2, rel=1e-12)


def test_variances_expected_of_a_spectrum_scatter_with_the_squared_gradients_about_its_own():
    surface = base_surface(hurst=0.8, periods=2.0, bandwidth=4.0, seed=97)
    found = ensemble_area(spectrum_of(surface), [0.3], rms_gradients=[0.1, 0.2])
    spread = (2 * 0.1**2 / 4 * np.array([0.4, 1.6])) ** 0.5
    expected = [[erf(0.3 * gradient / spread).mean()] for gradient in (0.1, 0.2)]
    assert_allclose(found, expected, rtol=1e-9)


def test_rungs_of_a_known_order_lead_to_their_limit_and_a_shift_grows_with_it():
    steps = np.array([0.4, 0.2, 0.1])
    found = fitted_line([[2.0 + 0.5 * s**1.5] * 2 for s in steps], steps**1.5, common=True)
    assert found.limit == pytest.approx(2.0, rel=1e-12)
    assert found.slope == pytest.approx(0.5, rel=1e-10)
    assert found.reach == pytest.approx(0.1**1.5 / (0.4**1.5 - 0.1**1.5), rel=1e-12)
    told = {"limit": 2.0, "slope": -0.5}
    ladders = xr.Dataset(coords={"hurst_ladder": ("ladder", [0.3])})
    for kind, order in (("bandwidth", 1.4), ("size", 2.0)):
        ladders[f"order_by_{kind}"] = ("ladder", [order])
        for name, value in told.items():
            ladders[f"kappa_by_{kind}_{name}"] = ("ladder", [value])
        ladders = claim(ladders, f"kappa_by_{kind}_slope", surfaces=0.3)
        ladders = claim(ladders, f"kappa_by_{kind}_limit", **{kind: 0.1 if kind == "bandwidth" else 0.001})
    shares = spectral_errors(ladders, hurst=0.3, bandwidth=8.0, periods=4.0)
    # Of the bandwidth the limit is less sure than the shift, of the sample the shift.
    assert_allclose(shares["bandwidth"], (0.5 * 8**-1.4 + 0.1) / 2, rtol=1e-12)
    assert_allclose(shares["size"], 0.8 / 4**2 / 2, rtol=1e-12)
    others = spectral_errors(ladders, hurst=0.5, bandwidth=8.0, periods=4.0)
    assert all(np.isnan(share) for share in others.values())


def test_a_path_presses_each_load_with_the_gradient_of_the_whole_surface():
    case = base_case(base_surface(hurst=0.8, periods=1.6, bandwidth=2.5, seed=101), reduced_pressure=0.1)
    path = pressed_path(case.heights((16, 16)), case, (0.05, 0.2), tolerance=1e-8)
    found = [result.mean_pressure for result in path]
    unit = case.contact_modulus * case.field.rms_gradient
    assert_allclose(found, [0.05 * unit, 0.2 * unit], rtol=1e-6)


# What is pressed.


@pytest.mark.parametrize("rolloff", ["plateau", "smooth"])
def test_the_rolloff_of_a_scene_is_that_of_its_spectrum_down_to_the_period(rolloff):
    surface = SelfAffineSurface(
        kind="self-affine", length=(1e-3, 5e-4), hurst=0.8, lambda_long=1e-4, lambda_short=1e-5,
        rms_gradient=0.1, rolloff=rolloff, seed=3,
    )  # fmt: skip
    spectrum = spectrum_of(surface)
    long = 2 * math.pi / 1e-4
    bend = {"plateau": 1.0, "smooth": ((1 + 0.2**2) / 2) ** -1.8}[rolloff]
    assert_allclose(spectrum(0.2 * long) / spectrum(long), bend, rtol=1e-12)
    assert spectrum.q_min == pytest.approx(2 * math.pi / 1e-3, rel=1e-12)


def test_further_realisations_have_seeds_of_their_own_and_share_no_wave():
    case = base_case(base_surface(hurst=0.8, periods=4.0, bandwidth=4.0, seed=103), reduced_pressure=0.1)
    fields = [case.further(k).field.heights for k in range(3)]
    seeds = [case.surface.seed_of(k) for k in range(3)]
    assert seeds == [103, 104, 105]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        alike = np.corrcoef(fields[one].ravel(), fields[other].ravel())[0, 1]
        # About 800 waves with independent phases: four deviations of (2 / m)^(1/2).
        assert abs(alike) < 0.2


def test_yielded_and_elastic_areas_and_loads_are_those_of_their_points():
    contact = pressed(wave(), 0.01, pressure_bound=0.02)
    weights = np.tile([[1.5], [0.5]], (16, 32))
    found = yielded(replace(contact, weights=weights))
    bound, touching = np.asarray(contact.at_bound), np.asarray(contact.in_contact)
    assert bound.any()
    assert found.plastic_area == pytest.approx((weights * bound).sum() / 1024, rel=1e-12)
    # The points at the bound have more than their share of the area.
    assert abs((weights * bound).sum() / bound.sum() - 1) > 0.01
    assert found.elastic_area == pytest.approx((weights * (touching & ~bound)).sum() / 1024, rel=1e-12)
    assert found.plastic_load == pytest.approx(0.02 * (weights * bound).sum() / 1024, rel=1e-8)
    assert found.elastic_area + found.plastic_area + found.open_area == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(("last", "kappa"), [(4.0, [3.0, 10.0]), (4.1, [np.nan, np.nan])])
def test_rows_are_compared_at_the_largest_value_that_all_have_be_it_the_first_of_one(last, kappa):
    each = xr.DataArray([[1.0, 3.0], [10.0, 30.0]], dims=("hurst", "rung"))
    alpha = each.copy(data=[[2.0, 4.0], [last, 8.0]])
    data = xr.Dataset({"kappa_each": each, "kappa_each_drift": 0 * each, "alpha": alpha})
    data = data.assign(kappa_each_error=error_of(each, grid=0.1))
    found = at_equal(data, "kappa", x="alpha", along="rung")
    assert float(found.alpha_equal) == 4.0
    assert_allclose(found.kappa_equal_each, kappa)
