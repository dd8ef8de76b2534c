"""What the studies share: base surfaces, checked options, the theory's line, the mean over surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import ValidationError

from persson import elastic
from validation.errors import UsageError
from validation.measures.statistics import Estimate, mean_over_surfaces
from validation.scenes.scene import Scene, SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike, NDArray

    from validation.solves.solve import NumbersJob

__all__ = [
    "LEAST_POINTS_PER_WAVE",
    "at_least",
    "base_surface",
    "ladder",
    "measure",
    "over_surfaces",
    "persson_area",
    "rising",
    "solid_of",
    "truncated_surface",
]


#: Grids coarser than this, as lambda_short/dx, are left out of every limit.
LEAST_POINTS_PER_WAVE = 3.0


def base_surface(*, hurst: float, size: float, ratio: float, seed: int) -> SelfAffineSurface:
    """Return the surface of a study from ratios of lengths.

    Parameters
    ----------
    hurst : float
        H.
    size : float
        L / lambda_long.
    ratio : float
        lambda_long / lambda_short.
    seed : int

    Raises
    ------
    UsageError
        In one line for each option that cannot be used.

    Notes
    -----
    The period is 1 mm and the gradient of C(q) is 0.1: both scale out of everything the studies report.
    """
    length = 1e-3
    if not (size >= 1 and ratio > 1):
        raise UsageError(f"size = {size:g}, ratio = {ratio:g}: must be at least 1, and above 1")
    try:
        return SelfAffineSurface(
            kind="self-affine",
            length=(length, length),
            hurst=hurst,
            lambda_long=length / size,
            lambda_short=length / size / ratio,
            rms_gradient=0.1,
            seed=seed,
        )
    except ValidationError as error:
        lines = (f"{item['loc'][-1]} = {item['input']!r}: {item['msg']}" for item in error.errors())
        raise UsageError("\n".join(lines)) from None


def rising(name: str, values: Sequence[float]) -> tuple[float, ...]:
    """Return an option that must be a list of positive numbers in rising order.

    Raises
    ------
    UsageError
        If it is not.
    """
    if not values or any(not v > 0 for v in values) or any(np.diff(values) <= 0):
        raise UsageError(f"{name} = {', '.join(f'{v:g}' for v in values)}: must be positive and rising")
    return tuple(float(v) for v in values)


def ladder(name: str, values: Sequence[float], *, shifts: int = 2) -> tuple[float, ...]:
    """Return grids, as lambda_short/dx, that a limit can be taken over.

    Raises
    ------
    UsageError
        If they do not rise, or are fewer than three solves on two grids of at least 3 points per wave.
    """
    grids = rising(name, values)
    at_least("shifts", shifts, 1)
    resolved = [n for n in grids if n >= LEAST_POINTS_PER_WAVE]
    if len(resolved) < 2 or len(resolved) * shifts**2 < 3:
        raise UsageError(
            f"{name} = {', '.join(f'{v:g}' for v in values)} with shifts = {shifts}: a limit over grids needs three solves on "
            f"two grids of at least {LEAST_POINTS_PER_WAVE:g} points per wave"
        )
    return grids


#: Surfaces, pairs or shifts that a study is given at most: what they scatter by is long known.
_MOST = 10_000


def at_least(name: str, value: int, least: int) -> int:
    """Return a number of things that must not be below `least`, nor beyond what any study needs.

    Raises
    ------
    UsageError
        If it is.
    """
    if value < least:
        raise UsageError(f"{name} = {value}: must be at least {least}")
    if value > _MOST:
        raise UsageError(f"{name} = {value}: must be at most {_MOST}")
    return value


def solid_of(scene: Scene | None) -> SolidSpec:
    """Return the solid of a scene, or one of E = 1 GPa and nu = 0.3."""
    return SolidSpec(young=1e9, poisson=0.3) if scene is None else scene.solid


def measure(bench: Bench | None, jobs: Sequence[NumbersJob]) -> list[xr.Dataset]:
    """Run jobs on a bench, by default the one in `results/solves`, and return their numbers in order."""
    results: Any = (bench or Bench.at()).solve(jobs)
    return [results[job] for job in jobs]


def persson_area(reduced_pressure: ArrayLike) -> NDArray[np.float64]:
    """A/A0 of Persson's theory at p* = p0/(E* h'_rms): erf(sqrt(2) p*).

    Examples
    --------
    >>> bool(abs(persson_area(0.001) / 0.001 - np.sqrt(8 / np.pi)) < 1e-5)
    True
    """
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    return np.asarray(
        elastic.contact_area(np.asarray(reduced_pressure, dtype=float), stress_variance=variance)
    )


def over_surfaces(values: xr.DataArray) -> Estimate:
    """Mean over the dimension "surface" of numbers that have no other."""
    return mean_over_surfaces(values.values)


def truncated_surface(
    seed: int, until: float, *, length: float, gradient: float, hurst: float, periods: float, bandwidth: float
) -> SelfAffineSurface:
    """Return a surface with its waves up to q/q_long = until, unchanged by those that are left out.

    Parameters
    ----------
    seed : int
    until : float
        At most `bandwidth`.
    length : float
        Period [m].
    gradient : float
        h'_rms of the whole surface.
    hurst, periods, bandwidth : float
        H, L / lambda_long, lambda_long / lambda_short of the whole surface.
    """

    def cut(ratio: float, slope: float) -> SelfAffineSurface:
        return SelfAffineSurface(
            kind="self-affine",
            length=(length, length),
            hurst=hurst,
            lambda_long=length / periods,
            lambda_short=length / periods / ratio,
            rms_gradient=slope,
            seed=seed,
        )

    whole = cut(bandwidth, gradient)
    if until == bandwidth:
        return whole
    spectrum = spectrum_of(whole)
    return cut(until, gradient * float(spectrum.m2(until * spectrum.q_long) / spectrum.m2()) ** 0.5)
