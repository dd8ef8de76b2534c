import importlib
import subprocess
import sys

import fem_contact

PROBE = """
import sys, fem_contact
dir(fem_contact)
heavy = {"numpy", "numba", "scipy", "skfem", "pyamg", "pyvista"}
print(*(name for name in sys.modules if name.split(".")[0] in heavy))
"""


def test_every_public_name_is_what_its_home_defines():
    for name in fem_contact.__all__:
        value = getattr(fem_contact, name)
        home = fem_contact._HOMES.get(name)
        assert value is (
            getattr(importlib.import_module(home), name)
            if home
            else importlib.import_module(f"fem_contact.{name}")
        )


def test_dir_lists_every_public_name():
    assert set(fem_contact.__all__) <= set(dir(fem_contact))


def test_an_unknown_name_is_an_attribute_error():
    assert not hasattr(fem_contact, "random_surfaces")


def test_importing_and_listing_the_package_loads_nothing_heavy():
    done = subprocess.run(
        [sys.executable, "-c", PROBE], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == []
