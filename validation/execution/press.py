"""One solve of a scene: a method presses one realisation of the surface on one grid; its fields are kept."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from itertools import product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from fem_contact.contact import ContactResult, Cost, Residuals, Status
from fem_contact.response import HalfSpace, Response
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Grid
from validation.effects.base import ContactModel
from validation.execution.solve import PAIR_SECONDS, Compiled, Prediction, Solve, dearer_by
from validation.files import atomic_path
from validation.netcdf import dataset_bytes
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import EffectSpec, Scene
from validation.solvers import find_solver
from validation.solvers.base import Job, Settings, Shift, Size, Solved, Solver

if TYPE_CHECKING:
    import xarray as xr


_FIELDS = {
    "pressure": ("Pa", "contact pressure, compression positive"),
    "gap": ("m", "gap u - h + offset"),
    "displacement": ("m", "surface displacement, positive into the elastic body"),
    "heights": ("m", "rigid profile, positive towards the elastic body"),
    "contacting_points": ("1", "membership of the contact set"),
    "at_bound": ("1", "points held at the pressure bound"),
    "weights": ("1", "area carried by each point over the mean cell area"),
}
#: In a `ContactResult`, where it has another name there.
_NAMES = {"contacting_points": "in_contact"}
_FORMAT = "fem-contact result 1"  # of one stored solve; folders of results have their own

#: Fields that are mostly zero or one; compressing others costs 50 ms per 256 x 256 points and saves nothing.
_COMPRESSED = frozenset({"pressure", "contacting_points", "at_bound"})


def fields_dataset(result: ContactResult, *, recipe: str) -> xr.Dataset:
    """Return one solve as a dataset over x and y."""
    import xarray as xr

    variables = {}
    for name, (unit, words) in _FIELDS.items():
        if (value := getattr(result, _NAMES.get(name, name))) is None:
            continue
        value, packed = value.astype(np.int8) if value.dtype == bool else value, name in _COMPRESSED
        # Checksums on all: whoever reads the file with another tool notices damage, too.
        options = {"zlib": packed, "complevel": 1, "shuffle": packed, "fletcher32": True, "_FillValue": None}
        variables[name] = xr.Variable(("x", "y"), value, {"units": unit, "long_name": words}, options)
    for axis, count, step in zip("xy", result.shape, result.spacing, strict=True):
        variables[axis] = xr.Variable(axis, np.arange(count) * step, {"units": "m"}, {"_FillValue": None})
    attributes = {
        "format": _FORMAT,
        "recipe": recipe,
        "lengths": list(result.lengths),
        "contact_modulus": result.contact_modulus,
        "offset": result.offset,
        "mean_pressure": result.mean_pressure,
        "status": result.status.name,
        "residuals": json.dumps(asdict(result.residuals)),
        "cost": json.dumps(asdict(result.cost)),
        "provenance": json.dumps(dict(result.provenance)),
    }
    return xr.Dataset(variables, attrs=attributes)


def decode_result(content: memoryview) -> ContactResult:
    """Return the solve of a netCDF file that is intact; ValueError or KeyError for another version's."""
    import netCDF4

    # By hand: half the time that xarray takes, and every page decodes all of its solves.
    with netCDF4.Dataset("memory", memory=content) as file:
        file.set_auto_maskandscale(False)
        attributes = file.__dict__
        if attributes["format"] != _FORMAT:
            raise ValueError(f"is not a '{_FORMAT}' file")
        present = [name for name in _FIELDS if name != "weights" or name in file.variables]
        values: dict[str, Any] = {_NAMES.get(name, name): file.variables[name][...] for name in present}
    values |= {name: values[name].astype(bool) for name in ("in_contact", "at_bound")}
    return ContactResult(
        **values,
        lengths=(float(attributes["lengths"][0]), float(attributes["lengths"][1])),
        contact_modulus=float(attributes["contact_modulus"]),
        offset=float(attributes["offset"]),
        mean_pressure=float(attributes["mean_pressure"]),
        status=Status[attributes["status"]],
        residuals=Residuals(**json.loads(attributes["residuals"])),
        cost=Cost(**json.loads(attributes["cost"])),
        provenance=json.loads(attributes["provenance"]),
    )


