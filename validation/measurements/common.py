"""What the studies share: base surfaces, checked options, the theory's line."""

from __future__ import annotations

import itertools
from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationInfo

from validation.errors import UsageError
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import Load, SelfAffineSurface, SolidSpec
from validation.units import Positive, wrong

#: Grids coarser than this, as lambda_short/dx, are left out of every limit.
LEAST_POINTS_PER_WAVE = 3.0 * (1 - 1e-9)

#: What is pressed where nobody says otherwise; E scales out of everything the studies report.
BASE_SOLID = SolidSpec(young=1e9, poisson=0.3)

#: Shortest waves along a side of the surface of a study: with eight points each, a grid of 16384 x 16384.
_MOST_WAVES = 2048

#: Loads closer than this, relative, are one.
_SAME = 1e-9


def base_surface(
    *, hurst: float, periods: float, bandwidth: float, seed: int, length: float = 1e-3, gradient: float = 0.1
) -> SelfAffineSurface:
    """Return the surface of a study: L = periods lambda_long = periods bandwidth lambda_short [m], h'_rms of C(q).

    The gradient scales out of everything the studies report, the period where nothing else has a length.
    """
    return SelfAffineSurface(
        kind="self-affine",
        length=(length, length),
        hurst=hurst,
        lambda_long=length / periods,
        lambda_short=length / periods / bandwidth,
        rms_gradient=gradient,
        seed=seed,
    )


def base_case(
    surface: SelfAffineSurface,
    *,
    reduced_pressure: float | None = None,
    pressure: float | None = None,
    solid: SolidSpec = BASE_SOLID,
) -> ContactProblem:
    """Return a surface that is pressed with p* = `reduced_pressure` or p0 = `pressure` [Pa].

    ``.further(k)`` is the k-th surface of its spectrum. p* is by the realised gradient, so that of one p0
    it differs from surface to surface. UsageError for more waves side by side than a plan can draw.
    """
    waves = max(surface.length) / surface.lambda_short
    if waves > _MOST_WAVES * (1 + 1e-9):
        raise UsageError(
            f"{waves:.0f} shortest waves along a side: at most {_MOST_WAVES} in a study; give fewer periods, or a smaller bandwidth"
        )
    return ContactProblem(
        surface=surface, solid=solid, load=Load(reduced_pressure=reduced_pressure, pressure=pressure)
    )


def reduced_load(problem: ContactProblem) -> float:
    """Return p* as it was given, or else from p0."""
    return problem.reduced_pressure if problem.load.reduced_pressure is None else problem.load.values[0]


def merged_loads(path: Any, problem: ContactProblem) -> tuple[float, ...]:
    """Return the loads [p*] of a problem, where it is one with those of a path."""
    loads = problem.load.values
    if problem.load.reduced_pressure is None:
        loads = tuple(pressure / problem.pressure_scale for pressure in problem.pressures)
    others = [float(p) for p in path if abs(float(p) / loads[0] - 1) > _SAME] if len(loads) == 1 else []
    return tuple(sorted({*others, *loads}))


def in_rising_order(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Refuse numbers that do not rise."""
    if any(later <= earlier for earlier, later in itertools.pairwise(values)):
        raise wrong("must be positive and rising")
    return values


def _given(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Refuse no values. A `Field(min_length=1)` in the type would win over a larger one of the option."""
    if not values:
        raise wrong("must have at least 1 value")
    return values


def _of_a_limit(per_wave: tuple[float, ...], others: ValidationInfo) -> tuple[float, ...]:
    shifts = others.data.get("shifts", SHIFTS)
    fine = sum(n >= LEAST_POINTS_PER_WAVE for n in per_wave)
    if fine < 2 or fine * shifts**2 < 3:
        raise wrong(
            f"with shifts = {shifts} a limit over grids needs three solves on two grids of at least "
            f"{LEAST_POINTS_PER_WAVE:g} points per wave"
        )
    return per_wave


def _resolving(per_wave: tuple[float, ...]) -> tuple[float, ...]:
    if per_wave[0] < LEAST_POINTS_PER_WAVE:
        raise wrong(f"must be {LEAST_POINTS_PER_WAVE:g} or more: coarser grids give no limit")
    return per_wave


#: Sub-grid shifts along each axis that the studies take unless they say otherwise.
SHIFTS = 2

#: Options of studies: positive numbers in rising order, none or more of them, at least one, two; grids, as
#: lambda_short/dx, that resolve the shortest waves; grids as points along a side; grids, as lambda_short/dx, over which a
#: limit can be taken, where a study has an option `shifts` with as many as that, if it stands before this one.
RisingOrNone = Annotated[tuple[Positive, ...], AfterValidator(in_rising_order)]
Rising = Annotated[tuple[Positive, ...], AfterValidator(_given), AfterValidator(in_rising_order)]
RisingSeveral = Annotated[Rising, Field(min_length=2)]
Resolved = Annotated[RisingSeveral, AfterValidator(_resolving)]
Counts = tuple[Annotated[int, Field(ge=2)], ...]
RisingGrids = Annotated[Counts, AfterValidator(_given), AfterValidator(in_rising_order)]
Ladder = Annotated[Rising, AfterValidator(_of_a_limit)]
