"""Laws of the distance from the theory in wide bands: what was planted is found, at its stated rate."""

import numpy as np
import pytest
import xarray as xr
from planted import decided

from validation import reference
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.execution.store import write_numbers
from validation.measurements.theory import with_variants
from validation.reference.fit import nayak
from validation.reference.interpolation import interpolated
from validation.reference.laws import fit
from validation.report.estimates import error_of, total_error
from validation.studies import find_study

TABLE = reference.table()
ALPHA = np.array([2.7, 5.2, 11.6, 28.0, 74.0, 200.0, 560.0])
LAWS = {
    "logarithm": lambda alpha: 0.5 - 0.04 * np.log(alpha),
    "power": lambda alpha: 0.6 * alpha**-0.2,
    "saturation": lambda alpha: 0.1 + 0.5 * alpha**-0.3,
}


@pytest.mark.parametrize("law", LAWS)
def test_a_law_continues_what_follows_it(law):
    far = np.array([2000.0, 1e4])
    continued = fit(law, ALPHA, LAWS[law](ALPHA), np.full(ALPHA.size, 1e-4), at=far)
    np.testing.assert_allclose(continued.values, LAWS[law](far), atol=1e-3)
    assert continued.freedom == {"saturation": 4}.get(law, 5)
    assert continued.chi_square < 0.1 * continued.freedom


@pytest.mark.parametrize("law", ["logarithm", "power"])
def test_ranges_hold_the_truth_at_their_rate(law):
    random, half = np.random.default_rng(7), np.full(ALPHA.size, 0.01)
    held = 0
    for _ in range(100):
        noisy = LAWS[law](ALPHA) + half / 1.96 * random.standard_normal(ALPHA.size)
        continued = fit(law, ALPHA, noisy, half, at=np.array([2000.0]))
        held += abs(continued.values[0] - LAWS[law](2000.0)) <= continued.halves[0]
    assert 88 <= held <= 99


def planted(law):
    """A table whose areas follow a law, to 0.2 %."""
    axes = {"hurst": [0.8], "bandwidth": 4.0 * 2.0 ** np.arange(7), "reduced_pressure": [0.05, 0.2]}
    data = with_variants(xr.Dataset(coords={"amplitudes": ["exact"], **axes}))
    alpha = [nayak(hurst=0.8, bandwidth=b) for b in axes["bandwidth"]]
    above = xr.DataArray(1 + LAWS[law](np.array(alpha)), dims="bandwidth")
    area = (data.area_persson * above).expand_dims(amplitudes=["exact"], hurst=[0.8])
    error = error_of(area, surfaces=0.002 * area, grid=0.0 * area, solver=0.0 * area, size=0.001 * area)
    return data.assign(area=area, area_error=error)


@pytest.fixture
def plant(monkeypatch):
    """Put a table that follows a law in the place of the shipped ones."""

    def put(law):
        data = planted(law)
        parts = {"table": slice(0, 4), "wide": slice(4, None)}
        for name, bands in parts.items():
            part = data.isel(bandwidth=bands).assign_attrs(TABLE.attrs)
            monkeypatch.setattr(reference, name, lambda part=part: part)

    return put


@pytest.mark.parametrize("law", LAWS)
def test_the_study_finds_the_law_that_was_planted(law, tmp_path, plant):
    plant(law)
    study = find_study("wide-band")
    data = study.compute(study.options(), bench=Bench.at(tmp_path))
    assert data.cells_within.sel(law=law) == data.cells_scored.sel(law=law) == 6
    assert data.law_miss_rms.sel(law=law) < 0.005
    assert (data.law_misfit.sel(law=law) < 0.1).all()
    end = decided(study, data, "area_excess_limit")
    assert set(end.outcomes) == {"+" if law == "saturation" else "0"}
    if law == "saturation":
        np.testing.assert_allclose(data.area_excess_limit, 0.1, atol=0.01)
    assert bool(data.nayak_close.sel(law="saturation").isnull().all()) == (law == "saturation")


def test_bands_to_fit_to_and_to_judge_by_are_needed(tmp_path, plant):
    plant("power")
    study = find_study("wide-band")
    for widest in (16.0, 256.0):
        with pytest.raises(UsageError, match="fitted_to"):
            study.compute(study.options(fitted_to=widest), bench=Bench.at(tmp_path))
    write_numbers(tmp_path / "data.nc", xr.Dataset({"area": 0.1}), recipe={})
    with pytest.raises(UsageError, match=r"no area_error, area_persson.*; give data\.nc of study reference"):
        study.compute(study.options(table=tmp_path / "data.nc"), bench=Bench.at(tmp_path))


def test_wide_cells_are_looked_up_and_between_the_tables_it_is_interpolated():
    cell = reference.wide().area.sel(amplitudes="exact", hurst=0.8, bandwidth=64.0, reduced_pressure=0.05)
    found = reference.lookup(hurst=0.8, bandwidth=64, reduced_pressure=0.05)["area"]
    assert (found.value, found.interpolation) == (pytest.approx(float(cell), rel=1e-12), 0)
    at = {"hurst": 0.8, "reduced_pressure": 0.05}
    narrow, between, wide = (reference.lookup(**at, bandwidth=b)["area"] for b in (32, 40, 64))
    assert narrow.value > between.value > wide.value
    assert narrow.interpolation == 0 < between.interpolation < between.uncertainty < 0.005 * between.value
    # H = .3 has no cell at the lightest load and takes no part there; elsewhere it does.
    light = reference.lookup(hurst=0.8, bandwidth=20, reduced_pressure=0.005)["area"].value
    between = [reference.wide().area.sel(hurst=0.8, bandwidth=b, reduced_pressure=0.005) for b in (16, 32)]
    assert between[1] < light < between[0]
    for asked, words in (
        ({"hurst": 0.8, "bandwidth": 48, "reduced_pressure": 0.3}, "goes from 0.01 to 0.2"),
        ({"hurst": 0.3, "bandwidth": 20, "reduced_pressure": 0.007}, "goes from 0.01 to 1.5"),
        ({"hurst": 0.9, "bandwidth": 100, "reduced_pressure": 0.05}, "no cell at H = 1, .* = 64"),
    ):
        with pytest.raises(UsageError, match=words):
            reference.lookup(**asked)


@pytest.mark.parametrize("name", ["area", "gap"])
def test_between_the_tables_intervals_hold_at_the_band_that_is_left_out(name):
    both = reference.wide().combine_first(reference.table()).sel(amplitudes="exact")
    both = both.sel(hurst=[0.3, 0.5, 0.8])
    for bandwidth in (32, 64):
        for hurst in both.hurst.values:
            for load in (0.01, 0.05, 0.2):
                at = {"hurst": float(hurst), "bandwidth": float(bandwidth), "reduced_pressure": load}
                left_out = both.drop_sel(bandwidth=bandwidth, reduced_pressure=0.005)
                found = interpolated(left_out, name, at)
                apart = abs(found.value - float(both[name].sel(at)))
                assert apart <= np.hypot(found.uncertainty, float(total_error(both, name).sel(at)))


def test_wide_cells_of_narrow_bands_are_a_lighter_load_alone():
    wide, table = reference.wide(), reference.table()
    narrow = wide.area.sel(bandwidth=table.bandwidth)
    assert narrow.sel(reduced_pressure=[0.005]).notnull().any()
    assert narrow.sel(reduced_pressure=table.reduced_pressure.values[[0, 2, 4]]).isnull().all()
