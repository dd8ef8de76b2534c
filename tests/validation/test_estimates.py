"""Cases become one dataset, and what is misnamed is refused in a line."""

import numpy as np
import pytest
import xarray as xr

from validation.audit import dataset, values
from validation.audit.ledger import Ledger
from validation.errors import UsageError
from validation.execution.results import write_results
from validation.files import digest_of, prepare_folder, write_json, write_record
from validation.measurements.common import base_case, base_surface
from validation.measurements.limits import limits_of, solved
from validation.measurements.measurement import press_on_grids
from validation.report.estimates import SOURCES, change, claim, derive, error_of, mean, power_law, total_error
from validation.report.findings import finding
from validation.report.marks import Figure, Line, Panel, draw
from validation.report.places import gather
from validation.report.table import Table
from validation.report.values import value_of
from validation.scenes.tables import SolidSpec

NUS = (0.0, 0.45)


def case(*, load=(0.1, 0.2), area=1.0):
    """Two areas over their loads."""
    return xr.Dataset(
        {"area_each": ("load", area * np.ones(2))},
        coords={"reduced_pressure": ("load", list(load)), "points": ("load", [8.0, 16.0])},
    )


def test_a_surface_whose_solve_failed_is_in_no_mean():
    data = xr.Dataset({"area_each": ("surface", [0.2, np.nan, 0.4]), "solve": ("surface", ["a", "", "b"])})
    assert mean(data, "area").area == pytest.approx(0.3)
    assert np.isnan(mean(data.drop_vars("solve"), "area").area)


def test_a_coordinate_is_one_along_the_dimensions_where_it_differs():
    parts = {(nu, k): case(load=(0.1 * (1 + nu), 0.2), area=k) for nu in NUS for k in range(3)}
    parts.pop((0.0, 2))
    data = gather(parts, poisson=NUS, surface=range(3))
    assert data.points.dims == ("load",)
    assert data.reduced_pressure.dims == ("poisson", "load")
    assert data.reduced_pressure.values.tolist() == [[0.1, 0.2], [0.1 * 1.45, 0.2]]
    assert np.isnan(data.area_each.values[0, 2]).all()


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (case().rename(area_each="kappa_each"), "differ in area_each, kappa_each"),
        (case().isel(load=[0]), "differ in load"),
    ],
)
def test_cases_that_are_not_alike_are_refused_by_what_differs(other, words):
    with pytest.raises(UsageError, match=words):
        gather({0: case(), 1: other}, surface=range(2))


def test_other_positions_along_a_dimension_are_refused():
    with pytest.raises(UsageError, match="'load' differs between the cases along surface"):
        gather({k: case().assign_coords(load=[k, 2.0]) for k in range(2)}, surface=range(2))


def test_p_star_of_one_p0_is_that_of_each_solid_and_the_audit_knows_it(bench, tmp_path):
    surface, cases = base_surface(hurst=0.8, periods=1.0, bandwidth=2.0, seed=3), {}
    for nu in NUS:
        first = base_case(surface, pressure=1e7, solid=SolidSpec(young=1e9, poisson=nu))
        for k in range(2):
            cases[nu, k] = press_on_grids(problem=first.further(k), grids=((8, 8), (16, 16)))
    parts = {place: limits_of(one) for place, one in solved(bench, cases).items()}
    data = gather(parts, poisson=NUS, surface=range(2))
    # All surfaces of a spectrum have its gradient.
    assert data.reduced_pressure.dims == ("poisson", "load")
    np.testing.assert_allclose(data.reduced_pressure[1] / data.reduced_pressure[0], 1 - 0.45**2, rtol=1e-12)
    first = data.assign_coords(reduced_pressure=("load", data.reduced_pressure.values[0]))
    for number, told in enumerate((data, first)):  # as it was before: that of the first case for all
        folder = prepare_folder(tmp_path / str(number))
        write_results(folder, told, kind="study", name="x", settings={}, store=bench.store.folder)
        summary = write_json(folder / "summary.json", {})
        write_record(folder / "shown.json", {"files": {"summary.json": digest_of(summary)}})
        ledger = Ledger()
        values.judge_dataset(dataset.Result(folder), ledger)
        assert not any("reduced_pressure" in line or "poisson" in line for line in ledger.unread)
        assert [entry.name.partition(" ")[0] for entry in ledger.wrong] == ["reduced_pressure"] * number


LAW = {"of": "area_each", "x": "lod", "along": ("load",)}


def _tabled(*columns):
    return lambda d: Table(rows=("load",), columns=columns).of(
        d.assign(pressure=1.0 * d["load"], pressure_map=2.0 * d["load"])
    )


_NAMELESS = Figure(name="a", caption="", panels=[Panel(marks=[Line(y="area_each")], x="poisson")])


