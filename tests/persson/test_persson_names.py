import importlib
import subprocess
import sys

import persson

PROBE = """
import sys, persson
dir(persson)
heavy = {"numpy", "numba", "scipy", "skfem", "pyamg", "pyvista"}
print(*(name for name in sys.modules if name.split(".")[0] in heavy))
"""


def test_every_public_name_is_what_its_home_defines():
    for name in persson.__all__:
        value = getattr(persson, name)
        home = persson._HOMES.get(name)
        assert value is (
            getattr(importlib.import_module(home), name)
            if home
            else importlib.import_module(f"persson.{name}")
        )


def test_dir_lists_every_public_name():
    assert set(persson.__all__) <= set(dir(persson))


def test_an_unknown_name_is_an_attribute_error():
    assert not hasattr(persson, "contact_areas")


def test_importing_and_listing_the_package_loads_nothing_heavy():
    done = subprocess.run(
        [sys.executable, "-c", PROBE], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == []
