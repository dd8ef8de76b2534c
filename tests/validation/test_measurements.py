"""Measurements: each argument that determines the numbers names the solve, as it did before."""

import itertools
import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from surfaces import SOFT

from fem_contact import HeightField, bem
from validation.execution.bench import Bench, PlannedOnly
from validation.execution.press import Press
from validation.execution.solve import LOCATED_EDGES
from validation.measurements import edge, flow, measurement
from validation.measurements.adhesive import sticky_contact
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import base_case, base_surface
from validation.measurements.edge import edge_of_contact
from validation.measurements.flow import leaks
from validation.measurements.grids import down_to_grid
from validation.studies import find_study

PRESSED = base_case(base_surface(hurst=0.8, periods=2.0, bandwidth=4.0, seed=23), reduced_pressure=0.05)
STICKY = sticky_contact(problem=PRESSED, grid=(24, 24), work=1e-3, reach=2e-6, shells=(1e4, 2e4))


def test_another_value_of_any_field_is_another_solve():
    others = {"work": 2e-3, "reach": 3e-6, "shells": (1e4,), "grid": (24, 36), "problem": PRESSED.further(1)}
    assert len({STICKY.key, *(STICKY.but(**{name: value}).key for name, value in others.items())}) == 6


def test_a_recipe_holds_the_fields_as_json_has_them_and_what_is_read_off():
    assert STICKY.recipe.items() >= {"work": 1e-3, "reach": 2e-6, "shells": [1e4, 2e4], "version": 1}.items()
    assert "edges" not in STICKY.recipe
    assert leaks(problem=PRESSED, grid=(24, 24), areas=(0.1,)).recipe["edges"] == LOCATED_EDGES


@pytest.mark.parametrize("points", [24, 25])
def test_roughness_down_to_the_grid_ends_with_a_whole_wave_short_of_the_last_one(points):
    fine = down_to_grid(PRESSED, points)
    assert fine.lengths[0] / fine.shortest == pytest.approx(11, rel=1e-12)


def test_what_is_left_to_the_solver_is_not_in_the_recipe():
    block = beside_bem(problem=PRESSED, grid=(8, 8), method="fem")
    assert "layer" not in block.recipe
    assert block.but(layer=True).recipe["layer"] is True
    edge = edge_of_contact(problem=PRESSED, grid=(24, 24))
    assert {"method", "settings"}.isdisjoint(edge.recipe)
    assert edge.but(settings=(("tolerance", 1e-9),)).recipe["settings"] == {"tolerance": 1e-9}


def test_names_and_costs_follow_from_the_kind_of_solve():
    assert STICKY.prefix == "sticky-24"
    assert STICKY.describe() == "adhesion 24x24, H = 0.8, nu = 0.3, surface 1"
    foretold = STICKY.predict()
    assert (foretold.seconds, foretold.peak_bytes) == (pytest.approx(0.0569, rel=0.01), 230400)
    few, many = (leaks(problem=PRESSED, grid=(24, 24), areas=areas) for areas in ((0.1,), (0.1, 0.2)))
    assert many.predict().seconds == pytest.approx(6 / 5 * few.predict().seconds)
    assert many.predict().unknowns == 24**2


def test_a_call_travels_by_the_name_of_its_measurement():
    again = pickle.loads(pickle.dumps(STICKY))
    assert again == STICKY
    assert again.measurement is STICKY.measurement


#: Solves of studies: their names since November 2026, and what is foretold of them, [s] and bytes.
OF_BEFORE = """
adhesion bem-256x256-e63573eda7427d35 0.217 9437184
archard archard-1-512-cbb78c6e2e3f8a62 1.27 31457280
autopsy edge-64-61c9515f8cbdd380 0.00992 655360
conductance measure-64x64-9ef75f4469b2695c 0.291 491520
creep creep-128x128-23af57dc878ca38a 2.2 40960000
depth beside-fem-64-a4c4d91a35dd1a4b 0.0156 2064384
heights heights-32-697ed3d7c71b7e45 0.01 204800
large-slope slopes-24-4c915c771e07fb17 7.09 296550000
leak leak-48-280e075a7c5e0e71 0.37 4608000
macroasperities magnified-256-05324962304d5743 8.00 32768000
pressure measure-512x512-4eaca9629ef04b88 12.4 31457280
reference unsolved-48x48-4ec549d1e39a4327 1.75 460800
refinement grid-roughness-64-e28cffaebdde639d 0.0184 491520
scaling cost-128-a37cb8447a96c158 0.0217 1966080
sliding slide-256x256-1653c8d8495d2be8 8.98 39321600
stress-near-zero edge-256-14b3183b9b75b9cc 0.0836 10485760
"""


