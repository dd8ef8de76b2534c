"""The finite-element block."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

from fem_contact.contact import ContactResult
from fem_contact.response import Response
from validation.arrays import Array
from validation.effects.base import Effect
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.solvers.base import Blocks, Cost, Job, Size, Solved, Solver, example_job, in_slot
from validation.solvers.bem import BYTES_PER_POINT
from validation.units import key

if TYPE_CHECKING:
    from fem_contact.block.mesh import BlockMesh
    from validation.scenes.problem import ContactProblem

# In units of a pair of real 256 x 256 transforms on one thread.
#: The reduced block, per pair of transforms on the grid; it makes its compliance first.
_REDUCED_PAIRS = 110.0
#: The whole block, per unknown: assembly, active sets, export.
_FULL_PAIRS_PER_UNKNOWN = 0.005
#: Active sets of a block that yields over those of an elastic one: 1 to 4, by how little it can bear.
_YIELDING_SETS = 2.0
_FULL_BYTES_PER_UNKNOWN = 300
#: Beyond this Poisson ratio elements of displacement alone lock.
_LOCKING = 0.49


#: Layers of a block; with the usual growth some forty reach the depth of the period.
_MOST_LAYERS = 4096


class FemOptions(Blocks):
    """Finite-element block on these surface grids."""

    method: Literal["full", "reduced"] = key(
        "the whole system, or its exact reduction to the surface", "full"
    )


class BlockSolver(Solver):
    """A solver whose body is a block of linear hexahedra, its surface nodes the points of a grid."""

    independent = True
    score_element = "Hex1"

    def felt(self, job: Job) -> Response:
        """Return the block of its mesh, reduced to the surface here."""
        from fem_contact.block import BlockResponse

        return BlockResponse(mesh=planned(job), solid=job.model.solid, width=job.field.spacing[0])

    def check_locking(self, problem: ContactProblem, *, above: float) -> None:
        """Refuse a solid that elements of displacement alone cannot follow."""
        if problem.solid.poisson > above:
            raise UsageError(
                f"solid.poisson = {problem.solid.poisson!r}: elements of method {self.name!r} lock above "
                f"{above}; leave [methods.{self.name}] out or lower it"
            )

    def score_settings(self, points: int) -> dict[str, float | str]:
        """Refine the layers with the grid: at one growth, finer grids approach a block that is .2 % off."""
        return {"growth": float(Blocks.model_fields["growth"].default) ** (self.score_points / points)}


class Fem(BlockSolver):
    """The finite-element block: the whole system, or its exact reduction to the surface."""

    name = "fem"
    label = "FEM"
    options = FemOptions
    slots = frozenset({"response", "pressure bound"})
    holds = frozenset({"offset"})
    sinks = True
    controls = frozenset({"offset", "max_iterations"})
    setting_keys = ("method", "tolerance", "growth", "depth")
    score_points = 16
    papers = (
        "Finite elements: [gustafsson2020].",
        "Full system, contact set: [hintermueller2002]; multigrid: [brandt1977].",
    )

    def handles(self, effect: type[Effect]) -> bool:
        """Whether the slot is one of its own, and the effect can be meshed."""
        return super().handles(effect) and effect.meshed

    def check(self, options: FemOptions, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse elements that lock, two depths, and a solid that is no clamped body."""
        depth, growth = options.depth or max(problem.lengths), options.growth
        for grid in options.grids:
            ratio = depth / max(problem.spacing(grid))
            layers = ratio if growth == 1 else math.log1p(ratio * (growth - 1)) / math.log(growth)
            if layers > _MOST_LAYERS:
                raise UsageError(
                    f"methods.fem.growth = {growth:.6g}: makes {layers:.3g} layers over a depth of "
                    f"{as_length(depth, 3)}; at most {_MOST_LAYERS} are solved: raise the growth or lower "
                    "the depth"
                )
        if options.method == "full":
            self.check_locking(problem, above=_LOCKING)
        if problem.load.held and (yielding := in_slot("pressure bound", effects)):
            raise UsageError(
                f"{yielding}: method 'fem' yields under a load only; give one in place of load.offset, or "
                "leave [methods.fem] out"
            )
        self.check_bodies(problem, effects, depth=options.depth)

    def variant(self, settings: Mapping[str, Any]) -> str:
        """Full or reduced."""
        return str(settings.get("method", "full"))

    def cost(self, size: Size) -> Cost:
        """Predict from the unknowns of the mesh."""
        method = self.variant(size.settings)
        unknowns = unknowns_of(size, method)
        pairs, room = _REDUCED_PAIRS * size.transforms, BYTES_PER_POINT * size.points
        if method == "full":
            sets = _YIELDING_SETS if in_slot("pressure bound", size.effects) else 1.0
            pairs = _FULL_PAIRS_PER_UNKNOWN * sets * unknowns
            room = _FULL_BYTES_PER_UNKNOWN * unknowns
        return size.cost(pairs, room, unknowns)

    def solve(self, job: Job) -> Solved:
        """Press the block with a load, or to an offset."""
        from fem_contact import block

        press = block.solve if "mean_pressure" in job.load else block.solve_displacement
        model, solutions = job.model, []
        arguments = {"method": "full", **job.load, **job.settings, **_mesh(job)}
        if model.body is not None and model.body.modulus is not None:
            arguments["modulus"] = model.body.modulus
        if model.pressure_bound is not None:
            arguments["pressure_bound"] = model.pressure_bound

        def pressed(**limits: Array) -> ContactResult:
            solutions.append(press(job.field, model.solid, **(arguments | limits)))
            return solutions[-1].contact

        if model.patch_hardness is None:
            contact = pressed()
        else:
            from fem_contact.hardness import press_by_patches

            contact = press_by_patches(
                job.field, model.patch_hardness, lambda limits: pressed(pressure_bound=limits)
            )
        # Only the full method holds the inside of the block, which may be a thousand times the surface.
        full = self.variant(job.settings) == "full"
        return Solved(contact=contact, block=replace(solutions[-1], contact=contact) if full else None)

    def warm_up(self, effects: Sequence[Effect], settings: Mapping[str, Any]) -> None:
        """Press a small block."""
        self.solve(example_job(16, effects, method=self.variant(settings)))

    def facts(self, options: FemOptions, problem: ContactProblem) -> Iterator[tuple[str, str]]:
        """Yield for each grid the discretisation error that its waves are answered with."""
        from fem_contact.block import wave_errors

        for grid in sorted(options.grids):
            spacing = max(problem.spacing(grid))
            name = f"finite elements, {grid[0]} x {grid[1]}"
            if problem.longest < 2 * spacing:
                cells = problem.longest / spacing
                yield name, f"carry no wave of this surface, whose longest is {cells:.3g} cells long"
                continue
            short, long = wave_errors(
                grid,
                problem.lengths,
                [max(wave, 2 * spacing) for wave in (problem.shortest, problem.longest)],
                poisson=problem.solid.poisson,
                depth=options.depth,
                growth=options.growth,
            )
            yield (
                name,
                f"compliance off by {short.along_axis:+.2%} along the axes and {short.along_diagonal:+.2%} "
                f"along the diagonal at {short.nodes:.3g} nodes per wave (the shortest), by "
                f"{long.along_axis:+.2%} at {long.nodes:.3g} (the longest); + is too soft",
            )


def unknowns_of(size: Size, method: str) -> int:
    """Return how many unknowns the block of a grid has."""
    from fem_contact.block import estimate

    mesh: dict[str, Any] = {n: v for n, v in size.settings.items() if n in ("depth", "growth", "element")}
    return estimate(size.grid, size.lengths, method=method, **mesh).unknowns  # type: ignore[arg-type]


def _mesh(job: Job) -> dict[str, Any]:
    """Return depth and growth of the layers, where they are said; an effect may say the depth."""
    mesh = {name: job.settings[name] for name in ("depth", "growth") if name in job.settings}
    if job.model.body is not None and job.model.body.depth is not None:
        mesh["depth"] = job.model.body.depth
    return mesh


def planned(job: Job) -> BlockMesh:
    """Return the mesh of a job."""
    from fem_contact.block import plan_mesh

    return plan_mesh(job.field.shape, job.field.lengths, **_mesh(job))
