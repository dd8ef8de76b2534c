"""What is taken where nothing is said, and what may be said: a user's old call does today what it did.

``python tests/validation/test_defaults.py`` writes gold/defaults.json again, where a change is meant.
"""

import importlib
import inspect
import json
import pkgutil
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Annotated, get_origin

import pytest
import typer
from gold import write_lines
from pydantic import BaseModel, TypeAdapter

import fem_contact as fc
import persson
import validation
from validation import notebook, units
from validation.cli import app
from validation.effects import effect_kinds
from validation.effects.hardness import Hardness
from validation.measurements.hard_cases import CASES
from validation.solvers import find_solver
from validation.solvers.base import Size

STORED = Path(__file__).parent / "gold/defaults.json"
_COSTS = [(name, {}) for name in ("bem", "fem", "tamaas", "contact_mechanics", "aspher", "calculix")]
_COSTS.append(("fem", {"method": "reduced"}))
#: Of a schema what describes a key, and what another version of pydantic may word in another way.
_WORDS = {"description", "title", "default", "type", "$ref", "$defs"}


def _below(kind):
    return {kind}.union(*map(_below, kind.__subclasses__()))


def _bounds(schema):
    """Numbers and words within which a value must lie."""
    if isinstance(schema, dict):
        schema = [value for name, value in schema.items() if name not in _WORDS]
    return [b for part in schema for b in _bounds(part)] if isinstance(schema, list) else [schema]


def _of_tables():
    """Keys of scenes and options of studies, with the bounds of their values."""
    for module in pkgutil.walk_packages(validation.__path__, "validation."):
        importlib.import_module(module.name)
    for table in _below(BaseModel):
        if table.__module__.startswith("validation."):
            place = f"{table.__module__.removeprefix('validation.')}.{table.__qualname__}"
            for key, schema in table.model_json_schema().get("properties", {}).items():
                bounds = sorted(map(str, _bounds(schema)))
                yield f"{place}.{key}", {"default": schema.get("default"), "bounds": bounds}


def _of_commands(command, path="fem-contact"):
    for name, inner in getattr(command, "commands", {}).items():
        yield from _of_commands(inner, f"{path} {name}")
    for asked in (a for a in command.params if "completion" not in a.name):  # typer's own
        yield f"{path} {'/'.join([*asked.opts, *asked.secondary_opts])}", asked.default


def _of_functions(owner, path):
    """Arguments of functions, constructors and methods, also in modules that have public names."""
    for name in getattr(owner, "__all__", vars(owner)):
        entry = inspect.unwrap(getattr(owner, name))
        if hasattr(entry, "__all__") or (inspect.isclass(entry) and inspect.ismodule(owner)):
            yield from _of_functions(entry, f"{path}.{name}")
        if name[0] != "_" and (inspect.isfunction(entry) or is_dataclass(entry)):
            for key, asked in inspect.signature(entry).parameters.items():
                if asked.default is not asked.empty:
                    yield f"{path}.{name}({key})", asked.default


def found():
    """All defaults by the place where a user would say something else."""
    command = typer.main.get_command(app)
    pairs = [*_of_tables(), *_of_commands(command)]
    # Where solvers are tried on their hard cases, and what is asked of them there.
    pairs += [(f"stability {case.name}", {"values": case.values, "bound": case.bound}) for case in CASES]
    # What solves are foretold to cost, and by how much effects make them dearer.
    for name, settings in _COSTS:
        cost = asdict(find_solver(name).cost(Size(grid=(24, 60), lengths=(2.0, 5.0), settings=settings)))
        pairs.append((f"cost of {name} {settings}", [f"{key} {value:.9g}" for key, value in cost.items()]))
    pairs += [(f"cost of {name}", effect.cost) for name, effect in effect_kinds().items()]
    by_size = Hardness(hardness=1e9, size_wavelength=1e-6, size_exponent=0.5)
    pairs += [("contacts until one bears its hardness by size", by_size.solves)]
    # Quantities, also those that only a command line has.
    for name, kind in vars(units).items():
        if get_origin(kind) is Annotated:
            bounds = sorted(map(str, _bounds(TypeAdapter(kind).json_schema())))
            pairs.append((f"units.{name}", {"bounds": bounds}))
    for owner in (fc, persson, notebook):
        pairs += _of_functions(owner, owner.__name__)
    return json.loads(json.dumps(dict(pairs), default=repr))


def test_what_is_not_said_is_what_it_was():
    known, now = json.loads(STORED.read_text(encoding="utf-8")), found()
    assert {k: now.get(k) for k in known if now.get(k) != known[k]} == {}
    assert now.keys() - known.keys() == set()


@pytest.mark.parametrize("name", ["bem", "fem"])
def test_a_solver_that_is_not_told_does_what_its_table_says(name):
    solver, grid = find_solver(name), (12, 8)
    told = dict(solver.settings(solver.options(grids=(grid,))))
    costs = [solver.cost(Size(grid=grid, lengths=(2.0, 1.0), settings=s)) for s in (told, {})]
    assert costs[0] == costs[1]
    assert solver.variant(told) == solver.variant({})


if __name__ == "__main__":
    write_lines(STORED, dict(sorted(found().items())))
