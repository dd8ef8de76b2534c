"""Sweeps and keys set from outside: equal to single runs, shared solves, refused before computing."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from validation.cli.commands import app
from validation.comparison.run import run_scene
from validation.comparison.sweep import (
    explain_sweep,
    realised_cases,
    report_sweep,
    run_sweep,
    solves_of_sweep,
)
from validation.comparison.sweep_page import sweep_findings
from validation.errors import SceneError, UsageError
from validation.report.words import with_error
from validation.scenes.scene import load_scene, scene_text
from validation.scenes.sweep import Sweep, load_asked

_HARD = "sweep.effects.hardness.hardness=['200 kPa', 60e3]"


@pytest.fixture(scope="module")
def small_scene(tmp_path_factory):
    from .conftest import _written

    return str(_written(tmp_path_factory.mktemp("swept"), fem=False))


@pytest.fixture(scope="module")
def load_sweep(small_scene):
    """Two loads times two hardnesses, side by side in one folder."""
    return load_asked(small_scene, ["sweep.load.pressure=['1 kPa', '10 kPa']", _HARD])


@pytest.fixture(scope="module")
def swept(load_sweep, tmp_path_factory):
    folder = tmp_path_factory.mktemp("results") / "swept"
    return folder, run_sweep(load_sweep, folder)


def test_a_sweep_of_load_and_hardness_equals_the_single_runs_number_for_number(small_scene, swept, tmp_path):
    folder, outputs = swept
    for load in (1e3, 1e4):
        settings = [f"load.pressure={load}", "hardness=60 kPa"]
        scene = load_asked(small_scene, settings)
        alone = run_scene(scene, tmp_path / "one", store_folder=folder / "solves", report=False)
        assert alone.solved == 0  # the sweep left its solves where any run finds them
        c, here = alone.comparison, outputs.data.sel(pressure=load, hardness=60e3)
        assert float(here["area"]) == c.limit.value
        assert float(here["area_error"]) == c.limit.uncertainty
        assert float(here["kappa"]) == c.limit.value / c.reduced_pressure
        assert float(here["theory"]) == c.theory.area
        assert float(here["theory_ensemble"]) == c.theory.ensemble_area
        assert float(here["theory_plastic"]) == c.theory.plastic
        row = c.rows[-1]
        of_bem = here.sel(solver="bem")
        for name in ("pixel", "perimeter", "plastic", "points_per_wave", "residual"):
            assert float(of_bem[name]) == getattr(row, name)
        assert str(of_bem["grid"].item()) == "48 x 48"


def test_the_dataset_has_the_swept_keys_as_dimensions_with_units(swept):
    _, outputs = swept
    data = outputs.data
    assert data["area"].dims == ("pressure", "hardness")
    assert data["pressure"].attrs["units"] == "Pa"
    assert data["hardness"].values.tolist() == [2e5, 6e4]
    assert data["reduced_pressure"].shape == (2, 2)


def test_the_page_has_one_row_for_each_case_and_its_figures_show_uncertainty_beside_the_theory(swept):
    folder, outputs = swept
    (table,) = outputs.page.tables
    assert len(table.rows) == 4
    limit = float(outputs.data["area"][0, 0]), float(outputs.data["area_error"][0, 0])
    assert table.rows[0][table.columns.index("A/A0 limit")] == with_error(*limit)
    figure = next(one for one in outputs.page.figures if one.name == "area-against-pressure")
    assert {"area", "area_error", "theory"} <= set(figure.data.data_vars)
    summary = json.loads((folder / "summary.json").read_text())
    assert len(summary["cases"]) == 4
    assert summary["findings"] == list(outputs.page.findings)


def test_the_report_of_a_sweep_is_made_again_without_its_solves(swept, tmp_path):
    folder, outputs = swept
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("solves", "report.html"))
    again = report_sweep(copy)
    assert again.page.findings == outputs.page.findings
    assert (copy / "report.html").read_text() == (folder / "report.html").read_text()


def test_findings_of_a_sweep_reverse_with_the_numbers(load_sweep, swept):
    _, outputs = swept
    data = outputs.data.copy(deep=True)
    data["area"] = 0.5 * data["theory"]
    (text,) = [one for one in sweep_findings(data, load_sweep.keys) if "Persson" in one]
    assert text.count("50 % below") == 2
    data["area"] = 1.25 * data["theory"]
    (text,) = [one for one in sweep_findings(data, load_sweep.keys) if "Persson" in one]
    assert text.count("25 % above") == 2
    data["area"] = np.nan * data["theory"]
    assert any("In 4 of 4 cases the limit" in one for one in sweep_findings(data, load_sweep.keys))


def test_a_product_runs_its_last_key_fastest_and_a_zip_runs_side_by_side(small_scene):
    lists = ["sweep.surface.seed=[3, 4]", "sweep.solid.young=['1 MPa', '3 MPa']"]
    product = load_asked(small_scene, lists)
    assert product.shape == (2, 2)
    pairs = [(scene.surface.seed, scene.solid.young) for scene in product.scenes]
    assert pairs == [(3, 1e6), (3, 3e6), (4, 1e6), (4, 3e6)]
    assert product.words(2) == "seed = 4, young = 1e+06 Pa"
    side = load_asked(small_scene, [*lists, "sweep.mode=zip"])
    assert [(scene.surface.seed, scene.solid.young) for scene in side.scenes] == [(3, 1e6), (4, 3e6)]
    assert side.words(1) == "seed = 4, young = 3e+06 Pa"


def test_a_zip_has_its_keys_along_one_dimension(small_scene, tmp_path):
    settings = ["sweep.seed=[3, 4]", "sweep.young=['1 MPa', '3 MPa']", "sweep.mode=zip"]
    sweep = load_asked(small_scene, [*settings, "methods.bem.shifts=1", "methods.bem.grids=[12, 24]"])
    data = run_sweep(sweep, tmp_path, report=False).data
    assert data["area"].dims == ("case",)
    assert data["young"].dims == ("case",)
    assert not (tmp_path / "report.html").exists()


def test_solves_that_cases_share_are_done_once(small_scene):
    sweep = load_asked(small_scene, ["sweep.methods.bem.grids=[[12, 24], [12, 24, 48]]"])
    explained = explain_sweep(sweep)
    assert (explained.solves, explained.asked) == (12, 20)
    assert len(solves_of_sweep(sweep, realised_cases(sweep))) == 12


def test_a_surface_that_cases_share_is_made_once(load_sweep):
    first, *others = realised_cases(load_sweep)
    assert all(other.field is first.field for other in others)
    assert others[-1].pressure == 1e4


def test_a_sweep_of_the_theory_alone_has_its_areas(tmp_path):
    sweep = load_asked("polished-steel", ["load.pressure=1 MPa", "sweep.solid.young=['100 GPa', '200 GPa']"])
    data = run_sweep(sweep, tmp_path, report=False).data
    (answer,) = run_scene(sweep.scenes[1], tmp_path / "one", report=False).comparison.answers
    assert float(data["theory_ensemble"].sel(young=2e11)) == answer.area[-1]
    assert "area" not in data


def test_a_key_is_set_with_units_by_its_name_or_its_last_word(small_scene):
    scene = load_asked(
        small_scene, ["solid.young=3 GPa", "hurst=0.5", "load.pressure='2 kPa'", "grids=[16, 32]"]
    )
    assert scene.solid.young == 3e9
    assert scene.surface.hurst == 0.5
    # Of two keys that exclude each other the one that is set replaces the other.
    assert (scene.load.pressure, scene.load.reduced_pressure) == (2e3, None)
    assert scene.methods.options("bem").grids == ((16, 16), (32, 32))
    (effect,) = load_asked(small_scene, ["hardness=1 MPa"]).effects
    assert (effect.kind, effect.hardness) == ("hardness", 1e6)
    assert load_asked(small_scene) == load_scene(small_scene)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("surface.hurts=0.5", "--set surface.hurts: is no key of a scene; did you mean 'surface.hurst'?"),
        ("depth=1 um", "--set depth: is short for methods.fem.depth,"),
        ("load=3", "--set load: is a table; name one of its keys: load.pressure, load.reduced_pressure"),
        ("hurst", "--set hurst: must be key=value"),
        ("title.x=1", "--set title.x: is no key of a scene"),
        ("hurst=2", "surface.hurst = 2: must be less than or equal to 1"),
        ("young=3 um", "solid.young = '3 um': is not a pressure"),
        ("sweep.young=3", "[sweep] solid.young = 3: must be a list of 1 to 256 values"),
        ("sweep.young=[]", "[sweep] solid.young = []: must be a list"),
        ("sweep.young=['1 GPa', 1e9]", "[sweep] solid.young: 1e+09 Pa is listed twice"),
        ("sweep.young=['1 GPa', '1 m']", "solid.young = '1 m': is not a pressure"),
        ("sweep.hurts=[1]", "--set hurts: is no key of a scene"),
        ("sweep.name=['a']", "[sweep] name: says how a scene is called or run"),
        ("sweep.mode=outer", "[sweep] mode = 'outer': must be 'product' or 'zip'"),
        ("sweep.lambda_short=['2 um', '4 um', '6 um']", "lambda_short = 6e-06 m: must be below"),
    ],
)
def test_a_setting_that_does_not_fit_is_one_line_that_names_the_key(small_scene, setting, words):
    with pytest.raises(UsageError) as refused:
        load_asked(small_scene, [setting])
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("mode = 'zip'\nseed = [1, 2]\nyoung = ['1 GPa']", "surface.seed has 2, solid.young has 1"),
        ("seed = [1, 2]\nsurface.seed = [3]", "[sweep] surface.seed: is listed twice"),
        ("pressure = ['1 kPa']\nreduced_pressure = [0.1]", "excludes load.pressure, which is swept, too"),
        ("mode = 'zip'", "[sweep] is empty"),
        ("run.workers = [1, 2]", "run.workers: says how a scene is called or run"),
    ],
)
def test_a_table_sweep_that_does_not_fit_is_refused_in_one_line(write_scene, table, words):
    path = write_scene(("[methods.theory]", f"[sweep]\n{table}\n[methods.theory]"), fem=False)
    with pytest.raises(SceneError) as refused:
        load_asked(str(path))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_swept_key_is_not_set_to_one_value_and_single_scenes_are_asked_for_by_name(write_scene):
    path = str(
        write_scene(("[methods.theory]", "[sweep]\nload.pressure = [10, 20]\n[methods.theory]"), fem=False)
    )
    assert isinstance(load_asked(path), Sweep)
    assert [scene.load.pressure for scene in load_asked(path, ["sweep.pressure=[30]"]).scenes] == [30.0]
    with pytest.raises(UsageError, match=r"load.pressure: is swept; set sweep.load.pressure"):
        load_asked(path, ["load.pressure=5"])
    with pytest.raises(SceneError, match="is many scenes; fem-contact run and explain take it"):
        load_scene(path)


def test_a_case_that_cannot_be_run_is_refused_before_anything_is_computed(small_scene, tmp_path):
    sweep = load_asked(small_scene, ["load.pressure=10 kPa", "sweep.hardness=['20 kPa', '5 kPa']"])
    with pytest.raises(UsageError, match=r"nominal pressure.*\(\[sweep\] at hardness = 5000 Pa\)"):
        run_sweep(sweep, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_the_scatter_between_surfaces_is_that_of_the_single_run(small_scene, tmp_path):
    settings = ["grids=[12, 24]", "shifts=1", "ensemble.realisations=3", "ensemble.grids=[16, 24]"]
    sweep = load_asked(small_scene, [*settings, "sweep.hurst=[0.6, 0.8]"])
    data = run_sweep(sweep, tmp_path, report=False).data
    alone = run_scene(sweep.scenes[1], tmp_path / "one", store_folder=tmp_path / "solves", report=False)
    assert alone.solved == 0
    assert float(data["scatter"].sel(hurst=0.8)) == alone.comparison.scatter.relative


def test_lines_of_one_value_have_one_colour_and_the_theory_another_style(swept):
    _, outputs = swept
    figure = next(one.figure for one in outputs.page.figures if one.name == "area-against-pressure")
    drawn = [bars[0] for bars in figure.axes[0].containers]
    area, theory = drawn[:2], drawn[2:]
    assert [line.get_color() for line in area] == [line.get_color() for line in theory]
    assert {line.get_linestyle() for line in area}.isdisjoint({line.get_linestyle() for line in theory})


def test_a_list_of_loads_in_a_swept_scene_is_refused(tmp_path):
    sweep = load_asked("polished-steel", ["load.pressure=['1 MPa', '2 MPa']", "sweep.poisson=[0.2, 0.3]"])
    with pytest.raises(UsageError, match=r"load.pressure: lists several.*sweep.load.pressure"):
        run_sweep(sweep, tmp_path / "results")


def test_a_measured_surface_is_swept_with_the_size_of_its_file(write_scene, tmp_path):
    waves = np.cos(2 * np.pi * np.arange(16) / 16)
    np.save(tmp_path / "map.npy", np.add.outer(waves, waves))
    path = tmp_path / "measured.toml"
    path.write_text(
        '[surface]\nkind = "file"\npath = "map.npy"\nlength = "10 um"\nunit = "10 nm"\nedges = "periodic"\n'
        '[solid]\nyoung = "1 GPa"\npoisson = 0.3\n[load]\nreduced_pressure = 0.1\n'
        "[methods.theory]\n[methods.bem]\ngrids = [16, 32]\n[sweep]\nload.reduced_pressure = [0.05, 0.2]\n"
    )
    sweep = load_asked(str(path))
    assert all(scene.surface.path.is_absolute() for scene in sweep.scenes)
    first, second = realised_cases(sweep)
    assert second.measured is first.measured
    assert second.pressure == pytest.approx(4 * first.pressure, rel=1e-12)


def test_the_sweep_in_the_docs_can_be_run(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "bench.md").read_text()
    (block,) = [text for text in page.split("```toml\n") if text.startswith("[sweep]")]
    path = tmp_path / "steel.toml"
    path.write_text(scene_text("hardness")[0] + "\n" + block.partition("```")[0])
    sweep = load_asked(str(path))
    assert sweep.shape == (5, 2)
    realised_cases(sweep)


def test_the_command_plans_explains_and_runs_a_sweep(small_scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = ["--set", "sweep.seed=[3, 4]", "--set", "methods.bem.grids=[12, 24]", "--set", "shifts=1"]
    call = CliRunner().invoke
    plan = json.loads(call(app, ["run", small_scene, *settings, "--dry-run", "--json"]).stdout)
    assert [row["stored"] for row in plan] == [False] * 4
    said = json.loads(call(app, ["explain", small_scene, *settings, "--json"]).stdout)
    assert said["solves"] == 4
    assert [case["case"] for case in said["cases"]] == ["seed = 3", "seed = 4"]
    assert not (tmp_path / "results").exists()
    done = json.loads(call(app, ["run", small_scene, *settings, "--json", "--no-report"]).stdout)
    assert done["sweep"] == {"surface.seed": [3, 4]}
    made = json.loads(call(app, ["report", "results/small", "--json"]).stdout)
    assert any(path.endswith("report.html") for path in made)
    refused = call(app, ["run", small_scene, *settings, "--accuracy", "1%"])
    assert isinstance(refused.exception, UsageError)
    # A single scene in the same folder leaves nothing of the sweep.
    call(app, ["run", small_scene, *settings[2:], "--no-report"], catch_exceptions=False)
    assert {path.name for path in (tmp_path / "results" / "small").glob("*.*")} == {
        "run.json",
        "summary.json",
        "table.csv",
    }
