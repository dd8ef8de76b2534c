"""Sweeps and keys set from outside: equal to single runs, shared solves, refused before computing."""

import csv
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import scipy.stats
from commanding import answer_of, invoke, output_of
from refusing import refused
from small_scene import ONE_BODY, scene_in

from fem_contact import NotConverged
from validation.audit import audit
from validation.audit.values import page_tables
from validation.comparison.explain import explain_sweep, problems_of, solves_of_sweep
from validation.comparison.run import report_scene, run_scene, run_sweep
from validation.comparison.sweep_views import sweep_views
from validation.errors import RunFailed, SceneError, UsageError
from validation.execution.bench import Bench
from validation.execution.press import Press
from validation.execution.results import read_results
from validation.report.estimates import total_error
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene, scene_text
from validation.scenes.sweep import Sweep, load_asked

_HARD = "sweep.effects.hardness.hardness=['200 kPa', 60e3]"


@pytest.fixture(scope="module")
def small_scene(tmp_path_factory):
    from .conftest import _written

    return str(_written(tmp_path_factory.mktemp("swept"), fem=False))


@pytest.fixture(scope="module")
def load_sweep(small_scene):
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
        alone = run_scene(scene, tmp_path / "one", bench=Bench.at(folder / "solves"), report=False)
        assert alone.solved == 0  # the sweep left its solves where any run finds them
        here = outputs.data.sel(pressure=load, hardness=60e3)
        for name in set(alone.data.data_vars) & set(here.data_vars):
            same = (here[name] == alone.data[name]) | (here[name].isnull() & alone.data[name].isnull())
            assert bool(same.all()), name
        assert len(set(alone.data.data_vars) & set(here.data_vars)) > 50


def test_the_dataset_has_the_swept_keys_as_dimensions_with_units(swept):
    _, outputs = swept
    data = outputs.data
    assert data["area"].dims == ("pressure", "hardness")
    assert data["pressure"].attrs["units"] == "Pa"
    assert data["hardness"].values.tolist() == [6e4, 2e5]
    assert data["reduced_pressure"].shape == (2, 2)


def test_the_report_of_a_sweep_is_made_again_without_its_solves(swept, tmp_path):
    folder, outputs = swept
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("solves", "report.html"))
    again = report_scene(copy)
    assert again.page.findings == outputs.page.findings
    assert (copy / "report.html").read_text() == (folder / "report.html").read_text()


def test_a_sweep_is_explained_by_its_first_and_last_case(small_scene):
    loads = load_asked(small_scene, ["sweep.reduced_pressure=[0.1, 0.2, 0.3]", "sweep.shifts=[1, 2]"])
    said = [part for part in explain_sweep(loads).parts() if isinstance(part, str)]
    assert "6 cases, every combination of load.reduced_pressure (3 values), " in said[0]
    for cases, told in ((2, False), (3, True)):
        few = load_asked(small_scene, [f"sweep.reduced_pressure={[0.1, 0.2, 0.3][:cases]}"])
        assert ("The first and the last of them:" in explain_sweep(few).parts()) == told
    cases = [f"\nCase reduced_pressure = {p}, bem_shifts = {n}:" for p, n in ((0.1, 1), (0.3, 2))]
    assert [text for text in said if "Case" in text] == cases


def test_cases_of_other_numbers_of_shifts_stand_side_by_side(small_scene, tmp_path):
    sweep = load_asked(small_scene, ["sweep.methods.bem.shifts=[1, 2]"])
    data = run_sweep(sweep, tmp_path, report=False).data
    alone = run_scene(load_asked(small_scene, ["shifts=1"]), tmp_path / "one", report=False).data
    assert float(data.area[0]) == float(alone.area)
    assert (data.solve.isel(shift=0) != "").all()
    assert (data.solve.isel(shift=1) != "").any(["solver", "grid"]).values.tolist() == [False, True]
    # The grids without a shift serve both cases, and the page says so.
    summary = json.loads((tmp_path / "summary.json").read_text())
    (cost,) = (found for found in summary["findings"] if found["kind"] == "cost")
    assert "{shared} more were asked for by several cases and done once" in cost["form"]
    assert cost["values"]["shared"]["value"] == int((data.solve.isel(shift=0)[0] != "").sum()) > 1


