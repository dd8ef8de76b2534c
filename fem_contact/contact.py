"""What a contact solver returns: fields, status, residuals free of units, and what the solve cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput, NotConverged

__all__ = ["ContactResult", "Cost", "Residuals", "Status", "measure_residuals"]

Array = NDArray[np.float64]


class Status(Enum):
    """How a solve ended; the value is a sentence with the remedy."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "stopped at the iteration limit: allow more iterations or a larger tolerance"
    STAGNATED = "the residual no longer falls: the tolerance is below what the arithmetic can reach"
    CYCLING = "the active set repeats itself: solve the linear systems more accurately"
    TIME_LIMIT = "stopped at the time limit: allow more time or a coarser grid"
    SEPARATED = "pulled apart: adhesion does not bear this tension, and there is no equilibrium to return"


@dataclass(frozen=True, kw_only=True)
class Residuals:
    """By how much the contact conditions are missed; all dimensionless, none depends on the unit system.

    Attributes
    ----------
    penetration : float
        max(-g, 0) / h_rms over points not at the pressure bound.
    tension : float
        max(-p, 0) / (E* h'_rms).
    complementarity : float
        sum p |g| / (sum p * h_rms) over points not at the pressure bound.
    load : float
        |mean p - p0| / p0.
    """

    penetration: float
    tension: float
    complementarity: float
    load: float

    @property
    def worst(self) -> float:
        """The largest of the four; NaN if any of them is."""
        values = (self.penetration, self.tension, self.complementarity, self.load)
        # max() of Python loses a NaN that is not its first argument, and a NaN residual must never pass for a
        # small one.
        return float(np.max(values))


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a solve cost.

    Attributes
    ----------
    wall_seconds, cpu_seconds : float
        Elapsed and processor time of the solve, set-up included.
    iterations : int
        Outer iterations: conjugate-gradient steps (boundary elements) or active sets (finite elements).
    fft_pairs : float
        Forward and backward transforms in units of one pair on the finest grid.
    linear_iterations : int
        Inner iterations of a linear solver, summed over outer iterations.
    unknowns : int
        Unknowns of the discrete problem, interior ones included.
    peak_bytes : int
        Largest memory held by the arrays of the solve.
    """

    wall_seconds: float
    cpu_seconds: float
    iterations: int
    fft_pairs: float = 0.0
    linear_iterations: int = 0
    unknowns: int
    peak_bytes: int


@dataclass(frozen=True, kw_only=True, eq=False)
class ContactResult:
    """Solution of one contact problem on one grid.

    Attributes
    ----------
    pressure, gap, displacement : (nx, ny) arrays
        p [Pa], compression positive; g = u - h + offset [m]; u [m], positive into the elastic body.
    in_contact : (nx, ny) array of bool
        Membership of the solver's contact set, never ``p > eps``.
    at_bound : (nx, ny) array of bool
        Points where the pressure bound is active; -g is then plastic indentation.
    heights : (nx, ny) array
        The rigid profile h that was pressed in [m].
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    contact_modulus : float
        E* [Pa] of the half-space the residuals refer to.
    offset : float
        Distance of the mean planes before deformation [m]; approach = -offset.
    mean_pressure : float
        Mean of `pressure` [Pa].
    weights : (nx, ny) array or None
        Area carried by each point over the mean cell area; None where all are 1.
    status : Status
    residuals : Residuals
    cost : Cost
    provenance : mapping of str to str
        Method, settings and versions, in words.
    """

    pressure: Array
    gap: Array
    displacement: Array
    in_contact: NDArray[np.bool_]
    at_bound: NDArray[np.bool_]
    heights: Array
    lengths: tuple[float, float]
    contact_modulus: float
    offset: float
    mean_pressure: float
    status: Status
    residuals: Residuals
    cost: Cost
    weights: Array | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("pressure", "gap", "displacement", "in_contact", "at_bound", "heights", "weights"):
            value = getattr(self, name)
            if value is not None:
                view = value.view()
                view.setflags(write=False)
                object.__setattr__(self, name, view)
        object.__setattr__(self, "provenance", MappingProxyType(dict(self.provenance)))

    def __reduce__(self) -> tuple[object, ...]:
        # A mapping proxy cannot be pickled, and unpickled arrays would be writable: build the copy anew.
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _rebuilt, (values | {"provenance": dict(self.provenance)},)

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points (nx, ny)."""
        nx, ny = self.pressure.shape
        return nx, ny

    @property
    def spacing(self) -> tuple[float, float]:
        """Grid spacing (dx, dy) [m]."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    def checked(self) -> ContactResult:
        """Return this result if its solver converged.

        Raises
        ------
        NotConverged
            Otherwise, with the status and the worst residual.
        """
        if self.status is not Status.CONVERGED:
            raise NotConverged(f"{self.status.value} (worst residual {self.residuals.worst:.3g})")
        return self


def _rebuilt(values: dict[str, Any]) -> ContactResult:
    return ContactResult(**values)


def measure_residuals(
    *,
    pressure: Array,
    gap: Array,
    heights: Array,
    lengths: tuple[float, float],
    contact_modulus: float,
    rms_gradient: float,
    target_pressure: float | None = None,
    at_bound: NDArray[np.bool_] | None = None,
    weights: Array | None = None,
) -> Residuals:
    """Evaluate the residuals of any code's pressure and gap, in the same words for all of them.

    Lengths are measured in h_rms and stresses in E* h'_rms; for a flat surface in p0 L / E* and p0.

    Parameters
    ----------
    pressure, gap, heights : (nx, ny) arrays
        p [Pa], g [m], h [m].
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    contact_modulus : float
        E* [Pa].
    rms_gradient : float
        h'_rms of the surface [-].
    target_pressure : float, optional
        The prescribed mean pressure p0 [Pa]; None where the mean gap or the offset was prescribed, which
        leaves a load residual of 0.
    at_bound : (nx, ny) array of bool, optional
        Points held at the pressure bound; their gap may be negative.
    weights : (nx, ny) array, optional
        Area of each point over the mean cell area.

    Raises
    ------
    InvalidInput
        For fields of different shapes, which would otherwise be broadcast into residuals of nothing.
    """
    others = {"gap": gap, "heights": heights, "at_bound": at_bound, "weights": weights}
    for name, values in others.items():
        if values is not None and values.shape != pressure.shape:
            raise InvalidInput(
                f"{name} of shape {values.shape}: must have the shape {pressure.shape} of pressure"
            )
    w = np.ones_like(pressure) if weights is None else weights
    mean = float(np.mean(w * pressure))
    load_scale = abs(mean if target_pressure is None else target_pressure)
    length_scale = float(np.std(heights))
    stress_scale = contact_modulus * rms_gradient
    # A constant surface has h_rms of rounding size: it is flat, and roughness can be no scale.
    if length_scale <= 8 * np.finfo(float).eps * float(np.max(np.abs(heights), initial=0.0)):
        length_scale = load_scale * max(lengths) / contact_modulus
        stress_scale = load_scale
    free = np.ones(pressure.shape, dtype=bool) if at_bound is None else ~at_bound
    closed = np.where(free, gap, 0.0)
    total = float(np.sum(np.abs(w * pressure)))

    def ratio(value: float, scale: float) -> float:
        if scale == 0:
            return 0.0 if value == 0 else np.inf
        return value / scale

    return Residuals(
        penetration=ratio(max(-float(closed.min()), 0.0), length_scale),
        tension=ratio(max(-float(pressure.min()), 0.0), stress_scale),
        complementarity=ratio(float(np.sum(np.abs(w * pressure * closed))), total * length_scale),
        load=0.0 if target_pressure is None else ratio(abs(mean - target_pressure), abs(target_pressure)),
    )
