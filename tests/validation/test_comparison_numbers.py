"""What the comparison computes, by numbers known in closed form: loads, theories, intervals, recipes."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from made_results import made_areas

from fem_contact import BondedLayer, FrictionlessLayer, HalfSpace, HeightField, Solid, bem, located_limit
from fem_contact.area import TRAITS
from persson import SelfAffine, elastic
from validation.comparison import accuracy_search
from validation.comparison.accuracy_search import Ladder, Search
from validation.comparison.numbers import _value_of
from validation.comparison.reductions import read_off
from validation.effects.adhesion import Adhesion
from validation.effects.base import ContactModel, Roughness, TheoryInputs
from validation.effects.coating import Coating
from validation.effects.graded import Graded
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.errors import NoLimit, RunFailed, UsageError
from validation.execution.attempt import Progress
from validation.execution.bench import Execution
from validation.execution.press import Press, decode_result, fields_dataset
from validation.measurements import ensemble
from validation.measurements.measurement import area_limits
from validation.netcdf import dataset_bytes
from validation.report.estimates import claim, derive
from validation.report.findings import finding
from validation.report.table import budget_table, shown
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, load_scene
from validation.scenes.sweep import load_asked
from validation.solvers.theory import TheoryOptions, predict, stress_distribution, with_effects

SOLID = Solid(young=2e9, poisson=0.3)
SPECTRUM = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2e5, q_short=8e5)


def scene(**changed):
    """A scene of a period of 3 x 2 whose cells are oblong."""
    waves = {"hurst": 0.8, "lambda_long": 1.0, "lambda_short": 0.5, "rms_gradient": 0.05, "seed": 9}
    said = {
        "name": "oblong",
        "surface": {"kind": "self-affine", "length": [3.0, 2.0], "amplitudes": "gaussian", **waves},
        "solid": {"young": 2e9, "poisson": 0.3},
        "load": {"reduced_pressure": 0.2},
        "methods": {"theory": {}, "bem": {"grids": [[24, 12], [32, 32]]}},
    }
    return Scene.model_validate(said | changed)


def _excess(value, error):
    """A dataset whose area is so far from the theory, with such an interval."""
    data = xr.Dataset({"area": 0.2, "pressure": 0.2 / (1 + value)})
    data = derive(claim(data, "area", grid=0.2 * error / (1 + value)), area_excess="area / pressure - 1")
    return finding("comparison", "{verdict}", data, by="area_excess").outcomes


@pytest.mark.parametrize(("errors", "outcome"), [(0.9, "0"), (1.1, "+"), (-1.1, "-")])
def test_agreement_is_claimed_within_the_interval_and_no_more(errors, outcome):
    assert _excess(errors * 0.02, 0.02) == (outcome,)


VARIANCE = float(elastic.stress_variance(SPECTRUM.m2(), contact_modulus=SOLID.contact_modulus))


def _theory(*effects, **options):
    options = {"variance": VARIANCE, "spectrum": SPECTRUM, "options": TheoryOptions(**options)}
    return with_effects(TheoryInputs.by(SOLID, effects), 5e6, **options)


def test_contact_of_a_hard_solid_is_that_of_the_elastic_one():
    exact = float(elastic.contact_area(5e6, stress_variance=VARIANCE))
    assert _theory(Hardness(hardness=1e13)).area == pytest.approx(exact, rel=1e-9)
    # Where everything yields, the hardness carries the load alone.
    soft = _theory(Hardness(hardness=5.5e6))
    assert soft.plastic == pytest.approx(5 / 5.5, rel=1e-6)
    assert soft.area == pytest.approx(soft.plastic, abs=1e-6)


def test_adhesion_without_work_leaves_the_theory_of_hardness():
    # The theory with adhesion is solved to 1e-6 of the area, on nodes whose error it states below 1e-4.
    hard = Hardness(hardness=6e7)
    both, alone = _theory(Adhesion(work=1e-9, reach=1e-8), hard), _theory(hard)
    found = (both.area, both.other, both.plastic)
    assert found == pytest.approx((alone.area, alone.area, alone.plastic), rel=1e-3)


def test_where_the_theory_has_no_answer_the_reason_is_kept_and_there_is_no_distribution():
    found = _theory(Hardness(hardness=2.5e6))
    assert math.isnan(found.area)
    assert found.note.startswith("no answer: pressure = ")
    scene = load_asked("hardness", ["hardness=1 MPa"])
    assert stress_distribution(realise(scene), scene.effects, None, np.linspace(0, 1, 5)) is None


@pytest.mark.parametrize("name", ["quickstart", "hardness", "adhesion", "soft-layer"])
def test_the_distribution_of_the_theory_holds_its_area(name):
    scene = load_scene(name)
    problem, options = realise(scene), scene.methods.options("theory")
    found = predict(problem, scene.effects, options)
    stress = np.linspace(-4, 8, 40_001) * problem.pressure_scale
    density = stress_distribution(problem, scene.effects, options, stress)
    # The adhesive walls are told between nodes of the iteration.
    elastic_area = found.area - (found.plastic or 0.0)
    assert np.trapezoid(density, stress) == pytest.approx(elastic_area, rel=2e-4, abs=2e-7)


def test_areas_are_projected_only_where_that_is_asked_for():
    sticky = Adhesion(work=2.0, reach=1e-8)
    assert abs(_theory(sticky, area="projected").area / _theory(sticky).area - 1) > 1e-4


def test_a_spectrum_is_brought_to_the_gradient_of_the_surface():
    problem = realise(scene())
    assert abs(problem.field.rms_gradient / 0.05 - 1) > 0.01
    assert math.sqrt(problem.own_spectrum.m2()) == pytest.approx(problem.field.rms_gradient, rel=1e-9)


def test_points_per_wave_are_those_of_the_coarser_axis():
    problem = realise(scene())
    assert problem.points_per_wave((24, 12)) == pytest.approx(0.5 / (2 / 12), rel=1e-12)
    assert problem.points_per_wave((12, 24)) == pytest.approx(0.5 / (3 / 12), rel=1e-12)


def test_the_unit_of_reduced_pressure_is_modulus_times_gradient():
    problem = realise(scene())
    exact = 2e9 / (1 - 0.09) * problem.field.rms_gradient
    assert problem.pressure_scale == pytest.approx(exact, rel=1e-12)
    assert problem.pressure == pytest.approx(0.2 * exact, rel=1e-12)
    assert problem.reduced_pressure == pytest.approx(0.2, rel=1e-12)


def test_a_budget_lists_every_source_and_adds_up():
    told = {"surfaces": 0.02, "grid": 0.04, "solver": 0.06, "size": 0.08, "bandwidth": 0.1, "depth": 0.12}
    data = claim(xr.Dataset({"kappa": 2.0}), "kappa", theory="it is simulated", **told)
    (row,) = budget_table(data, ["kappa"]).rows
    columns = budget_table(data, ["kappa"]).columns
    cells = dict(zip(columns, row, strict=True))
    assert [cells[f"{name} [%]"] for name in told] == pytest.approx([1, 2, 3, 4, 5, 6])
    assert cells["theory [%]"] == "does not enter"
    assert "theory [%]" not in shown(budget_table(data, ["kappa"])).columns
    assert cells["for this spectrum and period [%]"] == pytest.approx(math.sqrt(1 + 4 + 9 + 36))
    assert cells["for any [%]"] == pytest.approx(math.sqrt(91))
    (unknown,) = budget_table(claim(data, "kappa", bandwidth=math.nan), ["kappa"]).rows
    cells = dict(zip(columns, unknown, strict=True))
    assert cells["bandwidth [%]"] == "not measured"
    assert math.isnan(cells["for any [%]"])
    printed = shown(budget_table(claim(data, "kappa", bandwidth=math.nan), ["kappa"]))
    assert {"solver [%]"} == {*printed.columns} & {"bandwidth [%]", "solver [%]", "for any [%]"}
    assert printed.note == "Not measured: bandwidth. What does not enter: theory."
    assert cells["for this spectrum and period [%]"] == pytest.approx(math.sqrt(50))


def _search(monkeypatch, target=0.4):
    """A search that plans nothing."""
    bench = SimpleNamespace(wanted="", execution=Execution(), progress=Progress())
    search = Search(scene=scene(), problem=realise(scene()), target=target, bench=bench)
    ladder = Ladder(grids=((64, 64),), shifts=1, error=0.1, seconds=0.0, peak_bytes=0)
    monkeypatch.setattr(Search, "_cheapest", lambda self, ladders, tried, *, share: ladder)
    monkeypatch.setattr(Search, "_grid", lambda self, level: (64, 64))
    return search


def test_an_accuracy_claims_twice_the_standard_error_of_the_grids_and_the_tolerance(monkeypatch):
    planted = [made_areas(0.21, 32, 0.02), made_areas(0.2, 64, 0.02)]
    limit = located_limit(planted)
    search = _search(monkeypatch)
    # The pilot solves one grid, the ladder both.
    answers = iter([[planted[1]], planted])
    monkeypatch.setattr(Search, "_solved", lambda self, *asked: next(answers))
    found = search.own_surface()
    assert found.area == pytest.approx(limit.value, rel=1e-12)
    assert found.error == pytest.approx(2 * limit.uncertainty / limit.value + 7 * search.tolerance, rel=1e-12)


@pytest.mark.parametrize(("points", "told"), [((16,), True), ((16, 32), False)])
def test_an_area_of_a_few_points_is_told_of_one_grid_and_not_where_finer_ones_were_asked(points, told):
    read = _value_of([made_areas(12 / n**2, n, 0.01) for n in points], tolerance=1e-8)
    np.testing.assert_allclose(read.area, 12 / 16**2 if told else math.nan)
    assert read.why.item()  # there is no limit


@pytest.mark.parametrize("resolved", [False, True])
def test_grids_that_disagree_end_the_search_where_they_resolve_the_surface(monkeypatch, resolved):
    planted, search = [made_areas(0.2, 128, 0.02), made_areas(0.2, 256, 0.02)], _search(monkeypatch)
    doubts = iter(["the grids disagree", ""])
    limit = located_limit(planted)
    monkeypatch.setattr(accuracy_search, "_RESOLVED", 0 if resolved else math.inf)
    monkeypatch.setattr(
        accuracy_search, "limit_over", lambda areas: dataclasses.replace(limit, doubt=next(doubts))
    )
    monkeypatch.setattr(Search, "_solved", lambda self, *asked: planted)
    monkeypatch.setattr(Search, "_foretell", lambda self, *told: None)
    if resolved:
        with pytest.raises(RunFailed, match="the grids disagree; all solves are stored"):
            search.own_surface()
    else:
        assert search.own_surface().area == limit.value


def test_a_ladder_takes_the_seconds_of_all_its_shifts(monkeypatch):
    search, known = _search(monkeypatch), made_areas(0.2, 64, 0.02)
    search.bench.pair = 1e-3
    one, more = (search._planned(((24, 16), (48, 32)), shifts, known) for shifts in (1, 3))
    assert one.seconds == sum(search.costs[grid].seconds for grid in one.grids) > 0
    assert more.seconds == pytest.approx(9 * one.seconds)
    assert more.peak_bytes == one.peak_bytes == search.costs[(48, 32)].peak_bytes


def test_the_mean_over_surfaces_is_asked_of_finer_grids_until_it_is_known(monkeypatch):
    ladders = [
        Ladder(grids=((n, n),), shifts=1, error=0.02, seconds=float(n), peak_bytes=0) for n in (128, 192, 256)
    ]
    # What takes no longer is no finer, either.
    alike = dataclasses.replace(ladders[0], grids=((120, 120),))

    def mean(half, grid):
        numbers = {"half_width": 0.2 * half, "grid": 0.2 * grid, "surfaces": 8, "peak_bytes": 64}
        return SimpleNamespace(estimate=SimpleNamespace(value=0.2), **numbers)

    search, tried = _search(monkeypatch, target=0.1), []
    answers = [NoLimit("too small"), mean(0.3, 0.25), mean(0.1, 0.05)]

    def answered(problem, *, grids, **asked):
        tried.append(grids)
        answer = answers[len(tried) - 1]
        if isinstance(answer, NoLimit):
            raise answer
        return answer

    def cheapest(self, ladders, tried, *, share):
        return min((one for one in ladders if one.grids not in tried), key=lambda one: one.seconds)

    monkeypatch.setattr(accuracy_search, "mean_area", answered)
    monkeypatch.setattr(Search, "_chains", lambda self, known: [*ladders, alike])
    monkeypatch.setattr(Search, "_cheapest", cheapest)
    search.bench.affordable = lambda seconds, peak: True
    single = SimpleNamespace(finest=None)
    assert search.ensemble(single) is answers[2]
    assert tried == [one.grids for one in ladders]
    assert (search.doubt, search.peak_bytes) == (pytest.approx(0.25 / 0.02), 64)
    # Where the grids are not what is missing, more surfaces are.
    tried.clear()
    answers[:] = [mean(0.3, 0.01)]
    with pytest.raises(RunFailed, match="the mean over 8 surfaces is known to 30 %; all solves are stored"):
        search.ensemble(single)


def test_a_method_that_fails_beside_says_so_and_the_others_are_heard(monkeypatch):
    search, planted = _search(monkeypatch), [made_areas(0.21, 32, 0.02), made_areas(0.2, 64, 0.02)]
    search.bench.account = SimpleNamespace(reserved=1.0)
    solves = {
        name: tuple(Press(method=name, grid=grid, problem=search.problem) for grid in ((24, 16), (48, 32)))
        for name in ("bem", "fem")
    }
    search.others = solves
    search.areas = dict(zip(solves["fem"], planted, strict=True))

    def solved(self, asked):
        if asked == solves["bem"]:
            raise RunFailed("it stopped")

    monkeypatch.setattr(Search, "_solved", solved)
    failed, heard = search.beside()
    assert (failed.method, failed.doubt) == ("bem", "it stopped")
    assert math.isnan(failed.area)
    assert (heard.area, heard.doubt) == (located_limit(planted).value, "")


def test_the_mean_over_surfaces_claims_their_interval_the_grids_whole_error_and_the_tolerance():
    coarse = 0.2 + 0.01 * np.sin(np.arange(64.0))
    numbers = {"pixel": 0.2, "perimeter": 0.2, "edge_fraction": 0.02, "peak_bytes": 8.0}
    numbers |= dict.fromkeys(TRAITS, 0.0) | {"subcell": np.array([coarse, coarse + 1e-3])[:, None]}
    dims = ("grid", "shift", "load")
    fine = xr.Dataset(
        {name: (dims, np.broadcast_to(value, (2, 1, 64))) for name, value in numbers.items()}
        | {"seconds": ("load", np.ones(64))},
        coords={
            "points": ("grid", [32, 64]),
            "cells": ("grid", [32**2, 64**2]),
            "points_per_wave": ("grid", [4.0, 8.0]),
        },
    )
    ending = [fine.isel(grid=[0]), fine]
    told = np.cos(np.arange(64.0))[:, None]
    times = [pressed.seconds.values[:, None] for pressed in ending]
    samples = ensemble.Chained(unsolved=told[:32], further=told, unsolved_seconds=1.0, seconds=times)
    # What the next pair costs, on each grid and without a solve: slopes of 2 on what is told, of 3 on the
    # coarse grid.
    both = dataclasses.replace(samples, further=np.hstack([told, 0 * told]))
    slopes = ((2.0, 0.0), 0.3), ((3.0,), 0.1)
    chain = [SimpleNamespace(coefficients=np.array(slope), left=left) for slope, left in slopes]
    costs = [(9 * 0.3, 2 + 1 / 96), (0.1, 2.0), (9 * 4 * np.var(told, ddof=1), 1 / 96)]
    assert np.array(both.parts(chain)) == pytest.approx(np.array(costs), rel=1e-12)
    grids = ((32, 32), (64, 64))
    found = ensemble._estimated(ending, samples, grids=grids, tolerance=1e-3)
    limits, errors = area_limits(fine)
    # The difference between the grids is the same everywhere: only the coarse mean and its step are left.
    assert found.estimate.value == pytest.approx(np.mean(limits), rel=0.01)
    grid = 1.96 * math.sqrt(np.mean(errors**2))
    assert found.grid == pytest.approx(grid + 7e-3 * found.estimate.value, rel=1e-12)
    assert found.half_width == pytest.approx(math.hypot(found.grid, found.estimate.half_width), rel=1e-12)
    assert (found.surfaces, found.peak_bytes) == (128, 8)
    assert found.scatter == pytest.approx(np.std(coarse, ddof=1) / np.mean(coarse), rel=1e-12)


def test_surfaces_that_are_only_looked_at_are_seen_on_the_grid_that_all_share():
    grids = ((24, 12), (36, 18), (48, 24))
    drawn = ensemble._Drawn(base=realise(scene()), grids=grids, tolerance=1e-6)
    drawn.grow((0, 0, 0, 100))
    calls = {"looked": [], "pressed": []}
    for (what, last, _), call in drawn.cases().items():
        if what in calls:
            calls[what].append((last, call))
    assert len(calls["looked"]) > 1
    assert all(call.key == call.but(grid=grids[0]).key for _, call in calls["looked"])
    assert all(call.key == call.but(grids=grids[: last + 1]).key for last, call in calls["pressed"])
    # Those that end with the coarsest grid are looked at, too.
    firsts = [{call["first"] for last, call in calls[what] if last == 0} for what in calls]
    assert firsts[0] == firsts[1]


def test_a_recipe_tells_tolerances_shifts_and_grids_apart():
    problem = realise(scene())
    usual = Press(method="bem", grid=(24, 12), problem=problem, settings=(("tolerance", 1e-8),))
    changes = (
        {"settings": (("tolerance", 1e-6),)},
        {"shift": (0.0, 0.5)},
        {"grid": (12, 24)},
        {"problem": problem.further(1)},
        {"effects": (Hardness(hardness=1e9),)},
    )
    others = {dataclasses.replace(usual, **change).key for change in changes}
    assert len({usual.key, *others}) == 1 + len(changes)


@pytest.fixture(scope="module")
def weighted():
    """A contact whose points carry unequal areas, some at the bound."""
    wave = np.cos(2 * np.pi * np.arange(16) / 16)
    field = HeightField(heights=1e-3 * (wave[:, None] + wave), lengths=(1.0, 1.0))
    result = bem.solve(field, HalfSpace(solid=SOLID), mean_pressure=1e6)
    weights = np.tile([[1.5, 0.5], [0.5, 1.5]], (8, 8))
    at_bound = np.zeros((16, 16), dtype=bool)
    at_bound[0, 0] = at_bound[0, 2] = at_bound[0, 1] = True
    return dataclasses.replace(result, weights=weights, at_bound=at_bound)


def test_node_weights_are_read_back_bit_for_bit(weighted):
    found = decode_result(dataset_bytes(fields_dataset(weighted, recipe="{}")))
    np.testing.assert_array_equal(found.weights, weighted.weights)
    assert (found.offset, found.mean_pressure) == (weighted.offset, weighted.mean_pressure)


def test_stored_fields_carry_checksums(weighted):
    import netCDF4

    with netCDF4.Dataset("memory", memory=dataset_bytes(fields_dataset(weighted, recipe="{}"))) as file:
        fields = [variable for variable in file.variables.values() if variable.ndim == 2]
        assert len(fields) == 7
        assert all(variable.filters()["fletcher32"] for variable in fields)


def test_the_yielded_area_counts_each_point_by_its_weight(weighted):
    solve = Press(method="bem", grid=(16, 16), problem=realise(scene()))
    _, numbers = read_off(solve, weighted)
    assert numbers["plastic"] == pytest.approx((1.5 + 0.5 + 1.5) / 256, rel=1e-12)


def _wave(modulus, wavelength):
    return float(np.squeeze(modulus(np.array([2 * np.pi / wavelength]))))


def test_short_waves_feel_the_coating_and_long_waves_the_bulk():
    told = TheoryInputs.by(SOLID, [Coating(young=6e9, thickness=1e-6)])
    assert _wave(told.modulus, 1e-9) == pytest.approx(6e9 / 0.91, rel=1e-3)
    assert _wave(told.modulus, 1e-2) == pytest.approx(2e9 / 0.91, rel=1e-2)


def test_a_graded_profile_falls_to_one_over_e_at_its_depth_for_mesh_and_theory():
    effect = Graded(bulk_young=8e9, depth=3e-6)
    model, told = ContactModel.filled(SOLID, [effect]), TheoryInputs.by(SOLID, [effect])
    exact, zero = 8e9 + (2e9 - 8e9) / math.e, np.zeros(1)
    ratio = model.body.modulus(zero, zero, np.array([-3e-6]))[0]
    assert 2e9 * float(ratio) == pytest.approx(exact, rel=1e-12)
    assert [float(told.modulus.young(z)) for z in (3e-6, 0.0)] == pytest.approx([exact, 2e9], rel=1e-12)


def test_a_frictionless_base_makes_a_softer_layer():
    bases = ("bonded", "frictionless")
    layers = [ContactModel.filled(SOLID, [Thickness(thickness=1e-6, base=base)]) for base in bases]
    assert [type(model.response) for model in layers] == [BondedLayer, FrictionlessLayer]
    q = np.array([[1e6]])
    bonded, free = (float(model.response.compliance(q, 0 * q)[0, 0]) for model in layers)
    assert free > 1.01 * bonded
    assert layers[0].body.depth == 1e-6
    assert layers[1].body is None


def _rough(**changed):
    said = {"modulus": 1e9, "gradient": 0.1, "curvature": 1e5, "longest": 1e-5, "shortest": 1e-6}
    return Roughness(**{**said, "full_energy": 0.01, **changed})


@pytest.mark.parametrize(("hardness", "matters"), [(1.9e8, True), (2.1e8, False)])
def test_a_hardness_matters_below_four_deviations_of_the_stress_at_full_contact(hardness, matters):
    # The deviation is E* h'_rms / 2 = 5e7 Pa.
    assert Hardness(hardness=hardness).judge(_rough()).verdict.startswith("matters") is matters


def test_hardness_rises_by_its_power_at_its_wavelength():
    effect = Hardness(hardness=1e9, size_wavelength=1e-6, size_exponent=0.5)
    told = TheoryInputs.by(SOLID, [effect])
    assert _wave(told.hardness, 1e-6) == pytest.approx(math.sqrt(2) * 1e9, rel=1e-12)
    assert _wave(told.hardness, 1e-6 / 3) == pytest.approx(2e9, rel=1e-12)
    with pytest.raises(UsageError, match="method 'tamaas' knows one hardness"):
        effect.check_solver("tamaas", key="effects")


def test_the_judgement_of_adhesion_is_free_of_units():
    # All lengths by 2^20 and all pressures by 2^-30: curvature by 2^-20, work and energy by 2^-10.
    k, s = 2.0**20, 2.0**-30
    first = Adhesion(work=0.05, reach=2e-9).judge(_rough())
    lengths = {"longest": 1e-5 * k, "shortest": 1e-6 * k}
    rough = _rough(modulus=1e9 * s, curvature=1e5 / k, full_energy=0.01 * k * s, **lengths)
    assert Adhesion(work=0.05 * k * s, reach=2e-9 * k).judge(rough).number == first.number
