"""The public names of the two packages: each stands once, in the stub, and is imported when first asked."""

import subprocess
import sys

import pytest

import fem_contact
import persson

PROBE = """
import sys, {package}
dir({package})
heavy = {{"numpy", "numba", "scipy", "skfem", "pyamg", "pyvista"}}
print(*(name for name in sys.modules if name.split(".")[0] in heavy))
"""

both = pytest.mark.parametrize("package", [fem_contact, persson], ids=lambda package: package.__name__)


@both
def test_every_public_name_is_there_and_listed(package):
    for name in package.__all__:
        value = getattr(package, name)
        assert getattr(value, "__name__", name).rpartition(".")[2] == name
    assert set(package.__all__) <= set(dir(package))


@both
def test_importing_and_listing_the_package_loads_nothing_heavy(package):
    code = PROBE.format(package=package.__name__)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == []


@both
def test_an_unknown_name_is_an_attribute_error(package):
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = package.no_such_thing


def test_the_old_name_of_pressing_a_solid_that_yields_says_the_new_one():
    with pytest.raises(AttributeError, match=r"fem_contact\.press_yielding"):
        _ = fem_contact.press


@pytest.mark.parametrize(
    ("line", "new"),
    [
        ("import validation.methods.tamaas", "validation.solvers"),
        ("from validation.solves.bench import Bench", "validation.execution"),
        ("from validation.measures import common", "validation.measurements"),
        ("from validation.scenes.realised import realise", "validation.scenes.problem"),
        ("from validation.effects.base import Slots", "called ContactModel"),
        ("from validation.effects.base import Told", "called TheoryInputs"),
    ],
)
def test_an_import_by_an_old_name_says_the_new_one(line, new):
    with pytest.raises(ImportError, match=new):
        exec(line)
