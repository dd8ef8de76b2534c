"""3-D pictures: where rendering fails there is a word, not a crash and not half a file."""

import shutil

import pytest
from small_scene import scene_of

from validation.comparison import run
from validation.execution.results import read_results
from validation.report.page import Picture
from validation.sandbox import OutOfBounds


@pytest.mark.parametrize("words", ["crashed its process (SIGSEGV)", "took more than 120 s"])
def test_a_renderer_that_dies_or_hangs_leaves_a_word_and_no_file(tmp_path, monkeypatch, words):
    def ends(worker, *_, **bounds):
        worker._stderr.write(b"libGL.so.1: cannot open shared object file\n")
        raise OutOfBounds(words)

    monkeypatch.setattr(run.Child, "call", ends)
    picture, missing = run.render_stored(tmp_path / "solve.nc", label="BEM 8 x 8")
    assert picture is None
    assert words in missing
    assert "libGL.so.1" in missing
    assert list(tmp_path.iterdir()) == []


def test_what_is_rendered_is_the_stored_contact(small_run, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("fem_contact.export.render_surface", lambda *drawing: drawn.append(drawing))
    (stored,) = (small_run.folder / "solves").glob("fem-24x16-*.nc")
    run._render(stored, tmp_path / "surface.png")
    ((path, solution),) = drawn
    assert path == tmp_path / "surface.png"
    assert solution.pressure.shape == (24, 16)


def test_a_run_renders_what_was_asked_for_of_its_finest_finite_elements(small_run, monkeypatch):
    assert small_run.page.pictures == ()
    picture = Picture(name="surface", caption="", png=b"")
    monkeypatch.setattr(run, "render_stored", lambda path, label: (picture, f"{label} in {path.stem}"))
    result = read_results(small_run.folder)
    page = run.result_page(result, figures=True, pictures=True)
    (finest,) = (small_run.folder / "solves").glob("fem-24x16-*.nc")
    assert (page.pictures, page.no_picture) == ((picture,), f"fem on 24 x 16 in {finest.stem}")
    assert run.result_page(result, figures=True).pictures == ()


def test_the_same_run_with_pictures_and_without_has_them_and_has_none(small_run, tmp_path, monkeypatch):
    picture = Picture(name="surface", caption="", png=b"x")
    monkeypatch.setattr(run, "render_stored", lambda *_, **__: (picture, ""))
    shutil.copytree(small_run.folder, tmp_path / "out")
    for pictures in (False, True, False):
        run.run_scene(scene_of(small_run), tmp_path / "out", pictures=pictures)
        assert (tmp_path / "out/figures/surface.png").exists() == pictures


def test_a_stored_solve_becomes_a_picture_wherever_a_renderer_lives(small_run):
    stored = next((small_run.folder / "solves").glob("bem-24x16-*.nc"))
    picture, missing = run.render_stored(stored, label="BEM 24 x 16")
    # Without a graphics library the process dies; a mistake of ours has the name of an exception.
    assert "Error" not in missing
    assert "InvalidInput" not in missing
    assert picture is None or picture.png.startswith(b"\x89PNG")
