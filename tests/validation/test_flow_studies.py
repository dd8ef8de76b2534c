"""The studies of conductance and leak: their numbers are the surface's, their sentences the numbers'."""

import numpy as np
import pytest
import xarray as xr

from fem_contact import HalfSpace, bem, contact_areas, flow_conductance, frozen_contact, open_gap
from validation.measures.common import base_case, persson_area
from validation.measures.flow import GAP_EDGES
from validation.measures.measurement import grid_for
from validation.solves.bench import Bench
from validation.studies import conductance, leak

LOADS = (0.01, 0.04, 0.16)


@pytest.fixture(scope="module")
def stiff(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("conductance"))
    options = conductance.Options(
        reduced_pressures=LOADS, periods=(1.0, 2.0), bandwidth=3.0, surfaces=2, shifts=1, seed=17
    )
    return options, conductance.run(options, bench=bench)


@pytest.fixture(scope="module")
def leaking(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("leak"))
    options = leak.Options(areas=(0.1, 0.35), bandwidths=(4.0,), surfaces=3, seed=17)
    return options, leak.run(options, bench=bench)


def test_the_stiffness_of_the_study_is_that_of_the_frozen_contact_on_its_finest_grid(stiff):
    options, data = stiff
    case = base_case(options.surface(2.0), reduced_pressure=0.04).further(1)
    solid = HalfSpace(solid=case.elastic)
    contact = bem.solve(case.heights(grid_for(case, 8.0)), solid, mean_pressure=case.pressure)
    own = frozen_contact(contact, solid).stiffness * case.field.rms_height / case.pressure
    assert float(data.stiffness[1, 1, 1]) == pytest.approx(own, rel=1e-5)


def planted(power):
    """A dataset whose K grows with the load to a power, the same for all surfaces, half of the theory's."""
    loads = np.array(LOADS)
    stiffness = np.broadcast_to(2.0 * loads ** (power - 1), (1, 4, 3))
    theory = np.broadcast_to(4.0 * loads ** (power - 1), (1, 3, 3))
    step = np.full((1, 4, 2), power)
    return xr.Dataset(
        {
            "stiffness": (("sample", "surface", "load"), stiffness),
            "grid_error": (("sample", "surface", "load"), np.full((1, 4, 3), 0.01)),
            "area": (("sample", "surface", "load"), np.full((1, 4, 3), 0.3)),
            "exponent": (("sample", "surface", "step"), step),
            "theory": (("sample", "variant", "load"), theory),
        },
        coords={
            "periods": ("sample", [4.0]),
            "reduced_pressure": ("load", loads),
            "step_pressure": ("step", np.sqrt(loads[1:] * loads[:-1])),
            "variant": ["persson", "yang_persson", "wang_mueser"],
        },
    )


def test_a_planted_power_and_a_planted_theory_are_found_again():
    said = conductance.findings(planted(0.75))
    assert "to the power 0.75 +- 0 (95 %, 4 surfaces)" in said[0]
    assert "K h_rms/p0 = 6.325 +- 0.01" in said[1]  # 2 * .01^-.25, and the grid alone
    assert said[1].count("2 times that") == 3
    row = conductance.table(planted(0.75)).rows[-1]
    assert row[3:7] == pytest.approx((2 * 0.16**-0.25, 0.0, 0.01, 4 * 0.16**-0.25))


def test_the_exponent_is_the_slope_of_the_stiffness_between_the_loads(stiff):
    _, data = stiff
    absolute = data.stiffness.values * np.array(LOADS)
    slope = np.diff(np.log(absolute), axis=-1) / np.log(4.0)
    assert data.exponent.values == pytest.approx(slope, rel=1e-12)


def test_areas_asked_for_are_met_and_closed_directions_are_those_beyond_their_threshold(leaking):
    options, data = leaking
    assert data.located.values == pytest.approx(
        np.broadcast_to(np.array(options.areas)[:, None], (1, 3, 2, 2)), abs=2e-4
    )
    beyond = data.located > data.gap_threshold
    assert np.array_equal(beyond, data.closed.values.astype(bool))
    assert np.array_equal(data.conductance.values == 0, beyond)
    assert np.all(data.balance < 1e-10)


