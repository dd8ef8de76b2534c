"""A small scene for the tests of the comparison: seconds, but every part of a real one."""

from __future__ import annotations

from pathlib import Path

import pytest

from validation.comparison.run import Outputs, run_scene
from validation.scenes.scene import load_scene

_HEAD = """
name = "small"
title = "A small scene"

[surface]
kind = "self-affine"
length = "10 um"
hurst = 0.7
lambda_long = "5 um"
lambda_short = "2.5 um"
rms_gradient = 0.05
seed = 77

[solid]
young = "2 MPa"
poisson = 0.3

[load]
reduced_pressure = 0.1

[methods.theory]

[methods.bem]
grids = [12, 24, 48]
shifts = 2
"""
_FEM = """
[methods.fem]
grids = [12, 24]
depth = "5 um"
"""


def _written(folder: Path, *replacements: tuple[str, str], fem: bool = True) -> Path:
    text = _HEAD + (_FEM if fem else "")
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "scene.toml"
    path.write_text(text)
    return path


@pytest.fixture
def write_scene(tmp_path):
    """Write the small scene with pieces of its text replaced; `fem=False` leaves the finite elements out."""

    def write(*replacements: tuple[str, str], fem: bool = True) -> Path:
        return _written(tmp_path, *replacements, fem=fem)

    return write


@pytest.fixture(scope="session")
def small_run(tmp_path_factory) -> Outputs:
    """The small scene, run once."""
    folder = tmp_path_factory.mktemp("small")
    return run_scene(load_scene(str(_written(folder))), folder / "results")