@pytest.mark.parametrize("row", OF_BEFORE.strip().splitlines())
def test_solves_of_before_are_found_again(row, tmp_path):
    study, key, seconds, peak_bytes = row.split()
    bench = replace(Bench.at(tmp_path), plan_only=True)
    with pytest.raises(PlannedOnly) as planned:
        find_study(study).compute(find_study(study).options(), bench=bench)
    # Where this fails, what is measured has changed: raise `RESULTS_VERSION`, or a version, and then these.
    (foretold,) = (solve.predict() for solve in planned.value.args if solve.key == key)
    assert foretold.peak_bytes == int(peak_bytes)
    assert foretold.seconds == pytest.approx(float(seconds), rel=0.01)


# On oblong cells of an oblong period, which no study has of itself.

_X, _Y = np.meshgrid(np.arange(24) / 24, np.arange(16) / 16, indexing="ij")
_MODES = itertools.product(range(4), (-2, 1, 3))
_WAVES = sum(np.cos(2 * np.pi * (m * _X + n * _Y) + m + 3 * n) / (m * m + n * n) for m, n in _MODES)


def turned(width):
    """A contact on a period of 3 and this width, and the same with its axes swapped."""
    for heights, lengths in ((_WAVES, (3.0, width)), (_WAVES.T, (width, 3.0))):
        field = HeightField(heights=heights, lengths=lengths)
        yield bem.solve(field, SOFT, mean_pressure=2.0, tolerance=1e-10)


@pytest.mark.parametrize(
    ("read", "width"),
    [
        (lambda one: measurement.histograms_of(one, SimpleNamespace(pressure_scale=2, shortest=0.4)), 1.5),
        (lambda one: {"square": edge.inverse_square_coefficient(one)}, 1.5),
        (lambda one: measurement._read_off(one, PRESSED, (), located=False), 1.5),
        (lambda one: flow._read_off(one, one, unit=0.01), 2.0),  # of square cells alone
    ],
    ids=["histograms", "edge", "measured", "magnified"],
)
def test_what_is_read_off_a_contact_does_not_know_which_axis_is_first(read, width):
    first, second = map(read, turned(width))
    for name in first.keys() - {"seconds", "residual", "peak_bytes"}:
        assert_allclose(first[name], second[name], rtol=1e-6, atol=1e-9, err_msg=name)
    assert first.keys() == second.keys()
    assert np.isfinite(next(iter(first.values()))).all()


def test_both_sides_of_a_grid_count_and_are_named():
    numbers = dict.fromkeys(("pixel", "perimeter", "edge_fraction"), 0.1)
    areas = measurement.stored_areas(numbers, grid=(24, 16), edge_constant=0.5)
    assert (areas.spacing, areas.cells) == ((1 / 24, 1 / 16), 384)
    press = Press(method="bem", grid=(24, 16), problem=PRESSED, shift=(0.25, 0.5))
    assert press.prefix == "bem-24x16"
    assert press.label == "BEM 24 x 16"
    assert press.describe() == "BEM 24x16, shift (0.25, 0.5)"


def test_half_the_spacing_deserves_an_eighth_of_the_tolerance_down_to_the_least():
    # PRESSED has eight shortest waves side by side: 2 to 512 points on each.
    found = [measurement.grid_tolerance(PRESSED, [(n, n), (8, 8)]) for n in (16, 64, 128, 256, 4096)]
    assert_allclose(found, [1e-5, 1e-5, 1e-5 / 8, 1e-5 / 64, 1e-8], rtol=1e-9)
