"""Studies of kappa on inputs whose answer is known: Hurst exponents, refinement, the verdict."""

import math

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from planted import (
    SMALL,
    STUDENT,
    THREE,
    PlantedBench,
    block,
    column,
    decided,
    located,
    made_of,
    measurement,
    realisation,
)
from solving import persson_area

from fem_contact import area_error
from fem_contact.area import EDGE_CONSTANTS, TRAITS
from validation.measurements import references
from validation.report.estimates import claim, total_error
from validation.report.marks import draw
from validation.studies import find_study, hurst, refinement, theory_verdict

# hurst: kappa of pairs, ladders ------------------------------------------------------------------------

PAIR = np.array([0.03, -0.03, 0.05, -0.01])  # +h and -h of two pairs: means 0 and 0.02
FEW = {"hursts": (0.2, 0.6), "reduced_pressures": (0.05, 0.1), "periods": 2.0, "pairs": 2, "seed": 61}


def _kappa_of(solve):
    """kappa = 2 + H/10 on spectra of bandwidth 2; along the ladders 1.8 + 0.4 step^order more."""
    surface, own = solve["problem"].surface, realisation(solve)
    band = surface.lambda_long / surface.lambda_short
    waves = surface.length[0] / surface.lambda_long
    kappa = 2 + surface.hurst / 10
    kappa += 0.4 * (1 / band) ** (2 - 2 * surface.hurst) - 0.4 * 0.5 ** (2 - 2 * surface.hurst)
    kappa += 0.4 * (1 / waves) ** 2 - 0.4 * (1 / 2) ** 2
    if solve.kind == "ByMethod":
        # An area 1 % larger, whose edges are 4 / n.
        area, edges = 0.05 * 1.01 * (kappa + PAIR[own % 4]), 4 / solve["grid"][0]
        numbers = {
            "pixel": area + 0.198 * edges,
            "perimeter": located(area, edges, area_error.perimeter_law(0.198)),
            "subcell": np.nan,
            "edge_fraction": edges,
        }
        numbers |= dict.fromkeys(TRAITS, 0.0) | {"edge_constant": 0.198, "seconds": 1.0}
        return xr.Dataset({name: ((), value) for name, value in numbers.items()})
    return measurement(solve, lambda p: p * (kappa + PAIR[own % 4]))


@pytest.fixture(scope="module")
def exponents():
    own = {"methods": ("bem",), "bandwidths": (2.0,), "points_per_wave": (4.0, 6.0, 8.0), "shifts": 1}
    ladders = {"hursts": (0.2,), "bandwidths": (2.0, 3.0, 4.0), "periods": (1.5, 2.0), "pairs": 2}
    told = {f"ladder_{name}": value for name, value in ladders.items()}
    return made_of(hurst, _kappa_of, **FEW, **own, **told)


def test_hurst_finds_the_planted_kappa(exponents):
    assert_allclose(exponents.kappa[0], [[2.03, 2.03], [2.07, 2.07]], rtol=1e-12)
    table = hurst.views(exponents).table.of(exponents)
    assert_allclose(column(table, "kappa"), [2.03, 2.03, 2.07, 2.07], rtol=1e-12)


def test_hurst_draws_every_bandwidth_that_was_pressed_and_says_which():
    own = {"methods": ("bem",), "bandwidths": (2.0, 4.0), "ladders": False, "shifts": 1}
    exponents = made_of(hurst, _kappa_of, **FEW, **own)
    (figure,) = (one for one in hurst.views(exponents).figures if one.name == "kappa-against-hurst")
    limits = [line for line in draw(figure, exponents).drawn if line.mark.y == "kappa"]
    assert [line.label for line in limits] == [
        "limit over grids, bandwidth 2",
        "limit over grids, bandwidth 4",
    ] * 2


def test_hurst_has_counted_kappa_on_every_grid_and_what_it_exceeds_the_limit_by(exponents):
    for g, n in enumerate((16, 24, 32)):
        expected = [[k + 0.1 * 2 / n / p for p in (0.05, 0.1)] for k in (2.03, 2.07)]
        assert_allclose(exponents.kappa_pixel.isel(family=0, grid=g), expected, rtol=1e-12)
    each = [0.1 * 2 / 16 / p / (2 + h / 10 + PAIR) for h in (0.2, 0.6) for p in (0.05, 0.1)]
    assert_allclose(exponents.kappa_excess[0], np.mean(each), rtol=1e-9)


