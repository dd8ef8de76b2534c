"""Running scenes: results on disk, resumed after a kill, refused before anything is computed."""

from __future__ import annotations

import base64
import csv
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time

import meshio
import numpy as np
import pytest
import xarray as xr

from validation.comparison.run import run_scene
from validation.errors import RunFailed, UsageError
from validation.files import prepare_folder
from validation.report.words import mathematics
from validation.scenes.scene import load_scene
from validation.scenes.surfaces import height_field, reference_field
from validation.solves.press import Press, solves_of
from validation.solves.running import solve_all
from validation.solves.store import Store


def test_a_run_leaves_table_fields_block_and_report(small_run):
    names = {path.name for path in small_run.files}
    assert {"report.html", "table.csv", "summary.json"} <= names
    assert all(path.exists() for path in small_run.files)
    with (small_run.folder / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["method"], row["grid"]) for row in rows] == [
        ("bem", "12x12"),
        ("bem", "24x24"),
        ("bem", "48x48"),
        ("fem", "12x12"),
        ("fem", "24x24"),
    ]
    summary = json.loads((small_run.folder / "summary.json").read_text())
    assert summary["findings"] == list(small_run.comparison.findings)


def test_stored_fields_are_standard_netcdf_with_units(small_run):
    scene = small_run.comparison.scene
    solve = solves_of(scene)[-1]
    with xr.open_dataset(small_run.folder / "solves" / f"{solve.key}.nc") as data:
        assert {"pressure", "gap", "displacement", "contacting_points"} <= set(data.data_vars)
        assert data.pressure.attrs["units"] == "Pa"
        assert data.gap.attrs["units"] == "m"
        np.testing.assert_allclose(float(data.pressure.mean()), small_run.comparison.pressure, rtol=1e-9)


def test_the_deformed_block_is_a_vtu_with_stress(small_run):
    (path, *_) = [path for path in small_run.files if path.suffix == ".vtu"]
    block = meshio.read(path)
    assert any("stress" in name.lower() for name in block.cell_data)
    assert block.cells[0].type == "hexahedron"


def test_running_again_repeats_nothing_and_finds_the_same(small_run, tmp_path):
    again = run_scene(small_run.comparison.scene, small_run.folder)
    assert again.solved == 0
    assert again.reused == small_run.solved
    assert repr(again.comparison.rows) == repr(small_run.comparison.rows)


