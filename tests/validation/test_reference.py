"""The reference table: nodes as they stand, between them within the uncertainty, nothing outside."""

import contextlib
import itertools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from commanding import answer_of, invoke, output_of
from gold.asked import STUDIES
from numpy.testing import assert_allclose
from refusing import refused
from scipy.optimize import least_squares
from scipy.special import erf

from persson import separation
from persson.scale import Scale
from persson.spectrum import SelfAffine
from validation import reference
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.measurements.common import base_case, base_surface
from validation.measurements.control_variates import Known, chained_mean, unsolved_statistics
from validation.measurements.ensemble import _Drawn, mean_area
from validation.measurements.limits import limits_of
from validation.measurements.measurement import grid_for, grids_for, press_on_grids
from validation.measurements.table_samples import QUANTITIES, at_loads, joined, with_size
from validation.reference.citable import ATTRIBUTES, as_csv
from validation.reference.fit import at_equal_alpha, bandwidth_at, nayak
from validation.reference.interpolation import _curvature, _place, interpolated
from validation.reference.theory import theory_at_nodes
from validation.report.estimates import claim, total_error
from validation.studies import reference as study

DOCS = Path(__file__).parents[2] / "docs"

HURSTS, BANDWIDTHS = np.array([0.1, 0.5, 1.0]), np.array([4.0, 8.0, 16.0])
LOADS = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5])


def law(h, b, p):
    excess = 1.4 - 0.1 * h + 0.02 * np.log(b) - 0.05 * np.log(p / 0.1)
    return erf(2**0.5 * p) * excess, 0.3 / p**0.3 * b**-0.05


@pytest.fixture
def planted(monkeypatch):
    area, gap = law(HURSTS[:, None, None], BANDWIDTHS[None, :, None], LOADS)
    dims = ("hurst", "bandwidth", "reduced_pressure")
    values = {"area": area, "gap": gap + 0 * area, "saving": area, "area_by_spectrum": 0.97 * area}
    coords = {"hurst": HURSTS, "bandwidth": BANDWIDTHS, "reduced_pressure": LOADS}
    data = xr.Dataset({name: (dims, value) for name, value in values.items()}, coords)
    data = claim(data, "area", surfaces=0.004 * data.area)
    data = claim(data, "gap", surfaces=0.01 * data.gap)
    data = claim(data, "area_by_spectrum", surfaces=0.006 * data.area)
    data = xr.concat([data, 1.02 * data.sel(hurst=[0.1, 1.0])], "amplitudes", join="outer")
    data = data.assign_attrs(periods=4.0)
    data = data.assign_coords(amplitudes=["exact", "gaussian"])
    monkeypatch.setattr(reference, "table", lambda rolloff: data)
    return data


def test_between_nodes_the_truth_lies_within_the_uncertainty(planted):
    rng = np.random.default_rng(7)
    for _ in range(20):
        h, p = rng.uniform(0.1, 1.0), np.exp(rng.uniform(np.log(0.01), np.log(0.5)))
        b = np.exp(rng.uniform(np.log(4), np.log(16)))
        found = reference.lookup(hurst=h, bandwidth=b, reduced_pressure=p)
        area, gap = law(h, b, p)
        assert abs(found["area"].value - area) <= found["area"].uncertainty
        assert abs(found["gap"].value - gap) <= found["gap"].uncertainty
        assert found["area"].uncertainty < 0.01 * area


def test_nothing_is_extrapolated(planted):
    inside = {"hurst": 0.5, "bandwidth": 8.0, "reduced_pressure": 0.1}
    for name, value in (("hurst", 0.05), ("bandwidth", 17.0), ("reduced_pressure", 0.6), ("hurst", np.nan)):
        with refused(UsageError, f"{name} = .*is not extrapolated"):
            reference.lookup(**inside | {name: value})


def test_beside_a_cell_that_was_not_made_it_refuses_and_elsewhere_does_not_mind(planted):
    whole = reference.lookup(hurst=0.4, bandwidth=6.0, reduced_pressure=0.03)["area"]
    for name in ("area", "gap"):
        planted[name][0, 0, 2] = planted[name][0, 2, 2] = np.nan  # no H = .1 or 1 at bandwidth 16
    without = reference.lookup(hurst=0.4, bandwidth=6.0, reduced_pressure=0.03)["area"]
    assert without.value == pytest.approx(whole.value, rel=2e-3)
    at_node = reference.lookup(hurst=0.5, bandwidth=16.0, reduced_pressure=0.1)["area"]
    assert at_node.value == pytest.approx(law(0.5, 16.0, 0.1)[0], rel=1e-12)
    with pytest.raises(UsageError, match=r"no cell at H = 0.1, lambda_long/lambda_short = 16"):
        reference.lookup(hurst=0.4, bandwidth=12.0, reduced_pressure=0.03)


