"""A small scene for the tests of the comparison: seconds, but every part of a real one."""

import pickle

import pytest
from gold.asked import STUDIES
from gold.make import new_numbers
from small_scene import small_scene

from validation.comparison.run import run_scene
from validation.execution.bench import Bench
from validation.files import atomic_path
from validation.scenes.scene import load_scene
from validation.studies import find_study

_HEAD = 'name = "small"\ntitle = "A small scene"\n' + small_scene(
    "shifts = 2\n\n[methods.theory]\n", grids="[12, 24, 48]"
)
_FEM = """
[methods.fem]
grids = [12, 24]
depth = "5 um"
"""


def _written(folder, *replacements, fem=True):
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

    def write(*replacements, fem=True):
        return _written(tmp_path, *replacements, fem=fem)

    return write


@pytest.fixture
def read_scene(write_scene):
    """Read the small scene with pieces of its text replaced."""
    return lambda *replacements, fem=True: load_scene(str(write_scene(*replacements, fem=fem)))


@pytest.fixture(scope="session")
def bench(tmp_path_factory, worker_id):
    """One store of this session, which all its processes share: what one test solves, no other does."""
    folder = tmp_path_factory.getbasetemp()
    return Bench.at((folder if worker_id == "master" else folder.parent) / "solves")


@pytest.fixture(scope="session")
def numbers(bench, tmp_path_factory):
    """Numbers of a study as its gold file asks for them, by name: computed once for all processes."""

    def known(name):
        path = bench.store.folder.parent / f"{name}.pickle"
        if not path.exists():
            data = new_numbers(name, bench, tmp_path_factory.mktemp("asked"))
            with atomic_path(path) as draft:
                draft.write_bytes(pickle.dumps(data))
        return pickle.loads(path.read_bytes())

    return known


@pytest.fixture(scope="session")
def asked(numbers):
    """Options and numbers of a study as its gold file asks for them, by name."""
    return lambda name: (find_study(name).options(**STUDIES[name]), numbers(name))


@pytest.fixture(scope="session")
def small_run(tmp_path_factory):
    """The small scene, run once."""
    folder = tmp_path_factory.mktemp("small")
    return run_scene(load_scene(str(_written(folder))), folder / "results")
