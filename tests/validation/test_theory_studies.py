"""The studies that compare limits with the theory: kappa over H, load and magnification, and the verdict."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from validation.errors import UsageError
from validation.files import write_record
from validation.measures.common import persson_area
from validation.measures.theory import VARIANTS
from validation.solves.bench import Bench
from validation.solves.store import write_numbers
from validation.studies import find_study, hurst, magnification, pressure, theory_verdict
from validation.studies._outputs import report_study
from validation.studies.theory_verdict import words as words_of

SMALL = {"periods": 2.0, "bandwidth": 2.0}


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    return Bench.at(tmp_path_factory.mktemp("solves"))


def test_hurst_study_reports_change_by_surface_and_finds_the_bandwidth_of_equal_nayak(bench):
    options = hurst.Options(
        hursts=(0.2, 0.8),
        bandwidths=(2.0,),
        equal_nayak=2.2,
        reduced_pressures=(0.1,),
        periods=2.0,
        pairs=2,
        points_per_wave=(4.0, 6.0),
        ladder_hursts=(),
    )
    data = hurst.run(options, bench=bench)
    assert data.family.values.tolist() == ["bandwidth 2", "alpha 2.2"]
    assert np.ptp(data.bandwidth.values[0]) == 0 < np.ptp(data.bandwidth.values[1])
    change = data.kappa_each.isel(hurst=-1) / data.kappa_each.isel(hurst=0) - 1
    np.testing.assert_allclose(data.kappa_change, change.mean("surface"), rtol=1e-12)
    flat = data.assign(kappa_change=0 * data.kappa_change)
    assert hurst.views(flat).findings[0].outcomes == ("0", "0")


def test_an_impossible_nayak_parameter_is_refused_by_name(bench):
    with pytest.raises(UsageError, match=r"equal_nayak = 1\.2: no bandwidth gives it"):
        hurst.run(hurst.Options(equal_nayak=1.2), bench=bench)


def test_magnification_ends_at_the_theory_of_the_whole_surface(bench):
    options = magnification.Options(
        reduced_pressures=(0.1,),
        magnifications=(1.0, 2.0),
        surfaces=2,
        points_per_wave=(4.0, 6.0),
        **SMALL,
    )
    data = magnification.run(options, bench=bench)
    np.testing.assert_allclose(data.area_persson_each.isel(magnification=-1), persson_area(0.1), rtol=1e-9)
    area = data.area_each.isel(load=0)
    assert np.all(area.isel(magnification=0) > area.isel(magnification=-1))


@pytest.mark.parametrize(
    ("ratio", "interval", "words"),
    [
        (1.0, 0.0, "exact"),
        (1.3, 0.02, "off by +30 %"),
        (0.8, 0.02, "off by -20 %"),
        (1.01, 0.5, "not determinable"),
    ],
)
def test_a_verdict_follows_from_the_ratio_and_its_interval(ratio, interval, words):
    assert words_of.verdict(ratio, interval) == words


def straight_edge() -> xr.Dataset:
    """P = 2 sigma at p* = .05, as `stress-near-zero` leaves it, in windows that close like sqrt(dx)."""
    spacing = 1 / np.array([16.0, 32.0, 64.0, 128.0])
    slope = 2.0 * np.linspace(0.9, 1.1, 4)[:, None]
    density = slope * 0.4 * np.sqrt(spacing) / 2
    return xr.Dataset(
        {
            "density_at_zero": (("surface", "grid"), density),
            "slope": (("surface", "grid"), np.broadcast_to(slope, density.shape)),
        },
        coords={"spacing": ("grid", spacing)},
        attrs={"reduced_pressure": 0.05},
    )


def test_the_slope_at_zero_is_scored_against_every_variant():
    data = straight_edge()
    scores = theory_verdict._edge_scores(data)
    # Persson's closed form, 2 p exp(-p^2 / 2V) / (V sqrt(2 pi V)) with V = 1/4.
    persson = 8 * 0.05 * np.exp(-2 * 0.05**2) / np.sqrt(np.pi / 2)
    assert float(scores.edge_slope_ratio[0]) == pytest.approx(2.0 / persson, rel=1e-9)
    # A variant that stores less energy has a smaller variance, and so a steeper start.
    assert np.all(scores.edge_slope_ratio[1:] < scores.edge_slope_ratio[0])


@pytest.fixture(scope="module")
def scored(bench):
    options = {
        "surfaces": 3,
        "points_per_wave": (4.0, 6.0, 8.0),
        "shifts": 1,
        "ladder_reduced_pressures": (),
        "edge": False,
        "reduced_pressures": (0.02, 0.1, 0.3, 4.0),
    }
    return theory_verdict.run(theory_verdict.Options(**options, **SMALL), bench=bench)


def test_every_quantity_of_the_theory_is_scored_and_full_contact_is_exact(scored):
    rows = theory_verdict.table(scored).rows
    words = {row[0] for row in rows}
    assert set(words_of.QUANTITIES.values()) <= words
    closed = [row for row in rows if row[1] == "0.99 to 1" and row[0] in ("contact area", "mean gap")]
    assert [row[2] for row in closed] == ["exact", "exact"]
    # A variant without a stored energy says nothing of it.
    energy = next(row for row in rows if row[0] == "elastic energy")
    assert energy[2 + list(VARIANTS).index("xu")] == "says nothing"
    assert len(theory_verdict.budget(scored).rows) == 4


def test_a_report_lists_what_is_uncertain_and_writes_it_as_csv(scored, tmp_path):
    said = {"format": "fem-contact study 1", "study": "theory-verdict", "options": {"seed": 2006}}
    write_record(tmp_path / "study.json", said)
    write_numbers(tmp_path / "data.nc", scored, recipe=said)
    report_study(tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "What is uncertain" in page
    assert "does not enter" in page
    assert (tmp_path / "budget.csv").read_text().startswith("number,value,grid [%],solver [%],surfaces [%]")


def test_a_range_is_judged_by_what_is_decided_in_it():
    ratios, intervals = np.array([1.3, 1.1, 1.02]), np.array([0.4, 0.05, 0.03])
    assert words_of.range_verdict(ratios, intervals) == "off by +10 %"
    assert words_of.range_verdict(ratios[[0, 2]], intervals[[0, 2]]) == "right within 5 %"
    assert words_of.range_verdict(ratios[:1], intervals[:1]) == "not determinable"


def test_a_score_follows_the_numbers(scored):
    better = scored.assign(ratio=scored.ratio * 0 + 1.0)
    cells = [cell for row in theory_verdict.table(better).rows[:4] for cell in row[2:]]
    assert all(cell == "exact" or "right within" in cell or cell == "not determinable" for cell in cells)
    worse = scored.assign(ratio=scored.ratio * 3)
    assert any("off by a factor" in str(cell) for cell in theory_verdict.table(worse).rows[0][2:])


def test_the_pressure_study_says_up_to_where_the_distributions_keep_still(bench):
    options = pressure.Options(
        surfaces=3,
        points_per_wave=(4.0, 6.0, 8.0),
        shifts=1,
        reduced_pressures=(0.02, 0.1, 0.3, 4.0),
        **SMALL,
    )
    data = pressure.run(options, bench=bench)
    text = " ".join(pressure.findings(data))
    assert "P(sigma) A0/A, against that at" in text
    # Were all loads alike, the claim would hold to the heaviest.
    alike = data.assign(stress_share=data.stress_share * 0 + data.stress_share.isel(load=0))
    heaviest = float(data.area.mean("surface")[-1])
    assert f"the claim holds up to A/A0 = {heaviest:.2g} within 0.000" in " ".join(pressure.findings(alike))


def test_the_ladders_of_the_hurst_study_keep_phases_and_area(bench):
    options = hurst.Options(
        hursts=(0.4,),
        bandwidths=(2.0,),
        reduced_pressures=(0.2,),
        pairs=2,
        periods=1.0,
        points_per_wave=(4.0, 6.0),
        ladder_bandwidths=(2.0, 3.0),
        ladder_periods=(1.0, 2.0),
        ladder_pairs=2,
        ladder_reduced_pressure=0.2,
    )
    data = hurst.run(options, bench=bench)
    assert data.nayak_by_bandwidth[0, 0] < data.nayak_by_bandwidth[0, 1]
    assert float(data.order_by_bandwidth[0]) == pytest.approx(1.2, rel=1e-12)
    # The first rung of the bandwidth ladder is the study's own spectrum: the same surfaces on the same grids.
    assert float(data.kappa_by_bandwidth[0, 0]) == pytest.approx(float(data.kappa.squeeze()), rel=1e-12)
    assert set(np.unique(data.solve_by_bandwidth[0, 0])) == set(np.unique(data.solve))
    # A quarter of the area, so four times the pairs; the others are no samples of the larger.
    assert ((data.solve_by_size != "").sum("surface_by_size") == [[16, 4]]).all()
    budget = find_study("hurst").budget(data)
    row = dict(zip(budget.columns, budget.rows[0], strict=True))
    assert row["bandwidth [%]"] not in ("does not enter", "not measured")
    assert row["for any [%]"] >= row["for this spectrum and period [%]"] > 0


@pytest.mark.parametrize("name", ["hurst", "pressure", "magnification", "theory-verdict"])
@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--points-per-wave 8,4", "--points-per-wave = 8,4: must be positive and rising"),
        ("--points-per-wave 2,4", "with shifts = 2 a limit over grids needs three solves on two grids"),
        ("--shifts 1 --points-per-wave 4,6", "with shifts = 1 a limit over grids needs three solves"),
        ("--reduced-pressures 0,1", "must be greater than 0"),
        ("--size 4", "unknown option '--size'; it has: "),
    ],
)
def test_options_are_refused_by_name_before_anything_runs(name, options, words):
    with pytest.raises(UsageError) as caught:
        find_study(name).parse(options.split())
    assert words in str(caught.value)
