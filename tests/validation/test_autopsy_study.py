"""The study `autopsy`: its instrument is exact where all is known, its budgets close, its outcomes follow."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from planted import decided
from pydantic import ValidationError
from scipy.special import ndtr, stdtrit

from persson import elastic, solve_diffusion
from validation.measurements import diffusion, limits, rings
from validation.measurements.common import base_case, base_surface
from validation.measurements.rings import (
    Pressed,
    budget,
    composed_inflow,
    diffused_area,
    memory,
    ring_ends,
)
from validation.report.estimates import derive, mean, ratio_of_means
from validation.studies import autopsy

SMALL = {"periods": 2, "bandwidth": 4.0, "surfaces": 2, "probe_surfaces": 2, "probes": (2.0,)}


def chain(*, load, **changes):
    surface = base_surface(hurst=0.8, periods=2.0, bandwidth=4.0, seed=71)
    settings = {
        "problem": base_case(surface, reduced_pressure=load),
        "points": 48,
        "ends": (1.0, 2**0.5, 2.0, 2**1.5, 4.0),
        "restarts": (1.0, 2.0),
    }
    return rings.chain(**{**settings, **changes})


def test_a_ratio_of_means_has_a_value_where_one_surface_has_none():
    gone, back = ("surface", [2.0, 4.0, 0.0]), ("surface", [1.5, 2.0, 1.0])
    data = xr.Dataset({"share_lost_each": gone, "share_entered_each": back})
    ratio = ratio_of_means("share_entered_each", "share_lost_each", "surface")
    data = mean(derive(data, entered_ratio_each=ratio), "entered_ratio")
    assert data.entered_ratio.item() == pytest.approx(0.75)
    # Residuals 0, -1 and 1 of a mean of 2, and Student's factor of three samples.
    half = data.entered_ratio_error.sel(source="surfaces").item()
    assert half == pytest.approx(stdtrit(2, 0.975) * 0.5 / 3**0.5)


@pytest.fixture(scope="module")
def full():
    """A chain whose contact stays full: what the theory says of it is exact."""
    return chain(load=1.8).do()


def test_at_full_contact_every_term_is_that_of_the_theory_to_rounding(full):
    growth = np.diff(full.variance_share.values) / full.variance_share.values[:-1]
    # D = 1: the mean of delta^2 is Delta V, for the points all together.
    assert_allclose(full.pressure_change_square, growth, rtol=1e-12)
    # No drift, for points of any pressure: that of a ring is minus that of its negative.
    assert np.count_nonzero(full.bin_contact.values[-1]) > 10
    rounding = 1e-12 * float(full.nominal)
    assert_allclose(full.bin_change, 0, atol=rounding)
    assert_allclose(full.pressure_cross_change, 0, atol=rounding)
    # Nothing crosses p = 0: the fluxes of Eqs. 24 to 26 vanish, and with them what they carry.
    for name in ("area_lost", "area_entered", "load_entered", "square_entered", "pressure_change"):
        assert_allclose(full[name], 0, atol=rounding)
    assert_allclose(full.square_change, growth, rtol=1e-9)
    assert_array_equal(full.subcell, 1.0)


def test_at_full_contact_restarted_diffusion_keeps_all_area_and_nothing_is_remembered(full):
    # Eight deviations from zero: the normal distribution of the theory has nothing there, either.
    heavy = chain(load=4.0, ends=(1.0, 2.0, 4.0), points=32).do()
    known = heavy.area_diffused.values[np.isfinite(heavy.area_diffused.values)]
    assert known.size == 5
    assert_allclose(known, 1.0, rtol=1e-12)
    assert float(full.points_out.sum()) == 0
    assert float(full.contact_crossed) == 0


@pytest.fixture(scope="module")
def partial():
    return chain(load=0.1).do()


def test_no_point_is_missing_from_the_budgets_of_area_load_and_square(partial):
    both = partial.pixel.mean("sign").values[1:] - partial.pixel.values[0, :-1]
    assert_allclose(partial.area_entered - partial.area_lost, both, atol=1e-14)
    assert_allclose(partial.pressure_change, -partial.load_entered, rtol=1e-9)
    told = partial.pressure_change_square + 2 * partial.pressure_cross_change + partial.square_entered
    assert_allclose(told, partial.square_change, rtol=1e-9)
    for name, total in (
        ("bin_contact", partial.pixel[0, :-1]),
        ("bin_lost", partial.area_lost),
        ("bin_change", partial.pressure_change),
    ):
        assert_allclose(partial[name].sum("bin"), total, atol=1e-12)


def test_the_chain_ends_at_the_whole_surface(partial):
    case = chain(load=0.1)
    whole, ends = case["problem"].heights((48, 48)).heights, case["ends"]
    own = rings.Rings(case["problem"], 48, 1e-7)
    assert_allclose(own.heights(0.0, 4.0), whole, atol=1e-12 * np.abs(whole).max())
    total = sum(own.heights(*pair) for pair in zip((0.0, *ends), ends, strict=False))
    assert_allclose(total, whole, atol=1e-12 * np.abs(whole).max())
    # p* = p0/(E* h'_rms) and E* h'_rms = 2 sqrt(V).
    assert_allclose(partial.nominal, 0.2, rtol=1e-9)


def test_flows_of_a_free_walk_are_those_of_the_normal_distribution():
    rng = np.random.default_rng(77)
    stress, step = rng.normal(0.5, 1.0, 400_000), 0.1 * rng.normal(0.0, 1.0, 400_000)

    def state(values):
        return Pressed(pressure=np.maximum(values, 0), in_contact=values > 0)

    found = budget(state(stress), [state(stress + sign * step) for sign in (1, -1)], unit=1.0)
    p = (np.arange(20_000) + 0.5) * 3e-4
    density = np.exp(-0.5 * (p - 0.5) ** 2) / np.sqrt(2 * np.pi)
    lost = 3e-4 * np.sum(density * ndtr(-p / 0.1))
    net = ndtr(0.5 / np.sqrt(1.01)) - ndtr(0.5)
    # Both signs of a step are one sample of the counts.
    error = np.sqrt(lost / stress.size)
    assert found["area_lost"] == pytest.approx(lost, abs=4 * error)
    assert found["area_entered"] - found["area_lost"] == pytest.approx(net, abs=4 * np.sqrt(2) * error)


def test_drift_and_diffusivity_are_found_where_they_were_put():
    rng = np.random.default_rng(78)
    p = rng.uniform(2.0, 5.0, 100_000)
    before = Pressed(pressure=p, in_contact=np.ones(p.size, dtype=bool))
    step = 0.02 * rng.normal(0.0, 1.0, p.size)
    after = [
        Pressed(pressure=p - 0.001 * p + sign * step, in_contact=before.in_contact) for sign in (1.0, -1.0)
    ]
    bins = budget(before, after, unit=1.0)
    held = bins["bin_contact"] > 0
    assert_allclose(bins["bin_change"][held], -0.001 * bins["bin_pressure"][held], rtol=1e-9)
    square = np.mean(step**2) + np.mean((0.001 * p) ** 2)
    assert bins["bin_change_square"].sum() == pytest.approx(square, rel=1e-9)


def test_diffusion_started_from_a_distribution_is_that_of_each_of_its_pressures():
    pressure = np.array([0.0, 0.3, 1.0, 2.5])
    state = Pressed(pressure=pressure, in_contact=pressure > 0)
    by_equation = sum(
        float(solve_diffusion([0.49], pressure=p).checked().area_elastic[0]) for p in pressure[1:]
    )
    assert diffused_area(state, 0.49) == pytest.approx(by_equation / 4, rel=1e-6)


def test_persson_s_own_distribution_goes_on_as_if_nothing_had_happened():
    """Restarted from the theory's own P(p), diffusion ends at the theory's area."""
    p = (np.arange(200_000) + 0.5) * 5e-5
    density = (np.exp(-0.5 * (p - 0.4) ** 2) - np.exp(-0.5 * (p + 0.4) ** 2)) / np.sqrt(2 * np.pi)
    share = density * 5e-5
    drawn = np.repeat(p, np.round(share * 1e7).astype(int))
    state = Pressed(pressure=drawn, in_contact=np.ones(drawn.size, dtype=bool))
    area = diffused_area(state, 1.0) * share.sum()
    assert area == pytest.approx(float(elastic.contact_area(0.4, stress_variance=2.0)), rel=1e-3)


def test_memory_counts_returns_by_the_rings_since_leaving():
    rows = ("xxx..", "x.x..", "x...x", "xxx..")
    found = memory([np.array([letter == "x" for letter in row]) for row in rows])
    # Out when a ring began: never in contact 2 + 2 + 1; left one ring ago 1 + 1; two rings ago 1.
    assert found["points_out"][1].tolist() == [5, 2, 1, 0, 0]
    assert found["points_returned"][1].tolist() == [1, 1, 1, 0, 0]
    assert found["contact_crossed"] == pytest.approx(2 / 3)
    assert found["contact_out"][1] == pytest.approx([0, 1 / 3, 2 / 3, 0])
    assert found["inflow"][1] == pytest.approx([1 / 5, 1 / 5])


def test_without_memory_two_rings_compose():
    rng = np.random.default_rng(79)
    contact = [rng.random(200_000) < 0.5]
    for _ in range(2):
        draw = rng.random(contact[0].size)
        contact.append(np.where(contact[-1], draw < 0.8, draw < 0.1))
    first, before, after = (Pressed(pressure=c.astype(float), in_contact=c) for c in contact)
    true = float(np.mean(~first.in_contact & after.in_contact))
    assert composed_inflow(~first.in_contact, before, after, unit=1.0) == pytest.approx(true, rel=0.03)


def test_a_ring_is_as_high_as_its_step_asks_for_and_the_load_is_of_the_waves_there():
    surface = base_surface(hurst=0.3, periods=2.0, bandwidth=4.0, seed=71)
    probe = rings.probe(
        problem=base_case(surface, reduced_pressure=4.0), points=40, magnification=2.0, steps=(0.01, 0.16)
    )
    data = probe.do()
    assert_allclose(data.nominal, 8.0, rtol=1e-12)
    assert_allclose(data.pressure_change_square, (0.01, 0.16), rtol=1e-12)


def test_rings_without_a_wave_are_left_out():
    assert ring_ends(periods=2, bandwidth=4.0, steps_per_octave=2).size == 5
    few = ring_ends(periods=1, bandwidth=2.0, steps_per_octave=8)
    assert few.tolist() == pytest.approx([1.0, 2**0.5, 2.0])


def autopsied(bench, points_per_wave, *loads):
    options = autopsy.Options(
        hursts=(0.8,),
        reduced_pressures=loads,
        points_per_wave=points_per_wave,
        probe_points_per_wave=(6.0, 9.0),
        slope_points_per_wave=(4.0, 6.0, 8.0),
        variance_steps=(0.01, 0.16),
        **SMALL,
    )
    return autopsy.run(options, bench=bench)


@pytest.fixture(scope="module")
def data(bench):
    return autopsied(bench, (4.0, 6.0), 0.1, 4.0)


def test_the_grids_share_is_what_finer_grids_change(data, bench):
    finer = autopsied(bench, (12.0, 18.0), 0.1)
    for name in (
        "square_growth",
        "square_diffusion",
        "square_drift",
        "square_reentry",
        "area_exponent_pixel",
    ):
        share = data[f"{name}_error"].sel(source="grid").isel(load=0).values
        off = np.abs(data[name].isel(load=0) - finer[name].isel(load=0)).values
        assert np.all(off < 1.5 * share), name
        assert np.all(share < 0.15), name
    # P'(0), of three grids: the parabola through them beside the straight line.
    assert np.all(data.pressure_slope_error.sel(source="grid").isel(load=0) > 0.1)


def test_at_full_contact_the_budgets_of_every_octave_are_those_of_the_theory(data):
    full = data.isel(load=1)
    for name in ("growth", "diffusion", "told", "growth_path"):
        assert_allclose(full[f"square_{name}_each"], 1, atol=1e-10, err_msg=name)
    for name in ("square_drift_each", "square_reentry_each"):
        assert_allclose(full[name], 0, atol=1e-10, err_msg=name)
    for name in ("area_exponent", "area_exponent_pixel", "area_exponent_persson"):
        assert_allclose(full[f"{name}_each"], 0, atol=1e-12)
    assert_allclose(full.area_diffused_ratio_each.isel(octave=0), 1, rtol=1e-12)


def test_the_terms_of_partial_contact_add_up_to_the_change(data):
    light = data.isel(load=0)
    terms = light.square_diffusion_each + light.square_drift_each + light.square_reentry_each
    assert_allclose(terms, light.square_growth_each, rtol=1e-9)
    # Contact is lost and found again at p* = .1, and the load that is found is missing elsewhere.
    assert np.all(light.square_drift_each < 0)
    assert np.all(light.square_reentry_each > 0)
    assert float(data.square_gap) < 0.02


def test_means_over_octaves_of_short_waves_are_of_those_octaves(data):
    # Of two octaves none begins at zeta = 4: the last one stands for short waves.
    assert_allclose(data.square_growth_late_each, data.square_growth_each.isel(octave=-1))


def test_what_diffusion_loses_in_half_an_octave_is_told_over_the_truth(data):
    at, start = data.isel(load=0), 0
    half = at.area_each.isel(level=start + 1) / at.area_each.isel(level=start)
    lost = at.area_diffused_ratio_each.isel(octave=0, level=start + 1) * half
    assert_allclose(at.loss_ratio_each.isel(octave=0), np.log(lost) / np.log(half), rtol=1e-10)


def test_the_flow_of_eq_26_is_half_the_slope_over_the_area(data):
    """V P'(0) / 2 A with the pressure in units of E* h'_rms = 2 sqrt(V)."""
    at = data.isel(load=0, probe=0, hurst=0)
    area = at.area_probe_each.isel(probe_level=0).mean("probe_surface")
    assert_allclose(at.edge_loss_slope, at.pressure_slope / 8 / area, rtol=1e-9)
    assert float(at.edge_loss) == pytest.approx(-float(at.area_exponent_probe.isel(variance_step=-1)))


def test_outcomes_follow_from_the_numbers(data):
    said = {one.by: one for one in autopsy.views(data).findings}
    assert len(said["inflow_excess"].outcomes) == 1  # contact is full at the larger load
    told = data.copy(deep=True)
    for name in ("inflow_excess", "edge_loss_excess"):
        for excess, outcome in ((0.5, "+"), (-0.5, "-"), (0.0, "0")):
            told[name][:] = excess
            told[f"{name}_error"][:] = 0.1
            found = decided(autopsy, told, name)
            assert found.outcomes == (outcome,)


def test_a_limit_of_counted_numbers_is_that_of_the_straight_line_through_the_two_finest_grids():
    spacing = xr.DataArray([0.25, 0.125, 0.0625], dims="grid")
    counted = 3.0 + 2.0 * spacing + xr.DataArray([5.0, 0.0, 0.0], dims="grid")
    assert_allclose(limits.two_grid_limit(counted, spacing), 3.0, rtol=1e-12)


def test_an_exponent_is_found_between_neighbours_and_over_all_steps():
    steps = xr.DataArray([0.01, 0.04, 0.16], dims="variance_step")
    found = diffusion.exponents(7.0 * steps**0.5, steps)
    assert_allclose(found, 0.5, rtol=1e-12)


@pytest.mark.parametrize(("excess", "within"), [(0.0, 1e-12), (0.3, 0.004), (0.9, 0.015)])
def test_an_exponent_of_one_half_is_found_under_the_next_order_of_the_step(excess, within):
    """Of c sqrt(dV) (1 + a sqrt(dV)), measured a = .2 to .9, a straight line leaves .01 at most."""
    steps = xr.DataArray([0.0025, 0.01, 0.04, 0.16], dims="variance_step")
    powers = diffusion.exponents(3.0 * steps**0.5 * (1 + excess * steps**0.5), steps)
    assert float(diffusion.power_at_zero_step(powers, steps)) == pytest.approx(0.5, abs=within)
    assert excess == 0 or float(powers[0]) - 0.5 > within


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"probes": (1.0, 4.0)}, "must be at least 2"),
        ({"steps_per_octave": 3}, "multiple of 2"),
        ({"points_per_wave": (8.0,)}, "at least 2 items"),
    ],
)
def test_options_that_give_no_answer_are_refused(options, words):
    with pytest.raises(ValidationError, match=words):
        autopsy.Options(**options)