def test_a_plain_run_leaves_nothing_of_an_earlier_run_to_an_accuracy(small_run, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.comparison.report._drawings", lambda *a: ())
    (tmp_path / "accuracy.json").write_text("{}")
    run_scene(small_run.comparison.scene, tmp_path, store_folder=small_run.folder / "solves")
    assert (tmp_path / "report.html").exists()
    assert not (tmp_path / "accuracy.json").exists()


def test_pixel_area_averaged_over_shifts_decreases_with_refinement(small_run):
    pixel = [row.pixel for row in small_run.comparison.rows_of("bem")]
    assert all(row.solves == 4 for row in small_run.comparison.rows_of("bem"))
    assert pixel == sorted(pixel, reverse=True)
    assert pixel[-1] > small_run.comparison.limit.value


def test_finite_and_boundary_elements_approach_each_other(small_run):
    coarse, fine = small_run.comparison.cross
    assert fine.pressure < coarse.pressure
    assert abs(fine.pixel) < abs(coarse.pixel)


def test_the_report_holds_five_figures_the_findings_and_one_script_that_its_policy_names(small_run):
    page = (small_run.folder / "report.html").read_text()
    assert page.count("<svg") == 5
    for finding in small_run.comparison.findings:
        assert mathematics(finding) in page
    assert "default-src 'none'" in page
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in page


def test_an_option_recomputes_only_what_it_affects(write_scene):
    base = {solve.key for solve in solves_of(load_scene(str(write_scene())))}
    finer = {
        solve.key
        for solve in solves_of(load_scene(str(write_scene(("grids = [12, 24]", "grids = [12, 24, 32]")))))
    }
    stiffer = {
        solve.key for solve in solves_of(load_scene(str(write_scene(("poisson = 0.3", "poisson = 0.4")))))
    }
    growth = {
        solve.key for solve in solves_of(load_scene(str(write_scene(("depth =", "growth = 1.3\ndepth =")))))
    }
    assert base < finer
    assert not base & stiffer
    assert {key for key in base if key.startswith("bem")} == {key for key in growth if key.startswith("bem")}
    assert not {key for key in base if key.startswith("fem")} & growth


def test_a_stored_result_is_read_back_bit_for_bit(write_scene, tmp_path):
    solve = solves_of(load_scene(str(write_scene(fem=False))))[0]
    store = Store(folder=prepare_folder(tmp_path / "store"))
    solved = solve.do()
    store.save(solve, solved)
    result, found = solved.contact, store.load(solve)
    for name in ("pressure", "gap", "displacement", "heights", "in_contact"):
        np.testing.assert_array_equal(getattr(found, name), getattr(result, name))
    assert (found.offset, found.residuals, found.cost, found.status) == (
        result.offset,
        result.residuals,
        result.cost,
        result.status,
    )


@pytest.mark.parametrize("damage", ["truncate", "flip"])
def test_a_damaged_file_is_set_aside_and_recomputed(write_scene, tmp_path, damage):
    solves = solves_of(load_scene(str(write_scene(fem=False))))[:2]
    store = Store(folder=prepare_folder(tmp_path / "store"))
    solve_all(solves, store)
    path = store.path(solves[1])
    content = bytearray(path.read_bytes())
    if damage == "truncate":
        content = content[: len(content) // 2]
    else:
        content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    intact = store.load(solves[1]) is not None
    # A flipped byte may fall into padding, which carries nothing; a truncated file is always noticed.
    assert not (intact and damage == "truncate")
    if not intact:
        assert path.with_suffix(".nc.corrupt").exists()
        assert solve_all(solves, store).solved == 1


def test_every_flipped_byte_of_the_fields_is_noticed(write_scene, tmp_path):
    solve = solves_of(load_scene(str(write_scene(fem=False))))[0]
    store = Store(folder=prepare_folder(tmp_path / "store"))
    solve_all((solve,), store)
    path = store.path(solve)
    content, truth = path.read_bytes(), store.load(solve)
    wrong = 0
    for position in np.random.default_rng(9).integers(0, len(content), 60):
        damaged = bytearray(content)
        damaged[position] ^= 0x10
        path.write_bytes(damaged)
        found = store.load(solve)
        if found is not None:
            wrong += not np.array_equal(found.pressure, truth.pressure) or not np.array_equal(
                found.gap, truth.gap
            )
    assert wrong == 0


def test_a_killed_run_continues_after_its_finished_solves(write_scene, tmp_path):
    path = write_scene(("grids = [12, 24, 48]", "grids = [12, 24, 48, 384, 512]"), fem=False)
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
    finished = [solve for solve in solves if store.holds(solve)]
    assert 3 <= len(finished) < len(solves)
    small = tuple(solve for solve in solves if solve.grid[0] < 100)
    times = {solve.key: store.path(solve).stat().st_mtime_ns for solve in finished}
    assert solve_all(small, store).solved == len(small) - len([solve for solve in finished if solve in small])
    assert times == {solve.key: store.path(solve).stat().st_mtime_ns for solve in finished}


def test_ctrl_c_keeps_what_is_finished_and_leaves_no_drafts(write_scene, tmp_path, monkeypatch):
    scene = load_scene(str(write_scene(fem=False)))
    done = []

    do = Press.do

    def interrupted(solve, threads=None):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(solve)
        return do(solve, threads=threads)

    monkeypatch.setattr(Press, "do", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_scene(scene, tmp_path / "results")
    names = sorted(path.name for path in (tmp_path / "results" / "solves").iterdir())
    assert names == sorted(f"{solve.key}.nc" for solve in done)


def test_an_output_folder_that_cannot_be_written_is_refused_before_computing(
    write_scene, tmp_path, monkeypatch
):
    monkeypatch.setattr(Press, "do", lambda solve, threads=None: pytest.fail("computed"))
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    with pytest.raises(UsageError, match=r"--output = .*cannot be written to"):
        run_scene(load_scene(str(write_scene())), blocker / "results")


def test_an_effect_no_method_handles_is_refused_before_computing(write_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(Press, "do", lambda solve, threads=None: pytest.fail("computed"))
    path = write_scene(("[solid]", '[[effects]]\nkind = "thickness"\nthickness = "5 um"\n\n[solid]'))
    with pytest.raises(
        UsageError, match=r"\[\[effects\]\] 1 kind = 'thickness': method 'theory' does not handle it"
    ):
        run_scene(load_scene(str(path)), tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_an_incompressible_solid_is_refused_for_elements_that_lock(write_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(Press, "do", lambda solve, threads=None: pytest.fail("computed"))
    path = write_scene(("poisson = 0.3", "poisson = 0.5"))
    with pytest.raises(UsageError, match=r"solid\.poisson = 0\.5: method 'fem' locks above 0\.49"):
        run_scene(load_scene(str(path)), tmp_path / "results")


def test_a_failed_solve_names_itself_and_keeps_the_others(write_scene, tmp_path):
    path = write_scene(("shifts = 2", "shifts = 1\ntolerance = 1e-300"), fem=False)
    with pytest.raises(RunFailed, match="BEM 12x12"):
        run_scene(load_scene(str(path)), tmp_path / "results")


def _file_scene(write_scene, tmp_path, heights):
    np.save(tmp_path / "heights.npy", heights)
    head = (
        'kind = "self-affine"\nlength = "10 um"\nhurst = 0.7\nlambda_long = "5 um"\nlambda_short = "2.5 um"\n'
    )
    return write_scene(
        (
            head + "rms_gradient = 0.05\nseed = 77",
            'kind = "file"\npath = "heights.npy"\nlength = "10 um"\nunit = "1 nm"',
        ),
        fem=False,
    )


def test_a_surface_from_a_file_runs(write_scene, tmp_path):
    x = np.arange(16) / 16
    waves = 30 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :]
    scene = load_scene(str(_file_scene(write_scene, tmp_path, waves)))
    outputs = run_scene(scene, tmp_path / "results")
    assert outputs.comparison.rms_height == pytest.approx(15e-9, rel=1e-12)
    assert outputs.comparison.theory.ensemble_area is None
    # The grid of 12 cannot hold what 16 samples may: nobody asked for that.
    (said,) = [text for text in outputs.comparison.findings if "Under-resolved" in text]
    assert "the measured heights may hold waves down to two of their own samples" in said
    assert "because the scene" not in said


def test_nan_in_a_surface_file_is_refused_before_computing(write_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(Press, "do", lambda solve, threads=None: pytest.fail("computed"))
    heights = np.zeros((16, 16))
    heights[3, 4] = np.nan
    scene = load_scene(str(_file_scene(write_scene, tmp_path, heights)))
    with pytest.raises(UsageError, match=r"surface\.path = .*heights\.npy.*1 of 256 heights are NaN"):
        run_scene(scene, tmp_path / "results")


def test_a_missing_surface_file_is_refused(write_scene, tmp_path):
    path = _file_scene(write_scene, tmp_path, np.zeros((8, 8)))
    (tmp_path / "heights.npy").unlink()
    with pytest.raises(UsageError, match=r"surface\.path = .*cannot be read"):
        run_scene(load_scene(str(path)), tmp_path / "results")


def test_an_under_resolved_grid_presses_the_point_values_of_the_true_surface(write_scene):
    scene = load_scene(
        str(write_scene(("grids = [12, 24, 48]", "grids = [6]\nunder_resolved = true"), fem=False))
    )
    fine = reference_field(scene.surface).resampled((24, 24))
    np.testing.assert_allclose(
        height_field(scene.surface, (6, 6)).heights, fine.heights[::4, ::4], atol=1e-12 * fine.rms_height
    )
    shifted = height_field(scene.surface, (6, 6), shift=(0.25, 0.5)).heights
    np.testing.assert_allclose(shifted, fine.heights[1::4, 2::4], atol=1e-12 * fine.rms_height)
