"""`run --accuracy`: what it claims holds on finer grids, and what it cannot reach it refuses by name."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from accuracy_coverage import Case, judged
from refusing import refused
from small_scene import GRIDS, ONE_BODY, STICKY
from small_scene import ensemble as ensemble_of

from validation.cli.options import chosen_accuracy
from validation.comparison import accuracy_search
from validation.comparison.accuracy import parse_accuracy, reach
from validation.comparison.accuracy_search import Metered, Search
from validation.errors import RunFailed, SceneError, UsageError
from validation.execution.bench import Bench, Execution
from validation.execution.press import solves_of
from validation.measurements.common import base_case, base_surface
from validation.measurements.ensemble import area_pairs, mean_area
from validation.measurements.measurement import area_limits, grids_for, limit_over
from validation.measurements.statistics import pair_means
from validation.report.estimates import mean_of
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.sweep import load_asked
from validation.scenes.tables import Load, SolidSpec

MIB = 2**20


@pytest.fixture
def scene(read_scene):
    return read_scene(fem=False)


@pytest.fixture
def ensemble(read_scene):
    return read_scene(ensemble_of(2, "[12, 24]"), fem=False)


@pytest.fixture
def bench(tmp_path):
    return Bench.at(tmp_path / "solves")


def holds(reached, truth):
    """Whether what is claimed holds the limit over fine grids."""
    return abs(reached.area - truth.value) < reached.error * truth.value + 2 * truth.uncertainty


@pytest.mark.parametrize(
    ("text", "value"), [("1%", 0.01), ("0.01", 0.01), (" 2.5 % ", 0.025), ("1e-3", 1e-3), ("50%", 0.5)]
)
def test_an_accuracy_is_a_share_or_a_percentage(text, value):
    assert parse_accuracy(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "one", "1 permille", "0", "-1%", "51%", "nan", "1%%", "0,01", "0.5"])
def test_what_is_no_accuracy_is_refused_in_one_line(text):
    with refused(UsageError, r"must be a share such as 1% or 0\.01|0\.5% or 50%"):
        parse_accuracy(text)


def test_an_accuracy_is_asked_for_with_its_time():
    asked = chosen_accuracy("2 %", time_limit="10 min", dry_run=False, execution=Execution())
    assert asked == {"target": pytest.approx(0.02), "time_limit": 600.0}


def test_the_claimed_error_holds_on_finer_grids(scene, bench):
    finest, truth = [], Case(scene=scene, target=0.1).truth()
    for target in (0.1, 0.01):
        reached = reach(scene, bench, target=target)
        assert reached.error <= target
        assert holds(reached, truth)
        finest.append(max(nx * ny for nx, ny in reached.grids))
    assert finest[0] < finest[1]


def test_the_mean_over_surfaces_is_as_accurate_as_asked(ensemble, bench):
    results = {}
    for target in (0.2, 0.1):
        reached = reach(ensemble, bench, target=target)
        found = results[target] = reached.summary()
        assert found["mean_error"] <= target
        assert found["error"] <= target
        assert 0 < found["statistical"] < found["mean_error"]
        assert found["surfaces"] == 2 * sum(found["pairs"])
        assert len(found["pairs"]) == len(found["surface_grids"]) == 3
    # Both intervals hold the mean of the ensemble, each on 95 of 100 sets of seeds.
    distance = abs(results[0.1]["mean"] / results[0.2]["mean"] - 1)
    assert distance < results[0.1]["mean_error"] + results[0.2]["mean_error"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("amplitudes", "load"),
    [("exact", "reduced_pressure"), ("gaussian", "reduced_pressure"), ("gaussian", "pressure")],
)
def test_the_controlled_mean_is_that_of_plain_surfaces_whatever_amplitudes_and_load(amplitudes, load, bench):
    surface = base_surface(hurst=0.7, periods=2.0, bandwidth=4.0, seed=4711)
    base = ContactProblem(
        surface=surface.model_copy(update={"amplitudes": amplitudes}),
        solid=SolidSpec(young=0.91e9, poisson=0.3),
        load=Load(**{load: {"reduced_pressure": 0.1, "pressure": 0.01e9}[load]}),
    )
    grids = grids_for(base, (3.0, 6.0, 12.0))
    found = mean_area(base, half_width=0.01, bench=bench, grids=grids, tolerance=1e-5)
    more = {"first": 77_000_000, "count": 400, "tolerance": 1e-5, "effects": ()}
    plain = area_pairs(problem=base, grids=found.grids[1:], **more)
    areas, _ = area_limits(plain.do())
    middle, half = mean_of(areas, 0, pairs=True)
    assert abs(found.estimate.value - float(middle)) < 1.5 * math.hypot(found.half_width, float(half))
    if load == "pressure":
        # h'_rms tells most of what scatters.
        assert found.chain[0].left < 0.5 * np.var(pair_means(areas))


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


def test_the_cheapest_way_that_can_be_gone_is_gone_and_else_the_cheapest_is_told():
    """Three ways suffice, of 3, 2 and 1 s; the fastest takes the most memory."""
    needs = {8: (3.0, 1), 16: (2.0, 2), 32: (1.0, 4)}
    ways = [
        SimpleNamespace(grids=((n, n),), seconds=seconds, peak_bytes=mib * MIB, error=0.005)
        for n, (seconds, mib) in needs.items()
    ]
    ways.append(SimpleNamespace(grids=((4, 4),), seconds=0.1, peak_bytes=MIB, error=0.02))

    def searched(free, tried=()):
        bench = SimpleNamespace(affordable=lambda _, size: size <= free, wanted="1 %", means=lambda: "no")
        search = SimpleNamespace(target=0.01, bench=bench)
        return Search._cheapest(search, ways, {((n, n),) for n in tried}, share=1.0)

    assert searched(2 * MIB) is ways[1]
    assert searched(2 * MIB, tried=[16]) is ways[0]
    for tried, needed in (((), "4 MiB and 1 s"), ((32,), "2 MiB and 2 s")):
        with pytest.raises(UsageError, match=rf"1 %: needs about {needed} \(.*\), and no; nothing is"):
            searched(0, tried)
    with pytest.raises(UsageError, match=r"needs more than .* about 2.0 % is within"):
        searched(MIB, tried=needs)


def test_an_accuracy_beyond_the_time_limit_is_refused_before_the_main_solves(scene, bench):
    with pytest.raises(UsageError, match=r"s are left; .* within reach"):
        reach(scene, bench, target=1e-5, time_limit=0.4)
    assert len(list(bench.store.folder.glob("*.nc"))) <= 3


def test_a_scatter_that_too_few_surfaces_can_average_is_refused_with_what_is_known(
    ensemble, bench, monkeypatch
):
    monkeypatch.setattr(accuracy_search, "_MOST_SURFACES", 64)
    with pytest.raises(RunFailed, match=r"the mean over \d+ surfaces is known to .* all solves are stored"):
        reach(ensemble, bench, target=0.003)


def test_an_effect_without_a_law_of_error_is_refused_by_name(read_scene, bench):
    scene = read_scene(STICKY, fem=False)
    with pytest.raises(UsageError, match=r"\[\[effects\]\] 1 kind = 'adhesion'"):
        reach(scene, bench, target=0.01)


@pytest.mark.parametrize(
    "effect", ["'hardness'\nhardness = '60 kPa'", "'coating'\nyoung = '4 MPa'\nthickness = '1 um'"]
)
def test_with_an_effect_the_corrected_area_is_claimed(effect, read_scene, bench):
    scene = read_scene(f"[[effects]]\nkind = {effect}\n", ONE_BODY, fem=False)
    reached = reach(scene, bench, target=0.05)
    assert not reached.located
    assert reached.error <= 0.05
    assert holds(reached, Case(scene=scene, target=0.05).truth())
    assert "corrected at its edge" in next(iter(reached.sentences()))


def test_bodies_held_too_far_apart_to_touch_are_told_so(read_scene, bench):
    far = read_scene(("reduced_pressure = 0.1", 'offset = "1 mm"'), fem=False)
    with pytest.raises(RunFailed, match=r"load.offset = 1 mm: nothing touches so far apart; come closer"):
        reach(far, bench, target=0.1)


def test_finite_elements_are_put_beside_on_their_own_grids(read_scene, bench):
    scene = read_scene(("grids = [[12, 8], [24, 16]]", "grids = [[12, 6], [24, 12]]"))
    reached = reach(scene, bench, target=0.05)
    (other,) = reached.beside
    grids = scene.methods.options("fem").grids
    assert (other.method, other.grids) == ("fem", tuple(grids))
    assert 0 < reached.solving_seconds <= reached.seconds
    assert abs(other.area / reached.area - 1) < other.error + reached.error
    # Point by point, too: boundary elements are solved on these grids.
    assert set(grids) <= set(reached.grids)
    assert set(reached.chosen(scene).methods.solvers) == {"bem", "fem"}
    assert any(text.startswith("Beside it FEM") for text in reached.sentences())


def test_a_single_grid_of_another_method_is_put_beside_without_a_limit(read_scene, bench):
    reached = reach(read_scene(("grids = [[12, 8], [24, 16]]", "grids = [[12, 8]]")), bench, target=0.05)
    (other,) = reached.beside
    assert other.doubt
    assert f"Beside it FEM on 12 x 8: no limit: {other.doubt}." in list(reached.sentences())


def test_what_solves_took_foretells_those_of_their_kind_alone(scene, bench):
    metered = Metered(store=bench.store, execution=bench.execution, pair=1e-3)
    small, *others = solves_of(scene, realise(scene))
    finer = next(solve for solve in others if solve.grid != small.grid)
    plain = {solve: metered.seconds(solve) for solve in (small, finer)}
    taken = metered.solve([small]).made()[0].seconds
    assert metered.seconds(small) == pytest.approx(plain[small] * (0.1 + taken) / (0.1 + plain[small]))
    assert metered.seconds(finer) == plain[finer]


def test_workers_share_what_solves_take(read_scene, bench, monkeypatch):
    scene, notes = read_scene(), []
    how = {"execution": Execution(workers=4), "progress": SimpleNamespace(plan=notes.append)}
    metered = Metered(store=bench.store, pair=1e-3, time_limit=100.0, wanted="1 %", **how)
    assert metered.affordable(390.0)
    assert not metered.affordable(410.0)
    fem = [solve for solve in solves_of(scene, realise(scene)) if solve.method == "fem"]
    search = Search.__new__(Search)
    search.bench, search.others = metered, {"fem": fem}
    search.reserve()
    alone = sum(metered.seconds(solve) for solve in fem)
    assert metered.account.reserved == pytest.approx(alone / 4)
    assert f"{100 - alone / 4:.3g} s are left beside {alone / 4:.2g} s for other methods" in metered.means()
    done = SimpleNamespace(solves=fem, made=lambda: [SimpleNamespace(seconds=1.0)] * len(fem))
    monkeypatch.setattr(Bench, "solve", lambda self, wanted, **how: done)
    metered.solve(fem)
    assert metered.account.predicted == pytest.approx(alone / 4)
    search._foretell("all", 40.0)
    least, most = map(float, re.search(r"all, (\S+) to (\S+) s", notes[0]).groups())
    assert least < 10 < most < 40
    assert least * most == pytest.approx(100, rel=0.5)
    # It is seconds that have to be left, not surfaces.
    search._watch(SimpleNamespace(surfaces=800), ())
    assert "800 surfaces for the mean" in notes[-1]


def test_finite_elements_that_do_not_fit_are_refused_before_anything_is_solved(read_scene, tmp_path):
    small = Bench.at(tmp_path / "results", execution=Execution(memory=2 * MIB))
    with pytest.raises(UsageError, match=r"methods\.fem needs about .* name coarser ones, or leave it out"):
        reach(read_scene(), small, target=0.05)
    assert not small.store.folder.exists()


@pytest.mark.parametrize("length", [(1.0, 1.0), (3.0, 2.0), (1.0, 1.0371), (1.0, 0.0913)])
def test_a_grid_is_found_with_cells_that_are_nearly_square(length):
    surface = base_surface(hurst=0.7, periods=1.0, bandwidth=4.0, seed=3)
    waves = {"lambda_long": min(length), "lambda_short": min(length) / 4}
    base = base_case(surface.model_copy(update={"length": length, **waves}), reduced_pressure=0.1)
    search = Search(scene=SimpleNamespace(surface=base.surface), problem=base, target=0.1, bench=None)
    for level in (3, 4, 12):
        nx, ny = search._grid(level)
        assert base.points_per_wave((nx, ny)) >= level * (1 - 1e-9)
        assert nx * length[1] / (ny * length[0]) == pytest.approx(1, abs=0.0201)
        assert (nx % 2, ny % 2) == (0, 0)


def test_full_contact_is_exact_on_the_coarsest_grids(read_scene, bench):
    scene = read_scene(("reduced_pressure = 0.1", "reduced_pressure = 6.0"), fem=False)
    reached = reach(scene, bench, target=1e-4)
    assert (reached.area, math.prod(reached.grids[-1])) == (1.0, 16 * 8)


@pytest.mark.slow
def test_claims_hold_as_often_as_they_say_on_surfaces_and_loads_of_many_kinds(tmp_path):
    held = 0
    for seed in range(991_000, 991_072):
        case = Case.drawn(seed, "elastic", tmp_path)
        reached, _, right = judged(case)
        assert reached.error <= case.target
        held += right
    # 63 of 72 or more are right in 99.7 of 100 cases if each is with 95 %.
    assert held >= 63


def test_grids_that_will_be_chosen_may_be_missing_or_too_coarse(write_scene, bench):
    extra = "shifts = 2\n\n[ensemble]"
    path = str(write_scene((f"{GRIDS}\n", ""), ("shifts = 2", extra), fem=False))
    scenes = [
        load_asked(path, ["methods.bem.grids=[3]", "ensemble.grids=[2, 3]"], grids_chosen=True),
        load_asked(path, grids_chosen=True),
    ]
    first, second = (reach(scene, bench, target=0.2) for scene in scenes)
    means = [found.ensemble.estimate.value for found in (first, second)]
    assert (first.area, means[0], second.solves) == (second.area, means[1], 0)
    assert all(realise(scenes[0]).resolved_by(grid) for grid in first.grids)
    with pytest.raises(SceneError, match=r"methods\.bem\.grids = \[3, 3\]: too coarse"):
        load_asked(path, ["methods.bem.grids=[3]", "ensemble.grids=[12, 24]", "ensemble.realisations=2"])
    # Those of another method are solved as they stand.
    beside = str(write_scene(("grids = [[12, 8], [24, 16]]", "grids = [3]")))
    with pytest.raises(SceneError, match=r"methods\.fem\.grids = \[3, 3\]: too coarse"):
        load_asked(beside, grids_chosen=True)


def test_where_grids_disagree_more_than_foretold_the_next_ones_are_chosen_so_much_finer(
    scene, bench, monkeypatch
):
    def far_apart(areas):
        limit = limit_over(areas)
        return replace(limit, uncertainty=30 * limit.uncertainty)

    monkeypatch.setattr(accuracy_search, "limit_over", far_apart)
    notes, quiet = [], dict.fromkeys(("start", "begin", "done", "note"), lambda *_: None)
    progress = SimpleNamespace(**quiet, plan=notes.append)
    reached = reach(scene, replace(bench, progress=progress), target=0.03)
    assert reached.error <= 0.03
    # Of five pairs of grids, each finer than the one before, three are left out.
    assert sum("this surface on" in note for note in notes) == 2


def test_a_time_limit_that_is_over_stops_the_run_by_name(scene, bench):
    with pytest.raises((UsageError, RunFailed), match="--accuracy = 1 %"):
        reach(scene, bench, target=0.01, time_limit=1e-9)
