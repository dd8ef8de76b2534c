"""One solve of a scene: a method presses one realisation of the surface on one grid; its fields are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from fem_contact.contact import ContactResult
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from validation.arrays import Grid
from validation.effects.base import ContactModel
from validation.execution.fields import decode_result, fields_dataset
from validation.execution.solve import PAIR_SECONDS, Compiled, Prediction, Solve, dearer_by
from validation.files import atomic_path
from validation.netcdf import dataset_bytes
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import EffectSpec, Scene
from validation.solvers import find_solver
from validation.solvers.base import Job, Settings, Shift, Size, Solved, Solver

if TYPE_CHECKING:
    from fem_contact.response import Response
    from fem_contact.surface import HeightField


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