@dataclass(frozen=True, kw_only=True)
class Press(Solve):
    """One solve: a method, one realisation of the surface on one grid, a solid and a load.

    The surface may be shifted by parts of a cell; `settings` has only what the method was told, such as its
    tolerance.
    """

    threaded: ClassVar[bool] = True

    method: str
    grid: Grid
    shift: Shift = (0.0, 0.0)
    problem: ContactProblem
    settings: Settings = ()
    effects: tuple[EffectSpec, ...] = ()

    @property
    def solver(self) -> Solver:
        """The method."""
        return find_solver(self.method)

    @property
    def is_own(self) -> bool:
        """Whether it presses the scene's own surface where it stands."""
        return self.problem.realisation == 0 and self.shift == (0.0, 0.0) and not self.problem.variation

    @property
    def response(self) -> Response:
        """What answers to pressure: the solid with its layers."""
        return ContactModel.filled(self.problem.elastic, self.effects).felt_response

    @property
    def below(self) -> Response:
        """What lies below the contact: of two bodies, which answer as one half-space, the first."""
        solid = self.problem.solid
        if solid.second_young is None:
            return self.response
        return HalfSpace(solid=Solid(young=solid.young, poisson=solid.poisson))

    @cached_property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the result, as JSON-ready data, and nothing else."""
        return {
            "method": self.method,
            "grid": list(self.grid),
            "shift": list(self.shift),
            # Moved before fewer points than those of a map are taken; solves of before were not.
            **({"moved": "the map"} if any(self.shift) and self.problem.aliases(self.grid) else {}),
            **self.problem.recipe,
            "settings": dict(self.settings),
            "effects": [effect.model_dump(mode="json", exclude_none=True) for effect in self.effects],
        }

    @property
    def prefix(self) -> str:
        """Method and grid."""
        return f"{self.method}-{self.grid[0]}x{self.grid[1]}"

    @property
    def label(self) -> str:
        """Method and grid, as tables and figures call them."""
        return f"{self.solver.label} {self.grid[0]} x {self.grid[1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        parts = {
            f"surface {self.problem.realisation + 1}": self.problem.realisation,
            self.problem.variation: self.problem.variation,
            "inverted": self.problem.inverted,
            f"shift ({self.shift[0]:g}, {self.shift[1]:g})": self.shift != (0.0, 0.0),
        }
        grid = f"{self.solver.label} {self.grid[0]}x{self.grid[1]}"
        return ", ".join([grid, *(words for words, holds in parts.items() if holds)])

    def height_field(self) -> HeightField:
        """Return the heights that are pressed."""
        field = self.problem.heights(self.grid, self.shift)
        for effect in self.effects:
            field = effect.shaped(field)
        return field

    def predict(self, *, pair_seconds: float = PAIR_SECONDS) -> Prediction:
        """Predict from the sizes of grid and mesh, and what the effects cost on this machine."""
        cost = self.solver.cost(
            Size(
                grid=self.grid,
                lengths=self.problem.lengths,
                settings=dict(self.settings),
                effects=self.effects,
                dearer=dearer_by(self.effects),
            )
        )
        return Prediction(
            seconds=cost.pairs * pair_seconds, peak_bytes=cost.peak_bytes, unknowns=cost.unknowns
        )

    def do(self, *, threads: int | None = None) -> Solved:
        """Solve; what comes of it can be used. A FemContactError when the solve failed."""
        problem = self.problem
        solved = self.solver.solve(
            Job(
                field=self.height_field(),
                load=problem.load.held or {"mean_pressure": problem.pressure},
                model=ContactModel.filled(problem.elastic, self.effects),
                settings=dict(self.settings),
                threads=threads,
            )
        )
        solved.contact.checked()
        return solved

    def encode(self, result: Solved) -> memoryview:
        """Return fields and provenance."""
        return dataset_bytes(fields_dataset(result.contact, recipe=self.recipe_text))

    def decode(self, content: memoryview) -> ContactResult:
        """Read fields and provenance."""
        return decode_result(content)

    def block_file(self, folder: Path) -> Path:
        """Where the deformed block of a finite-element solve is exported to."""
        return folder / f"{self.key}.vtu"

    def written_beside(self, result: Solved, folder: Path) -> None:
        """Export the deformed block, where the method holds one."""
        if result.block is not None:
            from fem_contact.export import write_block

            with atomic_path(self.block_file(folder)) as draft:
                write_block(draft, result.block)

    @property
    def compiled(self) -> Compiled:
        """The method with its effects."""
        return ((self.method, dict(self.settings), self.effects),)

    def after(self, previous: Solve | None) -> Press:
        """Share the surface of the previous solve, if it is the same one."""
        shared = getattr(previous, "problem", None)
        return replace(self, problem=shared) if shared == self.problem else self


#: What came of solves.
Contacts: TypeAlias = Mapping[Press, ContactResult]


def solves_of(scene: Scene, problem: ContactProblem | None = None) -> tuple[Press, ...]:
    """List the solves of a scene, coarse grids first; one that is asked for twice is listed once.

    The `problem` of the scene may have been made already.
    """
    problem = problem or realise(scene)
    solves: list[Press] = []
    for name, solver in scene.methods.solvers.items():
        options = scene.methods.options(name)
        press = partial(Press, method=name, settings=solver.settings(options), effects=scene.effects)
        solves += (press(grid=g, shift=shift, problem=problem) for g, shift in solver.places(options))
        if scene.ensemble is not None and solver is scene.ensemble_solver:
            for k, grid in product(range(scene.ensemble.realisations), sorted(scene.ensemble.grids)):
                solves.append(press(grid=grid, problem=problem.further(k)))
    return tuple({solve.key: solve for solve in solves}.values())


def run_solves(scene: Scene, problem: ContactProblem) -> tuple[Press, ...]:
    """List the solves of a run: those of the scene, and those of its map treated otherwise.

    The latter are on the coarsest grid of the first method that is quick, unless the scene wants none, or
    they cost more than its own and it does not ask for them.
    """
    solves, solver = solves_of(scene, problem), scene.ensemble_solver
    treated = getattr(scene.surface, "treatment", False)
    if solver is None or treated is False:
        return solves
    first = min((s for s in solves if s.method == solver.name and s.is_own), key=lambda s: prod(s.grid))
    variations = problem.variations
    whole = sum(prod(s.grid) for s in solves if s.method == solver.name)
    if not treated and len(variations) * prod(first.grid) > whole:
        return solves
    # Without its spikes a map may be flat.
    rough = (case for case in variations if case.measured and case.measured.is_rough)
    return (*solves, *(replace(first, problem=case) for case in rough))
