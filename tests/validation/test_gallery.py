"""The gallery: its pictures are those that its command makes, and they are small."""

import importlib.util
import re
from pathlib import Path

import pytest
from matplotlib.image import imread

from validation.studies import studies

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"


@pytest.fixture
def make():
    """The script docs/gallery/make.py as a module."""
    spec = importlib.util.spec_from_file_location("gallery_make", GALLERY / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_gallery_shows_what_its_command_makes_and_stays_small(make):
    page = (GALLERY / "README.md").read_text(encoding="utf-8")
    shown = {f"{name}.png" for names in make.SHOWN.values() for name in names}
    assert set(re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)) == shown
    assert {path.name for path in GALLERY.iterdir()} >= shown
    assert set(make.SHOWN) <= set(studies())
    pictures = [path for path in GALLERY.iterdir() if path.suffix in (".png", ".svg")]
    assert sum(path.stat().st_size for path in pictures) < 25_000 * len(pictures)


def test_the_gallery_is_drawn_again_from_the_datasets_that_are_there(
    make, left, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(make, "SHOWN", {"area": ("kappa",)})
    left("area", tmp_path / "results" / "area")
    make.main(["area", "--redraw", "--output", str(tmp_path)])
    assert imread(tmp_path / "kappa.png").shape[1] > 300
    assert "kappa.png" in capsys.readouterr().out


def test_the_reference_of_the_gallery_is_drawn_from_the_table_that_is_shipped(make, tmp_path, capsys):
    make.main(["reference", "--output", str(tmp_path)])
    assert {path.stem for path in tmp_path.iterdir()} == set(make.SHOWN["reference"])
    assert capsys.readouterr().out.count(".png") == 3