def test_each_kind_of_amplitudes_and_of_gradient_has_its_own_numbers(planted):
    asked = {"hurst": 0.1, "bandwidth": 8.0, "reduced_pressure": 0.1}
    plain, by_spectrum = reference.lookup(**asked), reference.lookup(**asked, gradient="spectrum")
    assert list(by_spectrum) == ["area", "kappa"]
    assert "area_by_spectrum" not in plain
    assert by_spectrum["area"].value == pytest.approx(0.97 * plain["area"].value, rel=1e-12)
    assert by_spectrum["area"].uncertainty == pytest.approx(0.006 * plain["area"].value, rel=1e-6)
    gaussian = reference.lookup(**asked, amplitudes="gaussian")
    assert gaussian["gap"].value == pytest.approx(1.02 * plain["gap"].value, rel=1e-12)
    with pytest.raises(UsageError, match=r"no cell at H = 0.5.*amplitudes = gaussian"):
        reference.lookup(**asked | {"hurst": 0.5}, amplitudes="gaussian")
    with pytest.raises(UsageError, match=r"gradient = 'profile': must be 'surface' or 'spectrum'"):
        reference.lookup(**asked, gradient="profile")
    told = "reference --hurst 0.1 --ratio 8 --reduced-pressure 0.1 --amplitudes gaussian --gradient spectrum"
    area, kappa = answer_of(told).values()
    assert area["value"] == pytest.approx(1.02 * by_spectrum["area"].value, rel=1e-12)
    assert kappa["value"] == pytest.approx(10 * area["value"], rel=1e-12)
    assert area["persson"] == pytest.approx(erf(2**0.5 * 0.1), rel=1e-12)


def test_surfaces_with_a_roll_off_have_cells_and_a_theory_of_their_own():
    asked = {"hurst": 0.8, "bandwidth": 8.0, "reduced_pressure": 0.05}
    node = reference.table("plateau").sel(amplitudes="exact", **asked)
    found = reference.lookup(**asked, rolloff="plateau")
    for name in QUANTITIES:
        assert found[name].value == pytest.approx(float(node[name]), rel=1e-9)
        assert found[name].uncertainty == pytest.approx(float(total_error(node, name)), rel=1e-6)
    bent = {"rolloff": "plateau", "q_min": 1.0}
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=4.0, q_short=32.0, **bent)
    scale = Scale(spectrum=spectrum, contact_modulus=1.0)
    gap = separation.mean_separation(0.1 * 0.05, scale=scale) / spectrum.moments().rms_height
    told = answer_of("reference --hurst 0.8 --ratio 8 --reduced-pressure 0.05 --rolloff plateau")
    assert told["gap"]["value"] == found["gap"].value
    assert told["gap"]["persson"] == pytest.approx(float(gap), rel=1e-6)
    assert abs(told["gap"]["persson"] / reference.persson_theory(**asked)["gap"] - 1) > 0.01
    with pytest.raises(UsageError, match=r"bandwidth = 64.0: the table .* goes from 4 to 32"):
        reference.lookup(**asked | {"bandwidth": 64.0}, rolloff="plateau")
    with pytest.raises(UsageError, match=r"rolloff = 'smooth': must be 'sharp' or 'plateau'"):
        reference.lookup(**asked, rolloff="smooth")
    with pytest.raises(UsageError, match=r"rolloff = 'smooth'"):
        reference.persson_theory(**asked, rolloff="smooth")
    with pytest.raises(UsageError, match=r"amplitudes = 'gaussian': must be 'exact'$"):
        reference.lookup(**asked, rolloff="plateau", amplitudes="gaussian")


@pytest.mark.parametrize(("name", "rolloff"), [("area", "sharp"), ("gap", "sharp"), ("gap", "plateau")])
def test_intervals_hold_at_nodes_that_are_left_out(name, rolloff):
    data, every = reference.table(rolloff).sel(amplitudes="exact"), 7 if rolloff == "sharp" else 3
    errors, held = total_error(data, name), []
    for axis in ("hurst", "bandwidth", "reduced_pressure"):
        for k in range(1, data.sizes[axis] - 1):
            rest = data.drop_isel({axis: k})
            # One node in seven or three, which no axis has in common: each takes a while.
            nodes = data[name].isel({axis: [k]}).to_series().dropna()
            for place, value in list(nodes.items())[k % every :: every]:
                point = dict(zip(data[name].dims, place, strict=True))
                with contextlib.suppress(UsageError):
                    found = interpolated(rest, name, point)
                    held.append(abs(found.value - value) <= np.hypot(found.uncertainty, errors.sel(point)))
    assert len(held) > 50
    assert np.mean(held) > 0.95