def test_the_widest_path_has_a_narrowest_place_unless_the_gap_is_closed(leaking):
    _, data = leaking
    assert np.array_equal(data.constriction.values > 0, data.closed.values == 0)


def test_the_flow_of_the_study_is_that_of_the_surface_at_that_area(leaking):
    options, data = leaking
    case = base_case(options.surface(4.0), reduced_pressure=0.1).further(2)
    solid, grid = HalfSpace(solid=case.elastic), grid_for(case, 6.0)
    areas, leaks = [], []
    for load in (0.030, 0.035, 0.040, 0.045, 0.050):
        contact = bem.solve(case.heights(grid), solid, mean_pressure=load * case.pressure_scale)
        gap = open_gap(contact)
        areas.append(contact_areas(contact, subcell=True).subcell)
        leaks.append(flow_conductance(gap, contact.lengths, axis="y").conductance / gap.mean() ** 3)
    assert areas[0] < 0.1 < areas[-1]
    there = np.interp(float(data.located[0, 2, 0, 1]), areas, leaks)
    assert float(data.conductance[0, 2, 0, 1]) == pytest.approx(
        there, rel=0.02
    )  # straight between five loads


def test_the_sentences_of_the_leak_hold_means_over_surfaces_of_both_directions(leaking):
    _, data = leaking
    means = data.gap_threshold[0].mean("axis").values
    said = next(line for line in leak.findings(data) if "the gap ceases" in line)
    half = 4.302652729911275 * means.std(ddof=1) / np.sqrt(3)  # Student, two degrees of freedom
    assert f"A/A0 = {means.mean():.4g} +- {half:.2g}" in said
    row = leak.table(data).rows[1]
    assert row[2] == pytest.approx(float(data.conductance[0, :, 1].mean()), rel=1e-12)
    assert row[7] == pytest.approx(100 * float(data.closed[0, :, 1].mean()))


def test_gaps_and_contact_share_the_area_and_narrow_gaps_are_those_of_the_state(leaking):
    options, data = leaking
    case = base_case(options.surface(4.0), reduced_pressure=0.1).further(1)
    load = float(data.reduced_pressure[0, 1, 1])
    state = bem.solve(
        case.heights(grid_for(case, 6.0)),
        HalfSpace(solid=case.elastic),
        mean_pressure=load * case.pressure_scale,
    )
    narrow = GAP_EDGES[1:] < 0.1001
    found = float((data.gap_density[0, 1, 1] * np.diff(GAP_EDGES))[narrow].sum())
    gaps = state.gap[~state.in_contact]
    assert found == pytest.approx(np.sum(gaps < 0.1 * case.field.rms_height) / state.gap.size, abs=2e-3)


def test_the_gaps_of_the_theory_leave_what_its_contact_does_not_cover(leaking):
    _, data = leaking
    covered = (data.theory_density * np.diff(GAP_EDGES)).sum("gap_bin").sel(variant="Persson")
    expected = 1 - persson_area(data.reduced_pressure)
    # Gaps beyond 4 h_rms are rare even at light load.
    assert covered.values == pytest.approx(expected, abs=5e-3)


def test_a_planted_share_of_narrow_gaps_is_said(leaking):
    _, data = leaking
    told = data.copy(deep=True)
    told["gap_density"][:] = 0.2
    told["theory_density"][:] = 0.3
    said = [line for line in leak.findings(told) if "h_rms, contact left out" in line]
    assert "cover 0.02 +- " in said[0]
    assert "Persson 0.03 (cumulated shares at most 0.4 apart)" in said[0]  # .1 times 4.01 h_rms


@pytest.mark.parametrize(
    ("threshold", "verdict"), [(0.40, "it seals"), (0.50, "it leaks"), (0.435, "is not decided")]
)
def test_the_rim_seals_if_its_area_is_above_the_threshold_and_its_interval(leaking, threshold, verdict):
    _, data = leaking
    told = data.copy(deep=True)
    told["gap_threshold"][:] = threshold + np.array([-0.01, 0.0, 0.01])[None, :, None]
    (said,) = (line for line in leak.findings(told) if line.startswith("Tire rim"))
    assert verdict in said