def test_hurst_tells_each_theory_its_load(exponents):
    expected = [math.erf(math.sqrt(2) * p) / p for p in (0.05, 0.1)]
    assert_allclose(exponents.kappa_persson, expected, rtol=1e-12)
    # The planted gradient is that of C(q): both ways of telling it agree.
    assert_allclose(exponents.kappa_ensemble[0], [expected] * 2, rtol=1e-12)
    assert_allclose(exponents.kappa_ratio, 2.05 / np.array(expected), rtol=1e-9)


def test_hurst_ladders_lead_to_the_planted_limits_by_the_orders_of_their_laws(exponents):
    for kind, order, start in (("by_bandwidth", 1.6, 0.4 * 0.5**1.6), ("by_size", 2.0, 0.4 * 0.5**2)):
        assert_allclose(exponents[f"order_{kind}"][0], order, rtol=1e-12)
        # The pairs repeat: each rung has the mean .01 of two of them.
        assert_allclose(exponents[f"kappa_{kind}_limit"][0], 2.03 - start, rtol=1e-9)
        assert_allclose(exponents[f"kappa_{kind}_slope"][0], 0.4, rtol=1e-9)


def test_hurst_decides_whether_kappa_changes_with_the_exponent_by_the_interval_over_pairs(exponents):
    low, high = (np.array([2 + h / 10 + PAIR]) for h in (0.2, 0.6))
    ratio = (high / low - 1).reshape(2, 2).mean(axis=1)
    assert_allclose(exponents.kappa_change[0], ratio.mean(), rtol=1e-9)
    half = STUDENT[2] * abs(ratio[1] - ratio[0]) / 2
    found = total_error(exponents, "kappa_change", sources=["surfaces"])
    assert_allclose(found[0], half, rtol=1e-6)
    error = total_error(exponents, "kappa_change")
    for factor, outcome in ((0.9, "0"), (1.1, "+"), (-1.1, "-")):
        trend = hurst.views(exponents.assign(kappa_change=factor * error)).findings[0]
        assert trend.outcomes == (outcome,) * 2


def test_hurst_has_kappa_by_each_solver_on_its_own_grids_and_its_distance_from_boundary_elements():
    few = FEW | {"bandwidths": (2.0,), "reduced_pressures": (0.05,), "ladders": False}
    leg = {"method_bandwidth": 2.0, "method_pairs": 2, "method_points_per_wave": (4.0, 6.0, 8.0)}
    exponents = made_of(hurst, _kappa_of, **few, **leg)
    assert exponents.solver.values.tolist() == ["bem", "fem"]
    assert "surface_by_solver" not in exponents.coords  # surfaces have no names of their own
    planted = [[2.03, 2.07], [1.01 * 2.03, 1.01 * 2.07]]
    assert_allclose(exponents.kappa_by_solver, planted, rtol=1e-9)
    assert_allclose(exponents.kappa_by_solver_difference[1], 0.01, rtol=1e-7)
    # All of what the grids leave, on every surface: they are off to one side.
    grids = exponents.area_by_solver_each_error.sel(source="grid") / exponents.area_by_solver_each
    both = (grids**2).sum("solver").mean("surface_by_solver")
    far = total_error(exponents, "kappa_by_solver_difference")[1]
    assert_allclose(far, 1.01 * np.sqrt(both), rtol=1e-2)
    found = decided(hurst, exponents, "kappa_by_solver_difference")
    for factor, outcome in ((0.9, "agree"), (1.1, "differ")):
        moved = exponents.assign(kappa_by_solver_difference=factor * total_error(exponents, found.by))
        told = decided(hurst, moved, found.by)
        assert told.outcomes == (outcome,) * 2
    assert "kappa_by_solver" in hurst.views(exponents).budget
    assert hurst.views(exponents).figures[0].name == "kappa-of-solvers"


