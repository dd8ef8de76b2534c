"""A surface and a solid, checked and ready to be solved at any load."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fem_contact._checks import LEAST, array, choice, instance, positive
from fem_contact._checks import field as field_of
from fem_contact.complementarity import (
    FourierOperator,
    FreeOperator,
    Solution,
    operator_of,
    polonsky_keer,
    solve_nested,
    surely_partial,
)
from fem_contact.complementarity.arrays import Device
from fem_contact.contact import ContactResult, Cost, Residuals, Status, measure_residuals
from fem_contact.errors import InvalidInput
from fem_contact.response import Response, check_response
from fem_contact.settings import Settings
from fem_contact.surface import HeightField

__all__ = ["SLACK", "Method", "Problem"]

Array = NDArray[np.float64]
Method = Literal["preconditioned", "double", "polonsky-keer"]


@dataclass(kw_only=True)
class Problem:
    """A surface, a solid and solver settings, ready to be solved at any load."""

    surface: HeightField
    heights: Array
    level: float
    response: Response
    operator: FourierOperator | FreeOperator
    bound: Array | None
    settings: Settings
    method: Method
    device: Device | None = None
    clock: float = field(default_factory=time.perf_counter)
    processor: float = field(default_factory=time.process_time)

    @classmethod
    def checked(
        cls,
        surface: HeightField,
        response: Response,
        *,
        bound: float | Array | None,
        settings: Settings,
        method: Method,
        device: object = None,
    ) -> Problem:
        """Refuse what no computation can start from, and set up the operator."""
        clock, processor = time.perf_counter(), time.process_time()
        instance("surface", surface, HeightField, what="a `HeightField`")
        check_response(response)
        choice("method", method, ("preconditioned", "double", "polonsky-keer"))
        if method == "polonsky-keer" and device is not None:
            raise InvalidInput("method = 'polonsky-keer' runs on no device: use 'preconditioned'")
        if method == "polonsky-keer" and bound is not None:
            raise InvalidInput("method = 'polonsky-keer' knows no pressure bound: use 'preconditioned'")
        operator = operator_of(response, surface.shape, surface.lengths, threads=settings.threads)
        if device is not None and isinstance(operator, FreeOperator):
            raise InvalidInput("device: runs periodic solids; leave it out for a `FreeHalfSpace`")
        heights, level = _levelled(surface)
        return cls(
            surface=surface,
            heights=heights,
            level=level,
            response=response,
            operator=operator,
            bound=_checked_bound(bound, surface),
            settings=settings,
            method=method,
            device=None if device is None else Device(device),
            clock=clock,
            processor=processor,
        )

    def check_load(self, mean_pressure: float) -> None:
        """Refuse a load that cannot be carried."""
        positive("mean_pressure", mean_pressure, unit="Pa")
        if self.bound is not None and float(np.mean(self.bound)) < mean_pressure * (1 - SLACK):
            raise InvalidInput(
                f"pressure_bound with mean {float(np.mean(self.bound)):.6g} Pa: must not be below "
                f"mean_pressure = {mean_pressure:.6g} Pa, or nothing carries the load"
            )

    def checked_start(self, start: Array | None) -> Array | None:
        """Refuse a start that is no pressure field."""
        if start is None:
            return None
        values = field_of("start", start, self.surface.shape, unit="Pa")
        if values.min() < 0 or not np.mean(values) > LEAST:
            raise InvalidInput("start: must be pressures in Pa, none negative, not all zero")
        return values

    def at(self, load: float, *, start: Array | None = None, settings: Settings | None = None) -> Solution:
        """Solve at one mean pressure."""
        partial = surely_partial(self.heights, coarse=self._coarse, mean_force=load)
        exact = self._all_at_bound(load) or (None if partial else self._full_contact(load))
        if exact is not None:
            return exact
        solution = self._iterated(load, start=start, settings=settings or self.settings)
        # One pair goes into the question whether the contact is full.
        asked = 0.0 if partial else self.operator.pairs
        return replace(solution, fft_pairs=solution.fft_pairs + asked)

    def _iterated(self, load: float, *, start: Array | None, settings: Settings) -> Solution:
        heights, operator = self.heights, self.operator
        if self.method == "polonsky-keer":
            return polonsky_keer(
                operator,
                heights,
                mean_force=load,
                length_scale=self._length_scale(load),
                settings=settings,
                start=start,
            )
        return solve_nested(
            operator,
            heights,
            coarse=self._coarse,
            mean_force=load,
            length_scale=self._length_scale(load),
            settings=settings,
            start=start,
            bound=self.bound,
            double=self.method == "double",
            device=self.device,
        )

    def _length_scale(self, load: float) -> float:
        """Length [m] of residuals: that of the roughness, or of a flat patch the one it sinks by."""
        scale = self.surface.rms_height
        flat = scale <= 8 * np.finfo(float).eps * float(np.max(np.abs(self.surface.heights)))
        return load * max(self.surface.lengths) / self.response.contact_modulus if flat else scale

    def _coarse(self, shape: tuple[int, int]) -> FourierOperator | FreeOperator:
        return operator_of(self.response, shape, self.surface.lengths, threads=self.operator.threads)

    def full_pressure(self) -> Array:
        """Pressure [Pa] of full contact but for its mean: p-hat = h-hat / C(q)."""
        assert isinstance(self.operator, FourierOperator)
        pressure = np.empty(self.surface.shape)
        self.operator.invert(self.heights, pressure)
        pressure -= np.mean(pressure)
        return pressure

    def _full_contact(self, load: float) -> Solution | None:
        """Answer where all points touch; None where that needs tension or more than the bound.

        The pressure of a patch is not found in a step: what presses it full is iterated.
        """
        if isinstance(self.operator, FreeOperator):
            return None
        force = self.full_pressure()
        force += load
        if force.min() < 0 or (self.bound is not None and np.any(force > self.bound)):
            return None
        return self.solution(force, pairs=2.0)

    def _all_at_bound(self, load: float) -> Solution | None:
        """Answer where the bound leaves no choice, at the offset of least indentation."""
        if self.bound is None or float(np.mean(self.bound)) > load * (1 + SLACK):
            return None
        solution = self.solution(self.bound.copy(), pairs=1.0)
        offset = -float(np.max(solution.displacement - self.heights))
        return replace(solution, offset=offset, at_bound=np.ones(self.surface.shape, dtype=bool))

    def solution(self, force: Array, *, pairs: float) -> Solution:
        """Wrap a known pressure that makes contact everywhere it is positive, or everywhere at all."""
        displacement = np.empty(force.shape)
        self.operator.apply(force, displacement)
        return Solution(
            force=force,
            displacement=displacement,
            offset=float(np.mean(self.heights - displacement)),
            in_contact=np.ones(force.shape, dtype=bool),
            at_bound=np.zeros(force.shape, dtype=bool),
            status=Status.CONVERGED,
            iterations=0,
            fft_pairs=pairs,
            peak_bytes=force.nbytes + displacement.nbytes,
        )

    def _judged(self, status: Status, residuals: Residuals) -> Status:
        """Return the status that the residuals of the final fields allow."""
        if status is Status.CONVERGED and not residuals.within(self.settings.tolerance):
            status = Status.STAGNATED
        dx, dy = self.surface.spacing
        oblong = max(dx, dy) > _OBLONG * min(dx, dy)
        return Status.OBLONG_CELLS if status is Status.STAGNATED and oblong else status

    def result(self, solution: Solution, *, target: float | None) -> ContactResult:
        """Measure a solution and dress it up."""
        surface = self.surface
        gap = solution.displacement - self.heights
        gap += solution.offset
        residuals = measure_residuals(
            pressure=solution.force,
            gap=gap,
            heights=self.heights,
            lengths=surface.lengths,
            contact_modulus=self.response.contact_modulus,
            rms_gradient=surface.rms_gradient,
            target_pressure=target,
            at_bound=solution.at_bound,
        )
        held = self.operator.nbytes + (0 if self.bound is None else self.bound.nbytes)
        return ContactResult(
            pressure=solution.force,
            gap=gap,
            displacement=solution.displacement,
            in_contact=solution.in_contact,
            at_bound=solution.at_bound,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=self.response.contact_modulus,
            offset=solution.offset + self.level,
            mean_pressure=float(np.mean(solution.force)),
            status=self._judged(solution.status, residuals),
            tolerance=self.settings.tolerance,
            residuals=residuals,
            cost=Cost(
                wall_seconds=time.perf_counter() - self.clock,
                cpu_seconds=time.process_time() - self.processor,
                iterations=solution.iterations,
                fft_pairs=solution.fft_pairs,
                unknowns=gap.size,
                peak_bytes=max(solution.peak_bytes + held, 4 * gap.nbytes + held),
            ),
            provenance={
                "method": f"boundary elements by FFT, {_PLACED[type(self.operator)]}",
                "solver": f"bounded conjugate gradients, {self.method}",
                "tolerance": repr(self.settings.tolerance),
            },
        )


#: What stands for the pressure between the points of a grid, in words.
_PLACED = {
    FourierOperator: "pressure collocated at the grid points",
    FreeOperator: "pressure constant on each cell of a patch with free surroundings",
}

#: Relative difference at which a load counts as equal to the bound: means of equal numbers differ by
#: rounding.
SLACK = 1e-12

#: Ratio of the sides of a cell beyond which a residual that no longer falls is put down to it.
_OBLONG = 30.0

#: Mean height over the rms height beyond which heights are counted from their mean while solving: the digits
#: that a distant reference plane costs would be missing in the gap.
_DISTANT = 100.0


def _levelled(surface: HeightField) -> tuple[Array, float]:
    """Heights to solve with, and the level [m] they are counted from."""
    mean = float(np.mean(surface.heights))
    if abs(mean) <= _DISTANT * surface.rms_height:
        return surface.heights, 0.0
    return surface.heights - mean, mean


def _checked_bound(bound: float | Array | None, surface: HeightField) -> Array | None:
    if bound is None:
        return None
    values = array("pressure_bound", bound, unit="Pa")
    if values.ndim > 0 and values.shape != surface.shape:
        raise InvalidInput(
            f"pressure_bound of shape {values.shape}: must be one pressure or of shape {surface.shape}"
        )
    if not np.all(values >= LEAST):
        raise InvalidInput("pressure_bound: must be positive and finite everywhere, in Pa")
    return np.array(np.broadcast_to(values, surface.shape))
