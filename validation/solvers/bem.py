"""FFT boundary elements."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pydantic import StrictInt

from validation.arrays import Grid
from validation.effects.base import Effect
from validation.errors import UsageError
from validation.solvers.base import Cost, Gridded, Job, Shift, Size, Solved, Solver, example_job, in_slot
from validation.units import key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

#: Per pair of transforms on the grid; 25 to 30 are needed, and the passes between them cost.
_PAIRS = 80.0
BYTES_PER_POINT = 15 * 8
#: Further bytes per point where a patch is transformed on twice the points along both axes.
_DOUBLED = 14 * 8


class BemOptions(Gridded):
    """FFT boundary elements on these grids, each on `shifts`^2 sub-grid shifts of the surface."""

    shifts: StrictInt = key("positions of the surface below the grid along each axis, e.g. 2", 1, ge=1, le=8)


class Bem(Solver):
    """FFT boundary elements."""

    name = "bem"
    label = "BEM"
    options = BemOptions
    slots = frozenset({"response", "pressure bound", "gap law", "boundary"})
    locates_edges = True
    for_ensembles = True
    holds = frozenset({"mean_gap", "offset"})
    controls = frozenset({"offset", "max_iterations"})
    papers = ("Boundary elements by FFT: [stanley1997]; conjugate gradients with bounds: [polonsky1999].",)

    def cited(self, effects: Sequence[Effect]) -> tuple[str, ...]:
        """With attraction the energy has many minima, which another algorithm finds."""
        sticky = ("Boundary elements by FFT: [stanley1997]; projected Newton method: [bertsekas1982].",)
        return sticky if in_slot("gap law", effects) else self.papers

    def places(self, options: BemOptions) -> Iterator[tuple[Grid, Shift]]:
        """Yield each grid on all of its shifts."""
        steps = [k / options.shifts for k in range(options.shifts)]
        yield from itertools.product(sorted(options.grids), itertools.product(steps, steps))

    def cost(self, size: Size) -> Cost:
        """Predict from the size of the grid."""
        bytes_per_point = BYTES_PER_POINT + (_DOUBLED if in_slot("boundary", size.effects) else 0)
        return size.cost(_PAIRS * size.dearer * size.transforms, bytes_per_point * size.points)

    def solve(self, job: Job) -> Solved:
        """Press; attraction makes the problem one of many minima, which another algorithm finds."""
        field, model, response = job.field, job.model, job.model.felt_response
        options: dict[str, Any] = {"threads": job.threads, **job.load, **job.settings}
        if model.gap_law is not None:
            from fem_contact import adhesion

            state = adhesion.solve(
                field, response, law=model.gap_law, hardness=model.pressure_bound, **options
            )
            return Solved(contact=state.contact)
        from fem_contact import bem

        if "mean_pressure" not in job.load:
            held = bem.solve_displacement(field, response, pressure_bound=model.pressure_bound, **options)
            return Solved(contact=held)
        if model.pressure_bound is not None:
            from fem_contact.hardness import Hardness, press_yielding

            hardness = model.patch_hardness or Hardness(pressure=model.pressure_bound)
            return Solved(contact=press_yielding(field, response, hardness=hardness, **options))
        return Solved(contact=bem.solve(field, response, **options))

    def check(self, options: BemOptions, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse a mean gap with attraction, of which several states may have one, and shifts of a patch."""
        if options.shifts > 1 and (free := in_slot("boundary", effects)):
            raise UsageError(
                f"methods.bem.shifts = {options.shifts}: {free} presses one patch, which has no period to be "
                "moved in; leave shifts out"
            )
        if "mean_gap" in problem.load.held and (sticky := in_slot("gap law", effects)):
            raise UsageError(f"load.mean_gap: with {sticky} several states have the same; give load.offset")

    def warm_up(self, effects: Sequence[Effect], settings: Mapping[str, Any]) -> None:
        """Press a small surface: large enough for all passes, those of single precision among them."""
        self.solve(replace(example_job(256, effects, tolerance=1e-6), threads=1))
