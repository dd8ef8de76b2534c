"""One datum is made once: surfaces drawn, files read, results read."""

import collections
import importlib

import numpy as np
import pytest

from validation.comparison.run import run_scene
from validation.execution.store import Store
from validation.scenes import surfaces
from validation.scenes.scene import load_scene


@pytest.fixture
def counted(monkeypatch):
    """Count the calls of a function of a module, by name."""
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


def test_a_measured_file_is_read_and_hashed_once_in_a_run(write_scene, tmp_path, counted):
    x = np.cos(2 * np.pi * np.arange(16) / 16)
    np.save(tmp_path / "heights.npy", 30 * x[:, None] * x[None, :])
    head = (
        'kind = "self-affine"\nlength = "10 um"\nhurst = 0.7\nlambda_long = "5 um"\nlambda_short = "2.5 um"\n'
    )
    path = write_scene(
        (
            head + "rms_gradient = 0.05\nseed = 77",
            'kind = "file"\npath = "heights.npy"\nlength = "10 um"\nunit = "1 nm"',
        ),
        fem=False,
    )
    scene = load_scene(str(path))
    calls = counted(importlib.import_module("validation.scenes.topography.measured"), "read_topography")
    outputs = run_scene(scene, tmp_path / "results", report=False)
    assert outputs.solved > 4
    assert calls["read_topography"] == 1