@pytest.mark.parametrize("rolloff", ["sharp", "plateau"])
@pytest.mark.parametrize("name", ["area", "gap"])
def test_what_is_a_multiple_of_the_theory_is_read_off_exactly(planted, name, rolloff):
    data = planted.sel(amplitudes="exact").assign_attrs(rolloff=rolloff)
    nodes = [tuple(data[axis].values.tolist()) for axis in ("hurst", "bandwidth", "reduced_pressure")]
    persson = theory_at_nodes(*nodes, lowest=0.25 if rolloff == "plateau" else 1.0)[name]
    point = {"hurst": 0.6, "bandwidth": 5.0, "reduced_pressure": 0.03}
    found = interpolated(data.assign({name: (data[name].dims, 1.1 * persson)}), name, point)
    exact = 1.1 * reference.persson_theory(**point, rolloff=rolloff)[name]
    assert found.value == pytest.approx(exact, rel=1e-9)
    assert found.interpolation < 1e-9 * exact


def test_between_two_nodes_the_distance_from_the_nearer_one_is_uncertain(planted):
    two = planted.sel(amplitudes="exact", hurst=[0.1, 0.5])
    # Of which no theory says anything.
    two = two.rename(gap="patch_density", gap_error="patch_density_error")
    asked = {"hurst": 0.2, "bandwidth": 8.0, "reduced_pressure": 0.1}
    found = interpolated(two, "patch_density", asked)
    nearest = float(two.patch_density.sel(hurst=0.1, bandwidth=8.0, reduced_pressure=0.1))
    assert found.interpolation == pytest.approx(abs(found.value - nearest))
    two = two.assign(patch_density=two.patch_density * (1 + two.hurst))
    found, nearest = interpolated(two, "patch_density", asked), 1.1 * nearest
    distance = found.value * abs(np.log(found.value / nearest))
    assert found.interpolation == pytest.approx(1.5 * distance, rel=1e-9)
    assert found.interpolation > 0.05 * nearest


def test_what_bends_along_an_axis_is_uncertain_by_the_parabola_through_its_nodes(planted):
    """Of c x^2 that is c (x - x_0) (x_1 - x) between two nodes, of whatever axes."""
    nodes = {"hurst": HURSTS, "bandwidth": np.log(BANDWIDTHS), "reduced_pressure": np.log(LOADS)}
    h, b, p = np.ix_(*nodes.values())
    asked = {"hurst": 0.6, "bandwidth": 5.0, "reduced_pressure": LOADS[0]}
    places = [_place(planted, axis, asked) for axis in asked]
    found = _curvature(0.4 * h**2 - 0.3 * b**2 + 0 * p, places)
    apart = 0.4 * 0.1 * 0.4 + 0.3 * np.log(5 / 4) * np.log(8 / 5)
    assert found == pytest.approx(apart, rel=1e-9)


def test_between_its_loads_the_area_of_a_surface_is_read_off():
    loads = np.array(study.Options().reduced_pressures)
    areas = law(0.8, 8.0, loads)[0]
    for share in (0.93, 1.0, 1.04):
        found = at_loads(areas, loads=loads, targets=share * loads)
        assert found == pytest.approx(law(0.8, 8.0, share * loads)[0], rel=2e-6)


def test_where_alpha_is_all_that_matters_it_is_seen_and_where_the_hurst_exponent_does_too():
    hursts, bandwidths = np.array([0.3, 0.8]), np.array([4.0, 8.0, 16.0, 32.0])
    loads = np.array([0.01, 0.1, 0.2])
    table = xr.Dataset(coords={"hurst": hursts, "bandwidth": bandwidths, "reduced_pressure": loads})
    table = table.assign(area=(("hurst", "bandwidth", "reduced_pressure"), closed(table, FIT)))
    table = claim(table, "area", surfaces=1e-3 * table.area)
    found = at_equal_alpha(table, (4.0, 6.0, 12.0))
    assert np.isfinite(found.area.values[:2]).all()
    assert np.isnan(found.area.values[2, 0]).all()  # beyond bandwidth 32 at H = .3
    assert found.area.values[:2, 0] == pytest.approx(found.area.values[:2, 1], rel=1e-3)
    assert found.area.values[0, 0] == pytest.approx(fitted_area(loads, alpha=4.0), rel=1e-3)
    # Of surfaces with a roll-off alpha is another.
    rolled = table.assign_attrs(rolloff="plateau", periods=2.0)
    assert at_equal_alpha(rolled, (4.0,)).bandwidth[0, 1] == bandwidth_at(hurst=0.8, alpha=4.0, lowest=0.5)
    steep = at_equal_alpha(table.assign(area=table.area * (1 + 0.1 * table.hurst)), (4.0,)).area
    assert steep.values[0, 1] / steep.values[0, 0] == pytest.approx([1.08 / 1.03] * 3, rel=1e-3)


