"""A surface and a solid, checked and ready to be solved at any load."""

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from fem_contact._checks import bound as bound_of
from fem_contact._checks import choice, instance, positive
from fem_contact._types import Array, Shape
from fem_contact.bem.parallel import SlabSurface
from fem_contact.complementarity import FreeOperator, Solution, polonsky_keer, solve_nested, surely_partial
from fem_contact.complementarity.arrays import ArrayGrids
from fem_contact.complementarity.direct import SLACK, all_at_bound, touching
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.in_slabs import SlabGrids
from fem_contact.contact import Clock, ContactResult, Status, residuals_of
from fem_contact.errors import InvalidInput
from fem_contact.response import FreeHalfSpace, Response, check_response
from fem_contact.settings import Settings
from fem_contact.surface import HeightField

Method = Literal["preconditioned", "double", "polonsky-keer"]


class Problem:
    """A surface, a solid and solver settings, checked and ready to be solved at any load.

    Heights, bound and what the operator acts on are arrays of `grids`: of NumPy, on a device, or slabs.
    """

    def __init__(
        self,
        surface: HeightField | SlabSurface,
        response: Response,
        *,
        bound: float | Array | None,
        settings: Settings,
        method: Method,
        device: object = None,
    ) -> None:
        self.clock = Clock()
        if not isinstance(surface, SlabSurface):
            instance("surface", surface, HeightField)
        check_response(response)
        choice("method", method, ("preconditioned", "double", "polonsky-keer"))
        if method == "polonsky-keer" and (device is not None or isinstance(surface, SlabSurface)):
            raise InvalidInput("method = 'polonsky-keer' runs on no device and no MPI: use 'preconditioned'")
        if method == "polonsky-keer" and bound is not None:
            raise InvalidInput("method = 'polonsky-keer' knows no pressure bound: use 'preconditioned'")
        self.grids = grids = _grids(surface, response, device=device, threads=settings.workers)
        self.heights, self.level = grids.put(surface.heights), 0.0
        mean = float(grids.xp.mean(self.heights))
        if abs(mean) > _DISTANT * surface.rms_height:
            self.heights, self.level = self.heights - mean, mean
        if bound is not None:
            # A number fills the rows that are here; of a field of the whole `put` takes them.
            bound = bound_of("pressure_bound", bound, surface.shape)
            bound = np.array(np.broadcast_to(bound, surface.shape if bound.ndim else surface.heights.shape))
        self.surface, self.response, self.settings, self.method = surface, response, settings, method
        self.operator = self._on_grid(surface.shape)
        self.bound: Any = grids.put(bound)

    def check_load(self, mean_pressure: float) -> None:
        """Refuse a load that cannot be carried."""
        positive("mean_pressure", mean_pressure)
        mean = None if self.bound is None else float(self.grids.xp.mean(self.bound))
        if mean is not None and mean < mean_pressure * (1 - SLACK):
            raise InvalidInput(
                f"pressure_bound with mean {mean:.6g} Pa: must not be below "
                f"mean_pressure = {mean_pressure:.6g} Pa, or nothing carries the load"
            )

    def at(self, load: float, *, start: Any = None, settings: Settings | None = None) -> Solution:
        """Solve at one mean pressure."""
        partial = not self.grids.in_slabs and surely_partial(
            self.heights, coarse=self._on_grid, mean_force=load, xp=self.grids.xp
        )
        known: dict[str, Any] = {"bound": self.bound, "xp": self.grids.xp}
        exact = all_at_bound(self.operator, self.heights, mean_force=load, **known)
        # The pressure of a patch is not found in a step: what presses it full is iterated.
        if exact is None and not partial and not isinstance(self.operator, FreeOperator):
            rough = self.full_pressure()
            exact = touching(self.operator, self.heights, rough, load, pairs=2.0, **known)
        if exact is not None:
            return exact
        scale = self.surface.rms_height
        if scale <= 8 * np.finfo(float).eps * self._highest():
            # The length that a flat patch sinks by.
            scale = load * max(self.surface.lengths) / self.response.contact_modulus
        options: dict[str, Any] = {
            "mean_force": load,
            "length_scale": scale,
            "settings": settings or self.settings,
            "start": start,
        }
        if self.method == "polonsky-keer":
            solution = polonsky_keer(self.operator, self.heights, **options)
        else:
            options |= {"coarse": self._on_grid, "grids": self.grids, "bound": self.bound}
            solution = solve_nested(self.operator, self.heights, double=self.method == "double", **options)
        # One pair goes into the question whether the contact is full.
        question = 0.0 if partial else self.operator.pairs
        return replace(solution, fft_pairs=solution.fft_pairs + question)

    def _highest(self) -> float:
        """Largest absolute height [m] of the surface as it was given."""
        ends = self.grids.xp.max(self.heights), self.grids.xp.min(self.heights)
        return max(abs(float(end) + self.level) for end in ends)

    def _on_grid(self, shape: Shape) -> Any:
        return self.grids.operator_of(self.response, shape, self.surface.lengths)

    def full_pressure(self) -> Any:
        """Pressure [Pa] of full contact but for its mean: p-hat = h-hat / C(q)."""
        pressure = self.grids.xp.empty_like(self.heights)
        self.operator.invert(self.heights, pressure)
        pressure -= self.grids.xp.mean(pressure)
        return pressure

    def result(self, solution: Solution, *, target: float | None) -> ContactResult:
        """Measure a solution and dress it up."""
        surface, grids, lengths = self.surface, self.grids, self.surface.lengths
        gap = solution.displacement - self.heights
        gap += solution.offset
        with np.errstate(all="ignore"):
            residuals = residuals_of(
                grids.residual_sums(solution.force, gap, solution.at_bound),
                points=math.prod(surface.shape),
                rms_height=surface.rms_height,
                highest=self._highest(),
                longest=max(lengths),
                contact_modulus=self.response.contact_modulus,
                rms_gradient=grids.rms_gradient(surface, self.heights),
                target_pressure=target,
            )
        status, (dx, dy) = solution.status, surface.spacing
        if status is Status.CONVERGED and not residuals.within(self.settings.tolerance):
            status = Status.STAGNATED
        if status is Status.STAGNATED and max(dx, dy) > _OBLONG * min(dx, dy):
            status = Status.OBLONG_CELLS
        solution, gap = grids.fetched(solution), grids.fetched_field(gap)
        placed = "pressure collocated at the grid points"
        if isinstance(self.operator, FreeOperator):
            placed = "pressure constant on each cell of a patch with free surroundings"
        held = self.operator.nbytes + (0 if self.bound is None else gap.nbytes)
        if grids.in_slabs:
            lengths = dx * gap.shape[0], lengths[1]
        return ContactResult(
            pressure=solution.force,
            gap=gap,
            displacement=solution.displacement,
            in_contact=solution.in_contact,
            at_bound=solution.at_bound,
            heights=surface.heights,
            lengths=lengths,
            contact_modulus=self.response.contact_modulus,
            offset=solution.offset + self.level,
            mean_pressure=float(np.mean(solution.force)),
            status=status,
            tolerance=self.settings.tolerance,
            residuals=residuals,
            cost=self.clock.cost(
                iterations=solution.iterations,
                fft_pairs=solution.fft_pairs,
                unknowns=math.prod(surface.shape),
                peak_bytes=max(solution.peak_bytes + held, 4 * gap.nbytes + held),
            ),
            provenance={
                "method": f"boundary elements by FFT, {placed}",
                "solver": f"bounded conjugate gradients, {self.method}",
                "tolerance": repr(self.settings.tolerance),
            },
        )


#: Ratio of the sides of a cell beyond which a residual that no longer falls is put down to it.
_OBLONG = 30.0
#: Mean height over the rms height beyond which heights are counted from their mean while solving: the digits
#: that a distant reference plane costs would be missing in the gap.
_DISTANT = 100.0


def _grids(surface: HeightField | SlabSurface, response: Response, *, device: object, threads: int) -> Grids:
    """Where the arrays of a solve are."""
    name = "device" if device is not None else "comm"
    if device is None and not isinstance(surface, SlabSurface):
        return Grids(surface.shape, threads=threads)
    if isinstance(response, FreeHalfSpace):
        raise InvalidInput(f"{name}: runs periodic solids; leave it out for a `FreeHalfSpace`")
    if not isinstance(surface, SlabSurface):
        return ArrayGrids(device, surface.shape, threads=threads)
    if device is not None:
        raise InvalidInput("device, comm: give one of them")
    return SlabGrids(surface.slabs, threads=threads)
