"""The study of creep: its areas are those of the solver, its theory that of the realised surface."""

import numpy as np
import pytest

from fem_contact import PronySolid, contact_areas, creep
from persson import StandardSolid, contact_area, stress_variance
from validation.measurements.common import base_case
from validation.scenes.tables import SolidSpec
from validation.studies import find_study


def test_the_study_is_the_solver_on_the_finest_grid_and_the_theory_of_its_gradient(asked):
    options, data = asked("creep")
    rubber = PronySolid.standard(relaxed=1e6, unrelaxed=1e7, time=1e-3, poisson=0.5)
    solid = SolidSpec(young=1e6, poisson=0.5)
    case = base_case(options.self_affine(), reduced_pressure=0.1, solid=solid).further(1)
    held = [0, 1e-4 / 3, 2e-4 / 3, 1e-4, 4e-4, 7e-4, 1e-3]
    times = np.array([*held, *(1e-3 + np.array(held))])
    loads = case.pressure * np.repeat([1.0, 0.5], 7)
    path = creep(case.heights((24, 24)), rubber, times=times, mean_pressure=loads)
    areas = [contact_areas(path[k].checked()).perimeter for k in (3, 6, 10, 13)]
    assert data.area_each.values[1].ravel() == pytest.approx(areas, rel=1e-9)
    modulus = 1 / StandardSolid(relaxed=1e6, unrelaxed=1e7, time=1e-3).creep_compliance(1.1e-3) / 0.75
    variance = stress_variance(case.field.rms_gradient**2, contact_modulus=modulus)
    expected = contact_area(case.pressure / 2, stress_variance=variance)
    assert data.area_persson_each.values[1, 1, 0] == pytest.approx(expected, rel=1e-9)
    # What it touches more than the elastic contact of that time is the error of the steps, then memory.
    assert (abs(data.area_memory.values[0]) < 0.05).all()
    assert (data.area_memory.values[1] > 0.05).all()
    said = find_study("creep").views(data).findings
    worst = next(one for one in said if "miss it by at most" in one.text)
    assert worst.values["worst"].value == float(abs(data.area_memory_each.isel(phase=0)).max())
    missed = abs(data.area_each - data.area_crept_each).isel(phase=0).max("instant").mean("surface")
    solver = data.area_error.sel(source="solver").transpose("phase", "instant")
    assert solver.values == pytest.approx(np.full((2, 2), missed), rel=1e-12)