def test_parts_are_joined_and_what_is_missing_stays_open():
    def part(h, b, **attrs):
        dims = ("hurst", "bandwidth", "reduced_pressure")
        area = np.full((1, 1, 2), h * b)
        return xr.Dataset(
            {"area": (dims, area), "pairs": (dims[:2], [[f"{round(100 / b)} on 3"]])},
            coords={"hurst": [h], "bandwidth": [b], "reduced_pressure": [0.1, 0.2]},
            attrs={"study": "reference", "periods": 4.0, "tolerance": 1e-6} | attrs,
        )

    whole = joined([part(0.8, 16.0), part(0.3, 4.0), part(0.8, 4.0)])
    assert whole.area.values[..., 0] == pytest.approx(np.array([[1.2, np.nan], [3.2, 12.8]]), nan_ok=True)
    assert whole.pairs.values.tolist() == [["25 on 3", ""], ["25 on 3", "6 on 3"]]
    with pytest.raises(UsageError, match=r"periods = 4\.0, 8\.0"):
        joined([part(0.8, 16.0), part(0.3, 4.0, periods=8.0)])
    with pytest.raises(UsageError, match="rolloff = plateau, sharp: the parts"):
        joined([part(0.8, 16.0), part(0.3, 4.0, rolloff="plateau")])


def test_the_size_of_the_sample_is_twice_the_change_that_is_seen_and_its_interval():
    dims = ("hurst", "bandwidth", "reduced_pressure")

    def cells(value, width, *, hursts, bandwidths, periods):
        shape = (len(hursts), len(bandwidths), 2)
        coords = {"hurst": hursts, "bandwidth": bandwidths, "reduced_pressure": [0.1, 0.2]}
        data = {name: (dims, np.broadcast_to(value, shape).copy()) for name in QUANTITIES}
        made = xr.Dataset(data, coords=coords, attrs={"periods": periods})
        return claim(made, *QUANTITIES, surfaces=width)

    table = cells([2.0, 2.0], 0.006, hursts=[0.3, 0.55, 0.8], bandwidths=[8.0, 16.0, 32.0], periods=4.0)
    there = {"hursts": [0.3, 0.8], "bandwidths": [8.0, 32.0]}
    small = cells([1.0, 1.0], 0.003, **there, periods=4.0)
    seen = np.array([[0.05, 0.0], [0.0, 0.02]])
    larger = cells([1 + seen, 1.01 + seen], 0.004, **there, periods=8.0)
    whole = with_size(table, small, larger)
    # 5 % at the first load, 0 at four times the bandwidth, each to 0.5 % over the root of two Hurst
    # exponents; 0 and 2 % at the second. Between them half of both. At the larger H 1 % more.
    size = whole.gap_error.sel(source="size")
    between = np.insert(seen, 1, seen.mean(0), axis=0) + 0.005
    halves = 0.005 / np.array([[2], [4], [2]]) ** 0.5
    assert_allclose(size.values[1], 2 * (2 * between + halves), rtol=1e-9)
    single = with_size(table, *(part.sel(bandwidth=[8.0]) for part in (small, larger)))
    one = single.gap_error.sel(source="size").values[2]
    assert_allclose(one, [2 * (2 * (seen[0] + 0.01) + 0.005)] * 3, rtol=1e-9)
    total = total_error(whole, "gap", sources=["surfaces", "size"])
    assert total.values[2, 0] == pytest.approx(np.hypot(0.006, size.values[2, 0]))
    assert whole.attrs["larger_periods"] == 8.0


def test_the_command_prints_what_is_looked_up(planted):
    asked = "reference --hurst 0.8 --ratio 8 --reduced-pressure 0.05"
    found = reference.lookup(hurst=0.8, bandwidth=8.0, reduced_pressure=0.05)
    told = output_of(asked)
    assert told.startswith("H = 0.8, lambda_long/lambda_short = 8, p* = 0.05")
    assert f"{found['area'].value:.3f}"[:5] in told
    data = answer_of(asked)
    assert data["area"]["value"] == found["area"].value
    old = invoke(asked.replace("--reduced-", "--"))
    assert old.exit_code == 2
    assert "--reduced-pressure" in old.output
    theory = reference.persson_theory(hurst=0.8, bandwidth=8.0, reduced_pressure=20.0)
    assert theory["energy_ratio"] == pytest.approx(1, rel=1e-9)
    assert (theory["gap"], theory["compliance"]) == pytest.approx((0, 0), abs=1e-9)


