"""A small scene for the tests of the comparison: seconds, but every part of a real one."""

import pickle
from unittest.mock import patch

import numpy as np
import pytest
from gold.asked import STUDIES
from gold.make import leave_study, new_numbers
from small_scene import GRIDS, ensemble, small_scene

from validation.comparison.run import run_scene
from validation.execution.bench import Bench
from validation.files import locked, prepare_folder
from validation.report import figure
from validation.scenes.scene import load_scene
from validation.studies import find_study

_HEAD = 'name = "small"\ntitle = "A small scene"\n' + small_scene(
    "shifts = 2\n\n[methods.theory]\n", grids=GRIDS.removeprefix("grids = ")
)
_FEM = """
[methods.fem]
grids = [[12, 8], [24, 16]]
depth = "5 um"
"""


def _written(folder, *changes, fem=True):
    text = _HEAD + (_FEM if fem else "")
    for change in changes:
        if isinstance(change, str):
            text += f"\n{change}"
            continue
        old, new = change
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "scene.toml"
    path.write_text(text)
    return path


#: Where what a figure looks like is tested. Elsewhere its file is there without a drawing, which takes long.
_DRAWN = ("facade", "gallery", "page", "pictures", "report_in_browser", "reproduce")


@pytest.fixture(autouse=True, scope="module")
def _figures(request):
    if request.module.__name__.split(".")[-1].removeprefix("test_") in _DRAWN:
        yield
        return
    with patch.object(figure, "save_figure", lambda drawn, path: path.write_text("<svg></svg>")):
        yield


@pytest.fixture
def write_scene(tmp_path):
    """Write the small scene with pieces of its text replaced, and tables added; `fem=False`: without fem."""
    return lambda *changes, fem=True: _written(tmp_path, *changes, fem=fem)


@pytest.fixture
def read_scene(write_scene):
    """Read the small scene so changed."""
    return lambda *changes, fem=True: load_scene(str(write_scene(*changes, fem=fem)))


@pytest.fixture
def solved(read_scene, tmp_path, bench):
    """Run the small scene of boundary elements so changed, without a report."""
    asked = {"bench": bench, "report": False}
    return lambda *changes: run_scene(read_scene(*changes, fem=False), tmp_path / "results", **asked)


@pytest.fixture
def map_scene(read_scene, tmp_path):
    """Read the small scene with a map of heights [nm] in place of its waves."""

    def read(heights):
        np.save(tmp_path / "heights.npy", heights)
        waves = 'kind = "self-affine"\nlength = ["10 um", "5 um"]\nhurst = 0.7\nlambda_long = "5 um"\n'
        waves += 'lambda_short = "2.5 um"\nrms_gradient = 0.05\nseed = 77'
        file = 'kind = "file"\npath = "heights.npy"\nlength = "10 um"\nunit = "1 nm"'
        return read_scene((waves, file), fem=False)

    return read


@pytest.fixture(scope="session")
def bench(tmp_path_factory, worker_id):
    """One store of this session, which all its processes share: what one test solves, no other does."""
    folder = tmp_path_factory.getbasetemp()
    return Bench.at((folder if worker_id == "master" else folder.parent) / "solves")


@pytest.fixture(scope="session")
def once(bench):
    """What a function makes, by name: once for all processes of this session."""

    def known(name, make):
        place = bench.store.folder.parent / name
        place.mkdir(exist_ok=True)
        path = place / "made.pickle"
        with locked(place):
            if not path.exists():
                path.write_bytes(pickle.dumps(make()))
        return pickle.loads(path.read_bytes())

    return known


@pytest.fixture(scope="session")
def numbers(once, bench, tmp_path_factory):
    """Numbers of a study as its gold file asks for them, by name."""
    return lambda name: once(name, lambda: new_numbers(name, bench, tmp_path_factory.mktemp("asked")))


@pytest.fixture(scope="session")
def asked(numbers):
    """Options and numbers of a study as its gold file asks for them, by name."""
    return lambda name: (find_study(name).options(**STUDIES[name]), numbers(name))


@pytest.fixture(scope="session")
def left(numbers, bench):
    """Leave in a folder what a study makes of its gold numbers; without a report their data alone."""

    def leave(name, folder, *, report=True):
        return leave_study(name, numbers(name), prepare_folder(folder), bench=bench, report=report)

    return leave


@pytest.fixture(scope="session")
def small_run(once, tmp_path_factory):
    """The small scene, run once."""
    folder = tmp_path_factory.mktemp("small")
    return once("small run", lambda: run_scene(load_scene(str(_written(folder))), folder / "results"))


@pytest.fixture(scope="session")
def ensemble_run(once, tmp_path_factory):
    """The small scene of boundary elements on three surfaces, run once without a report."""
    folder = tmp_path_factory.mktemp("ensemble")
    scene = load_scene(str(_written(folder, ensemble(3), fem=False)))
    return once("ensemble run", lambda: run_scene(scene, folder / "results", report=False))
