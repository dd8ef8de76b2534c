"""`run --accuracy`: what it claims holds on finer grids, and what it cannot reach it refuses by name."""

from __future__ import annotations

import math

import pytest

from fem_contact.area import contact_areas
from fem_contact.extrapolation import located_limit
from validation.comparison.accuracy import parse_accuracy, reach
from validation.errors import RunFailed, UsageError
from validation.measures.common import base_surface
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.methods.bem import BemOptions
from validation.scenes.realised import realise
from validation.scenes.scene import Load, Methods, Scene, SolidSpec, load_scene
from validation.solves.bench import Bench
from validation.solves.press import solves_of
from validation.solves.running import Execution, solve_all
from validation.solves.store import Store

MIB = 2**20


@pytest.fixture
def scene(write_scene):
    return load_scene(str(write_scene(fem=False)))


@pytest.fixture
def ensemble(write_scene):
    extra = "shifts = 2\n\n[ensemble]\nrealisations = 2\ngrids = [12, 24]"
    return load_scene(str(write_scene(("shifts = 2", extra), fem=False)))


@pytest.fixture
def bench(tmp_path):
    return Bench.at(tmp_path / "solves")


def truth_of(scene, folder) -> tuple[float, float]:
    """Limit of the located area over grids of 12 to 32 points per shortest wave, with its uncertainty."""
    bem = BemOptions(grids=((48, 48), (64, 64), (96, 96), (128, 128)), shifts=1)
    fine = scene.model_copy(update={"methods": scene.methods.model_copy(update={"bem": bem})})
    store, solves = Store(folder=folder), solves_of(fine)
    folder.mkdir()
    solve_all(solves, store)
    limit = located_limit([contact_areas(store.load(solve), subcell=True) for solve in solves])
    return limit.value, limit.uncertainty


@pytest.mark.parametrize(
    ("text", "value"), [("1%", 0.01), ("0.01", 0.01), (" 2.5 % ", 0.025), ("1e-3", 1e-3)]
)
def test_an_accuracy_is_a_share_or_a_percentage(text, value):
    assert parse_accuracy(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "one", "1 permille", "0", "-1%", "51%", "nan", "inf", "1%%", "0,01"])
def test_what_is_no_accuracy_is_refused_in_one_line(text):
    with pytest.raises(UsageError, match=r"must be a share such as 1% or 0\.01") as caught:
        parse_accuracy(text)
    assert "\n" not in str(caught.value)


def test_the_claimed_error_holds_on_finer_grids(scene, bench, tmp_path):
    truth, uncertainty = truth_of(scene, tmp_path / "fine")
    costs = []
    for target in (0.1, 0.01, 0.003):
        reached = reach(scene, bench, target=target)
        assert reached.error <= target
        assert abs(reached.area / truth - 1) < reached.error + 2 * uncertainty / truth
        costs.append(max(nx * ny for nx, ny in reached.grids))
    assert costs[0] < costs[1] < costs[2]


def test_the_mean_over_surfaces_is_as_accurate_as_asked(ensemble, bench):
    results = {}
    for target in (0.2, 0.1):
        results[target] = reach(ensemble, bench, target=target)
        assert results[target].mean_error <= target
        assert results[target].error <= target
        assert 0 < results[target].statistical < results[target].mean_error
    assert results[0.1].surfaces > results[0.2].surfaces
    # Both intervals hold the mean of the ensemble, each on 95 of 100 sets of seeds.
    distance = abs(results[0.1].mean / results[0.2].mean - 1)
    assert distance < results[0.1].mean_error + results[0.2].mean_error


def test_an_accuracy_beyond_memory_is_refused_with_the_one_within_reach(scene, tmp_path):
    small = Bench.at(tmp_path / "results", execution=Execution(memory=4 * MIB))
    with pytest.raises(UsageError, match=r"--accuracy = 0.001 %: needs about .* 4 MiB are free") as caught:
        reach(scene, small, target=1e-5)
    words = str(caught.value).partition(" % is within reach")[0].rpartition("about ")[2]
    reachable = float(words) / 100
    assert 1e-5 < reachable < 0.1
    # Said to two digits.
    reached = reach(scene, small, target=1.1 * reachable)
    assert reached.error <= 1.1 * reachable


def test_an_accuracy_beyond_the_time_limit_is_refused_before_the_main_solves(scene, bench):
    with pytest.raises(UsageError, match=r"s are left; .* within reach"):
        reach(scene, bench, target=1e-5, time_limit=0.4)
    assert len(list(bench.store.folder.glob("*.nc"))) <= 3


def test_a_time_limit_that_is_over_stops_the_run_by_name(scene, bench):
    with pytest.raises((UsageError, RunFailed), match="--accuracy = 1 %"):
        reach(scene, bench, target=0.01, time_limit=1e-9)


def test_a_scatter_that_too_few_surfaces_can_average_is_refused_with_what_is_known(ensemble, bench):
    with pytest.raises(RunFailed, match=r"the mean over \d+ surfaces is known to .* all solves are stored"):
        reach(ensemble, bench, target=0.003)


def test_an_effect_without_a_law_of_error_is_refused_by_name(write_scene, bench):
    hard = "[[effects]]\nkind = 'hardness'\nhardness = '1 MPa'\n\n[solid]"
    path = write_scene(("[solid]", hard), ("[methods.theory]\n", ""), fem=False)
    with pytest.raises(UsageError, match=r"\[\[effects\]\] 1 kind = 'hardness'"):
        reach(load_scene(str(path)), bench, target=0.01)


def test_full_contact_is_exact_on_the_coarsest_grids(write_scene, bench):
    path = write_scene(("reduced_pressure = 0.1", "reduced_pressure = 6.0"), fem=False)
    reached = reach(load_scene(str(path)), bench, target=1e-4)
    assert (reached.area, math.prod(reached.grids[-1])) == (1.0, 16 * 16)


@pytest.mark.slow
@pytest.mark.parametrize("target", [0.05, 0.01, 0.003])
def test_claims_hold_as_often_as_they_say_on_surfaces_and_loads_of_many_kinds(target, bench):
    held = 0
    for k in range(24):
        surface = base_surface(hurst=(0.3, 0.8)[k % 2], periods=2.0, bandwidth=8.0, seed=991_000 + k)
        load = Load(reduced_pressure=(0.02, 0.05, 0.2)[k % 3])
        scene = Scene(
            name="one",
            surface=surface,
            solid=SolidSpec(young=1e9, poisson=0.3),
            load=load,
            methods=Methods(bem=BemOptions(grids=((64, 64),))),
        )
        reached = reach(scene, bench, target=target)
        pressed = realise(scene)
        fine = Measurement(realised=pressed, grids=tuple(grid_for(pressed, n) for n in (16, 24, 32)))
        (truth,), (uncertainty,) = area_limits(bench.solve([fine])[fine])
        assert reached.error <= target
        held += abs(reached.area / truth - 1) <= math.hypot(reached.error, 2 * uncertainty / truth)
    # 20 of 24 or more are right in 99.7 of 100 cases if each is with 95 %.
    assert held >= 20
