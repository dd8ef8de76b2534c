"""Running scenes: results on disk, resumed after a kill, refused before anything is computed."""

import base64
import csv
import errno
import hashlib
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_scene import GRIDS, OBLONG, ensemble, scene_in, scene_of
from solving import solve_all

from fem_contact import NotConverged, find_patches
from validation.comparison.run import report_scene, run_scene
from validation.errors import RunFailed, UsageError
from validation.execution.bench import Bench
from validation.execution.press import Press, solves_of
from validation.execution.store import Store
from validation.report.words import mathematics
from validation.scenes.scene import load_scene
from validation.scenes.surfaces import height_field, sampled, waves_of
from validation.scenes.tables import Load


def test_a_run_leaves_table_fields_block_and_report(small_run):
    names = {path.name for path in small_run.files}
    assert {"report.html", "table.csv", "summary.json"} <= names
    assert all(path.exists() for path in small_run.files)
    with (small_run.folder / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    bem, fem = ("12 x 8", "24 x 16", "48 x 32"), ("12 x 8", "24 x 16")
    expected = [*(("bem", grid) for grid in bem), *(("fem", grid) for grid in fem)]
    assert [(row["method"], row["grid"]) for row in rows] == expected
    (block, *_) = [meshio.read(path) for path in small_run.files if path.suffix == ".vtu"]
    assert any("stress" in name.lower() for name in block.cell_data)
    summary = json.loads((small_run.folder / "summary.json").read_text())
    assert tuple(finding["text"] for finding in summary["findings"]) == small_run.page.findings
    area, error = (summary["numbers"]["area"][key] for key in ("value", "error"))
    assert area == float(small_run.data.area)
    assert error == pytest.approx(float((small_run.data.area_error**2).sum() ** 0.5), rel=1e-12)


def test_maps_are_of_the_grid_with_most_points_whatever_its_shape(tmp_path):
    text = OBLONG.replace("[24, 12]", "[48, 12]").replace("[48, 24]", "[16, 16]")
    data = run_scene(scene_in(tmp_path, text), tmp_path / "results", report=False).data
    assert data.attrs["map_grid"] == "48 x 12"
    assert data.pressure_map.shape[1:] == data.heights.shape == (48, 12)


def test_the_page_is_made_of_the_dataset_and_of_what_was_asked_alone(small_run, tmp_path):
    alone = tmp_path / "alone"
    alone.mkdir()
    for name in ("result.json", "data.nc"):
        shutil.copy(small_run.folder / name, alone / name)
    again = report_scene(alone)
    assert again.page.findings == small_run.page.findings
    for name in ("table.csv", "numbers.csv", "figures/area.csv"):
        assert (alone / name).read_bytes() == (small_run.folder / name).read_bytes()
    summaries = [(folder / "summary.json").read_text() for folder in (small_run.folder, alone)]
    assert summaries[0] == summaries[1]


def test_the_answer_and_the_surface_stand_before_the_contact_and_every_figure_names_its_files(small_run):
    names = [drawing.name for drawing in small_run.page.figures]
    assert names == ["area", "surface", "pressure-maps", "pressure-distribution", "cost"]
    for name in names:
        suffixes = {path.suffix for path in (small_run.folder / "figures").glob(f"{name}*")}
        assert suffixes == {".svg", ".pdf", ".csv", ".nc"}
    heights = small_run.data.heights
    field = height_field(scene_of(small_run).surface)
    assert_allclose(heights.values, field.resampled((24, 16)).heights, atol=1e-12)
    spectrum = small_run.data.power_spectrum
    assert spectrum.sizes["wavevector"] >= 2
    # Parseval: rings of C(q) hold the variance of the heights.
    told = small_run.data.power_spectrum_told
    assert float((spectrum / told).mean()) == pytest.approx(1, abs=0.6)


def test_contact_in_numbers_follows_from_the_fields(small_run):
    scene = scene_of(small_run)
    store, data = Store(folder=small_run.folder / "solves"), small_run.data
    own = [s for s in solves_of(scene) if s.method == "bem" and s.is_own]
    *coarser, finest = (store.read(solve).result for solve in sorted(own, key=lambda s: s.grid))
    assert_allclose(data.mean_gap, finest.gap.mean(), rtol=1e-12)
    gap, largest = (lambda result: result.gap.mean()), (lambda result: result.pressure.max())
    for name, power, read in (("mean_gap", 1.5, gap), ("largest_pressure", 1.0, largest)):
        ratios = [max(finest.spacing) / max(result.spacing) for result in coarser]
        left = [(read(r) - read(finest)) * k**power for r, k in zip(coarser, ratios, strict=True)]
        half = 4.302652729911275 * math.hypot(*left) / 2**0.5  # Student's of two samples
        assert len(left) == 2
        assert_allclose(data[f"{name}_error"].sel(source="grid"), half, rtol=1e-9)
    assert float(data.approach) == -finest.offset
    assert float(data.largest_pressure) == finest.pressure.max()
    assert float(data.patches) == find_patches(finest.in_contact, finest.spacing).count
    lx, ly = finest.lengths
    assert_allclose(data.contact_area, float(data.area_own) * lx * ly, rtol=1e-12)
    listed = {row[0]: row for row in small_run.page.records["numbers"].rows}
    assert listed["area of real contact of this surface"][-1] == "um^2"
    # The stiffness of the contact set: load over approach of a slightly larger load.
    more = replace(own[-1], problem=replace(own[-1].problem, load=Load(reduced_pressure=(0.1002,))))
    pressed = more.do().contact
    slope = (pressed.mean_pressure - finest.mean_pressure) / (finest.offset - pressed.offset)
    assert_allclose(data.stiffness, slope * float(data.rms_height) / finest.mean_pressure, rtol=0.01)


def test_one_grid_gives_an_answer_that_says_what_it_rests_on(read_scene, tmp_path):
    scene = read_scene((f"{GRIDS}\nshifts = 2", "grids = [[24, 12]]"), fem=False)
    outputs = run_scene(scene, tmp_path / "results")
    data = outputs.data
    assert float(data.area) == float(data.area_located.item()) > 0
    assert np.isnan(data.area_error.sel(source="grid"))
    (card, *_) = outputs.page.answers
    assert "a second grid of 3 points per shortest wave gives the limit" in card.basis
    assert "not determinable" not in card.answer
    assert "cost" not in {drawing.name for drawing in outputs.page.figures}


def test_a_block_is_copied_where_the_results_take_no_links(small_run, tmp_path, monkeypatch):
    def fails(*paths):
        raise OSError(errno.EXDEV, "Invalid cross-device link")

    monkeypatch.setattr(os, "link", fails)
    bench = Bench.at(small_run.folder / "solves")
    copied = run_scene(scene_of(small_run), tmp_path / "out", bench=bench, report=False)
    mine, its = (sorted(folder.rglob("fields/*.vtu")) for folder in (copied.folder, small_run.folder))
    assert [path.name for path in mine] == [path.name for path in its] != []
    assert all(one.read_bytes() == other.read_bytes() for one, other in zip(mine, its, strict=True))


def test_the_report_holds_five_figures_the_findings_and_one_script_that_its_policy_names(small_run):
    page = (small_run.folder / "report.html").read_text()
    assert page.count("<svg") == 5
    for finding in small_run.page.findings:
        assert mathematics(finding) in page
    assert "default-src 'none'" in page
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in page


def test_an_option_recomputes_only_what_it_affects(read_scene):
    def keys(*change, method=""):
        solves = solves_of(read_scene(*change))
        return {solve.key for solve in solves if solve.key.startswith(method)}

    growth = ("depth =", "growth = 1.3\ndepth =")
    assert keys() < keys(("[24, 16]]\ndepth", "[24, 16], 32]\ndepth"))
    assert not keys() & keys(("poisson = 0.3", "poisson = 0.4"))
    assert keys(method="bem") == keys(growth, method="bem")
    assert not keys(method="fem") & keys(growth)


def test_a_killed_run_continues_after_its_finished_solves(write_scene, tmp_path):
    path = write_scene((GRIDS, "grids = [12, 24, 48, 384, 512]"), fem=False)
    folder = tmp_path / "results"
    command = [sys.executable, "-m", "validation.cli", "run", str(path), "-o", str(folder), "--quiet"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    solves = folder / "solves"
    while not (solves.is_dir() and len(list(solves.glob("bem-*.nc"))) >= 3):
        assert process.poll() is None, "the run ended before it could be killed"
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    store = Store(folder=solves)
    solves = solves_of(load_scene(str(path)))
    finished = [solve for solve in solves if store.read(solve)]
    assert 3 <= len(finished) < len(solves)
    small = tuple(solve for solve in solves if solve.grid[0] < 100)
    times = {solve.key: store.path(solve).stat().st_mtime_ns for solve in finished}
    assert solve_all(small, store).solved == len(small) - len([solve for solve in finished if solve in small])
    assert times == {solve.key: store.path(solve).stat().st_mtime_ns for solve in finished}


@pytest.fixture
def solves_nothing(monkeypatch):
    monkeypatch.setattr(Press, "do", lambda solve, threads=None: pytest.fail("computed"))


def test_a_folder_that_cannot_be_written_is_refused_before_computing(read_scene, tmp_path, solves_nothing):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    with pytest.raises(UsageError, match=r"--output = .*cannot be written to"):
        run_scene(read_scene(), blocker / "results")


def test_what_a_method_does_not_handle_is_refused_before_computing(read_scene, tmp_path, solves_nothing):
    with pytest.raises(UsageError, match=r"solid\.poisson = 0\.5: elements of method 'fem' lock above 0\.49"):
        run_scene(read_scene(("poisson = 0.3", "poisson = 0.5")), tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_a_failed_solve_is_a_row_of_the_report_of_the_others(write_scene, tmp_path, monkeypatch):
    path = write_scene(ensemble(3))
    do = Press.do

    def failing(solve, threads=None):
        if solve.method == "fem" or (solve.problem.realisation == 1 and solve.grid == (24, 16)):
            raise NotConverged("stopped at the iteration limit; allow more")
        return do(solve, threads=threads)

    monkeypatch.setattr(Press, "do", failing)
    outputs = run_scene(load_scene(str(path)), tmp_path / "results")
    data, why = outputs.data, "FEM 12x8: stopped at the iteration limit; allow more"
    assert (tmp_path / "results" / "report.html").exists()
    assert data.failure.sel(solver="fem", grid="12 x 8").item() == why
    assert (data.failure.sel(solver="bem") == "").all()
    assert outputs.page.findings[0] == f"Not all solves succeeded: {data.failures.item()}."
    assert data.failures.item().endswith("; allow more, and 2 more")
    (row,) = [row for row in outputs.page.tables[0].rows if row[:2] == ("fem", "12 x 8")]
    assert row[-1] == why
    assert set(row[2:6]) == {""}
    assert data.area_own_error.sel(source="grid") > 0
    assert data.area_each.isnull().values.tolist() == [False, True, False]
    assert "surface 2" in data.failure_each.values[1]
    assert np.isnan(data.area)
    with pytest.raises(RunFailed, match="the report is of the others"):
        outputs.check()
    monkeypatch.undo()
    again = run_scene(load_scene(str(path)), tmp_path / "results", report=False)
    assert again.solved == 3
    assert "failures" not in again.data
    again.check()


def test_a_surface_from_a_file_runs(map_scene, tmp_path):
    x = np.arange(16) / 16
    waves = 30 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :]
    scene = map_scene(waves)
    outputs = run_scene(scene, tmp_path / "results", report=False)
    assert_allclose(outputs.data.rms_height, 15e-9, rtol=1e-12)
    assert "area_ensemble" not in outputs.data
    assert outputs.data.attrs["treatment"]
    # Grids of fewer than 17 points cannot hold what 16 samples may.
    assert outputs.data.resolved.values.tolist() == [0, 0, 1]
    assert any("Under-resolved" in text and "12 x 8" in text for text in outputs.page.findings)


def test_an_under_resolved_grid_presses_the_point_values_of_the_true_surface(read_scene):
    scene = read_scene((GRIDS, "grids = [6]\nunder_resolved = true"), fem=False)
    fine = height_field(scene.surface).resampled((24, 24))
    coarse = height_field(scene.surface, (6, 6)).heights
    assert_allclose(coarse, fine.heights[::4, ::4], atol=1e-12 * fine.rms_height)
    shifted = sampled(waves_of(scene.surface, 0), scene.surface, (6, 6), (0.25, 0.5)).heights
    assert_allclose(shifted, fine.heights[1::4, 2::4], atol=1e-12 * fine.rms_height)
