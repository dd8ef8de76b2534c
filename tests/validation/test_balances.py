"""What adds up does: seconds, counts and dates of solves, shares of area, load and error."""

import json
import os
import re
import time
from datetime import UTC, datetime

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from processes import run_python
from small_scene import scene_in, small_scene

from fem_contact import HeightField, Solid
from validation import sandbox
from validation.comparison.run import run_scene
from validation.effects.base import ContactModel
from validation.execution.bench import Bench
from validation.execution.provenance import Made
from validation.execution.store import check_store
from validation.measurements.common import base_case, base_surface
from validation.measurements.control_variates import unsolved_pairs
from validation.measurements.ensemble import area_pairs
from validation.measurements.grids import grid_roughness
from validation.measurements.measurement import press_on_grids
from validation.report.estimates import shown_sources, total_error
from validation.solvers import find_solver


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """A run from nothing, what lies in its store, and when it began and ended (whole seconds)."""
    folder = tmp_path_factory.mktemp("balance")
    began = datetime.now(UTC).replace(microsecond=0)
    scene = scene_in(folder, small_scene("shifts = 2\n[methods.fem]\ngrids = [[12, 8], [24, 16]]\n"))
    outputs = run_scene(scene, folder / "results", bench=Bench.at(folder / "solves"), report=False)
    made = {path: Made(**found.made) for path, _, found in check_store(folder / "solves", set_aside=False)}
    solves = {}
    for path in made:
        with xr.open_dataset(path) as stored:
            cost = json.loads(stored.attrs["cost"])
        solves[path.stem] = {"wall": cost["wall_seconds"], "made": made[path]}
    return outputs, solves, (began, datetime.now(UTC))


def test_each_solve_is_counted_once_with_its_seconds_within_the_run(fresh):
    outputs, solves, (began, ended) = fresh
    data, made = outputs.data, [solve["made"] for solve in solves.values()]
    assert set(np.ravel(data.solve.values)) - {""} == set(solves)
    assert (outputs.solved, outputs.reused, int(data.shifts.sum())) == (len(solves), 0, len(solves))
    count, seconds = re.match(r"(\d+) solves, done .* in (\S+) s\.", data.attrs["solves_made"]).groups()
    assert int(count) == len(solves)
    assert float(seconds) == pytest.approx(sum(one.seconds for one in made), rel=5e-3)
    spent = sum(solve["wall"] for solve in solves.values())
    assert_allclose(data.seconds.sum(), spent, rtol=1e-9)
    assert_allclose(data.seconds_total, spent, rtol=1e-9)
    # A solve is within what was done about it, and all that was done within the run.
    assert all(solve["wall"] <= solve["made"].seconds for solve in solves.values())
    assert sum(one.seconds for one in made) <= (ended - began).total_seconds()
    assert all(began <= datetime.fromisoformat(one.finished) <= ended for one in made)


@pytest.mark.parametrize("method", ["bem", "fem", "tamaas", "contact_mechanics", "calculix"])
def test_what_a_solver_says_that_it_took_is_within_what_passed(method):
    solver = find_solver(method)
    if (missing := solver.available()) is not None:
        pytest.skip(missing)
    x, y = np.arange(12)[:, None] / 12, np.arange(8)[None, :] / 8
    field = HeightField(heights=0.01 * (np.cos(2 * np.pi * x) + np.cos(2 * np.pi * y)), lengths=(1.5, 1.0))
    sandbox.end()  # a process that has pressed before grows by nothing
    run_python("-c", "pass")  # whose time is not the solver's
    began, clock = time.perf_counter(), sum(os.times()[:4])
    cost = solver.pressed(field, ContactModel(solid=Solid(young=1.0, poisson=0.3)), 0.01).cost
    assert 0 < cost.wall_seconds <= time.perf_counter() - began
    # Of a process that goes on the system has told nothing yet; four counts are of hundredths of a second.
    taken = os.cpu_count() * cost.wall_seconds if method in {"tamaas", "contact_mechanics"} else 0.04
    assert 0 <= cost.cpu_seconds <= sum(os.times()[:4]) - clock + taken
    assert cost.unknowns >= field.heights.size
    assert (cost.iterations > 0) == (method not in {"tamaas", "calculix"}), "told by no other"
    assert (cost.peak_bytes > 0) == (method != "calculix"), "of another program it is not known"


def test_the_seconds_that_a_measurement_keeps_are_within_those_of_its_solve(tmp_path):
    surface = base_surface(hurst=0.7, periods=2.0, bandwidth=4.0, seed=4711)
    problem = base_case(surface, reduced_pressure=0.1)
    pressed = {"problem": problem, "grids": ((24, 24), (32, 32)), "effects": (), "tolerance": 1e-6}
    cases = [
        press_on_grids(shifts=2, **pressed),
        area_pairs(first=3, count=2, **pressed),
        unsolved_pairs(problem=problem, grid=(32, 32), first=3, count=2),
        grid_roughness(problem=problem, grid=(24, 24)),
    ]
    results = Bench.at(tmp_path).solve(cases)
    for case, made in zip(cases, results.made(), strict=True):
        kept = results[case]
        spent = np.ravel(kept.seconds.values if "seconds" in kept else kept.attrs["seconds"])
        assert np.all(spent > 0)
        # Processor time of one thread, whatever other threads of this process take.
        assert spent.sum() <= 2 * made.seconds, case.describe()


def test_contact_and_gap_share_the_nominal_area_and_the_load(fresh):
    data = fresh[0].data
    width = float(data.stress_wide.diff("wide").isel(wide=0))
    counted = data.density_wide.sum("wide", min_count=1) * width
    assert counted.notnull().sum() == data.sizes["solver"]  # of the finest grid of each
    assert_allclose(counted, data.area_pixel.where(counted.notnull()), rtol=1e-9)
    carried = (data.density_wide * data.stress_wide).sum("wide", min_count=1) * width
    assert_allclose(carried.stack(all=carried.dims).dropna("all"), data.reduced_pressure, rtol=0.02)
    assert_allclose(data.contact_area, data.area * data.nominal_area, rtol=1e-12)
    load = float(data.pressure_map.fillna(0.0).mean())
    assert load == pytest.approx(float(data.pressure), rel=1e-6)


@pytest.mark.parametrize("name", ["run", "magnification", "hurst"])
def test_shares_of_an_error_make_the_whole(name, fresh, numbers):
    data = fresh[0].data if name == "run" else numbers(name)
    judged = 0
    for error in (name for name in map(str, data.data_vars) if name.endswith("_error")):
        parts, whole = data[error], total_error(data, error.removesuffix("_error"))
        square = sum(parts.sel(source=source, drop=True).fillna(0.0) ** 2 for source in shown_sources(parts))
        assert_allclose((whole**2).where(whole.notnull()), square.where(whole.notnull()), rtol=1e-12)
        judged += int((whole > 0).sum())
    assert judged > 0
