"""Statistics, limits and closed forms that studies print, a second time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import erf, stdtrit

from validation.audit.limits import limit_over
from validation.audit.stored import Array
from validation.audit.studies.kept import Numbers

__all__ = [
    "LEAST_POINTS",
    "VARIANTS",
    "drift_of",
    "grid_share",
    "half_width",
    "limits_of",
    "order_of",
    "pairs",
    "persson",
    "root_sum",
    "solver_share",
    "variant_area",
]

#: Points per shortest wave below which a grid enters no limit.
LEAST_POINTS = 3.0
#: Variants of the theory as tables call them, and share of the energy stored at vanishing contact.
VARIANTS = {
    "persson": "Persson",
    "yang_persson": "Yang, Persson 2008",
    "wang_mueser": "Wang, Mueser 2017",
    "xu": "Xu et al. 2024",
}
_STORED, _STORED_XU = 0.45, 0.42


def half_width(values: Any) -> float:
    """Half of Student's 95 % interval of a mean."""
    x = np.asarray(values, dtype=float).ravel()
    deviation = math.sqrt(math.fsum((x - x.mean()) ** 2) / (x.size - 1))
    return float(stdtrit(x.size - 1, 0.975)) * deviation / math.sqrt(x.size)


def root_sum(*parts: float) -> float:
    """Root of the sum of squares."""
    return math.sqrt(math.fsum(part**2 for part in parts))


def pairs(values: Array) -> Array:
    """Means of the surfaces 2k and 2k + 1 along the last axis."""
    return np.asarray((values[..., 0::2] + values[..., 1::2]) / 2)


def grid_share(values: Array, errors: Array, drifts: Array) -> float:
    """Relative half width that grids leave on a mean: two standard errors, and the mean drift of the fits."""
    n = values.size
    random = 2 * math.sqrt(math.fsum(errors**2)) / n
    return root_sum(random, float(np.mean(drifts))) / float(np.mean(values))


def persson(reduced_pressure: Any) -> Array:
    """A/A0 = erf(p0 / sqrt(2 V)), V = (E* h')^2 / 4, at p* = p0 / (E* h')."""
    return np.asarray(erf(np.sqrt(2.0) * np.asarray(reduced_pressure, dtype=float)))


def variant_area(reduced_pressure: float, variant: str) -> float:
    """A/A0 of a variant: dV = S(P) dV_full up to V_full = (E* h')^2 / 4."""
    p = reduced_pressure
    if variant == "persson":
        return math.erf(math.sqrt(2) * p)

    def area(y: float) -> float:
        return math.erf(1 / math.sqrt(2 * y))

    def stored(y: float) -> float:
        square = area(y) ** 2
        if variant == "yang_persson":
            return _STORED + (1 - _STORED) * square
        return (5 - 2 * square + 6 * square**2) / 9

    full = 1 / (4 * p * p)

    def excess(u: float) -> float:
        """Of V_full over p0^2, with u = ln y, y = V / p0^2."""
        y = math.exp(u)
        if variant == "xu":
            return y / (_STORED_XU + (1 - _STORED_XU) * area(y)) - full
        # S = 1 where contact is full.
        low = math.log(1e-3)
        if u <= low:
            return y - full
        grown, _ = quad(lambda t: math.exp(t) / stored(math.exp(t)), low, u, epsrel=1e-11, limit=400)
        return 1e-3 + grown - full

    return area(math.exp(brentq(excess, math.log(full) - 2, math.log(full) + 1e-9, xtol=1e-13)))


@dataclass(frozen=True)
class _Counted:
    """The areas of one grid and shift of a stored measurement."""

    spacing: tuple[float, float]
    cells: int
    pixel: float
    perimeter: float
    edges: float
    subcell: float
    alignment: float = 0.0


def limits_of(measured: Numbers, keep: Sequence[int] | None = None) -> tuple[Array, Array]:
    """Limit of A/A0 over the resolved grids of a measurement and its standard error, for each load."""
    values, errors = [], []
    points = measured["points"]
    resolved = np.flatnonzero(measured["points_per_wave"] >= LEAST_POINTS * (1 - 1e-9))
    rows = resolved if keep is None else resolved[list(keep)]
    for load in range(measured["pixel"].shape[2]):
        areas = [
            _Counted(
                spacing=(1 / int(points[i]), 1 / int(points[i])),
                cells=int(points[i]) ** 2,
                pixel=float(measured["pixel"][i, j, load]),
                perimeter=float(measured["perimeter"][i, j, load]),
                edges=float(measured["edge_fraction"][i, j, load]),
                subcell=float(measured["subcell"][i, j, load]),
            )
            for i in rows
            for j in range(measured["pixel"].shape[1])
        ]
        found = limit_over(areas, located=True)
        values.append(math.nan if found is None else found.value)
        errors.append(math.nan if found is None else found.error)
    return np.array(values), np.array(errors)


def drift_of(measured: Numbers) -> Array:
    """By how much the limit moves without the coarsest resolved grid; 0 where too few are left."""
    resolved = int(np.sum(measured["points_per_wave"] >= LEAST_POINTS * (1 - 1e-9)))
    if resolved < 3 or (resolved - 1) * measured["pixel"].shape[1] < 3:
        return np.zeros(measured["pixel"].shape[2])
    return limits_of(measured, keep=range(1, resolved))[0] - limits_of(measured)[0]


def solver_share(usual: Numbers, strict: Numbers, *, grids: int | None = None) -> float:
    """Largest relative change of the limits by a hundred times smaller residual; at least one point's."""
    keep = None if grids is None else range(grids)
    first, second = limits_of(usual, keep)[0], limits_of(strict)[0]
    finest, shifts = int(strict["points"][-1]), strict["pixel"].shape[1]
    return float(np.max(np.maximum(np.abs(first - second), 1 / finest**2 / shifts) / second))


def order_of(spacing: Array, error: Array) -> float:
    """Slope of ln |error| over ln spacing by least squares."""
    u, v = np.log(spacing), np.log(np.abs(error))
    return float(np.sum((u - u.mean()) * (v - v.mean())) / np.sum((u - u.mean()) ** 2))