def test_hurst_puts_the_slope_over_the_load_beside_what_was_published(exponents):
    theory = persson_area(0.05) / 0.05
    assert float(exponents.reduced_pressure_ladder) == 0.05
    ratio = exponents.kappa_by_bandwidth / theory
    assert_allclose(exponents.kappa_ratio_by_bandwidth, ratio, rtol=1e-12)
    assert_allclose(
        exponents.kappa_ratio_difference[0], ratio[0, -1].item() - np.array([1.14, 1.13, 0.8]), rtol=1e-9
    )
    # Nothing was published for H = .2.
    assert all(one.kind != "agreement" for one in hurst.views(exponents).findings)
    error = float(total_error(exponents, "kappa_ratio_difference").values[0, 0])
    told = exponents.assign_coords(hurst_ladder=("ladder", [0.8]))
    told["kappa_ratio_difference"][0] = [0.9 * error, -0.9 * error, 1.1 * error]
    (found,) = (one for one in hurst.views(told).findings if one.kind == "agreement")
    assert found.outcomes == ("agree", "agree", "differ")


def test_the_budget_of_hurst_adds_the_planted_half_widths_as_a_root_of_squares(exponents):
    rows = find_study("hurst").budget(exponents)
    surfaces = np.array(column(rows, "surfaces [%]"))
    assert_allclose(surfaces[0], 100 * 0.01 * STUDENT[2] / 2.03, rtol=1e-9)
    parts = [np.array(column(rows, f"{name} [%]"), dtype=float) for name in ("grid", "solver", "surfaces")]
    own = np.sqrt(np.sum(np.square(parts), axis=0))
    assert_allclose(column(rows, "for this spectrum and period [%]"), own, rtol=1e-12)
    # Shift along the ladder of samples at L/lambda_long = 2: slope/4 over the limit, and its uncertainty.
    size = 0.4 + float(total_error(exponents, "kappa_by_size_slope").squeeze())
    assert_allclose(column(rows, "size [%]")[:2], 25 * size / 1.93, rtol=1e-9)
    assert column(rows, "size [%]")[2:] == ["not measured"] * 2
    assert all(math.isnan(total) for total in column(rows, "for any [%]")[2:])


def test_without_ladders_size_and_bandwidth_are_not_measured_and_their_solves_not_asked_for():
    told = "--methods bem --no-ladders --hursts 0.2 --pairs 2 --periods 2 --bandwidths 2"
    options = find_study("hurst").parse(told.split())
    cases = hurst.design(options)
    assert len(cases) == 4
    data = hurst.run(options, bench=PlantedBench(_kappa_of))
    assert data.kappa_error.sel(source=["size", "bandwidth"]).isnull().all()
    assert all(one.by != "kappa_by_bandwidth_slope" for one in hurst.views(data).findings)


# refinement: counted areas against the limit ------------------------------------------------------------


def _refined(solve):
    kind = solve.kind
    if kind == "GridRoughness":
        slopes = {"kappa": ("slope", np.array([3.0, 2.5, 1.9]) * (1.2 if solve["method"] == "fem" else 1.0))}
        return xr.Dataset(slopes, coords={"slope": ["spectral", "forward", "central"]})
    own = 0.1 * THREE[solve["problem"].realisation]
    if kind == "ByMethod":
        # An area 1 % larger, off by what the law says; counting adds .198 of its edges.
        true, edges, constant = 1.01 * own, 0.4 / solve["grid"][0], EDGE_CONSTANTS["Hex1"]
        left = located(true, edges, area_error.perimeter_law(constant))
        layer = {"pixel_bem": 0.1, "pixel_layer": 0.1 * 0.995}
        edge = {"edge_fraction": edges, "edge_constant": constant, "subcell": math.nan}
        return block(pixel=left + constant * edges, perimeter=left, **edge, **layer)
    return measurement(solve, lambda p: own)


@pytest.fixture(scope="module")
def refined():
    beside = {"elements": ("Hex1",), "fem_points_per_wave": (4.0, 6.0, 8.0), "grid_scale_grids": (24,)}
    return made_of(refinement, _refined, surfaces=3, ladders=False, **beside, **SMALL)


def test_refinement_finds_by_how_much_counting_exceeds_the_limit(refined):
    # .1 edges of 2 / n each, over the area of each surface.
    each = np.array([[0.2 / n / (0.1 * k) for k in THREE] for n in (16, 24, 32)])
    assert_allclose(refined.distance_pixel, each.mean(axis=1), rtol=1e-9)
    assert_allclose(refined.distance_perimeter, 0.0, atol=1e-9)
    counted = [(0.1 + 0.2 / n) / 0.05 for n in (16, 24, 32)]
    assert_allclose(refined.kappa_pixel, counted, rtol=1e-12)
    table = refinement.views(refined).table.of(refined)
    assert_allclose(column(table, "kappa, counted"), counted, rtol=1e-12)


def test_refinement_finds_the_planted_order_and_the_part_of_the_grid(refined):
    assert_allclose(refined.order_pixel, 1.0, rtol=1e-9)
    kappa, theory = 2.0, math.erf(math.sqrt(2) * 0.05) / 0.05
    assert_allclose(refined.kappa, kappa, rtol=1e-9)
    assert_allclose(refined.area_excess, kappa / theory - 1, rtol=1e-9)
    parts = [[0.2 / n / (0.1 * k + 0.2 / n - 0.05 * theory) for k in THREE] for n in (16, 24, 32)]
    assert_allclose(refined.grid_part, np.mean(parts, axis=1), rtol=1e-9)
    assert refinement.views(refined).findings[0].outcomes == ("+",)
    wide = refined.assign(area_excess=0.9 * total_error(refined, "area_excess"))
    assert refinement.views(wide).findings[0].outcomes == ("0",)


def test_refinement_finds_where_the_excess_of_the_coarse_grid_lies(refined):
    """Six tenths of what is counted lie at small pressures, on every grid."""
    excess = np.mean((0.1 * THREE + 0.2 / 16) / (0.1 * THREE + 0.2 / 32)) - 1
    above = (0.1 + 0.2 / 16) / (0.1 + 0.2 / 32) - 1
    assert_allclose(refined.area_pixel_change, excess, rtol=1e-9)
    assert_allclose(refined.small_stress_part, 0.6, rtol=1e-9)
    assert_allclose(refined.large_stress_change, above, rtol=1e-9)


def test_finite_elements_reach_the_planted_limit_one_per_cent_above_the_other(refined):
    assert_allclose(refined.distance_other_each, 0.01, rtol=1e-7)
    assert_allclose(refined.depth_share, 0.005, rtol=1e-9)
    # The planted blocks lie on their law. Depth and the grids of the other limit make the distance uncertain.
    assert_allclose(refined.area_each_drift, 0.0, atol=1e-9)
    grids, meshes = (
        1.01 * np.linalg.norm(refined[f"{name}_error"].sel(source="grid") / refined[name]) / 3
        for name in ("area_each", "area_other_each")
    )
    half = float(total_error(refined, "distance_other")[0])
    assert half == pytest.approx(math.hypot(grids, meshes, 0.005), rel=1e-3)
    found = decided(refinement, refined, "distance_other")
    assert found.outcomes == ("differ",)
    close = refined.assign(distance_other=0.9 * total_error(refined, "distance_other"))
    found = decided(refinement, close, "distance_other")
    assert found.outcomes == ("agree",)
    # In the budget the distance of the two limits is a part of the grids' share.
    grid = column(find_study("refinement").budget(refined), "grid [%]")
    own = refined.area_other_error.sel(source="grid").item() / refined.area_other.item()
    assert grid[1] == pytest.approx(100 * math.hypot(0.01, own), rel=1e-3)


@pytest.mark.parametrize(
    ("value", "half", "outcomes"),
    [
        (2.17, 0.09, ("agree", "differ", "agree")),
        # An interval that is wider than the range would meet it almost anywhere.
        (2.337, 1.8, ("?", "agree", "agree")),
        (2.5, 0.09, ("differ", "differ", "differ")),
        (2.1, float("nan"), ("?", "?", "?")),
    ],
)
def test_published_values_agree_only_with_an_interval_that_could_have_missed_them(
    refined, value, half, outcomes
):
    told = refined.drop_vars([n for n in refined.variables if "published" in str(n) or "paper" in str(n)])
    told = claim(told.assign(kappa=value), "kappa", surfaces=half, grid=0.0 * half, solver=0.0 * half)
    data = references.beside_published(told)
    found = decided(refinement, data, "kappa_difference")
    assert found.outcomes == outcomes


