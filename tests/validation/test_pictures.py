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
