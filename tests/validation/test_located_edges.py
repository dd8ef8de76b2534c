"""Stored numbers that hold a located area are other ones where edges are located otherwise."""

import hashlib
import importlib
import inspect
import json
import pkgutil
import re
import sys

import validation.measures
import validation.studies
from fem_contact.area import EDGE_MAPS
from validation.solves.solve import LOCATED_EDGES, NumbersSolve


def _kinds(base=NumbersSolve):
    for kind in base.__subclasses__():
        yield kind
        yield from _kinds(kind)


def test_every_solve_that_keeps_a_located_area_says_how_edges_are_located():
    for place in (validation.measures, validation.studies):
        for module in pkgutil.walk_packages(place.__path__, place.__name__ + "."):
            importlib.import_module(module.name)
    kinds = {kind for kind in _kinds() if kind.__module__.startswith("validation.")}
    locating, silent = set(), set()
    for kind in kinds:
        text = inspect.getsource(sys.modules[kind.__module__])
        if not re.search(r"located_area\(|subcell=(True|located)", text):
            continue
        locating.add(kind.__name__)
        recipes = [vars(base)["recipe"].fget for base in kind.__mro__ if "recipe" in vars(base)]
        if not any("LOCATED_EDGES" in inspect.getsource(recipe) for recipe in recipes):
            silent.add(kind.__name__)
    assert len(locating) >= 11
    assert not silent


def test_the_mark_goes_with_the_edge_maps():
    maps = json.dumps({name: list(numbers) for name, numbers in EDGE_MAPS.items()}, sort_keys=True)
    # Where this fails, the maps were changed: give `LOCATED_EDGES` another text, too, and both to this test.
    found = LOCATED_EDGES, hashlib.sha256(maps.encode()).hexdigest()[:16]
    assert found == ("edges of second order, traits of contour and heights", "fa92ad0fc57e0ee5")
