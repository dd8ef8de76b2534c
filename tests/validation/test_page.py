"""One kind of page: what a run and a study leave is written by the same code."""

from __future__ import annotations

import csv
import dataclasses
import json
import re
import shutil
import socket
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from validation.comparison.run import report_run, run_scene
from validation.report.page import Answer, Page, render, write_page
from validation.report.table import ResultTable, shown
from validation.report.words import mathematics
from validation.scenes.scene import load_scene
from validation.solves.bench import Bench
from validation.studies import find_study
from validation.studies._outputs import is_study, report_study, run_study


@pytest.fixture(scope="module")
def outputs(small_run, tmp_path_factory):
    """What a run and a study left behind: page, folder, and how both are made again."""
    folder = tmp_path_factory.mktemp("outputs")
    shutil.copytree(small_run.folder, folder / "run")
    (folder / "study").mkdir()
    options = {"pressures": (0.02, 0.1, 0.5), "seeds": (3, 4), "grids": (16, 24, 32), "bandwidth": 2.0}
    study = run_study(find_study("area"), options, folder / "study", bench=Bench.at(folder / "solves"))
    return {
        "run": (small_run.page, folder / "run", report_run),
        "study": (study.page, folder / "study", report_study),
    }


@pytest.mark.parametrize("kind", ["run", "study"])
def test_a_run_and_a_study_leave_the_same_kind_of_page(outputs, kind):
    page, folder, again = outputs[kind]
    written = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    html = (folder / "report.html").read_text(encoding="utf-8")
    headings = re.findall(r"<h2>(.*?)</h2>", html)
    assert headings[0] == "What was found"
    assert headings[-3:] == ["Figures", "Settings, seeds, versions", "Papers to cite"]
    for words in (page.lead, *page.findings, *(column for t in page.tables for column in t.columns)):
        assert mathematics(words) in html
    assert json.loads((folder / "summary.json").read_text())["findings"] == list(page.findings)
    for name, table in page.records.items():
        with (folder / f"{name}.csv").open(newline="") as file:
            assert len(list(csv.reader(file))) == 1 + len(table.rows)
    for drawing in page.figures:
        assert f'id="{drawing.name}"' in html
        suffixes = {path.suffix for path in folder.glob(f"figures/{drawing.name}.*")}
        assert suffixes == {".svg", ".pdf", ".csv", ".nc"}
    for path in written:
        if path.parts[0] in ("report.html", "figures", "summary.json", "table.csv", "data.csv"):
            (folder / path).unlink()
    again(folder)
    for path, content in written.items():
        if path.suffix != ".nc":
            assert (folder / path).read_bytes() == content, path


def _page(**said):
    return Page(title="A page", lead="p0 = 2 Pa", settings={"seed": 5}, seeds="5", papers=(), **said)


def test_a_page_writes_every_digit_and_shows_five(tmp_path):
    table = ResultTable.of(("name", "value"), [("a", 1 / 3), ("b", float("nan"))])
    data = xr.Dataset({"area": ("load", np.array([0.1, 0.2]))})
    page = _page(records={"table": table}, tables=(shown(table),), data=data, summary={"x": 1})
    files = write_page(page, tmp_path)
    assert [path.name for path in files] == ["report.html", "data.csv", "table.csv", "summary.json"]
    assert (tmp_path / "table.csv").read_text().splitlines()[1] == f"a,{1 / 3!r}"
    assert "0.33333</td>" in (tmp_path / "report.html").read_text()
    assert not (tmp_path / "figures").exists()


def test_what_looks_like_markup_is_shown_and_not_obeyed():
    page = dataclasses.replace(
        _page(findings=("<b>A/A0</b> = 1",), answers=(Answer(question="<i>", answer="<u>"),)),
        title="<script>alert(1)</script>",
    )
    html = render(page)
    assert "<script>" not in html
    assert "&lt;b&gt;A/A<sub>0</sub>&lt;/b&gt; = 1" in html
    assert not re.search(r"<[iu]>", html)


def test_a_run_of_another_scene_leaves_nothing_of_the_one_before(small_run, write_scene, tmp_path):
    folder = tmp_path / "results"
    shutil.copytree(small_run.folder, folder)
    old = [folder / "figures" / name for name in ("surface-3d.png", "other.svg", "other-bin.csv")]
    old += [folder / name for name in ("budget.csv", "data.csv", "data-load.csv", "study.json")]
    mine = [folder / "notes.txt", folder / "figures" / "notes.txt"]
    for path in (*old, *mine):
        path.write_text("earlier")
    draft = folder / "figures" / f".{socket.gethostname()}-{_dead_process()}-area.svg"
    draft.write_text("half")
    again = run_scene(load_scene(str(write_scene(("A small scene", "Another"), fem=False))), folder)
    assert again.solved == 0
    assert not [path for path in (*old, draft) if path.exists()]
    assert all(path.exists() for path in mine)
    assert {path.suffix for path in again.files if path.is_file()} == {".html", ".csv", ".json"}
    assert not list(folder.glob("fields/*"))


def test_an_interrupted_run_of_another_scene_does_not_stand_beside_the_old_report(
    small_run, write_scene, tmp_path, monkeypatch
):
    folder = tmp_path / "results"
    shutil.copytree(small_run.folder, folder)

    def interrupted(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("validation.comparison.run.solve_jobs", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_scene(small_run.comparison.scene, folder)
    assert (folder / "report.html").exists()
    with pytest.raises(KeyboardInterrupt):
        run_scene(load_scene(str(write_scene(("A small scene", "Another")))), folder)
    assert not (folder / "report.html").exists()
    assert not list(folder.glob("figures/*"))


def test_a_folder_is_that_of_what_ran_in_it_last(outputs, small_run, tmp_path):
    folder = tmp_path / "both"
    shutil.copytree(outputs["study"][1], folder)
    assert is_study(folder)
    run_scene(small_run.comparison.scene, folder, store_folder=small_run.folder / "solves")
    assert not is_study(folder)
    options = {"pressures": (0.1,), "seeds": (3, 4), "grids": (16, 24), "bandwidth": 2.0}
    run_study(find_study("area"), options, folder, bench=Bench.at(tmp_path / "solves"))
    assert is_study(folder)
    assert not (folder / "run.json").exists()
    assert not (folder / "table.csv").exists()


def _dead_process():
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    return done.pid
