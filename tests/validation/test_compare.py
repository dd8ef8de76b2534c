"""Results side by side: their datasets concatenated and subtracted; what cannot be compared."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.stats
import xarray as xr
from commanding import output_of

from validation.comparison.compare import _farthest, _findings, compare_folders, differing, side_by_side
from validation.comparison.run import run_scene, run_sweep
from validation.errors import UsageError
from validation.execution.results import Result, read_results
from validation.files import prepare_folder
from validation.report.estimates import NORMAL, SOURCES, claim, mean, total_error
from validation.scenes.sweep import load_asked
from validation.studies import find_study
from validation.studies._outputs import run_study


@pytest.fixture(scope="module")
def results(small_run, once, bench, tmp_path_factory):
    """Two runs of the small scene with other Hurst exponents, two studies, a sweep, all in one folder."""
    place = tmp_path_factory.mktemp("beside")
    return once("results to compare", lambda: _results(small_run, place, {"bench": bench, "report": False}))


def _results(small_run, folder, how):
    from .conftest import _written

    shutil.copytree(small_run.folder, folder / "first")
    scene = str(_written(folder, fem=False))
    run_scene(load_asked(scene, ["surface.hurst=0.9"]), folder / "other", **how)
    area, asked = find_study("area"), {"surfaces": 2, "grids": (16, 24), "bandwidth": 2.0}
    for seed in (3, 4):
        options = area.options(reduced_pressures=(0.1, 0.5), seed=seed, **asked)
        run_study(area, options, prepare_folder(folder / f"area-{seed}"), **how)
    for name, loads in (("swept", "0.05, 0.1"), ("swept-more", "0.1, 0.2")):
        run_sweep(load_asked(scene, [f"sweep.load.reduced_pressure=[{loads}]"]), folder / name, **how)
    return folder


def _summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_runs_are_concatenated_and_subtracted_with_the_errors_of_both(results, tmp_path):
    page = compare_folders([results / "first", results / "other"], tmp_path).page
    a, b = (read_results(results / name).data for name in ("first", "other"))
    data = read_results(tmp_path).data
    assert data.area.values.tolist() == [float(a.area), float(b.area)]
    assert float(data.area_apart.sel(result="other")) == float(b.area) - float(a.area)
    joint = np.hypot(a.area_error.sel(source="grid"), b.area_error.sel(source="grid"))
    assert float(data.area_apart_error.sel(result="other", source="grid")) == pytest.approx(
        float(joint), rel=1e-12
    )
    finest = float(a.area_pixel.sel(solver="bem", grid="48 x 32"))
    assert float(data.area_pixel.sel(result="first", solver="bem", grid="48 x 32")) == finest
    assert (tmp_path / "table.csv").exists()
    differing = _summary(tmp_path)["differing"]
    assert differing["surface.hurst"] == ["0.7", "0.9"]
    assert "solid.young" not in differing
    assert any("an [ensemble] in every scene tells" in text for text in page.findings)
    assert page.answers[0].answer.startswith("surface.hurst, methods.fem.grids")
    assert ["from it" in str(card.basis) for card in page.answers[1:]] == [False, True]


def _result(data, **asked):
    settings = {"scene": {"surface": {"seed": 1}, **asked}}
    return Result(kind="run", name="x", settings=settings, store=None, data=data)


def _planted(value, error, **asked):
    """Areas over the last dimension, loads, whose grids leave such an error."""
    value = np.asarray(value)
    dims = ("plant", "load")[-value.ndim :]
    errors = np.full((*value.shape, len(SOURCES)), np.nan)
    errors[..., SOURCES.index("grid")] = error
    data = {"area": (dims, value), "area_error": ((*dims, "source"), errors)}
    loads = np.linspace(0.1, 0.2, value.shape[-1])
    return _result(xr.Dataset(data, {"reduced_pressure": ("load", loads), "source": list(SOURCES)}), **asked)


@pytest.mark.parametrize(("error", "outcome"), [(0.001, "differ"), (0.02, "agree"), (np.nan, "?")])
def test_whether_results_differ_is_decided_by_the_intervals_of_both(error, outcome):
    pair = {"a": _planted([0.1, 0.2], error), "b": _planted([0.1, 0.21], error)}
    data = side_by_side(pair)
    assert data.area_apart.sel(result="b").values == pytest.approx([0, 0.01])
    found = [one for one in _findings(data, differing(pair)) if one.kind == "agreement"]
    assert [one.outcomes for one in found] == [(outcome,)]


def test_the_farthest_of_many_places_is_judged_by_the_interval_of_all():
    plants, places, half = 200, 8, 0.01 / 2**0.5
    draws = 0.2 + half * np.random.default_rng(5).standard_normal((2, plants, places))
    every = side_by_side({str(k): _planted(one, NORMAL * half) for k, one in enumerate(draws)})
    found = [_farthest(every.isel(plant=plant), "area", 1) for plant in range(plants)]
    assert all("of 8 places" in one.text for one in found)
    falsely = np.mean([one.outcomes == ("differ",) for one in found])
    assert abs(falsely - 0.05) < 3 * (0.05 * 0.95 / plants) ** 0.5


@pytest.mark.parametrize("pairs", [False, True])
def test_means_over_the_same_surfaces_differ_by_what_single_surfaces_do(pairs):
    rng = np.random.default_rng(6)
    first = 0.2 + 0.02 * rng.standard_normal(8)
    second = first + 0.01 + 0.001 * rng.standard_normal(8)
    results = {}
    for name, areas in (("a", first), ("b", second)):
        data = claim(xr.Dataset({"area_each": ("surface", areas)}), "area_each", grid=0.003)
        results[name] = _result(mean(data, "area", pairs=pairs).assign_coords(surface=range(8)))
    apart = side_by_side(results).isel(result=1)
    samples = (second - first).reshape(4, 2).mean(1) if pairs else second - first
    low, high = scipy.stats.ttest_1samp(samples, 0).confidence_interval()
    assert float(apart.area_apart) == pytest.approx((low + high) / 2)
    errors = apart.area_apart_error
    assert float(errors.sel(source="surfaces")) == pytest.approx((high - low) / 2, rel=1e-9)
    assert float(errors.sel(source="grid")) == pytest.approx(0.003 / 2)  # of 8 and 8 surfaces


def test_what_rounding_leaves_is_no_difference_and_what_is_unknown_or_endless_stays_so():
    pair = {"a": _planted([0.1, 0.2], 0.0), "b": _planted([0.1 * (1 + 2e-16), np.nan], 0.0)}
    np.testing.assert_array_equal(side_by_side(pair).area_apart.sel(result="b"), [0.0, np.nan])
    pair["b"] = _planted([np.inf, 0.2 * (1 + 1e-9)], 0.0)
    far, near = side_by_side(pair).area_apart.sel(result="b").values
    assert far == np.inf
    assert near == pytest.approx(2e-10, rel=1e-3)


def test_all_that_was_asked_otherwise_is_named_with_its_value_in_each():
    yields, layers = {"kind": "hardness", "hardness": 1e9}, {"kind": "thickness", "thickness": 1e-6}
    asked = [[yields], [yields | {"hardness": 2e9}, layers], []]
    told = differing({str(k): _planted([0.1, 0.2], 0.1, effects=one) for k, one in enumerate(asked)})
    assert told == {
        "effects.hardness": ("listed", "listed", ""),
        "effects.hardness.hardness": ("1 GPa", "2 GPa", ""),
        "effects.thickness": ("", "listed", ""),
        "effects.thickness.thickness": ("", "1 um", ""),
    }


def test_a_difference_is_no_surer_than_what_it_is_of(results, tmp_path, ensemble_run):
    """A mean over surfaces, whose interval is wide, beside one surface, whose scatter nobody measured."""
    page = compare_folders([results / "first", ensemble_run.folder], tmp_path / "out").page
    data = read_results(tmp_path / "out").data.isel(result=1)
    both = [read_results(folder).data.area_error for folder in (results / "first", ensemble_run.folder)]
    own, apart = data.area_error.sel(source="surfaces"), data.area_apart_error
    assert own > 0
    assert float(apart.sel(source="surfaces")) == pytest.approx(float(own), rel=1e-12)
    assert np.isnan(both[0].sel(source="surfaces"))
    grids = [float(errors.sel(source="grid")) for errors in both]
    assert float(apart.sel(source="grid")) == pytest.approx(np.hypot(*grids), rel=1e-12)
    assert any(text.startswith("Their surfaces differ") for text in page.findings)


def test_studies_are_compared_at_the_places_that_they_share(results, tmp_path):
    page = compare_folders([results / "area-3", results / "area-4"], tmp_path, report=False).page
    data = read_results(tmp_path).data
    where = page.records["table"].columns.index("where")
    assert {row[where].split(", ")[-1] for row in page.records["table"].rows} == {"p* = 0.1", "p* = 0.5"}
    for name in ("area-3", "area-4"):
        own = read_results(results / name).data.kappa.sel(reduced_pressure=[0.1, 0.5])
        found = data.kappa.sel(result=name, reduced_pressure=[0.1, 0.5])
        assert found.values.tolist() == own.values.tolist()
    assert _summary(tmp_path)["differing"] == {"seed": ["3", "4"]}
    # Of several surfaces each, whose scatter the intervals hold.
    assert not any(text.startswith("Their surfaces differ") for text in page.findings)


def test_scores_of_two_theories_are_told_apart_though_no_number_has_an_interval(numbers):
    scores = [numbers("reference-score").isel(theory=[k]) for k in (0, 1)]
    pair = {name: _result(data, theory=name) for name, data in zip(("persson", "xu"), scores, strict=True)}
    data = side_by_side(pair)
    first, other = (score.area_scored[0] for score in scores)
    assert np.nanmax(abs(data.area_scored_apart.isel(result=1) - (other - first))) < 1e-12
    texts = [one.text for one in _findings(data, differing(pair))]
    assert any("they have no interval to be judged by (difference " in text for text in texts)


def test_a_distance_that_is_asked_for_is_no_finding(results, tmp_path):
    scene = str(results / "scene.toml")
    run_scene(load_asked(scene, ["load.offset=0 um"]), tmp_path / "held", report=False)
    page = compare_folders([results / "first", tmp_path / "held"], tmp_path / "both", report=False).page
    names = [text.partition(":")[0] for text in page.findings]
    assert "load.offset" in _summary(tmp_path / "both")["differing"]
    assert not any("approach" in name for name in names)


def test_loads_that_were_written_in_one_unit_are_compared(results, tmp_path, bench):
    """Of which one is known to the last digit, and the other not: 70000 / .07 is not 1e6."""
    for load in ("0.05", "0.07"):
        scene = load_asked(str(results / "scene.toml"), [f"load.pressure='{load} MPa'"])
        run_scene(scene, tmp_path / load, bench=bench, report=False)
    compare_folders([tmp_path / "0.05", tmp_path / "0.07"], tmp_path / "both")
    pressure = read_results(tmp_path / "both").data.pressure
    assert pressure.values.tolist() == [0.05e6, 0.07e6]
    assert pressure.attrs["written_unit"] == 1e6


def test_sweeps_are_compared_where_their_values_meet(results, tmp_path):
    page = compare_folders([results / "swept", results / "swept-more"], tmp_path).page
    data = read_results(tmp_path).data
    assert data.reduced_pressure.values.tolist() == [0.1]  # of .05, .1 and of .1, .2
    assert float(data.area_apart.isel(result=1).item()) == 0
    assert page.findings


def test_what_cannot_be_compared_gets_one_line_and_the_rest_is_compared(results, tmp_path):
    (tmp_path / "empty").mkdir()
    folders = [results / "first", results / "area-3", tmp_path / "empty", results / "other"]
    page = compare_folders(folders, tmp_path / "out", report=False).page
    left_out = [text for text in page.findings if "not compared" in text]
    assert len(left_out) == 2
    assert "it is a study area, and" in left_out[0]
    assert "holds no finished results" in left_out[1]
    with pytest.raises(UsageError, match="fewer than two folders are left"):
        compare_folders([results / "first", results / "area-3"], tmp_path / "none")
    with pytest.raises(UsageError, match=r"scene\.toml: is a file; name the folder of results"):
        read_results(results / "scene.toml")
    with pytest.raises(UsageError, match="at least two results folders, each named once"):
        compare_folders([results / "first", results / "first"], tmp_path / "none")


def test_results_that_share_no_place_are_refused(results):
    swept = read_results(results / "swept")
    parts = {f"load {k}": replace(swept, data=swept.data.isel(reduced_pressure=[k])) for k in (0, 1)}
    with pytest.raises(UsageError, match="load 0, load 1: their datasets share no place"):
        side_by_side(parts)


def test_rows_that_nothing_names_are_not_paired_where_their_numbers_differ():
    def of(rows):
        data = xr.Dataset({"check_value": ("check", np.ones(rows))})
        return Result(kind="claims", name="scorecard", settings={}, data=data, store=Path())

    with pytest.raises(UsageError, match="rows without names cannot be paired"):
        side_by_side({"a": of(2), "b": of(3)})


@pytest.mark.parametrize("damaged", [False, True])
def test_a_results_folder_is_not_written_over(results, tmp_path, damaged):
    record = tmp_path / "result.json"
    text = (results / "other/result.json").read_text(encoding="utf-8")
    record.write_text(text[: -10 if damaged else None], encoding="utf-8")
    with pytest.raises(UsageError, match="holds results of its own"):
        compare_folders([results / "first", results / "other"], tmp_path)
    assert [*tmp_path.iterdir()] == [record]


def test_the_command_prints_and_writes(results, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = f"compare {results / 'first'} {results / 'other'} --no-report"
    assert "They differ in" in output_of(command)
    assert (tmp_path / "results" / "compare-first-other" / "data.nc").exists()
    assert not (tmp_path / "results" / "compare-first-other" / "report.html").exists()


def test_beside_a_result_without_an_interval_nothing_is_decided(results):
    pair = {name: read_results(results / name) for name in ("first", "other")}
    bare = pair["other"].data
    entering = ["surfaces", "grid", "solver", "size", "bandwidth"]
    bare = bare.assign(area_error=bare.area_error.where(~bare.source.isin(entering)))
    data = side_by_side(pair | {"other": replace(pair["other"], data=bare)})
    assert np.isnan(total_error(data, "area_apart").sel(result="other"))
    assert total_error(side_by_side(pair), "area_apart").sel(result="other") > 0
