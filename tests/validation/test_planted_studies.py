"""Studies on inputs whose answer is known: each printed number beside the one that was planted."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from made_results import made_areas
from numpy.testing import assert_allclose, assert_array_equal
from planted import (
    EDGES,
    SMALL,
    STUDENT,
    THREE,
    PlantedBench,
    block,
    column,
    contact,
    decided,
    edge_data,
    located,
    made_of,
    measurement,
)
from solving import persson_area

from validation.measurements import adhesive, limits, ways
from validation.measurements.limits import SHARES
from validation.measurements.measurement import area_limits, truncated_heights
from validation.report.estimates import NORMAL, total_error
from validation.studies import (
    accuracy_cost,
    adhesion,
    area,
    cross,
    depth,
    graded,
    hardness,
    magnification,
    pressure,
    scaling,
    stress_near_zero,
)

# area: limits of surfaces, from planted areas ---------------------------------------------------------


@pytest.fixture(scope="module")
def grown():
    """A/A0 = 2 p* on average over three surfaces, on all grids alike."""

    def answer(solve):
        (load,) = solve.problem.load.values
        n = solve.grid[0]
        value = 2 * load * THREE[solve.problem.realisation]
        areas = {"pixel": value + 0.2 / n, "subcell": located(value, 2 / n), "edge_constant": 0.103}
        return made_areas(value, n, 2 / n, **areas)

    patched = pytest.MonkeyPatch()
    patched.setattr(limits, "areas_of_solve", lambda solve, result: result)
    data = made_of(area, answer, grids=(16, 32, 48), reduced_pressures=(0.05, 0.2), surfaces=3, seed=61)
    patched.undo()
    return data


def test_area_gives_the_planted_kappa_with_the_interval_of_the_grids(grown):
    assert_allclose(grown.kappa, 2.0, rtol=1e-12)
    surfaces, grid = (grown.area_error.sel(source=source) for source in ("surfaces", "grid"))
    # Off to the same side on all surfaces: the error of the grids does not shrink with their number.
    each = grown.area_each_error.sel(source="grid")
    assert_allclose(grid, np.sqrt((each**2).mean("surface")), rtol=1e-12)
    assert_allclose(total_error(grown, "area"), np.hypot(surfaces, grid), rtol=1e-12)
    assert_allclose(grown.kappa_error, grown.area_error / grown.reduced_pressure, rtol=1e-12)
    theory = [math.erf(math.sqrt(2) * p) for p in (0.05, 0.2)]
    assert_allclose(grown.area_persson, theory, rtol=1e-12)
    assert_allclose(grown.kappa_persson, np.divide(theory, (0.05, 0.2)), rtol=1e-12)


def test_area_says_the_planted_distance_to_the_theory_and_its_side(grown):
    found, coarse = area.views(grown).findings
    assert found.outcomes == ("+", "+")
    away = 0.1 / math.erf(math.sqrt(2) * 0.05) - 1
    assert found.rows[0]["area_excess"].value == pytest.approx(away, rel=1e-9)
    assert found.rows[0]["kappa"].value == pytest.approx(2.0, rel=1e-12)
    assert coarse.values["grids"].value == "16 x 16"


# pressure: area, gap, stiffness and energy against load -------------------------------------------------

GAMMA, KAPPA = 0.4, 1.7


def _falling(solve):
    """A/A0 = 1.7 p*, gap = (3 - 0.4 ln p*) h_rms, energy a quarter of p* times that of full contact."""
    own = THREE[solve["problem"].realisation]
    return measurement(
        solve,
        lambda p: KAPPA * p * own,
        mean_gap=lambda p, n: 2e-6 * (3 - GAMMA * np.log(p)),
        energy=lambda p, n: 4.0 * p / 4 * (1 + 1 / n),
        stiffness=lambda p, n: 1 / (GAMMA * (1 + 1 / n)),
    )


@pytest.fixture(scope="module")
def pressed():
    loads = (0.02, 0.05, 0.1, 0.3)
    return made_of(pressure, _falling, surfaces=3, shifts=2, reduced_pressures=loads, **SMALL)


def test_pressure_gives_the_planted_kappa(pressed):
    assert_allclose(pressed.kappa, KAPPA, rtol=1e-12)
    table = pressure.views(pressed).table.of(pressed)
    assert_allclose(column(table, "kappa"), KAPPA, rtol=1e-12)
    assert_allclose(column(table, "p*"), [0.02, 0.05, 0.1, 0.3])


def test_pressure_takes_the_compliance_from_the_stiffness_and_its_change_for_the_error(pressed):
    assert_allclose(pressed.compliance, GAMMA * (1 + 1 / 32), rtol=1e-9)
    grid = pressed.compliance_error.sel(source="grid")
    assert_allclose(grid, NORMAL * GAMMA * (1 / 24 - 1 / 32), rtol=1e-9)


def test_pressure_carries_gap_and_energy_to_their_limits_of_second_order(pressed):
    assert_allclose(pressed.gap_each[0], 3 - GAMMA * np.log(pressed.reduced_pressure), rtol=1e-12)
    quarter = pressed.reduced_pressure / 4
    assert_allclose(pressed.energy_ratio_finest_each[0], quarter * (1 + 1 / 32), rtol=1e-12)
    step = quarter * (1 / 24 - 1 / 32) / ((8 / 6) ** 2 - 1)
    assert_allclose(pressed.energy_ratio_each[0], quarter * (1 + 1 / 32) - step, rtol=1e-12)
    # Alike on all surfaces: it does not shrink with their number.
    grid = pressed.energy_ratio_error.sel(source="grid")
    assert_allclose(grid, NORMAL * step, rtol=1e-9)


def test_pressure_compares_area_with_the_theory_at_the_same_load(pressed):
    found = decided(pressure, pressed, "area_excess")
    loads = pressed.reduced_pressure.values[pressure.picked_loads(pressed)]
    exact = [KAPPA * p / math.erf(math.sqrt(2) * p) - 1 for p in loads]
    assert_allclose([row["area_excess"].value for row in found.rows], exact, rtol=1e-9)
    assert found.outcomes == tuple("+" if abs(x) > 0.05 else "0" for x in exact)


def test_pressure_speaks_of_four_loads_where_there_is_a_limit():
    area = [0.1, 0.2, np.nan, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0]
    assert pressure.picked_loads(xr.Dataset({"area": ("load", area)})) == [0, 3, 5, 7]


def test_pressure_says_that_planted_patches_and_kappa_keep_still(pressed):
    found = decided(pressure, pressed, "kappa_change")
    assert found.outcomes == ("0",)
    assert found.values["area_change"].value == pytest.approx(1.5, rel=1e-9)
    assert found.values["patches_change"].value == 0


def test_pressure_shares_are_of_the_nominal_area_and_do_not_move_where_nothing_moves(pressed):
    counted = pressed.area_pixel_each.isel(grid=-1)
    assert_allclose(pressed.stress_share_each.sum("stress_bin"), counted, rtol=1e-12)
    for name in SHARES:
        assert_allclose(pressed[f"moved_{name}"], 0.0, atol=1e-12)
    # At light load P(sigma) A0/A of the theory tends to 4 s exp(-2 s^2): between loads near 0 it stays.
    assert np.max(pressed.moved_stress_persson[:2]) < 0.01
    # Per contact area, .4 of it at a large pressure and .6 at a small one; all patches are of one size.
    width = float(pressed.stress[1] - pressed.stress[0])
    assert_allclose(pressed.contact_stress_density[:, [2, 25]] * width, [[0.6, 0.4]] * 4, rtol=1e-12)
    assert_allclose(pressed.patch_cumulated[:, [79, 80]], [[0.0, 1.0]] * 4, atol=1e-12)


def test_the_theory_of_pressure_is_at_full_contact_where_every_gap_is_closed():
    """U/U_full is 1, and the gap 0, with all variants; nothing is compared there but the area."""
    full = {"mean_gap": lambda p, n: 0.0, "stiffness": lambda p, n: np.inf}
    loads = {"surfaces": 2, "shifts": 2, "reduced_pressures": (8.0, 16.0)}
    data = made_of(pressure, lambda solve: measurement(solve, lambda p: 1.0, **full), **loads, **SMALL)
    assert_allclose(data.energy_ratio_predicted, 1.0, rtol=1e-6)
    assert_allclose(data.gap_predicted, 0.0, atol=1e-6)
    assert_allclose(data.area_predicted, 1.0, rtol=1e-9)
    assert data.energy_ratio_over.isnull().all()


# magnification ------------------------------------------------------------------------------------------


def test_magnification_prints_the_planted_ratio_to_the_theory_of_the_waves_that_are_there():
    def answer(solve):
        rough = truncated_heights(
            solve["problem"], solve["grids"][0], truncation=solve["truncation"]
        ).rms_gradient
        own = THREE[solve["problem"].realisation]
        return measurement(solve, lambda p: 1.1 * float(persson_area(p * 0.1 / rough)) * own)

    asked = {"reduced_pressures": (0.05, 0.1), "magnifications": (1.5, 2.0), "surfaces": 3}
    data = made_of(magnification, answer, **asked, **SMALL)
    assert_allclose(data.area_ratio, 1.1, rtol=1e-9)
    table = magnification.views(data).table.of(data)
    assert column(table, "zeta") == [1.5, 2.0, 1.5, 2.0]


# hardness and adhesion: fields of known answers ---------------------------------------------------------


@pytest.fixture
def yielded_lines(monkeypatch):
    """A_pl = p* (1 + 3 dx) and A_el = p*/2 (1 - 2 dx), by surface."""
    q = np.array([1.0, 2.0]) * 2 * math.pi * 2.0 / 1e-4
    monkeypatch.setattr(hardness, "remaining_waves", lambda *told: (q, np.array([1.0, 0.5]), 0.25))
    monkeypatch.setattr(hardness, "remaining_by_theory", lambda *told: np.array([0.9, 0.1]))
    monkeypatch.setattr(hardness, "yielded", lambda result: result.parts)

    def answer(solve):
        problem, n = solve.problem, solve.grid[0]
        load = problem.pressure / problem.pressure_scale * THREE[problem.surface.seed - 61]
        own = {"plastic_area": load * (1 + 3 / n), "elastic_area": load / 2 * (1 - 2 / n)}
        return contact(parts=SimpleNamespace(**own))

    asked = {"reduced_pressures": (0.1, 0.2), "magnifications": (2.5,), "smoothing_reduced_pressure": 0.1}
    rough = {"surfaces": 3, "seed": 61, "grids": (32, 48, 96), "periods": 1.6, "bandwidth": 2.5}
    return made_of(hardness, answer, **asked, **rough)


def test_hardness_takes_limits_linear_in_the_spacing(yielded_lines):
    data = yielded_lines
    assert data.varied.values.tolist() == ["load", "load", "waves"]
    assert_allclose(data.area_plastic, [0.1, 0.2, 0.1], rtol=1e-9)
    assert_allclose(data.area_elastic, [0.05, 0.1, 0.05], rtol=1e-9)
    assert_allclose(data.area_plastic_pixel[:, -1], data.area_plastic * (1 + 3 / 96), rtol=1e-9)
    # The three grids lie on one line.
    grid = data.area_plastic_error.sel(source="grid")
    assert_allclose(grid, 0.0, atol=1e-9)


def test_the_step_to_a_limit_from_two_grids_is_its_error_and_shares_stay_within_one():
    """A/A0 = .98 + 2 dx and .5 - 3 dx, on two grids and on three of which the coarsest is off by .1."""
    points = np.array([20.0, 40.0, 100.0])
    lines = np.array([0.98 + 2 / points, 0.5 - 3 / points])
    lines[:, 0] += 0.1
    data = xr.Dataset({"area_pixel_each": (("surface", "grid"), lines)}, coords={"points": ("grid", points)})
    two = limits.straight_limit(data.isel(grid=slice(1, None)), "area")
    assert_allclose(two.area_each, [0.98, 0.5], rtol=1e-12)
    assert_allclose(two.area_each_drift, [-0.02, 0.03], rtol=1e-9)
    three = limits.straight_limit(data, "area")
    # The line of the two coarser grids, 20 and 40, ends where .1 less of the first would have been.
    assert_allclose(three.area_each_drift, 0.1, rtol=1e-9)
    above = limits.straight_limit(data.assign(area_pixel_each=data.area_pixel_each + 0.1), "area", most=1.0)
    assert_allclose(above.area_each, [1.0, 0.6], rtol=1e-12)


def test_hardness_says_the_planted_areas_and_what_smoothing_leaves(yielded_lines):
    plastic, elastic, *_, smoothing = hardness.views(yielded_lines).findings
    assert plastic.rows[0]["area_plastic"].value == pytest.approx(0.1, rel=1e-9)
    theory = float(yielded_lines.area_plastic_persson[0])
    assert plastic.rows[0]["area_plastic_excess"].value == pytest.approx(0.1 / theory - 1, rel=1e-9)
    assert plastic.outcomes == ("-" if theory > 0.1 else "+",) * 2
    assert elastic.rows[1]["area_elastic"].value == pytest.approx(0.1, rel=1e-9)
    said = {name: value.value for name, value in smoothing.values.items()}
    assert (said["spectrum_kept"], said["wave"], said["gradient_kept"]) == (0.5, pytest.approx(2.5), 0.25)
    assert said["spectrum_kept_excess_largest"] == pytest.approx(0.4)
    assert smoothing.outcomes == ("+",)


def _full_wave(solve):
    """A cosine in full contact: p - p0 = E* q h / 2, u = h, no gap."""
    problem, n = solve.problem, solve.grid[0]
    modulus, length = problem.contact_modulus, problem.lengths[0]
    q = 2 * np.pi / length
    h = 1e-9 * np.cos(q * np.arange(n) * length / n)[:, None] * np.ones(n)
    return contact(
        in_contact=np.ones((n, n), dtype=bool),
        at_bound=np.arange(n)[:, None] < n / 4 * np.ones(n),
        pressure=1e5 + modulus * q * h / 2,
        displacement=h + 3e-9,
        gap=np.zeros((n, n)),
        spacing=(length / n, length / n),
        contact_modulus=modulus,
    )


STUCK = {
    "works": (0.1, 0.3),
    "reduced_pressures": (0.2,),
    "magnifications": (2.0,),
    "hardnesses": (0.6,),
    "grids": (32, 48),
    "bandwidth": 2.0,
    "seed": 61,
}


@pytest.fixture
def silent(monkeypatch):
    """The theory has no answer."""
    monkeypatch.setattr(adhesive, "readings", lambda *args, **told: {"improved": None, "old": None})


def test_adhesion_gains_the_work_less_half_of_p_u_at_full_contact(silent):
    options = adhesion.Options(**STUCK)
    data = adhesion.run(options, bench=PlantedBench(_full_wave))
    assert_allclose(data.area, 1.0, rtol=1e-12)
    assert_allclose(data.area_plain, 1.0, rtol=1e-12)
    assert np.flatnonzero(np.isfinite(data.area_plastic)).tolist() == [4]
    assert_allclose(data.area_plastic[-1], 0.25, rtol=1e-9)
    # Closed form of the energy of a wave, E* q a^2 / 8, over the work: a share of U_full of each surface.
    stored = 1e7 / (1 - 0.5**2) * 2 * np.pi / 1e-5 * 1e-9**2 / 8
    works = np.array([one.adhesion.work for one in adhesion.design(options).values()]).reshape(-1, 3)
    assert_allclose(data.interface_energy, 1 - np.mean(stored / works, axis=1), rtol=1e-9)
    # The theory says nothing: there is nothing to be above or below.
    found = adhesion.views(data).findings
    assert all(set(one.outcomes) == {"?"} for one in found)
    assert found[0].rows[0]["area_gain"].value == 1.0


def test_adhesion_adds_the_scatter_of_its_surfaces_to_the_step_of_their_grids(silent, monkeypatch):
    monkeypatch.setattr(adhesive, "interface_energy", lambda contact, law: 0.0)
    data = made_of(adhesion, _counted, **STUCK)
    assert_allclose(data.area, 0.5, rtol=1e-12)
    assert_allclose(data.area_gain, 1.25, rtol=1e-12)
    error = data.area_error
    # Alike on all three surfaces, with the error that the mean of three such drifts has.
    assert_allclose(error.sel(source="grid"), 0.3 / 48 * (1 + 1 / 3) ** 0.5, rtol=1e-9)
    # What is off by the same share with and without adhesion does not enter their ratio.
    assert_allclose(data.area_gain_error.sel(source="surfaces"), 0.0, atol=1e-12)


def _counted(solve):
    """Counted areas .5 + .3 dx, or .4 + .3 dx without adhesion, by surface; half of it at the bound."""
    n, own = solve.grid[0], THREE[solve.problem.surface.seed - 61]
    sticky = any(effect.kind == "adhesion" for effect in solve.effects)
    area = own * (0.5 if sticky else 0.4) + 0.3 / n
    return contact(in_contact=np.array([area]), at_bound=np.array([area / 2]))


def test_areas_with_adhesion_end_at_one(silent, monkeypatch):
    monkeypatch.setattr(adhesive, "interface_energy", lambda contact, law: 0.0)

    def answer(solve):
        return contact(in_contact=np.array([1 - 3 / solve.grid[0] ** 2]), at_bound=np.array([0.0]))

    data = made_of(adhesion, answer, **STUCK)
    assert_array_equal(data.area, 1.0)


# cross and depth: finite against boundary elements ------------------------------------------------------


def test_cross_says_by_how_much_finite_elements_are_above_and_the_planted_order():
    def answer(solve):
        off = 0.5 * (8 / solve["grid"][0]) ** 1.5
        return block(
            pixel=0.12, pixel_bem=0.1, perimeter=0.11, perimeter_bem=0.1, pressure_half_space=off, gap=-0.2
        )

    grids = {"full_points_per_wave": (4.0, 8.0, 16.0), "reduced_points_per_wave": (4.0,)}
    data = made_of(cross, answer, surfaces=2, periods=1.0, bandwidth=2.0, elements=("Hex1",), **grids)
    full = data.sel(leg="full Hex1")
    assert_allclose(full.area_difference, 0.2, rtol=1e-12)
    assert_allclose(full.area_difference_perimeter, 0.1, rtol=1e-12)
    assert_allclose(full.pressure_difference, 0.5 / np.array([1, 2, 4]) ** 1.5, rtol=1e-12)
    assert_allclose(full.order, 1.5, rtol=1e-12)
    assert float(total_error(full, "order")) < 1e-9
    first, alone, *_ = cross.views(data).findings
    assert first.outcomes == ("-",)
    assert alone.outcomes == ("?",)


def test_depth_tells_the_bottom_from_the_mesh():
    """The mesh costs 2 %, the bottom 8 % at a quarter of a period, 0.1 % at one."""

    def answer(solve):
        bottom = {0.25e-3: 0.08, 1e-3: 0.001}[dict(solve["settings"])["depth"]]
        return block(pressure_half_space=0.02 + bottom, pressure_layer=0.02, pixel=0.11, pixel_bem=0.1)

    meshes = {"points_per_wave": 4.0, "depths": (0.25, 1.0), "growths": (1.1, 1.2), "elements": ("Hex1",)}
    data = made_of(depth, answer, poissons=(0.3,), **meshes)
    assert_allclose(data.area_difference, 0.1, rtol=1e-9)
    assert_allclose(data.pressure_difference_layer, 0.02, rtol=1e-12)
    assert_allclose(data.pressure_difference[:2], [0.1, 0.021], rtol=1e-12)
    (found,) = depth.views(data).findings
    assert found.values["deep"].value == 1.0
    assert found.values["shallow_difference"].value == pytest.approx(0.1)


def test_scaling_has_the_planted_exponents_and_what_they_allow(monkeypatch):
    """Time 2e-6 N^1.1, memory 64 N: in 16 GiB 2^28 points, in an hour fewer."""
    monkeypatch.setattr("validation.studies.scaling.available_memory", lambda: 2**34)

    def answer(solve):
        number = solve["grid"][0] ** 2.0
        cost = {"seconds": 2e-6 * number**1.1, "fft_pairs": 40.0, "peak_bytes": 64.0 * number, "area": 0.1}
        return xr.Dataset({name: ((), value) for name, value in cost.items()})

    data = made_of(scaling, answer, grids=(128, 256, 512, 1024), surfaces=2, seed=61)
    assert_allclose(data.exponent_seconds, 1.1, rtol=1e-9)
    # The root of what rounding leaves of 1 - r^2.
    assert float(total_error(data, "exponent_seconds")) < 1e-7
    assert_allclose(data.decade_seconds, 100**1.1, rtol=1e-9)
    assert_allclose(data.side_peak_bytes, 2**14, rtol=1e-9)
    side = (3600 / 2e-6) ** (1 / 2.2)
    assert_allclose(data.side_seconds, side, rtol=1e-9)
    assert_allclose(data.decades, math.log10(side / 32), rtol=1e-9)
    assert_allclose(data.seconds_fit, data.seconds, rtol=1e-9)
    _, grows, reaches = scaling.views(data).findings
    assert (grows.outcomes, reaches.kind) == (("+",), "cost")


# graded, near zero, costs -------------------------------------------------------------------------------


def test_graded_says_the_planted_error_inside_and_outside_the_range_of_the_claim(monkeypatch):
    monkeypatch.setattr(graded, "_profile", lambda ratio, options, q: np.array([1.3, 0.95, 1.04]))
    monkeypatch.setattr(graded, "_coating", lambda ratio, options, q: np.array([1.1, 0.6, 1.0]))
    monkeypatch.setattr(graded, "_grading", lambda ratio, q: np.array([5.0, 0.9, 0.1]))
    data = made_of(graded, None, ratios=(0.5,), waves=3)
    (found,) = graded.views(data).findings
    said = {**found.values, **found.rows[0]}
    assert said["felt_error_mild"].value == pytest.approx(-0.05, rel=1e-12)
    assert said["felt_error_profile"].value == pytest.approx(0.3, rel=1e-12)
    assert said["felt_error_coating"].value == pytest.approx(-0.4, rel=1e-12)


def test_near_zero_gives_students_interval_of_three_surfaces():
    root = np.sqrt(1 / np.array([16.0, 32.0, 64.0, 128.0]))
    scatter = THREE[:, None]
    data = edge_data(density=0.1 * scatter + root, slope=4 * scatter + root, contour=4 * scatter + root**2)
    own = data.isel(method=0)
    for name, mean in {"density": 0.1, "slope_window": 4.0, "slope_contour": 4.0}.items():
        assert_allclose(own[f"initial_{name}"], mean, rtol=1e-9)
        assert_allclose(total_error(own, f"initial_{name}"), 0.01 * mean * STUDENT[3], rtol=1e-6)
    # Persson's closed form at p* = .05, V = 1/4.
    persson = 8 * 0.05 * np.exp(-2 * 0.05**2) / np.sqrt(np.pi / 2)
    assert_allclose(data.initial_slope_persson, persson, rtol=1e-12)
    assert_allclose(own.initial_slope_excess, 4 / persson - 1, rtol=1e-9)
    table = stress_near_zero.views(data).table.of(data)
    assert_allclose(column(table, "P(0+) E* h'_rms"), 0.1 + root, rtol=1e-9)
    density, slope, ways, _ = stress_near_zero.views(data).findings
    assert (density.outcomes, slope.outcomes, ways.outcomes) == (("+",), ("+",), ("agree",))


def test_ways_to_an_accuracy_are_ranked_by_what_they_are_off_and_cost():
    labels = ["BEM pixel, 4 per wave", "BEM limit, 4 to 6 per wave", "other, 4 per wave"]
    data = xr.Dataset(
        {
            "area_deviation_rms": ("way", [0.0354, 0.001, 0.0005]),
            "seconds": ("way", [1.0, 5.0, 0.5]),
            "peak_bytes": ("way", [2.0**20, 2.0**21, 2.0**10]),
            "reference_rms": 1e-5,
            "reference_each_error": (("surface", "source"), np.full((2, 1), 2e-5)),
            "claimed_each": ("surface", [0.01, 0.01]),
            "missed_each": ("surface", [0.009, -0.011]),
        },
        # Measured by its process: another measure of memory, so that it is no way of ours.
        coords={"way": labels, "process": ("way", [0, 0, 1]), "source": ["grid"]},
    )
    data = ways.chosen_ways(ways.covered(data))
    assert int(data.held) == 1
    assert float(data.coverage) == 0.5
    one = data.sel(target=2)
    assert float(one.accuracy) == 0.01
    assert (str(one.way_fastest.item()), float(one.seconds_fastest)) == (labels[1], 5.0)
    assert (str(one.way_leanest.item()), float(one.peak_bytes_leanest)) == (labels[1], 2.0**21)


def test_deviations_of_ways_and_claims_are_those_of_planted_areas():
    """The reference is 0.2; counts are off by the planted excess, and limits by nothing."""

    def answer(solve):
        return measurement(solve, lambda p: 0.2)

    options = accuracy_cost.Options(
        surfaces=2,
        points_per_wave=(4.0, 6.0),
        held_out_points_per_wave=(6.0, 8.0),
        fem_points_per_wave=(),
        peer_points_per_wave=(),
        methods=("bem",),
        periods=1.6,
        bandwidth=2.5,
    )
    data = accuracy_cost.run(options, bench=PlantedBench(answer))
    pixel = data.sel(way="BEM pixel, 4 per wave")
    assert_allclose(pixel.area_deviation_each, 0.1 * EDGES / 16 / 0.2, rtol=1e-9)
    assert_allclose(pixel.area_deviation_rms, 0.1 * EDGES / 16 / 0.2, rtol=1e-9)
    assert_allclose(data.missed_each, 0.0, atol=1e-12)
    (value,), (error,) = area_limits(answer(next(iter(accuracy_cost.design(options).values()))))
    assert_allclose(data.claimed_each, NORMAL * error / value, rtol=1e-9)
