"""The study `macroasperities`: its instrument is the solver's, its outcomes are the numbers'."""

import numpy as np
import pytest
import xarray as xr

from fem_contact import HalfSpace, bem, contact_areas, percolates
from fem_contact.patches import find_patches
from persson.elastic import area_against_magnification
from validation.measurements.measurement import grid_for, without_waves_beyond
from validation.report.estimates import derive, mean, total_error
from validation.studies import macroasperities

ZETA = (0.5, 1.0, 2.0, 4.0)


@pytest.fixture(scope="module")
def options(asked):
    return asked("macroasperities")[0]


@pytest.fixture(scope="module")
def data(asked):
    return asked("macroasperities")[1]


def pressed(options, k, *, zeta, load):
    case = options.first.further(k)
    field = case.heights(grid_for(case, options.points_per_wave))
    cut = without_waves_beyond(field, zeta * 2 * np.pi / case.longest)
    pressure = load * case.pressure_scale
    return bem.solve(cut, HalfSpace(solid=case.elastic), mean_pressure=pressure).checked()


def test_areas_and_shares_are_those_of_the_surface_with_its_waves_up_to_zeta(options, data):
    seen, whole = (pressed(options, 2, zeta=zeta, load=0.05) for zeta in (1.0, 4.0))
    area = contact_areas(seen, subcell=True).subcell
    assert float(data.area_each[2, 1, 1]) == pytest.approx(area, rel=1e-5)
    inside = whole.pressure[seen.in_contact].sum() / whole.pressure.sum()
    assert float(data.load_inside_each[2, 1, 1]) == pytest.approx(inside, rel=1e-4)
    assert data.load_inside_each.values[..., -1] == pytest.approx(1.0, abs=1e-12)


def test_what_the_grid_leaves_is_twice_what_half_its_spacing_changes_on_the_first_surface(options, data):
    finer = options.model_copy(update={"points_per_wave": 2 * options.points_per_wave})
    coarse, fine = (pressed(one, 0, zeta=2.0, load=0.05) for one in (options, finer))
    areas = [contact_areas(state, subcell=True).subcell for state in (coarse, fine)]
    patches = [find_patches(state.in_contact, state.spacing).count for state in (coarse, fine)]
    here = data.isel(load=1, magnification=2)
    told = {name: float(here[f"{name}_error"].sel(source="grid")) for name in ("area", "patch_density")}
    assert told["area"] == pytest.approx(2 * abs(areas[1] - areas[0]), rel=1e-2)
    assert told["patch_density"] == pytest.approx(2 * abs(patches[1] - patches[0]) / options.periods**2)
    lightest = data.isel(load=1).macro_pressure_ratio_error.sel(source="grid")
    assert float(lightest) == pytest.approx(0.0, abs=1e-12)
    assert float(data.isel(load=2).macro_pressure_ratio_error.sel(source="grid")) > 0


def test_the_gradient_of_the_waves_that_are_there_is_what_the_theory_is_told(data):
    # 1 - A/A0 = erfc(sqrt 2 p0 / (E* h'(zeta))): with fewer waves there is more contact.
    assert np.all(np.diff(data.gradient_share_each) > 0)
    assert data.gradient_share_each.values[:, -1] == pytest.approx(1.0)
    assert np.all(np.diff(data.area_persson_each, axis=-1) <= 0)
    light = data.area_persson_each[:, 0, -1].values / 0.01
    assert light == pytest.approx(np.sqrt(8 / np.pi), rel=1e-3)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_gap_is_closed_before_its_threshold_and_open_behind_it(options, data, axis):
    gap = data.sel(axis=axis, phase="gap").isel(surface=1, percolating=0)
    at = float(gap.percolation_magnification_axis_each)
    before, behind = (pressed(options, 1, zeta=at * by, load=0.1) for by in (0.99, 1.01))
    assert not percolates(~before.in_contact, axis)
    assert percolates(~behind.in_contact, axis)
    areas = [contact_areas(state, subcell=True).subcell for state in (behind, before)]
    assert areas[0] < float(gap.percolation_area_axis_each) < areas[1]


