"""Results side by side: which numbers are paired, in which units they differ, what cannot be compared."""

from __future__ import annotations

import json
import math
import shutil

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from validation.cli.commands import app
from validation.comparison.beside import beside
from validation.comparison.beside_page import compare_folders
from validation.comparison.run import run_scene
from validation.comparison.sweep import run_sweep
from validation.errors import UsageError
from validation.scenes.sweep import load_asked
from validation.solves.bench import Bench
from validation.studies import find_study
from validation.studies._outputs import run_study


@pytest.fixture(scope="module")
def results(small_run, tmp_path_factory):
    """Two runs of the small scene with other Hurst exponents, two studies, a sweep, all in one folder."""
    from .conftest import _written

    folder = tmp_path_factory.mktemp("beside")
    shutil.copytree(small_run.folder, folder / "first")
    scene = str(_written(folder, fem=False))
    run_scene(load_asked(scene, ["surface.hurst=0.9"]), folder / "other", report=False)
    area = find_study("area")
    for seed in (3, 4):
        (folder / f"area-{seed}").mkdir()
        options = area.options(
            reduced_pressures=(0.1, 0.5), seed=seed, surfaces=2, grids=(16, 24), bandwidth=2.0
        )
        bench = Bench.at(folder / "solves")
        run_study(area, options, folder / f"area-{seed}", bench=bench, report=False)
    loads = load_asked(scene, ["sweep.load.reduced_pressure=[0.05, 0.1]"])
    run_sweep(loads, folder / "swept", store_folder=folder / "other" / "solves", report=False)
    more = load_asked(scene, ["sweep.load.reduced_pressure=[0.1, 0.2]"])
    run_sweep(more, folder / "swept-more", store_folder=folder / "other" / "solves", report=False)
    return folder


def _summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_runs_differ_by_their_limits_in_units_of_the_joint_uncertainty(results, tmp_path):
    page, _ = compare_folders([results / "first", results / "other"], tmp_path)
    a, b = (_summary(results / name)["limit"] for name in ("first", "other"))
    with xr.open_dataset(tmp_path / "data.nc") as data:
        (row,) = np.flatnonzero(data["quantity"].values == "A/A0 limit")
        here = data.isel(row=row)
        assert here["value"].values.tolist() == [a["value"], b["value"]]
        assert float(here["difference"][1]) == b["value"] - a["value"]
        joint = math.sqrt(a["uncertainty"] ** 2 + b["uncertainty"] ** 2)
        assert float(here["joint_error"][1]) == pytest.approx(joint, rel=1e-14)
    (said,) = [text for text in page.findings if text.startswith("A/A0 limit")]
    apart = abs(b["value"] - a["value"]) / joint
    assert ("so they are told apart" in said) == (apart > 2)
    assert f" {float(f'{apart:.1e}'):g} times" in said.replace(".0 ", " ")
    assert (tmp_path / "table.csv").exists()


def test_settings_that_differ_and_what_another_surface_would_change_are_said(results, tmp_path):
    page, _ = compare_folders([results / "first", results / "other"], tmp_path, report=False)
    differing = _summary(tmp_path)["differing"]
    assert differing["surface.hurst"] == ["0.7", "0.9"]
    assert "solid.young" not in differing
    assert any("by how much is unknown without an [ensemble]" in text for text in page.findings)
    assert not (tmp_path / "report.html").exists()


def test_a_figure_shows_all_results_and_its_numbers_are_written(results, tmp_path):
    page, files = compare_folders([results / "first", results / "other"], tmp_path)
    assert files[0] == tmp_path / "report.html"
    (drawing,) = page.figures
    assert set(drawing.data["result"].values) == {"first", "other"}
    assert any(str(curve).endswith("Persson") for curve in drawing.data["curve"].values)
    # The second run was not drawn: its distribution is missing, and the caption says how to get it.
    assert "no distribution was drawn for other: fem-contact report" in drawing.caption
    assert {path.suffix for path in (tmp_path / "figures").glob("beside.*")} == {
        ".svg",
        ".pdf",
        ".csv",
        ".nc",
    }


def test_a_result_beside_its_copy_differs_in_nothing(results, tmp_path):
    shutil.copytree(results / "first", tmp_path / "copy")
    page, _ = compare_folders([results / "first", tmp_path / "copy"], tmp_path / "out", report=False)
    assert page.findings[0].startswith("No setting differs")
    assert any("agree to the last digit" in text for text in page.findings)
    assert all(row[-1] == 0 or math.isnan(row[-1]) for row in page.records["table"].rows)


def test_studies_are_paired_row_by_row_over_their_common_columns(results):
    found = beside([results / "area-3", results / "area-4"])
    assert found.keys == ("reduced_pressure",)
    rows = {(row.where[-1], row.quantity): row for row in found.rows}
    for k, name in enumerate(("area-3", "area-4")):
        with xr.open_dataset(results / name / "data.nc") as data:
            for load in (0.1, 0.5):
                here = data.sel(reduced_pressure=load)
                number = rows[f"{load:.9g}", "kappa"].numbers[k]
                assert number.value == pytest.approx(float(here["kappa"]), rel=1e-12)
                assert number.error == pytest.approx(float(here["kappa_error"]), rel=1e-12)
    assert found.differing == {"seed": ("3", "4")}
    assert not found.one_surface


def test_sweeps_are_compared_where_their_values_meet(results, tmp_path):
    page, _ = compare_folders([results / "swept", results / "swept-more"], tmp_path)
    places = {row[0] for row in page.records["table"].rows}
    assert places == {"0.1"}  # of .05, .1 and of .1, .2
    assert page.figures


def test_what_cannot_be_compared_gets_one_line_and_the_rest_is_compared(results, tmp_path):
    (tmp_path / "empty").mkdir()
    folders = [results / "first", results / "area-3", tmp_path / "empty", results / "other"]
    page, _ = compare_folders(folders, tmp_path / "out", report=False)
    left_out = [text for text in page.findings if "not compared" in text]
    assert len(left_out) == 2
    assert "it is a study area, and" in left_out[0]
    assert "it holds no run, sweep or study" in left_out[1]
    with pytest.raises(UsageError, match="fewer than two folders are left"):
        beside([results / "first", results / "area-3"])
    with pytest.raises(UsageError, match="at least two results folders, each named once"):
        beside([results / "first", results / "first"])


def test_a_results_folder_is_not_written_over(results):
    with pytest.raises(UsageError, match=r"holds results of its own \(run.json\)"):
        compare_folders([results / "first", results / "other"], results / "other")


def test_the_command_prints_and_writes(results, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = ["compare", str(results / "first"), str(results / "other"), "--no-report"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    assert "They differ in" in done.output
    assert (tmp_path / "results" / "compare-first-other" / "data.nc").exists()
    assert json.loads(CliRunner().invoke(app, [*arguments, "--json"]).output)["differing"]