def test_the_table_that_is_shipped_is_whole_and_says_how_it_was_made():
    data = reference.table()
    made = np.isfinite(data.area.values)
    assert np.all(made.all(axis=3) == made.any(axis=3))
    exact = made & (data.amplitudes.values == "exact")[:, None, None, None]
    for name in QUANTITIES:
        assert np.all(np.isfinite(data[name].values) == made), name
        parts = {part: data[f"{name}_error"].sel(source=part).values for part in ("surfaces", "grid", "size")}
        assert np.all(np.isfinite(parts["size"]) == exact), name
        squares = sum(np.nan_to_num(part) ** 2 for part in parts.values())
        solver = (7 * data.attrs["tolerance"] * data[name].values) ** 2
        total = total_error(data, name).transpose(*data[name].dims).values
        assert total[made] == pytest.approx(np.sqrt(squares + solver)[made], rel=1e-9), name
        assert np.all(squares[exact] > 0), name
    assert np.all(np.diff(data.area.values, axis=3)[made[..., 1:]] > 0)
    assert data.attrs["study"] == "reference"
    assert {"seed", "periods", "tolerance", "larger_periods"} <= set(data.attrs)
    assert np.all((data.pairs.values != "") == made.all(axis=3))


@pytest.mark.parametrize(
    ("rolloff", "title", "hursts"),
    [("sharp", "The area", [0.1, 0.3, 0.5, 0.8, 1.0]), ("plateau", "With a roll-off", [0.8])],
)
def test_the_documentation_prints_the_areas_of_the_table_that_is_shipped(rolloff, title, hursts):
    data = reference.table(rolloff).sel(amplitudes="exact", hurst=hursts, bandwidth=[4.0, 8.0, 32.0])
    page = (DOCS / "reference_table.md").read_text(encoding="utf-8")
    lines = page.partition(f"## {title}")[2].partition("\n## ")[0].splitlines()
    header = next(line for line in lines if "| H |" in line)
    data = data.sel(reduced_pressure=[float(load) for load in re.findall(r"= ([\d.]+)", header)])
    lines = [line.strip("|").split("|") for line in lines if re.match(r"\| [\d.]+ \| \d+ \|", line)]
    rows = [[cell.strip() for cell in line] for line in lines]
    assert len(rows) == np.isfinite(data.area).all("reduced_pressure").sum()
    for hurst, bandwidth, *cells in rows:
        own = data.sel(hurst=float(hurst), bandwidth=float(bandwidth))
        for cell, area, error in zip(cells, own.area.values, total_error(own, "area").values, strict=True):
            digits, last = re.fullmatch(r"([\d.]+)\((\d+)\)", cell).groups()
            unit = 10.0 ** -len(digits.partition(".")[2])
            assert float(digits) == pytest.approx(area, abs=0.51 * unit)
            assert int(last) * unit == pytest.approx(error, abs=0.51 * unit)


@pytest.fixture(scope="module")
def small(bench, numbers):
    return study.Options(**STUDIES["reference"]), bench, numbers("reference")


def test_a_cell_of_the_table_is_the_chained_mean_of_its_pairs(small):
    options, bench, data = small
    cases = study.spectra(options, "exact")[0.8, 8.0].cases
    solved = bench.solve(cases.values())

    def gaps(last, grid):
        own = [solved[case] for name, case in cases.items() if name[0] == last]
        each = [float(one.mean_gap[grid, 0, 1]) / one.attrs["rms_height"] for one in own]
        return np.mean(np.reshape(each, (-1, 2)), axis=1)

    def told(ks):
        fields = [cases[0, 0, False]["problem"].further(k).heights((24, 24)) for k in ks]
        return np.array([list(unsolved_statistics(field).values()) for field in fields])

    coarse = (gaps(0, 0), told(range(8)))
    chain = chained_mean([coarse, (gaps(1, 1), gaps(1, 0))], Known.of_samples(told(range(12, 44))))
    own, data = chain[-1], data.sel(amplitudes="exact", hurst=[0.8])
    assert_allclose(data.gap[0, 0, 1], own.value, rtol=1e-12)
    half = total_error(data, "gap", sources=["surfaces"]).isel(hurst=0, bandwidth=0, reduced_pressure=1)
    assert_allclose(half, own.half_width, rtol=1e-12)


