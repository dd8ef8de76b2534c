"""One datum is made once: surfaces drawn, files read, results read."""

import collections
import importlib

import numpy as np
import pytest

from validation.comparison.run import run_scene
from validation.execution.store import Store
from validation.scenes import surfaces


@pytest.fixture
def counted(monkeypatch):
    calls = collections.Counter()

    def count(place, name):
        inner = getattr(place, name)

        def counting(*arguments, **options):
            calls[name] += 1
            return inner(*arguments, **options)

        monkeypatch.setattr(place, name, counting)
        return calls

    return count


def test_a_scene_of_many_solves_draws_its_random_surface_once(read_scene, tmp_path, counted):
    calls = counted(surfaces, "random_waves")
    outputs = run_scene(read_scene(), tmp_path / "results", report=False)
    assert outputs.solved == 14
    assert calls["random_waves"] == 1


def test_a_stored_result_is_read_once_in_a_run(read_scene, tmp_path, counted):
    scene = read_scene(fem=False)
    first = run_scene(scene, tmp_path / "results", report=False)
    calls = counted(Store, "read")
    second = run_scene(scene, tmp_path / "results")
    assert (first.solved, second.solved, second.reused) == (12, 0, 12)
    assert calls["read"] == 12


def test_a_measured_file_is_read_and_hashed_once_in_a_run(map_scene, tmp_path, counted):
    x = np.cos(2 * np.pi * np.arange(16) / 16)
    scene = map_scene(30 * x[:, None] * x[None, :])
    calls = counted(importlib.import_module("validation.scenes.topography.measured"), "read_topography")
    outputs = run_scene(scene, tmp_path / "results", report=False)
    assert outputs.solved > 4
    assert calls["read_topography"] == 1