def planted(data, *, power, which):
    """Mean pressures that grow with a power of the load, and scatter by half a per cent."""
    told = data.copy(deep=True)
    loads = told.reduced_pressure
    scatter = 1 + 0.005 * (told.surface - 1)
    told[f"{which}_ratio_each"][:] = (1 + (scatter - 1) * (loads > 0.01)) * (loads / 0.01) ** (1 - power)
    told = mean(told, f"{which}_ratio")
    return derive(told, **{f"{which}_shift": f"({which}_ratio - 1) / 0.1"})


def outcomes(data, by):
    return next(finding.outcomes for finding in macroasperities._findings(data) if finding.by == by)


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_pressure_that_stays_is_called_the_same_and_one_that_rises_is_not(data, power):
    told = planted(data, power=power, which="contact_pressure")
    assert outcomes(told, "contact_pressure_shift") == (("within",) * 2 if power == 1 else ("beyond",) * 2)
    half = 4.302652729911275 * 0.005 / np.sqrt(3) * 20 ** (1 - power)  # Student, two degrees of freedom
    assert float(total_error(told, "contact_pressure_ratio").isel(magnification=0)[2]) == pytest.approx(half)
    told["macro_pressure"] = 1.0 + 0 * told.reduced_pressure
    told = planted(told, power=power, which="macro_pressure")
    found = macroasperities._macroasperities(told, "", "the simulation")
    assert found.outcomes[1:] == (("within",) * 2 if power == 1 else ("beyond",) * 2)
    none = data.assign(macro_magnification=data.macro_magnification * np.nan)
    assert any("No load has a zeta_m" in said.text for said in macroasperities._findings(none))


def test_macroasperities_are_where_ln_a_of_the_theory_bends_most_and_their_pressure_is_that_of_the_area_there(
    options, data
):
    first, loads = options.first, data.reduced_pressure.values
    zetas = np.geomspace(0.5, 4.0, 2001)
    asked = {"pressure": loads[1] * first.pressure_scale, "contact_modulus": first.contact_modulus}
    asked |= {"magnification": zetas, "q_reference": 2 * np.pi / first.longest}
    told = area_against_magnification(first.own_spectrum, **asked)
    zeta = float(data.macro_magnification[1])
    assert zeta == pytest.approx(zetas[1 + np.argmax(np.diff(np.log(told), 2))], rel=0.01)
    seen = contact_areas(pressed(options, 2, zeta=zeta, load=loads[1]), subcell=True).subcell
    assert float(data.macro_area_each[2, 1]) == pytest.approx(seen, rel=1e-5)
    for which in ("", "_persson"):
        pressure = data.reduced_pressure / data[f"macro_area{which}_each"].mean("surface", skipna=False)
        xr.testing.assert_allclose(data[f"macro_pressure{which}"].drop_attrs(), pressure)


def test_thresholds_are_means_over_surfaces_of_both_directions(data):
    told = data.copy(deep=True)
    areas = np.array([[0.30, 0.40], [0.36, 0.38], [0.38, 0.40]])
    told["percolation_area_axis_each"].loc[{"phase": "contact"}] = areas[:, None, :]
    again = macroasperities._with_thresholds(told).sel(phase="contact")
    half = 4.302652729911275 * np.std([0.35, 0.37, 0.39], ddof=1) / np.sqrt(3)
    assert float(again.percolation_area_pooled) == pytest.approx(0.37)
    assert float(total_error(again, "percolation_area_pooled")) == pytest.approx(half)
    assert outcomes(macroasperities._with_thresholds(told), "percolation_area_excess")[0] == "+"
    told["percolation_area_axis_each"][0, 0, 0, 0] = np.nan
    assert outcomes(macroasperities._with_thresholds(told), "percolation_area_excess")[0] == "?"


def test_without_loads_to_percolate_at_there_are_no_thresholds(options, bench):
    few = {"reduced_pressures": (0.05, 0.2), "magnifications": (0.5, 1.0, 4.0), "percolating": ()}
    without = options.model_copy(update=few)
    data = macroasperities.run(without, bench=bench)
    assert "percolation_area" not in data
    assert len(macroasperities.views(data).figures) == 2
