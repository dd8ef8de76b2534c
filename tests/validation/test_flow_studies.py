"""The studies of conductance and leak: their numbers are the surface's, their sentences the numbers'."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from planted import STUDENT, THREE, PlantedBench, made_of, measurement
from solving import persson_area

from fem_contact import HalfSpace, bem, contact_areas, flow_conductance, frozen_contact, open_gap
from validation.measurements import flow
from validation.measurements.common import base_case
from validation.measurements.flow import GAP_EDGES
from validation.measurements.measurement import grid_for
from validation.report.estimates import total_error
from validation.studies import conductance, leak

LOADS = (0.01, 0.04, 0.16)


@pytest.fixture(scope="module")
def stiff(asked):
    return asked("conductance")


@pytest.fixture(scope="module")
def leaking(asked):
    return asked("leak")


def test_the_stiffness_of_the_study_is_that_of_the_frozen_contact_on_its_finest_grid(stiff):
    options, data = stiff
    case = base_case(options.self_affine(periods=2.0), reduced_pressure=0.04).further(1)
    solid = HalfSpace(solid=case.elastic)
    contact = bem.solve(case.heights(grid_for(case, 8.0)), solid, mean_pressure=case.pressure)
    own = frozen_contact(contact, solid).stiffness * case.field.rms_height / case.pressure
    assert float(data.stiffness_each[1, 1, 1]) == pytest.approx(own, rel=1e-5)


def test_a_planted_power_and_a_planted_theory_are_found_again():
    """K h_rms / p0 = 2 p*^-0.25 by surface, .3 more per points on coarser grids; a power of .75."""

    def answer(solve):
        own = THREE[solve["problem"].realisation]
        found = measurement(
            solve,
            lambda p: p,
            stiffness=lambda p, n: own * 2.0 * p**-0.25 + 0.3 / n,
            mean_gap=lambda p, n: 1e-6,
        )
        return found.assign_attrs(rms_height=2e-6)

    options = conductance.Options(
        reduced_pressures=LOADS, periods=(1.0,), bandwidth=3.0, surfaces=3, shifts=1
    )
    data = conductance.run(options, bench=PlantedBench(answer))
    loads, (coarse, fine) = (
        np.array(LOADS),
        (n for n, _ in next(iter(conductance.design(options).values()))["grids"]),
    )
    assert_allclose(data.stiffness[0], 2.0 * loads**-0.25 + 0.3 / fine, rtol=1e-12)
    grid = data.stiffness_error.sel(source="grid")[0]
    # All three surfaces drift alike; the error that their mean has by its size is part of it.
    assert_allclose(grid, (0.3 / coarse - 0.3 / fine) * (1 + 1 / 3) ** 0.5, rtol=1e-9)
    assert_allclose(data.gap, 0.5, rtol=1e-12)
    ratio = data.stiffness_persson_each / data.stiffness_each
    assert_allclose(data.stiffness_ratio_persson, ratio.mean("surface"), rtol=1e-12)
    light, persson, *_ = conductance.views(data).findings
    assert light.rows[0]["stiffness_exponent_light"].value == pytest.approx(0.75, abs=5e-3)
    assert light.outcomes == ("-",)
    sides = np.sign((data.stiffness_each / data.stiffness_persson_each - 1).mean("surface").values[0])
    assert persson.outcomes == tuple("+" if side > 0 else "-" for side in sides)


def test_the_exponent_is_the_slope_of_the_stiffness_between_the_loads(stiff):
    _, data = stiff
    absolute = data.stiffness_each.values * np.array(LOADS)
    slope = np.diff(np.log(absolute), axis=-1) / np.log(4.0)
    assert data.stiffness_exponent_each.values == pytest.approx(slope, rel=1e-12)


def test_areas_asked_for_are_met_and_closed_directions_are_those_beyond_their_threshold(leaking):
    options, data = leaking
    located = data.area_located_axis_each
    expected = np.broadcast_to(np.array(options.areas)[:, None], (1, 3, 2, 2))
    assert located.values == pytest.approx(expected, abs=2e-4)
    beyond = located > data.percolation_area_axis_each.sel(phase="gap")
    assert np.array_equal(beyond.transpose(*located.dims), data.closed_axis_each.values.astype(bool))
    assert np.array_equal(data.gap_conductance_axis_each.values == 0, beyond.transpose(*located.dims))
    assert np.all(data.balance_axis_each < 1e-10)


def test_a_threshold_is_bracketed_in_area_and_only_if_asked_in_place(monkeypatch):
    monkeypatch.setattr(flow, "located_area", lambda state: state.load / 8)
    states = flow.States(lambda load, start: SimpleNamespace(pressure=start, load=load))
    area, at = states.threshold(lambda state: state.load < 0.7, 0.05, 4.0, area=1e-4)
    assert (area, at) == (pytest.approx(0.7 / 8, abs=1e-4), pytest.approx(0.7, abs=8e-4))
    coarse = states.threshold(lambda state: state.load < 0.7, 0.05, 4.0, area=1e-4, ratio=3.0)[1]
    assert 0.7 / 3 < coarse < 0.7 * 3
    assert abs(coarse - 0.7) > 0.01


def test_a_contact_is_started_from_the_one_of_the_nearest_load_by_their_ratio():
    states = flow.States(lambda load, start: SimpleNamespace(pressure=load, start=start))
    assert [states(load).start for load in (0.1, 3.0, 0.2, 1.0, 0.1)] == [None, 0.1, 0.1, 3.0, None]


def test_the_widest_path_has_a_narrowest_place_unless_the_gap_is_closed(leaking):
    _, data = leaking
    assert np.array_equal(data.constriction_axis_each.values > 0, data.closed_axis_each.values == 0)


def test_the_flow_of_the_study_is_that_of_the_surface_at_that_area(leaking):
    options, data = leaking
    case = base_case(options.self_affine(bandwidth=4.0), reduced_pressure=0.1).further(2)
    solid, grid = HalfSpace(solid=case.elastic), grid_for(case, 6.0)
    areas, leaks = [], []
    for load in (0.030, 0.035, 0.040, 0.045, 0.050):
        contact = bem.solve(case.heights(grid), solid, mean_pressure=load * case.pressure_scale)
        gap = open_gap(contact)
        areas.append(contact_areas(contact, subcell=True).subcell)
        leaks.append(flow_conductance(gap, contact.lengths, axis="y").conductance / gap.mean() ** 3)
    assert areas[0] < 0.1 < areas[-1]
    there = np.interp(float(data.area_located_axis_each[0, 2, 0, 1]), areas, leaks)
    assert float(data.gap_conductance_axis_each[0, 2, 0, 1]) == pytest.approx(
        there, rel=0.02
    )  # straight between five loads


def test_thresholds_and_conductance_are_means_over_surfaces_of_both_directions(leaking):
    _, data = leaking
    means = data.percolation_area_axis_each.sel(phase="gap")[0].mean("axis").values
    half = STUDENT[3] * means.std(ddof=1) / np.sqrt(3)
    threshold, _, rim, *_ = leak.views(data).findings
    assert threshold.rows[1]["percolation_area_pooled"].value == pytest.approx(means.mean(), rel=1e-12)
    assert threshold.rows[1]["percolation_area_pooled"].error == pytest.approx(half, rel=1e-9)
    assert rim.values["percolation_area_pooled"].value == pytest.approx(means.mean(), rel=1e-12)
    own = float(data.gap_conductance_axis_each[0, :, 1].mean())
    assert float(data.gap_conductance[0, 1]) == pytest.approx(own, rel=1e-12)
    assert float(data.closed[0, 1]) == pytest.approx(float(data.closed_axis_each[0, :, 1].mean()))
    narrowest = float((data.constriction_axis_each[0, :, 1] ** 3 / 12).mean())
    assert float(data.gap_conductance_constriction[0, 1]) == pytest.approx(narrowest, rel=1e-12)


def test_gaps_and_contact_share_the_area_and_narrow_gaps_are_those_of_the_state(leaking):
    options, data = leaking
    case = base_case(options.self_affine(bandwidth=4.0), reduced_pressure=0.1).further(1)
    load = float(data.reduced_pressure_each[0, 1, 1])
    state = bem.solve(
        case.heights(grid_for(case, 6.0)),
        HalfSpace(solid=case.elastic),
        mean_pressure=load * case.pressure_scale,
    )
    narrow = GAP_EDGES[1:] < 0.1001
    found = float((data.gap_density_each[0, 1, 1] * np.diff(GAP_EDGES))[narrow].sum())
    # What counts as contact beyond the located edge is narrow, too.
    edge = float(state.in_contact.mean() - data.area_located_each[0, 1, 1])
    assert edge > 0.005
    assert float(data.gap_narrow_each[0, 1, 1]) == pytest.approx(found + edge, rel=1e-9)
    gaps = state.gap[~state.in_contact]
    assert found == pytest.approx(np.sum(gaps < 0.1 * case.field.rms_height) / state.gap.size, abs=2e-3)


def test_the_gaps_of_the_theory_leave_what_its_contact_does_not_cover(leaking):
    _, data = leaking
    covered = data.gap_share_persson_each.isel(gap_bin=-1)
    expected = 1 - persson_area(data.reduced_pressure_each)
    # Gaps beyond 4 h_rms are rare even at light load.
    assert covered.values == pytest.approx(expected, abs=5e-3)


def reduced(gap_density, thresholds=(0.3, 0.4, 0.5)):
    """What the study makes of surfaces of planted distributions of gaps and thresholds of the gap."""

    def answer(solve):
        mine = thresholds[solve["problem"].realisation]
        shape = (len(solve["areas"]), 2)
        flow = {name: (("area", "axis"), np.full(shape, 0.5)) for name in FLOW}
        density = np.full((len(solve["areas"]), GAP_EDGES.size - 1), gap_density)
        return xr.Dataset(
            flow
            | {"contact_threshold": ("axis", [0.3, 0.3]), "gap_threshold": ("axis", [mine, mine])}
            | {"reduced_pressure": ("area", [0.05, 0.1]), "counted": ("area", [0.51, 0.51])}
            | {"gap_density": (("area", "gap_bin"), density)},
            coords={"area": list(solve["areas"]), "axis": ["x", "y"]},
        )

    return made_of(leak, answer, areas=(0.1, 0.35), bandwidths=(4.0, 8.0), surfaces=3, seed=17)


FLOW = ("located", "conductance", "closed", "effective_medium", "constriction", "balance")


def test_a_planted_share_of_narrow_gaps_and_its_distance_to_the_theory_are_found():
    data = reduced(0.2)  # and 0.01 counts as contact beyond the located edge
    assert_allclose(data.gap_narrow, 0.03, rtol=1e-9)
    theory = data.gap_density_persson_each.mean("surface").values
    apart = np.abs(np.cumsum((theory - 0.2) * np.diff(GAP_EDGES), axis=-1) - 0.01).max(axis=-1)
    assert_allclose(data.gap_distance_persson, apart, rtol=1e-9)
    assert leak.views(data).findings[-2].outcomes == ("-", "-")


@pytest.mark.parametrize(("threshold", "verdict"), [(0.40, "+"), (0.50, "-"), (0.435, "0")])
def test_the_rim_seals_if_its_area_is_above_the_threshold_and_its_interval(threshold, verdict):
    data = reduced(0.2, thresholds=(threshold - 0.01, threshold, threshold + 0.01))
    # Three surfaces, whose phases are common to both spectra: half of the interval is .0248.
    half = float(total_error(data.sel(phase="gap"), "percolation_area_pooled"))
    assert half == pytest.approx(0.01 * STUDENT[3] / np.sqrt(3), rel=1e-9)
    _, _, rim, *_ = leak.views(data).findings
    assert rim.outcomes == (verdict,)
    words = {"+": "so it seals", "-": "so it leaks", "0": "is not decided"}
    assert words[verdict] in rim.text