def test_the_total_is_the_root_of_the_squares_of_surfaces_grid_size_and_solver(small):
    _, _, whole = small
    data = whole.sel(amplitudes="exact")
    parts = data.area_error.sel(source=["surfaces", "grid", "size"]) ** 2
    total = total_error(data, "area")
    assert_allclose(total**2, parts.sum("source") + (7e-6 * data.area) ** 2, rtol=1e-12)
    table = study.views(whole).table.of(whole)
    row = dict(zip(table.columns, table.rows[0], strict=True))
    assert row["A/A0 +- (95 %)"] == pytest.approx(float(total[0, 0, 0]), rel=1e-12)
    assert row["kappa"] == pytest.approx(float(data.area[0, 0, 0]) / 0.05)
    persson = erf(2**0.5 * 0.05)
    assert row["A/A(Persson) - 1"] == pytest.approx(float(data.area[0, 0, 0]) / persson - 1, rel=1e-9)
    assert_allclose(data.interval_worst, (total / data.area).max(("hurst", "bandwidth")), rtol=1e-12)


def test_what_is_saved_is_told_by_all_the_time_that_was_taken(small):
    looked = "further"
    options, bench, data = small
    spectrum = study.spectra(options, "exact")[0.8, 8.0]
    solved = bench.solve(spectrum.cases.values())
    measured = {name: solved[case] for name, case in spectrum.cases.items()}
    saving = spectrum.reduced(measured).saving
    assert_allclose(saving, data.saving.sel(amplitudes="exact", hurst=0.8, bandwidth=8.0), rtol=1e-12)
    spent = sum(one.attrs["seconds"] for name, one in measured.items() if len(name) == 1)
    spent += sum(one.seconds.sum(("grid", "shift")) for name, one in measured.items() if len(name) > 1)
    cost = study.views(data).findings[-1]
    assert (cost.kind, len(cost.rows)) == ("cost", data.bandwidth.size)
    slower = measured[looked,].assign_attrs(seconds=measured[looked,].attrs["seconds"] + 100.0)
    less = spectrum.reduced({**measured, (looked,): slower}).saving
    assert_allclose(saving.values / less.values, (spent.values + 100) / spent.values, rtol=1e-9)


def test_exact_amplitudes_have_one_gradient_and_the_two_loads_differ_by_its_ratio(small):
    options, bench, data = small
    exact = data.sel(amplitudes="exact", hurst=0.8, bandwidth=8.0)
    cases = study.spectra(options, "exact")[0.8, 8.0].cases
    solved = bench.solve([case for name, case in cases.items() if len(name) > 1])
    gradients = {round(float(one.attrs["rms_gradient"]), 12) for one in solved.values()}
    (gradient,) = gradients
    loads = np.array(options.reduced_pressures)
    told = at_loads(exact.area.values, loads=loads, targets=loads * 0.1 / gradient)
    assert exact.area_by_spectrum.values == pytest.approx(told, rel=1e-3)
    assert abs(gradient / 0.1 - 1) > 0.005


def test_gaussian_amplitudes_have_columns_of_their_own_and_no_part_of_the_size(small):
    _, _, data = small
    assert data.amplitudes.values.tolist() == ["exact", "gaussian"]
    exact, gaussian = (data.sel(amplitudes=name, hurst=[0.8]) for name in ("exact", "gaussian"))
    joint = np.hypot(*(total_error(part, "area") for part in (exact, gaussian)))
    assert np.all(abs(exact.area - gaussian.area) < 2 * joint)
    assert np.all(exact.area != gaussian.area)
    assert np.isfinite(exact.area_error.sel(source="size")).all()
    assert np.isnan(gaussian.area_error.sel(source="size")).all()
    # What is read off between the loads is a part of the grids' error.
    grids = gaussian.area_by_spectrum_error.sel(source="grid")
    rest = grids**2 - gaussian.area_by_spectrum_reading**2
    assert_allclose(rest, gaussian.area_error.sel(source="grid") ** 2, rtol=1e-6)


def test_a_roll_off_is_in_every_surface_that_is_pressed():
    options = study.Options(hursts=(0.3,), bandwidths=(4.0,), rolloff="plateau")
    (spectrum,) = study.spectra(options, "exact").values()
    (larger,) = study.spectra(options.samples_by_size()[1], "exact").values()
    for sampled, periods in ((spectrum, 4), (larger, 8)):
        power = np.abs(np.fft.fft2(sampled.base.heights((96, 96)).heights)) ** 2
        assert_allclose(power[1 : periods + 1, 0], power[periods, 0], rtol=1e-9)
        assert power[periods + 1, 0] < 0.99 * power[periods, 0]


def test_larger_samples_have_twice_the_periods_a_quarter_of_the_pairs_and_other_surfaces():
    options = study.Options(hursts=(0.3, 0.5), bandwidths=(8.0, 32.0), larger_bandwidths=(8.0, 32.0))
    small, larger = options.samples_by_size()
    assert (larger.hursts, larger.bandwidths, larger.periods) == ((0.3,), (8.0, 32.0), 8.0)
    assert small.ladder_of(8.0) == larger.ladder_of(32.0) == (3.0,)
    assert (small.pairs_of(8.0), larger.pairs_of(8.0)) == ((160,), (40,))
    assert (small.pairs_of(32.0), larger.pairs_of(32.0)) == ((40,), (10,))
    assert larger.seed > options.seed + 10_000
    assert (small.seed, small.periods) == (options.seed, options.periods)
    assert study.Options(hursts=(0.5,)).samples_by_size() is None


