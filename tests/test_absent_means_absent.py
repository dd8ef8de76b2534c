"""What a scene does not list costs nothing: no module, no transform, no array."""

import importlib.util
import json
from pathlib import Path

import pytest
from processes import run_python

PROBE = Path(__file__).with_name("absent_probe.py")

#: Modules that only an effect, or the theory of one, may load.
EFFECT_MODULES = {
    "fem_contact.adhesion",
    "fem_contact.adhesion.path",
    "fem_contact.adhesion.descent",
    "fem_contact.adhesion.laws",
    "fem_contact.hardness",
    "fem_contact.graded",
    "persson.adhesion",
    "persson.diffusion",
    "persson.graded",
    "persson.hardness",
    "validation.execution.calibration",
}

#: The probe's plain scene on commit d5147c4, before any effect was wired to a scene: transforms of all grids,
#: peak memory in arrays of the finest grid.
BASELINE = {"transforms": 37, "arrays": 13.008}


def probe(*effects):
    done = run_python(PROBE, json.dumps(list(effects)), OMP_NUM_THREADS="1", NUMBA_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def plain():
    return probe()


def test_the_modules_watched_exist():
    assert all(importlib.util.find_spec(name) for name in EFFECT_MODULES)


def test_a_plain_scene_imports_no_effect(plain):
    assert EFFECT_MODULES.isdisjoint(plain["modules"])


def test_a_plain_scene_spends_no_transform_more_than_before_effects_existed(plain):
    assert plain["transforms"] <= BASELINE["transforms"]


def test_a_plain_scene_allocates_no_array_more_than_before_effects_existed(plain):
    # Python's own objects and imports shift the peak by less than a quarter of an array.
    assert plain["arrays"] <= BASELINE["arrays"] + 0.25


def test_a_listed_effect_is_seen_by_the_same_probe(plain):
    hard = probe({"kind": "hardness", "hardness": 2e7})
    assert "fem_contact.hardness" in hard["modules"]
    assert hard["arrays"] > plain["arrays"] + 0.5
    assert hard["area"] > plain["area"]
