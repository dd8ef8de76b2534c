"""Studies read back: what is not computed again is listed."""

from __future__ import annotations

import json

import pytest
from small_scene import small_scene

from validation.audit import audit
from validation.scenes.scene import load_scene
from validation.solves.bench import Bench
from validation.studies import find_study
from validation.studies._outputs import run_study

_SCENE = small_scene()


@pytest.fixture
def folder(tmp_path):
    """A small study of its own surfaces, without a report."""
    made = tmp_path / "area"
    made.mkdir()
    study = find_study("area")
    options = study.options(grids=(16, 32, 48), reduced_pressures=(0.05, 0.3), surfaces=2, seed=61)
    run_study(study, options, made, bench=Bench.at(tmp_path / "solves"), report=False)
    return made


def test_numbers_of_solves_that_are_gone_are_listed_not_judged(folder):
    path = folder / "study.json"
    said = json.loads(path.read_text())
    path.write_text(json.dumps({**said, "store": "nowhere"}))
    ledger = audit(folder)
    assert ledger.wrong == ()
    assert "data.nc: area_each" in ledger.unread


def test_a_study_on_a_scene_is_computed_again_from_its_solves(tmp_path):
    (tmp_path / "mine.toml").write_text(_SCENE)
    study, folder = find_study("area"), tmp_path / "area"
    folder.mkdir()
    options = study.options(
        scene=load_scene(str(tmp_path / "mine.toml")), reduced_pressures=(0.1, 0.2), surfaces=2
    )
    run_study(study, options, folder, bench=Bench.at(tmp_path / "solves"), report=False)
    ledger = audit(folder)
    assert [str(entry) for entry in ledger.wrong] == []
    assert "data.nc: area_each" not in ledger.unread
