"""What a contact solver returns: fields, status, residuals free of units, and what the solve cost."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from functools import partial
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from fem_contact._checks import doubles, finite, instance, non_negative, positive, shape_of, shown
from fem_contact._types import Array, Lengths, Mask, Shape
from fem_contact.errors import InvalidInput, NotConverged
from fem_contact.surface.heights import checked_lengths


class Status(Enum):
    """How a solve ended; the value is a sentence with the remedy."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "stopped at the iteration limit: allow more iterations or a larger tolerance"
    STAGNATED = "the residual no longer falls: the tolerance is below what the arithmetic can reach"
    OBLONG_CELLS = "the residual no longer falls on cells far from square: choose spacings alike in x and y"
    CYCLING = "the active set repeats itself: solve the linear systems more accurately"
    TIME_LIMIT = "stopped at the time limit: allow more time or a coarser grid"
    NOT_CONFIRMED = (
        "the residuals of the returned pressure are above the tolerance: solve it more accurately, or accept "
        "a larger tolerance"
    )
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

    def within(self, tolerance: float | None) -> bool:
        """Whether they meet a tolerance, as the solvers understand it: never where one of them is NaN."""
        if tolerance is None:
            return True
        # What the solver added up in another order may differ by rounding.
        limit = tolerance * (1 + 1e-6) + 64 * np.finfo(float).eps
        return bool(self.complementarity <= limit and self.worst <= 10 * limit)


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


class Clock:
    """Elapsed and processor time since it was made."""

    def __init__(self) -> None:
        self.began, self.processor = time.perf_counter(), time.process_time()

    def cost(self, **counted: Any) -> Cost:
        """Return what was counted as a cost, with the time."""
        wall, cpu = time.perf_counter() - self.began, time.process_time() - self.processor
        return Cost(wall_seconds=wall, cpu_seconds=cpu, **counted)


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
    tolerance : float or None
        What the solver was asked for: complementarity at most this, the other residuals at most ten times as
        much. None where it judged its answer by something else.
    provenance : mapping of str to str
        Method, settings and versions, in words.
    """

    pressure: Array
    gap: Array
    displacement: Array
    in_contact: Mask
    at_bound: Mask
    heights: Array
    lengths: Lengths
    contact_modulus: float
    offset: float
    mean_pressure: float
    status: Status
    residuals: Residuals
    cost: Cost
    weights: Array | None = None
    tolerance: float | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("pressure", "gap", "displacement", "in_contact", "at_bound", "heights", "weights"):
            value = getattr(self, name)
            if value is not None or name != "weights":
                instance(name, value, np.ndarray, what="an array")
                view = value.view()
                view.setflags(write=False)
                object.__setattr__(self, name, view)
        instance("provenance", self.provenance, Mapping, what="a mapping")
        object.__setattr__(self, "provenance", MappingProxyType(dict(self.provenance)))

    def __reduce__(self) -> tuple[object, ...]:
        # A mapping proxy cannot be pickled, and unpickled arrays would be writable: build the copy anew.
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return partial(ContactResult, **(values | {"provenance": dict(self.provenance)})), ()

    @property
    def shape(self) -> Shape:
        """Grid points (nx, ny)."""
        nx, ny = self.pressure.shape
        return nx, ny

    @property
    def spacing(self) -> Lengths:
        """Grid spacing (dx, dy) [m]."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    @property
    def area_interval(self) -> tuple[float, float]:
        """Counted area A/A0 if all points that the tolerance leaves undecided are apart, and if all touch.

        Undecided is a point in contact that a lift by ten times the tolerance times h_rms would free, and one
        apart whose gap is less than that. The lift frees a point whose pressure is below E*/2 times the mean
        wavevector of the grid times the lift. Measured, not proved: docs/bem.md.

        Raises
        ------
        InvalidInput
            For a result that has no tolerance.
        """
        if self.tolerance is None:
            raise InvalidInput("area_interval: this result was not solved to a tolerance and has none")
        lift = _UNDECIDED * self.tolerance * float(np.std(self.heights))
        middles = (np.arange(32) + 0.5) / 32
        dx, dy = self.spacing
        mean_wavevector = float(np.mean(np.hypot(np.pi / dx * middles[:, None], np.pi / dy * middles)))
        least = 0.5 * self.contact_modulus * mean_wavevector * lift
        weights = weights_of(self)
        surely = self.in_contact & ((self.pressure > least) | self.at_bound)
        maybe = self.in_contact | (self.gap < lift)
        return float(np.mean(weights * surely)), float(np.mean(weights * maybe))

    @property
    def periodic(self) -> bool:
        """Whether it repeats; a patch with free surroundings ends at its sides."""
        return not self.provenance.get("method", "").endswith("free surroundings")

    @property
    def mean_gap(self) -> float:
        """Mean gap [m]; 0 where the bodies have yielded, which overlap there."""
        return float(np.mean(weights_of(self) * np.where(self.at_bound, 0.0, self.gap)))

    def checked(self) -> Self:
        """Return this result if its solver converged and its residuals say the same.

        Raises
        ------
        NotConverged
            Otherwise, with the status and the worst residual.
        """
        worst = self.residuals.worst
        if self.status is not Status.CONVERGED:
            raise NotConverged(f"{self.status.value} (worst residual {worst:.3g})")
        if not np.isfinite(worst) or not self.residuals.within(self.tolerance):
            raise NotConverged(
                f"called converged, but its worst residual is {worst:.3g}: check units and magnitudes"
            )
        return self

    def remeasured(self, *, rms_gradient: float, target_pressure: float, **changes: Any) -> Self:
        """Return this result with other fields, and with the residuals of what they then are."""
        changed = replace(self, **changes)
        names = ("pressure", "gap", "heights", "lengths", "contact_modulus", "at_bound", "weights")
        known: dict[str, Any] = {name: getattr(changed, name) for name in names}
        residuals = measure_residuals(**known, rms_gradient=rms_gradient, target_pressure=target_pressure)
        return replace(changed, residuals=residuals)