def test_a_gradient_of_the_spectrum_does_not_stand_for_the_realised_one(small_scene, tmp_path):
    sweep = load_asked(small_scene, ["amplitudes='gaussian'", "shifts=1", "sweep.rms_gradient=[0.05, 0.1]"])
    data = run_sweep(sweep, tmp_path, report=False).data
    realised = [realise(scene).field.rms_gradient for scene in sweep.scenes]
    assert data.rms_gradient.values == pytest.approx(realised, rel=1e-12)
    assert data.rms_gradient_spectrum.values.tolist() == [0.05, 0.1]
    assert not np.allclose(data.rms_gradient, data.rms_gradient_spectrum, rtol=1e-3)


def test_where_all_cases_fail_the_reason_is_all_there_is(small_scene, tmp_path, monkeypatch):
    def failing(solve, threads=None):
        raise NotConverged("stopped at the iteration limit; allow more")

    monkeypatch.setattr(Press, "do", failing)
    sweep = load_asked(small_scene, ["sweep.reduced_pressure=[0.1, 0.2]"])
    with pytest.raises(RunFailed, match="stopped at the iteration limit"):
        run_sweep(sweep, tmp_path, report=False)


def test_over_a_coating_kappa_is_no_number_of_a_homogeneous_solid(small_scene, tmp_path):
    one_body = Path(small_scene).read_text().replace(*ONE_BODY)
    coat = ["effects.coating.young='5 MPa'", "effects.coating.poisson=0.3"]
    sweep = scene_in(tmp_path, one_body, *coat, "sweep.effects.coating.thickness=['1 um', '2 um']")
    texts = [one.text for one in sweep_views(run_sweep(sweep, tmp_path, report=False).data).findings]
    assert sum(text.startswith("p* and kappa stand on E* of the solid below") for text in texts) == 1


def test_findings_of_a_sweep_reverse_with_the_numbers(swept):
    _, outputs = swept
    data = outputs.data
    falling, wide = data.assign(area=0.01 / data.area), data.assign(area_error=1000 * data.area_error)
    for changed, outcome in ((data, "+"), (falling, "-"), (wide, "0")):
        changes = [one for one in sweep_views(changed).findings if one.by == "change"]
        (change,) = [one for one in changes if one.text.startswith("From p = ")]
        assert change.outcomes == (outcome,)
    assert "does not change by more than its interval" in change.text
    agreed = "; in 0 of 4 cases with an interval the two agree within it."
    (told,) = [f.text for f in sweep_views(data).findings if "from Persson's theory" in f.text]
    assert told.endswith(agreed)
    bare = data.assign(area_excess_error=np.nan * data.area_excess_error)
    (told,) = [f.text for f in sweep_views(bare).findings if "from Persson's theory" in f.text]
    assert told.endswith("from Persson's theory.")


def test_what_is_written_with_a_unit_is_shown_in_it(small_scene, tmp_path):
    settings = ["solid.young=2000 kPa", "sweep.load.pressure=['0.1 bar', '0.2 bar']"]
    run_sweep(load_asked(small_scene, settings), tmp_path)
    titles, rows = page_tables((tmp_path / "report.html").read_text("utf-8"))["Every case"]
    assert (titles[0], [row[0] for row in rows]) == ("p [bar]", ["0.1", "0.2"])
    header, *lines = csv.reader((tmp_path / "table.csv").read_text("utf-8").splitlines())
    assert (header[0], [float(line[0]) for line in lines]) == ("p [Pa]", [1e4, 2e4])
    assert "From p = 0.1 bar to p = 0.2 bar" in (tmp_path / "summary.json").read_text("utf-8")
    ledger = audit(tmp_path)
    assert not ledger.wrong
    assert "report.html, Every case" in {entry.place for entry in ledger.entries}


def test_hurst_exponents_have_a_linear_axis_no_power_and_a_pointer_to_the_study(small_scene, tmp_path):
    settings = ["grids=[12, 24]", "shifts=1", "ensemble.realisations=3", "ensemble.grids=[16, 24]"]
    sweep = load_asked(small_scene, [*settings, "sweep.hurst=[0.2, 0.5, 0.9]"])
    outputs = run_sweep(sweep, tmp_path)
    figure = next(one for one in outputs.page.figures if one.name == "area-against-hurst")
    (axes,) = figure.figure.axes
    assert axes.get_xscale() == "linear"
    assert not any("power" in text for text in outputs.page.findings)
    assert any("study hurst" in text for text in outputs.page.findings)
    data, student = outputs.data, 4.302652729911275  # two degrees of freedom, 97.5 %
    # From the first to the last the same surfaces change, one by one.
    (told,) = [f for f in sweep_views(data).findings if f.by == "change"]
    ends = [data.isel(hurst=k) for k in (0, -1)]
    ratio = float(ends[1].area) / float(ends[0].area)
    left = (ends[1].area_each - ratio * ends[0].area_each) / ends[0].area
    shares = [float(total_error(end, "area", sources=["grid", "solver"]) / end.area) for end in ends]
    half = student * float(left.std("surface", ddof=1)) / 3**0.5
    change = told.values["change"]
    assert change.value == pytest.approx(ratio - 1)
    grids = ratio * np.hypot(shares[0] / (1 - shares[0] ** 2), shares[1])
    assert change.error == pytest.approx(np.hypot(half, grids), rel=1e-6)
    drawn = {one.mark.y: one for one in figure.drawn}
    band = drawn["area_lowest"].artist.get_paths()[0].vertices[:, 1]
    assert band.min() == pytest.approx(float(data.area_each.min()))
    assert band.max() == pytest.approx(float(data.area_each.max()))


def test_along_a_scale_the_power_is_that_of_the_numbers_with_its_interval(swept):
    data = swept[1].data.isel(hardness=0, drop=True).assign_attrs(keys="pressure")
    loads = [1e3, 3e3, 1e4, 5e4]
    few = data.isel(pressure=[0, 0, 1, 1]).assign_coords(pressure=("pressure", loads, data.pressure.attrs))
    few["area"] = ("pressure", 0.01 * (few.pressure.values / 1e3) ** 0.9 * [1.0, 1.02, 0.99, 1.01])
    (found,) = [one for one in sweep_views(few).findings if one.by == "exponent"]
    line = scipy.stats.linregress(np.log(loads), np.log(few.area))
    assert found.values["exponent"].value == pytest.approx(line.slope, rel=1e-12)
    student = 4.302652729911275  # two degrees of freedom, 97.5 %
    assert found.values["exponent"].error == pytest.approx(student * line.stderr, rel=1e-9)
    assert found.outcomes == ("+",)
    assert found.text.startswith("In the mean A/A0 rises as a power of p, with the exponent 0.9")
    single = [one.text for one in sweep_views(data.isel(pressure=[0])).findings if "Persson" in one.text]
    assert single
    assert not any(" to " in text for text in single)
    for fewer in (data, few.isel(pressure=slice(3))):
        assert not any(one.by == "exponent" for one in sweep_views(fewer).findings)


def test_a_product_runs_its_last_key_fastest_and_a_zip_runs_side_by_side(small_scene):
    lists = ["sweep.surface.seed=[3, 4]", "sweep.solid.young=['1 MPa', '3 MPa']"]
    product = load_asked(small_scene, lists)
    assert [len(key.values) for key in product.keys] == [2, 2]
    pairs = [(scene.surface.seed, scene.solid.young) for scene in product.scenes]
    assert pairs == [(3, 1e6), (3, 3e6), (4, 1e6), (4, 3e6)]
    assert product.place(2) == "seed = 4, young = 1 MPa"
    side = load_asked(small_scene, [*lists, "sweep.mode=zip"])
    assert [(scene.surface.seed, scene.solid.young) for scene in side.scenes] == [(3, 1e6), (4, 3e6)]
    assert side.place(1) == "seed = 4, young = 3 MPa"


def test_solves_that_cases_share_are_done_once(small_scene):
    sweep = load_asked(small_scene, ["sweep.methods.bem.grids=[[12, 24], [12, 24, 48]]"])
    explanation = explain_sweep(sweep)
    explained, costs = explanation.summary(), explanation.costs
    assert (explained["solves"], explained["asked"]) == (12, 20)
    assert explained["seconds"] == pytest.approx(sum(cost.seconds for cost in costs))
    assert explained["peak_bytes"] == max(cost.peak_bytes for cost in costs)
    assert len(solves_of_sweep(sweep, problems_of(sweep))) == 12
    theory_alone = load_asked("polished-steel", ["sweep.load.pressure=['1 MPa', '10 MPa']"])
    costs = explain_sweep(theory_alone).summary()
    assert [costs[name] for name in ("solves", "asked", "seconds", "peak_bytes")] == [0] * 4


def test_a_surface_that_cases_share_is_made_once(load_sweep):
    first, *others = problems_of(load_sweep)
    assert all(other.field is first.field for other in others)
    assert others[-1].pressure == 1e4


def test_a_surface_of_many_points_is_told_by_its_spectrum_only_where_it_is_not_pressed(
    load_sweep, monkeypatch
):
    monkeypatch.setattr("validation.scenes.surfaces.SURVEYED_POINTS", 1)
    assert [problem.drawn for problem in problems_of(load_sweep)] == [True] * 4
    assert [problem.drawn for problem in problems_of(load_sweep, surveyed=True)] == [False] * 4
    monkeypatch.setattr("validation.scenes.surfaces.sampled", None)
    assert len(explain_sweep(load_sweep).cases) == 4


def test_a_key_is_set_with_units_by_its_name_or_its_last_word(small_scene):
    settings = ["solid.young=3 GPa", "hurst=0.5", "load.pressure='2 kPa'", "grids=[16, 32]"]
    scene = load_asked(small_scene, settings)
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
        ("sweep.young=['1 GPa', 1e9]", "[sweep] solid.young: 1 GPa is listed twice"),
        ("sweep.young=['1 GPa', '1 m']", "solid.young = '1 m': is not a pressure"),
        ("sweep.hurts=[1]", "--set hurts: is no key of a scene"),
        ("sweep.name=['a']", "[sweep] name: says how a scene is called or run"),
        ("sweep.mode=outer", "[sweep] mode = 'outer': must be 'product' or 'zip'"),
        ("sweep.lambda_short=['2 um', '4 um', '6 um']", "lambda_short = 6 um: must be below"),
    ],
)
def test_a_setting_that_does_not_fit_is_one_line_that_names_the_key(small_scene, setting, words):
    with refused(UsageError, re.escape(words)):
        load_asked(small_scene, [setting])


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
    path = write_scene(f"[sweep]\n{table}\n", fem=False)
    with refused(SceneError, re.escape(words)):
        load_asked(str(path))


def test_a_swept_key_is_not_set_to_one_value_and_single_scenes_are_asked_for_by_name(write_scene):
    path = str(write_scene("[sweep]\nload.pressure = [10, 20]\n", fem=False))
    assert isinstance(load_asked(path), Sweep)
    assert [scene.load.pressure for scene in load_asked(path, ["sweep.pressure=[30]"]).scenes] == [30.0]
    with pytest.raises(UsageError, match=r"load.pressure: is swept; set sweep.load.pressure"):
        load_asked(path, ["load.pressure=5"])
    with pytest.raises(SceneError, match="is many scenes; fem-contact run and explain take it"):
        load_scene(path)


