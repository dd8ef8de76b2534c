"""Stored numbers that hold a located area are other ones where edges are located otherwise."""

import hashlib
import importlib
import inspect
import json
import pkgutil
import re
import sys

import validation.measurements
import validation.studies
from fem_contact.area import EDGE_MAPS
from validation.execution.measurement import Measurement
from validation.execution.solve import LOCATED_EDGES


def test_every_solve_that_keeps_a_located_area_says_how_edges_are_located():
    for place in (validation.measurements, validation.studies):
        for module in pkgutil.walk_packages(place.__path__, place.__name__ + "."):
            importlib.import_module(module.name)
    modules = [module for name, module in sys.modules.items() if name.startswith("validation.")]
    kinds = {one.kind: one for m in modules for one in vars(m).values() if isinstance(one, Measurement)}
    text = {kind: inspect.getsource(sys.modules[one.__module__]) for kind, one in kinds.items()}
    located = re.compile(r"(located_area|areas_of_solve|press_on_grids)\(|subcell=(True|not|located)")
    locating = {kind for kind in kinds if located.search(text[kind])}
    recipes = {kind: inspect.getsource(one.recipe) if one.recipe else "" for kind, one in kinds.items()}
    told = {kind for kind, one in kinds.items() if one.located or "LOCATED_EDGES" in recipes[kind]}
    assert len(locating) >= 10
    assert locating <= told


def test_the_mark_goes_with_the_edge_maps():
    maps = json.dumps({name: list(numbers) for name, numbers in EDGE_MAPS.items()}, sort_keys=True)
    # Where this fails, the maps were changed: give `LOCATED_EDGES` another text, too, and both to this test.
    found = LOCATED_EDGES, hashlib.sha256(maps.encode()).hexdigest()[:16]
    assert found == ("edges of second order, traits of contour and heights", "fa92ad0fc57e0ee5")
