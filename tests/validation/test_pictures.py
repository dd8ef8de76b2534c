"""3-D pictures: where rendering fails there is a word, not a crash and not half a file."""

from __future__ import annotations

import subprocess

from validation.comparison import pictures


def test_a_renderer_that_dies_leaves_a_word_and_no_file(tmp_path, monkeypatch):
    def died(command, **options):
        return subprocess.CompletedProcess(command, -11, "", "libGL.so.1: cannot open shared object file")

    monkeypatch.setattr(pictures.subprocess, "run", died)
    picture, missing = pictures.render_stored(tmp_path / "solve.nc", label="BEM 8 x 8")
    assert picture is None
    assert "libGL.so.1" in missing
    assert list(tmp_path.iterdir()) == []


def test_a_renderer_that_hangs_is_given_up(tmp_path, monkeypatch):
    def hang(command, **options):
        raise subprocess.TimeoutExpired(command, options["timeout"])

    monkeypatch.setattr(pictures.subprocess, "run", hang)
    picture, missing = pictures.render_stored(tmp_path / "solve.nc", label="BEM 8 x 8")
    assert picture is None
    assert "took more than" in missing
    assert list(tmp_path.iterdir()) == []


def test_what_is_rendered_is_the_stored_contact(small_run, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(
        "fem_contact.export.render_surface", lambda path, solution: drawn.append((path, solution))
    )
    (stored,) = (small_run.folder / "solves").glob("fem-24x24-*.nc")
    monkeypatch.setattr(pictures.sys, "argv", ["-c", str(stored), str(tmp_path / "surface.png")])
    pictures._main()
    ((path, solution),) = drawn
    assert path == tmp_path / "surface.png"
    assert solution.pressure.shape == (24, 24)


def test_a_run_renders_nothing_that_nobody_asked_for(small_run):
    assert small_run.page.pictures == ()


def test_a_stored_solve_becomes_a_picture_wherever_a_renderer_lives(small_run):
    stored = next((small_run.folder / "solves").glob("bem-24x24-*.nc"))
    picture, missing = pictures.render_stored(stored, label="BEM 24 x 24")
    # Without a graphics library the process dies; a mistake of ours has the name of an exception.
    assert "Error" not in missing
    assert "InvalidInput" not in missing
    assert picture is None or picture.png.startswith(b"\x89PNG")