def test_fewer_waves_take_more_surfaces_and_finer_grids():
    options = study.Options(pairs=(80, 30, 6, 2), points_per_wave=(3, 6, 12, 24), largest=1000)
    assert options.pairs_of(16.0) == (80, 30, 6)
    assert options.pairs_of(4.0) == (320, 120, 24, 8)
    assert options.pairs_of(32.0) == (40, 4, 4)
    with pytest.raises(ValueError, match="one for each"):
        study.Options(pairs=(80, 30), points_per_wave=(3, 6, 12))


def test_no_surface_serves_two_grids_or_is_looked_at_as_another():
    options = study.Options(hursts=(0.3,), bandwidths=(4.0, 32.0))
    for (_, bandwidth), spectrum in study.spectra(options, "exact").items():
        cases = spectrum.cases
        numbers = [name[1] for name in cases if len(name) > 1 and not name[2]]
        assert len(numbers) == len(set(numbers)) == sum(options.pairs_of(bandwidth))
        coarsest, further = cases["coarsest",], cases["further",]
        ending = {name[1] for name in cases if name[0] == 0}
        assert ending == set(range(coarsest["first"], coarsest["first"] + coarsest["count"]))
        assert further["first"] > max(numbers)


@pytest.mark.slow
def test_a_mean_to_an_accuracy_agrees_with_the_table_and_takes_what_it_needs(tmp_path):
    base = base_case(base_surface(hurst=0.5, periods=4.0, bandwidth=4.0, seed=90210), reduced_pressure=0.4)
    bench = Bench.at(tmp_path)
    grids = grids_for(base, (3.0, 6.0, 12.0))
    rough, fine = (mean_area(base, half_width=asked, bench=bench, grids=grids) for asked in (0.02, 0.002))
    known = reference.lookup(hurst=0.5, bandwidth=4.0, reduced_pressure=0.4)["area"]
    assert rough.half_width <= 0.02 * rough.estimate.value
    assert fine.half_width <= 0.002 * fine.estimate.value
    assert fine.pairs > rough.pairs
    assert abs(fine.estimate.value - known.value) <= 1.5 * np.hypot(fine.half_width, known.uncertainty)


def test_surfaces_that_are_added_are_new_ones_and_none_is_taken_back():
    base = base_case(base_surface(hurst=0.5, periods=4.0, bandwidth=4.0, seed=90210), reduced_pressure=0.4)
    drawn = _Drawn(base=base, grids=((48, 48), (96, 96), (192, 192)), tolerance=1e-6)
    first = drawn.cases()
    drawn.grow((30, 5, 3, 100))
    second = drawn.cases()
    assert drawn.counts == [32, 6, 4, 128]  # whole blocks
    assert all(second[name] == case for name, case in first.items())
    pairs: list[list[int]] = [[] for _ in range(4)]
    for name, case in second.items():
        pairs[name[1]] += range(case["first"], case["first"] + case["count"])
    assert [len(numbers) for numbers in pairs] == [2 * 32, 6, 4, 128]  # the first are looked at, too
    assert len(set().union(*pairs)) == 170


#: c_0, c_1, p_1 and n of `fitted_area`: least squares of the relative distance from the table.
FIT = (0.5606, 0.05449, 0.1893, 1.0067)


def fitted_area(load, *, alpha, constants=FIT):
    light, slope, middle, power = constants
    return erf(2**0.5 * load * (1 + (light - slope * np.log(alpha)) / (1 + (load / middle) ** power)))


def closed(table, constants, **lowest):
    spectra = itertools.product(table.hurst.values, table.bandwidth.values)
    alpha = np.array([nayak(hurst=h, bandwidth=b, **lowest) for h, b in spectra])
    over = alpha.reshape(table.hurst.size, -1, 1)
    return fitted_area(table.reduced_pressure.values, alpha=over, constants=tuple(constants))


def fitted(table):
    """Constants of the closed form by least squares over a table, and its relative distances."""
    area = table.area.transpose("hurst", "bandwidth", "reduced_pressure").values

    def misses(constants):
        return (closed(table, constants) / area - 1)[np.isfinite(area)]

    best = least_squares(misses, FIT).x
    return best, misses(best)


def test_the_closed_form_is_fitted_to_the_table_and_off_by_what_is_said():
    constants, distance = fitted(reference.table().sel(amplitudes="exact"))
    assert constants == pytest.approx(FIT, rel=2e-3)
    (said,) = re.findall(r"off by at most ([\d.]+) %", (DOCS / "reference_table.md").read_text("utf-8"))
    assert 100 * abs(distance).max() == pytest.approx(float(said), abs=0.051)


def test_of_surfaces_with_a_roll_off_alpha_is_what_matters_as_far_as_is_said():
    sharp, rolled = (reference.table(name).sel(amplitudes="exact") for name in ("sharp", "plateau"))
    off = closed(rolled, FIT, lowest=0.25) / rolled.area.transpose("hurst", "bandwidth", "reduced_pressure")
    said = re.search(r"off by -([\d.]+) to \+([\d.]+) %", (DOCS / "reference_table.md").read_text("utf-8"))
    least, most = map(float, said.groups())
    assert [100 * float(1 - off.min()), 100 * float(off.max() - 1)] == pytest.approx([least, most], abs=0.051)
    light = {"hurst": rolled.hurst, "reduced_pressure": [0.01, 0.02, 0.05]}
    one, other = (data.sel(light) for data in (sharp, rolled))
    joint = np.hypot(*(total_error(data, "area_equal") for data in (one, other)))
    apart = abs(one.area_equal - other.area_equal)
    assert int(apart.notnull().sum()) == int((apart <= joint).sum()) == 33


FOLDER = Path(reference.__file__).parent


def test_the_surfaces_of_the_page_are_those_of_the_table_and_have_the_areas_that_are_shipped():
    page = (DOCS / "reference_table.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(import numpy as np\n.*?)```", page, flags=re.DOTALL)
    names: dict = {}
    exec(code, names)  # the page's own words
    with np.load(FOLDER / "surfaces.npz") as shipped:
        for k, (hurst, seed) in enumerate(zip(shipped["hurst"], shipped["seed"], strict=True)):
            surface = base_surface(hurst=float(hurst), periods=4.0, bandwidth=4.0, seed=int(seed))
            case = base_case(surface, reduced_pressure=0.05)
            heights = names["surface"](float(hurst), 4, int(seed), 36)
            scale = 1e-3 * case.field.rms_gradient
            rolled = replace(case, surface=case.surface.model_copy(update={"rolloff": "plateau"}))
            plateau = names["surface"](float(hurst), 4, int(seed), 36, plateau=True)
            plateau *= 1e-3 * rolled.field.rms_gradient
            assert_allclose(plateau, rolled.heights((36, 36)).heights, rtol=0, atol=1e-12 * scale)
            assert_allclose(scale * heights, case.heights((36, 36)).heights, rtol=0, atol=1e-12 * scale)
            assert_allclose(heights, shipped["heights"][k], rtol=0, atol=1e-12)
            grids = tuple(grid_for(case, n) for n in (4.0, 6.0, 8.0))
            loads = tuple(shipped["reduced_pressure"])
            area = limits_of(press_on_grids(problem=case, grids=grids, reduced_pressures=loads).do())
            off = np.abs(area.area_each.values - shipped["area"][k])
            own = area.area_each_error.sel(source="grid").values + np.abs(area.area_each_drift.values)
            assert (off <= np.hypot(own, shipped["area_error"][k])).all()
            assert (shipped["area_error"][k] < 0.006 * shipped["area"][k]).all()


@pytest.mark.parametrize("name", ["table", "wide", "plateau"])
def test_the_table_says_what_it_is_and_its_csv_has_every_cell_that_was_made(name):
    data = reference.table("plateau") if name == "plateau" else getattr(reference, name)()
    file = FOLDER / f"{name}.csv"
    spectrum = {"lowest": 16, "power": "q^(-2-2H), no roll-off"}
    if name == "plateau":
        spectrum = {"lowest": 1, "power": "max(q, 2 pi/lambda_long)^(-2-2H)"}
    definition = ATTRIBUTES["definition"].format(**spectrum)
    assert (ATTRIBUTES | {"definition": definition}).items() <= data.attrs.items()
    assert data.area.attrs["ancillary_variables"] == "area_error"
    assert all("units" in data[name].attrs for name in data.data_vars if data[name].dtype.kind == "f")
    shipped = file.read_text(encoding="utf-8")
    assert shipped == as_csv(data)
    header, *rows = [line.split(",") for line in shipped.splitlines() if not line.startswith("#")]
    assert len(rows) == int(np.isfinite(data.area).sum())
    for row in rows:
        assert len(row) == len(header) == 16
        cell = data.sel(dict(zip(header[:4], [row[0], *map(float, row[1:4])], strict=True)))
        assert float(row[4]) == pytest.approx(float(cell.area), rel=1e-5)
        assert float(row[5]) == pytest.approx(float(total_error(cell, "area")), rel=1e-5)
