"""No module imports itself by way of others, in functions and for annotations included."""

import ast
import importlib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from validation._renamed import _NEW

ROOT = Path(__file__).parents[1]
PACKAGES = ("persson", "fem_contact", "validation")


def imports():
    files = {}
    for path in (path for name in PACKAGES for path in (ROOT / name).rglob("*.py")):
        files[".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")] = path
    found: dict[str, set[str]] = {}
    for module, path in files.items():
        named = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                named |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                named |= {f"{node.module}.{alias.name}" for alias in node.names} & files.keys() or {
                    node.module
                }
        found[module] = {name for name in named if name in files and name != module}
    return found


def test_there_are_no_import_circles():
    graph = imports()
    assert sum(map(len, graph.values())) > 1000
    TopologicalSorter(graph).prepare()  # raises CycleError, which lists the circle


@pytest.mark.parametrize("old", _NEW)
def test_the_import_of_an_old_name_says_the_new_one(old):
    with pytest.raises(ModuleNotFoundError, match=f"^{old} is called {_NEW[old]}$"):
        importlib.import_module(old)
    assert importlib.import_module(_NEW[old])