def test_refinement_has_kappa_of_the_protocols_by_slope_and_their_spread(refined):
    assert_allclose(refined.kappa_protocol[-1], [3.0, 2.5, 1.9], rtol=1e-12)
    assert_allclose(refined.kappa_protocol_spread, 3 / 1.9 - 1, rtol=1e-12)


def test_the_protocol_by_full_elements_says_what_the_grid_adds_to_what_converges_and_where_hyun_lies(refined):
    kappas = np.array([[3.0, 2.5, 1.9]]) * np.array([[1.0], [1.2]])
    for k in range(3):
        assert_allclose(refined.kappa_protocol_by_solver.isel(hurst_protocol=k), kappas, rtol=1e-12)
    assert_allclose(refined.kappa_protocol_limit, 2.0, rtol=1e-9)
    each, theory = 2.0 * THREE, math.erf(math.sqrt(2) * 0.05) / 0.05
    fem = refined.sel(solver="fem").isel(slope=0, hurst_protocol=-1)
    assert_allclose(fem.kappa_excess_protocol, np.mean(3.6 / each - 1), rtol=1e-9)
    assert_allclose(fem.grid_part_protocol, np.mean((3.6 - each) / (3.6 - theory)), rtol=1e-9)
    half = float(total_error(refined, "kappa_hyun_difference")[-1])
    assert half == pytest.approx(float(total_error(refined, "kappa_protocol_limit")[-1]), rel=1e-9)
    for value, outcome in ((0.9, "0"), (1.1, "+"), (-1.1, "-")):
        moved = refined.assign(kappa_hyun_difference=value * total_error(refined, "kappa_hyun_difference"))
        found = decided(refinement, moved, "kappa_hyun_difference")
        assert found.outcomes == (outcome,)
        assert ("explains none" in found.text) == (outcome == "-")
        # Where the intervals do not show that the grid raises kappa, nothing is concluded from it.
        same = moved.assign(kappa_excess_protocol=-0.1 + 0 * moved.kappa_excess_protocol)
        found = decided(refinement, same, "kappa_hyun_difference")
        assert "explains none" not in found.text


# theory-verdict -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scored():
    """A fifth more area than the theory, on three surfaces of a per cent of standard error."""

    def answer(solve):
        own = THREE[solve["problem"].realisation]
        return measurement(solve, lambda p: 1.4 * float(persson_area(p)) * own)

    asked = {"reduced_pressures": (0.02, 0.1, 0.2), "ladder_reduced_pressures": ()}
    return made_of(theory_verdict, answer, surfaces=3, shifts=2, **asked, **SMALL)


def test_the_verdict_scores_the_planted_ratio(scored):
    ratio, error = scored.area_over.sel(theory="Persson"), scored.area_over_error.sel(theory="Persson")
    assert_allclose(ratio, 1.4, rtol=1e-9)
    grid = (scored.area_error / scored.area).sel(source="grid")
    assert_allclose(error.sel(source="grid"), 1.4 * grid, rtol=1e-9)


def test_the_verdict_ranks_planted_two_fifths_behind_what_is_nearer_only_where_intervals_part_them(scored):
    assert_allclose(scored.area_off.sel(theory="Persson"), np.log(1.4), rtol=1e-9)
    half = (total_error(scored, "area_over") / scored.area_over).mean("load")
    assert np.all(total_error(scored, "area_off") <= half * (1 + 1e-12))
    order = theory_verdict.views(scored).findings[0]
    assert order.kind == "ranking"
    assert {row["name"].value for row in order.rows} == set(scored.theory.values)
    text = order.values["order"].value
    wide = scored.assign(area_over_error=scored.area_over_error + 9.0)
    assert "<" in text
    assert "<" not in theory_verdict.views(wide).findings[0].values["order"].value