@pytest.mark.parametrize(
    ("does", "words"),
    [
        (lambda d: mean(d, "area_each"), "mean of 'area_each': no 'area_each_each' in the dataset"),
        (lambda d: change(d, "aera", along="load"), "no 'aera_each'.*did you mean 'area_each'"),
        (lambda d: derive(d, kappa="area_ech / 2"), "kappa = area_ech / 2: no 'area_ech'.*mean 'area_each'"),
        (lambda d: power_law(d, "exponent", **LAW), "power law 'exponent': no 'lod'"),
        (lambda d: mean(d, "area", over="load_"), "no 'load_'; it is along poisson, surface, load"),
        (lambda d: claim(d, "area", grid=0.1), "claim: no 'area'"),
        (lambda d: error_of(d.area_each, gird=0.1), "no source of errors is called gird"),
        (_tabled("arrea"), "'arrea': no such quantity"),
        (_tabled("area_each"), "'area_each' is no single number here"),
        (_tabled("pressure", "pressure_map"), "'pressure' and 'pressure_map' have one title"),
        (lambda d: finding("value", "It is {area}.", d), "no single number area at a place"),
        (lambda d: finding("trend", "It {verdict}.", d), "names no value that decides"),
        (lambda d: draw(_NAMELESS, d), "'area_each' along 'poisson': name surface, load in 'by' or 'at'"),
    ],
)
def test_what_is_misnamed_is_refused_in_a_line(does, words):
    data = gather({(nu, k): case() for nu in NUS for k in range(2)}, poisson=NUS, surface=range(2))
    with pytest.raises(UsageError, match=words):
        does(data)


def test_the_change_of_a_place_with_itself_is_not_determinable():
    data = change(case().isel(load=[0]), "area", along="load")
    assert np.isnan(data.area_change_each.item())


def test_what_is_not_told_from_zero_has_its_whole_interval_as_a_size_too():
    """Of |d| both ends of the interval of d lie above."""
    data = claim(xr.Dataset({"d": ("load", [0.001, 0.0, -0.5])}), "d", grid=0.01)
    found = derive(data, size="abs(d)", least="maximum(d, 0)").isel(source=SOURCES.index("grid"))
    assert found.size_error.values == pytest.approx([0.01, 0.01, 0.01])
    assert found.least_error.values == pytest.approx([0.0055, 0.005, 0.0])


def test_a_change_has_the_errors_of_both_places():
    each = xr.Dataset(
        {"area_each": ("load", [0.5, 0.7, 0.4]), "area_each_drift": ("load", [0.03, 0.0, 0.01])}
    )
    each = claim(each, "area_each", grid=xr.DataArray([0.04, 0.5, 0.02], dims="load"))
    found = change(each, "area", along="load")
    assert float(found.area_change_each) == pytest.approx(0.8 - 1)
    grid = found.area_change_each_error.sel(source="grid")
    assert float(grid) == pytest.approx(0.8 * np.hypot(0.04 / 0.5, 0.02 / 0.4))
    assert float(found.area_change_each_drift) == pytest.approx((0.41 / 0.53 - 0.39 / 0.47) / 2, rel=2e-2)


def test_an_interval_names_its_sources_where_not_all_were_measured():
    form = "kappa = {kappa} and A/A0 = {area}."
    data = claim(xr.Dataset({"kappa": 2.0, "area": 0.1}), "kappa", "area", grid=0.02, depth="none")
    told = claim(data, "kappa", surfaces=0.0, solver=0.0, theory="none")
    assert f"{value_of(data, 'kappa')}" == "2.000 +- 0.020 (grid)"
    once, both = (finding("value", form, one).text for one in (data, told))
    assert once == "kappa = 2.000 +- 0.020 and A/A0 = 0.100 +- 0.020 (95 %: grid)."
    assert both == "kappa = 2.000 +- 0.020 and A/A0 = 0.100 +- 0.020 (grid)."


def test_a_list_of_no_case_says_none():
    data = xr.Dataset({"kappa": ("case", [2.0, 2.1])})
    said = [finding("value", "{each}.", data.isel(case=c), item="{kappa}").text for c in ([0, 1], [])]
    assert said == ["2 and 2.1.", "none."]


def test_what_grids_miss_at_random_averages_over_surfaces_and_what_drifts_with_them_does_not():
    each = xr.Dataset({"kappa_each": ("surface", [2.0] * 4), "kappa_each_drift": ("surface", [0.08] * 4)})
    kappa = mean(claim(each, "kappa_each", grid=0.12), "kappa")
    left = (0.12 / 2, 0.08, 0.08 / 2)
    assert float(kappa.kappa_error.sel(source="grid")) == pytest.approx(np.linalg.norm(left), rel=1e-12)
    # Of either sign they cancel by chance alone.
    of_either = each.assign(kappa_each_drift=("surface", [0.08, -0.08, -0.08, 0.08]))
    assert float(mean(of_either, "kappa").kappa_error.sel(source="grid")) == pytest.approx(0.04, rel=1e-12)
    # What does not enter a number does not enter their mean.
    exact = dict.fromkeys(SOURCES[2:], "it has none")
    whole = mean(claim(each.drop_vars("kappa_each_drift"), "kappa_each", grid=0.12, **exact), "kappa")
    assert f"{value_of(whole, 'kappa')}" == "2.000 +- 0.060"
    assert whole.kappa_error.attrs["depth"] == "does not enter: it has none"


def test_a_source_that_did_not_enter_does_once_a_number_is_claimed():
    data = claim(xr.Dataset({"area": ("load", [0.1, 0.2])}), "area", surfaces=0.03, grid="it is exact")
    assert "grid" in data.area_error.attrs
    np.testing.assert_array_equal(data.area_error.sel(source="surfaces"), 0.03)
    data = claim(data, "area", grid=0.04)
    assert "grid" not in data.area_error.attrs
    np.testing.assert_allclose(total_error(data, "area"), 0.05)
    assert claim(data, "area", grid="it is exact").area_error.attrs["grid"].startswith("does not enter")