class HasContact:
    """A result around that of a contact solver."""

    contact: ContactResult

    def checked(self) -> Self:
        """Return this if its solver converged, or raise `NotConverged`."""
        self.contact.checked()
        return self


#: Gaps, in tolerances times h_rms, within which a point may change sides before the solve is exact.
_UNDECIDED = 10.0


def weights_of(result: ContactResult) -> Array:
    """Return the area carried by each point over the mean cell area, 1 where all are alike."""
    return np.broadcast_to(1.0, result.shape) if result.weights is None else result.weights


def check_result(name: str, result: object) -> None:
    """Refuse what is no result of a contact solver."""
    instance(name, result, ContactResult, what="a `ContactResult`")


def measure_residuals(
    *,
    pressure: Array,
    gap: Array,
    heights: Array,
    lengths: Lengths,
    contact_modulus: float,
    rms_gradient: float,
    target_pressure: float | None = None,
    at_bound: Mask | None = None,
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
    shape = shape_of("pressure", pressure)
    for name, values in {"gap": gap, "heights": heights, "at_bound": at_bound, "weights": weights}.items():
        if values is not None and shape_of(name, values) != shape:
            raise InvalidInput(f"{name} of shape {np.shape(values)}: must have the shape {shape} of pressure")
    if 0 in shape or not shape:
        raise InvalidInput(f"pressure of shape {shape}: must hold at least one point")
    if at_bound is not None and not (isinstance(at_bound, np.ndarray) and at_bound.dtype == np.bool_):
        raise InvalidInput(f"at_bound = {shown(at_bound)}: must be an array of bool")
    # NaN is let through, for it makes the residual NaN.
    pressure, gap = doubles("pressure", pressure), doubles("gap", gap)
    weights = None if weights is None else doubles("weights", weights)
    heights = doubles("heights", heights)
    longest = max(checked_lengths(lengths))
    contact_modulus = positive("contact_modulus", contact_modulus)
    rms_gradient = non_negative("rms_gradient", rms_gradient)
    if target_pressure is not None:
        target_pressure = finite("target_pressure", target_pressure)
    with np.errstate(all="ignore"):
        return residuals_of(
            residual_sums(pressure, gap, at_bound=at_bound, weights=weights),
            points=heights.size,
            rms_height=float(np.std(heights)),
            highest=float(np.max(np.abs(heights))),
            longest=longest,
            contact_modulus=contact_modulus,
            rms_gradient=rms_gradient,
            target_pressure=target_pressure,
        )


#: Points whose residuals are measured at once: their temporary arrays stay in the cache.
_PART = 2**15


def residual_sums(
    pressure: Array, gap: Array, *, at_bound: Mask | None = None, weights: Array | None = None
) -> list[float]:
    """Return sums of w p, w |p| and w |p g|, the least gap off the bound and the least pressure."""
    pressure, gap = pressure.reshape(-1), gap.reshape(-1)
    at_bound = None if at_bound is None else at_bound.reshape(-1)
    weights = None if weights is None else weights.reshape(-1)
    rows = []
    for first in range(0, pressure.size, _PART):
        part = slice(first, first + _PART)
        p, g = pressure[part], gap[part]
        closed = g if at_bound is None else np.where(at_bound[part], 0.0, g)
        borne = p if weights is None else weights[part] * p
        size = np.abs(borne)
        rows.append((borne.sum(), size.sum(), np.abs(size * closed).sum(), closed.min(), p.min()))
    parts = np.array(rows).T
    return [*parts[:3].sum(axis=1).tolist(), float(parts[3].min()), float(parts[4].min())]


def residuals_of(
    sums: Sequence[float],
    *,
    points: int,
    rms_height: float,
    highest: float,
    longest: float,
    contact_modulus: float,
    rms_gradient: float,
    target_pressure: float | None,
) -> Residuals:
    """Return the residuals of fields from their `residual_sums`; see `measure_residuals`.

    `highest` is the largest absolute height [m], `longest` the longer period [m].
    """
    borne, total, work, lowest, least = sums
    mean = borne / points
    load_scale = abs(mean if target_pressure is None else target_pressure)
    length_scale, stress_scale = rms_height, contact_modulus * rms_gradient
    # A constant surface has h_rms of rounding size: it is flat, and roughness can be no scale.
    if length_scale <= 8 * np.finfo(float).eps * highest:
        length_scale = load_scale * longest / contact_modulus
        stress_scale = load_scale

    def ratio(value: float, scale: float) -> float:
        if scale == 0:
            return 0.0 if value == 0 else np.inf
        return value / scale

    return Residuals(
        penetration=ratio(max(-lowest, 0.0), length_scale),
        tension=ratio(max(-least, 0.0), stress_scale),
        complementarity=ratio(work, total * length_scale),
        load=0.0 if target_pressure is None else ratio(abs(mean - target_pressure), abs(target_pressure)),
    )