def test_a_case_that_cannot_be_run_is_refused_before_anything_is_computed(small_scene, tmp_path):
    sweep = load_asked(small_scene, ["load.pressure=10 kPa", "sweep.hardness=['20 kPa', '5 kPa']"])
    with pytest.raises(UsageError, match=r"nominal pressure.*\(\[sweep\] at hardness = 5 kPa\)"):
        run_sweep(sweep, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_lines_of_one_value_have_one_colour_and_the_theory_another_style(swept):
    _, outputs = swept
    figure = next(one for one in outputs.page.figures if one.name == "area-against-pressure")
    lines = {(one.mark.y, one.mark.at["hardness"]): one.artist[0] for one in figure.drawn}
    for k in (0, 1):
        area, theory = lines["area", k], lines["area_persson", k]
        assert area.get_color() == theory.get_color()
        assert area.get_linestyle() != theory.get_linestyle()
    assert lines["area", 0].get_color() != lines["area", 1].get_color()


def test_a_list_of_loads_in_a_swept_scene_is_refused(tmp_path):
    sweep = load_asked("polished-steel", ["load.pressure=['1 MPa', '2 MPa']", "sweep.poisson=[0.2, 0.3]"])
    with pytest.raises(UsageError, match=r"load.pressure: lists several.*sweep.load.pressure"):
        run_sweep(sweep, tmp_path / "results")


def test_keys_of_quantities_and_effects_are_swept(write_scene):
    text = write_scene()
    leak = ["quantities.leak.viscosity='1 mPa s'", "sweep.quantities.leak.pressure_drop=['1 MPa', '2 MPa']"]
    sweep = load_asked(str(text), [*leak, "sweep.effects.hardness.hardness=['1 GPa', '2 GPa']"])
    leaks, hard = ("quantities.leak.pressure_drop", (1e6, 2e6)), ("effects.hardness.hardness", (1e9, 2e9))
    assert [(key.key, key.values) for key in sweep.keys] == [leaks, hard]


def test_a_measured_surface_is_swept_with_the_size_of_its_file(write_scene, tmp_path):
    waves = np.cos(2 * np.pi * np.arange(16) / 16)
    np.save(tmp_path / "map.npy", np.add.outer(waves, waves))
    sweep = scene_in(
        tmp_path,
        '[surface]\nkind = "file"\npath = "map.npy"\nlength = "10 um"\nunit = "10 nm"\nedges = "periodic"\n'
        '[solid]\nyoung = "1 GPa"\npoisson = 0.3\n[load]\nreduced_pressure = 0.1\n'
        "[methods.theory]\n[methods.bem]\ngrids = [16, 32]\n[sweep]\nload.reduced_pressure = [0.05, 0.2]\n",
    )
    assert all(scene.surface.path.is_absolute() for scene in sweep.scenes)
    first, second = problems_of(sweep)
    assert second.measured is first.measured
    assert second.pressure == pytest.approx(4 * first.pressure, rel=1e-12)


def test_the_sweep_in_the_docs_can_be_run(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "bench.md").read_text()
    (block,) = [text for text in page.split("```toml\n") if text.startswith("[sweep]")]
    sweep = scene_in(tmp_path, scene_text("hardness")[0] + "\n" + block.partition("```")[0])
    assert [len(key.values) for key in sweep.keys] == [5, 2]
    problems_of(sweep)


def test_a_case_whose_solves_fail_is_a_row_and_the_command_says_so(small_scene, tmp_path, monkeypatch):
    do = Press.do

    def failing(solve, threads=None):
        if solve.problem.load.values[0] < 0.3:
            raise NotConverged("stopped at the iteration limit; allow more")
        return do(solve, threads=threads)

    monkeypatch.setattr(Press, "do", failing)
    swept = "sweep.reduced_pressure=[0.1, 0.2, 0.3]"
    outcome = invoke("run", small_scene, "--set", swept, "--output", tmp_path, "--quiet")
    assert isinstance(outcome.exception, RunFailed)
    assert "not all solves succeeded, the report is of the others" in str(outcome.exception)
    assert "In 2 of 3 cases solves failed: BEM" in outcome.output
    assert "From p*" not in outcome.output  # one area goes nowhere
    data = read_results(tmp_path).data
    assert (tmp_path / "report.html").exists()
    assert (data.failures != "").values.tolist() == [True, True, False]
    assert data.area.isnull().values.tolist() == [True, True, False]
    assert data.attrs["title"] == "A small scene"


def test_the_command_plans_explains_and_runs_a_sweep(small_scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = ["--set", "sweep.seed=[3, 4]", "--set", "methods.bem.grids=[12, 24]", "--set", "shifts=1"]
    plan = answer_of("run", small_scene, *settings, "--dry-run")
    assert [row["stored"] for row in plan] == [False] * 4
    said = answer_of("explain", small_scene, *settings)
    assert said["solves"] == 4
    assert [case["case"] for case in said["cases"]] == ["seed = 3", "seed = 4"]
    assert not (tmp_path / "results").exists()
    done = answer_of("run", small_scene, *settings, "--no-report")
    (key,) = done["sweep"]["keys"]
    assert (key["key"], key["values"]) == ("surface.seed", [3, 4])
    # A seed is no parameter along which an area goes.
    found = [text["text"] for text in json.loads(Path("results/small/summary.json").read_text())["findings"]]
    assert any(text.startswith("Over 2 surfaces the mean is A/A0") for text in found)
    assert not any("From seed" in text for text in found)
    made = answer_of("report results/small")
    assert any(path.endswith("report.html") for path in made)
    refused = invoke("run", small_scene, *settings, "--accuracy", "1%")
    assert isinstance(refused.exception, UsageError)
    # A single scene in the same folder leaves nothing of the sweep.
    output_of("run", small_scene, *settings[2:], "--no-report")
    names = "budget.csv shown.json data.nc numbers.csv result.json summary.json table.csv"
    assert {path.name for path in (tmp_path / "results" / "small").glob("*.*")} == {*names.split()}
