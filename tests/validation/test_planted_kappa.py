"""Studies of kappa on inputs whose answer is known: Hurst exponents, refinement, the verdict."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from planted import SMALL, STUDENT, THREE, PlantedBench, block, column, measurement, numbers, realisation

from validation.measures.common import persson_area
from validation.studies import (
    hurst,
    refinement,
    theory_verdict,
)

# hurst: kappa of pairs, ladders ------------------------------------------------------------------------

PAIR = np.array([0.03, -0.03, 0.05, -0.01])  # +h and -h of two pairs: means 0 and 0.02


def _kappa_of(solve):
    """kappa = 2 + H/10 on spectra of bandwidth 2; along the ladders 1.8 + 0.4 step^order more."""
    surface, own = solve.realised.surface, realisation(solve)
    band = surface.lambda_long / surface.lambda_short
    waves = surface.length[0] / surface.lambda_long
    kappa = 2 + surface.hurst / 10
    kappa += 0.4 * (1 / band) ** (2 - 2 * surface.hurst) - 0.4 * 0.5 ** (2 - 2 * surface.hurst)
    kappa += 0.4 * (1 / waves) ** 2 - 0.4 * (1 / 2) ** 2
    return measurement(solve, lambda p: p * (kappa + PAIR[own % 4]))


@pytest.fixture(scope="module")
def exponents():
    options = hurst.Options(
        hursts=(0.2, 0.6),
        bandwidths=(2.0,),
        reduced_pressures=(0.05, 0.1),
        pairs=2,
        seed=61,
        periods=2.0,
        points_per_wave=(4.0, 6.0, 8.0),
        ladder_hursts=(0.2,),
        ladder_bandwidths=(2.0, 3.0, 4.0),
        ladder_periods=(1.5, 2.0),
        ladder_pairs=2,
        shifts=1,
    )
    return hurst.run(options, bench=PlantedBench(_kappa_of))


def test_hurst_prints_the_planted_kappa_with_students_interval_over_pairs(exponents):
    table = hurst.table(exponents)
    np.testing.assert_allclose(column(table, "kappa limit"), [2.03, 2.03, 2.07, 2.07], rtol=1e-12)
    # Two pairs, 0 and .02: standard error .01.
    np.testing.assert_allclose(column(table, "+- (95 %, surfaces)"), 0.01 * STUDENT[2], rtol=1e-9)


def test_hurst_prints_counted_kappa_on_the_coarsest_and_on_the_finest_grid(exponents):
    table = hurst.table(exponents)
    for title, n in (("counted at lambda_short/dx = 8", 32), ("counted at 4", 16)):
        expected = [k + 0.1 * 2 / n / p for k, p in ((2.03, 0.05), (2.03, 0.1), (2.07, 0.05), (2.07, 0.1))]
        np.testing.assert_allclose(column(table, title), expected, rtol=1e-12)


def test_hurst_puts_each_theory_in_its_column(exponents):
    table = hurst.table(exponents)
    expected = [math.erf(math.sqrt(2) * p) / p for p in (0.05, 0.1)] * 2
    np.testing.assert_allclose(column(table, "Persson, conditional"), expected, rtol=1e-12)
    # The planted gradient is that of C(q): both ways of telling it agree.
    np.testing.assert_allclose(column(table, "Persson, ensemble"), expected, rtol=1e-12)


def test_hurst_ladders_lead_to_the_planted_limits_by_the_orders_of_their_laws(exponents):
    for kind, order, start in (("bandwidth", 1.6, 0.4 * 0.5**1.6), ("size", 2.0, 0.4 * 0.5**2)):
        assert float(exponents[f"{kind}_order"][0]) == pytest.approx(order, rel=1e-12)
        # The pairs repeat: each rung has the mean .01 of two of them.
        assert float(exponents[f"{kind}_limit"][0]) == pytest.approx(2.03 - start, rel=1e-9)
        assert float(exponents[f"{kind}_slope"][0]) == pytest.approx(0.4, rel=1e-9)


def test_hurst_says_by_how_much_kappa_changes_from_the_lowest_to_the_highest_exponent(exponents):
    found = numbers(hurst.findings(exponents)[0].partition("changes by ")[2])
    low, high = (np.array([2 + h / 10 + PAIR]) for h in (0.2, 0.6))
    ratio = (high / low - 1).reshape(2, 2).mean(axis=1)
    error = abs(ratio[1] - ratio[0]) / 2
    np.testing.assert_allclose(found[0], 100 * ratio.mean(), atol=0.0501)
    np.testing.assert_allclose(found[1], 100 * STUDENT[2] * error, atol=0.0501)


def test_hurst_puts_the_slope_over_the_load_beside_the_theory_and_what_was_published(exponents):
    theory = persson_area(0.05) / 0.05
    assert exponents.attrs["ladder_reduced_pressure"] == 0.05
    (said,) = (line for line in hurst.findings(exponents) if line.startswith("D_f = 2.8"))
    first, last = (float(exponents.bandwidth_kappa[0, i]) / theory for i in (0, -1))
    assert f"is {first:.3f} +- " in said
    less = "less" if last > first else "more"
    assert f"it falls {100 * abs(last / first - 1):.1f} % {less} than his." in said
    told = exponents.copy(deep=True).assign_coords(ladder_hurst=("ladder", [0.8]))
    told["bandwidth_kappa"][:], told["bandwidth_half_width"][:] = 1.12 * theory, 0.03 * theory
    (said,) = (line for line in hurst.findings(told) if line.startswith("D_f = 2.2"))
    assert "1.14 by molecular dynamics (Yang, Tartaglino, Persson 2006), 1.13 by finite elements" in said
    assert said.endswith("0.8 by discretised continuum (Borri-Brunetto 2006) (outside the interval).")


def test_the_budget_of_hurst_adds_the_planted_half_widths_as_a_root_of_squares(exponents):
    rows = hurst.budget(exponents)
    surfaces = np.array(column(rows, "surfaces [%]"))
    np.testing.assert_allclose(surfaces[0], 100 * 0.01 * STUDENT[2] / 2.03, rtol=1e-9)
    parts = [np.array(column(rows, f"{name} [%]"), dtype=float) for name in ("grid", "solver", "surfaces")]
    own = np.sqrt(np.sum(np.square(parts), axis=0))
    np.testing.assert_allclose(column(rows, "for this spectrum and period [%]"), own, rtol=1e-12)
    # Shift along the ladder of samples at L/lambda_long = 2: slope/4 over the limit, and its uncertainty.
    size = 0.4 + float(exponents.size_slope_half_width[0])
    np.testing.assert_allclose(column(rows, "finite size [%]")[:2], 25 * size / 1.93, rtol=1e-9)
    assert column(rows, "finite size [%]")[2:] == ["not determinable"] * 2


# refinement: counted areas against the limit ------------------------------------------------------------


def _refined(solve):
    kind = type(solve).__name__
    if kind == "GridRoughness":
        slopes = {"kappa": ("slope", np.array([3.0, 2.5, 1.9]))}
        return xr.Dataset(slopes, coords={"slope": ["spectral", "forward", "central"]})
    own = 0.1 * THREE[solve.realised.realisation]
    if kind == "BlockMeasurement":
        # Its edges are 4 / n, and counting adds .198 of them to an area 1 % larger.
        true, edges = 1.01 * own, 4 / solve.grid[0]
        layer = {"pixel_bem": 0.1, "pixel_layer": 0.1 * 0.995}
        return block(pixel=true + 0.198 * edges, perimeter=true, **layer)
    return measurement(solve, lambda p: own)


@pytest.fixture(scope="module")
def refined():
    options = refinement.Options(
        surfaces=3,
        grid_scale_grids=(24,),
        ladders=False,
        elements=("Hex1",),
        fem_points_per_wave=(4.0, 6.0, 8.0),
        seed=61,
        **SMALL,
    )
    return refinement.run(options, bench=PlantedBench(_refined))


def test_refinement_prints_by_how_much_counting_exceeds_the_limit_and_its_interval(refined):
    table = refinement.table(refined)
    # .1 edges of 2 / n each, over the area of each surface.
    each = np.array([[0.2 / n / (0.1 * k) for k in THREE] for n in (16, 24, 32)])
    np.testing.assert_allclose(column(table, "pixel - limit [%]")[:3], 100 * each.mean(axis=1), rtol=1e-9)
    error = each.std(axis=1, ddof=1) / np.sqrt(3)
    np.testing.assert_allclose(column(table, "pixel +- (95 %) [%]")[:3], 100 * STUDENT[3] * error, rtol=1e-9)
    np.testing.assert_allclose(column(table, "perimeter - limit [%]")[:3], 0.0, atol=1e-9)
    counted = [(0.1 + 0.2 / n) / 0.05 for n in (16, 24, 32)]
    np.testing.assert_allclose(column(table, "kappa, counted (zeroth moment / p*)")[:3], counted, rtol=1e-12)


def test_refinement_finds_the_planted_order_and_verdict(refined):
    text = refinement.findings(refined)
    order = next(s for s in text if s.startswith("The pixel area differs"))
    assert order.endswith("fitted order 1.00).")
    kappa, theory = 2.0, math.erf(math.sqrt(2) * 0.05) / 0.05
    assert text[0].startswith(
        f"kappa in the limit of vanishing spacing is 2 +- {0.02 * STUDENT[3]:.2g} (95 %, 3"
    )
    assert f"{100 * (1 - theory / kappa):.0f} % of the simulated area is not explained" in text[0]
    share = [0.2 / n / (0.1 + 0.2 / n - 0.05 * theory) for n in (16, 24, 32)]
    assert ", ".join(f"{100 * s:.0f} % at {w}" for s, w in zip(share, (4, 6, 8), strict=True)) in text[1]


def test_refinement_says_where_the_excess_of_the_coarse_grid_lies(refined):
    """Six tenths of what is counted lie at small pressures, on every grid."""
    sentence = next(s for s in refinement.findings(refined) if s.startswith("The first moment"))
    excess = 100 * (np.mean((0.1 * THREE + 0.2 / 16) / (0.1 * THREE + 0.2 / 32)) - 1)
    above = 100 * ((0.1 + 0.2 / 16) / (0.1 + 0.2 / 32) - 1)
    assert f"the area, is {excess:+.1f} % on 4 against 8 points per wave" in sentence
    assert "Of that excess 60 % lies at sigma < 0.2 E* h'_rms" in sentence
    assert f"above it the coarse grid holds {above:+.1f} %" in sentence


def test_finite_elements_reach_the_planted_limit_one_per_cent_above_the_other(refined):
    np.testing.assert_allclose(refined.fem_limit[0] / refined.limit, 1.01, rtol=1e-9)
    assert float(refined.depth_error) == pytest.approx(0.005, rel=1e-9)
    # The planted blocks lie on their law. Depth and the grids of the other limit make the distance uncertain.
    np.testing.assert_allclose(refined.limit_drift, 0.0, atol=1e-9)
    grids = 100 * 2 * np.linalg.norm(refined.limit_error) / 3 / 0.1
    sentence = next(s for s in refinement.findings(refined) if s.startswith("Finite elements"))
    assert (
        f"differs by +1.00 +- {math.hypot(grids, 0.5):.2g} % (0.00 % the surfaces, 0.00 % their grids, "
        in sentence
    )
    assert f"{grids:.2f} % those of the boundary elements, 0.50 % the depth of the block; 95 %): " in sentence
    assert sentence.endswith(
        "they are told apart, so that the grids of the element leave 1.00 %, not 0.00 %."
    )
    close = refined.assign(depth_error=2 * refined.depth_error)
    sentence = next(s for s in refinement.findings(close) if s.startswith("Finite elements"))
    assert f"differs by +1.00 +- {math.hypot(grids, 1.0):.2g} %" in sentence
    assert sentence.endswith("1.00 % the depth of the block; 95 %): the two are not told apart.")
    # In the budget the distance of the two limits is a part of the grids' share.
    grid = column(refinement.budget(refined), "grid [%]")
    assert grid[1] == pytest.approx(1.0, rel=1e-3)


def test_refinement_says_the_spread_of_the_protocols_and_where_the_limit_lies(refined):
    sentence = next(s for s in refinement.findings(refined) if s.startswith("With roughness"))
    assert "kappa is 3.00 (spectral), 2.50 (forward), 1.90 (central)" in sentence
    assert f"a spread of {100 * (3 / 1.9 - 1):.0f} %, on both sides of the converged 2.00" in sentence


# theory-verdict -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scored():
    """A fifth more area than the theory, on three surfaces of a per cent of standard error."""

    def answer(solve):
        own = THREE[solve.realised.realisation]
        return measurement(solve, lambda p: 1.2 * float(persson_area(p)) * own)

    options = theory_verdict.Options(
        surfaces=3,
        shifts=2,
        reduced_pressures=(0.02, 0.1, 0.2),
        edge=False,
        ladder_reduced_pressures=(),
        seed=61,
        **SMALL,
    )
    return theory_verdict.run(options, bench=PlantedBench(answer))


def test_the_verdict_scores_the_planted_ratio_with_students_interval(scored):
    ratio = scored.ratio.sel(quantity="area", variant="persson")
    np.testing.assert_allclose(ratio, 1.2, rtol=1e-9)
    shares = scored.shares.sel(source="surfaces")
    np.testing.assert_allclose(shares, 0.01 * STUDENT[3], rtol=1e-9)
    half = 1.2 * np.hypot(shares, scored.shares.sel(source="grid"))
    np.testing.assert_allclose(scored.interval.sel(quantity="area", variant="persson"), half, rtol=1e-9)


def test_the_verdict_calls_a_planted_fifth_off_by_twenty_per_cent(scored):
    rows = [row for row in theory_verdict.table(scored).rows if row[0] == "contact area"]
    assert [row[2] for row in rows] == ["off by +20 %"] * len(rows)
    assert (
        "simulated over predicted area is 1.200 at the lightest load (p* = 0.02) and 1.200"
        in (theory_verdict.findings(scored)[0])
    )
    values = column(theory_verdict.budget(scored), "value")
    np.testing.assert_allclose(values, 1.2, rtol=1e-9)
