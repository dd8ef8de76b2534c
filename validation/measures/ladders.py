"""Limits in what a grid does not refine: the size of the sample and the bandwidth of the roughness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.stats
from numpy.typing import ArrayLike, NDArray

from validation.measures.statistics import combined

__all__ = ["SIZE_ORDER", "Rungs", "bandwidth_order", "rungs_limit"]

#: Order in lambda_long/L: the number of long waves on a period grows like (L/lambda_long)^2, and corrections to the
#: mean of anything that depends on them fall with that number.
SIZE_ORDER = 2.0

#: A limit further from the last rung than this many times the span of all rungs is not determinable.
_REACH = 2.0


def bandwidth_order(hurst: float) -> float:
    """Order in lambda_short/lambda_long: 2 (1 - H).

    The long waves matter by their share in the mean square gradient, and an octave at lambda_long carries a share that
    falls like (lambda_short/lambda_long)^(2 (1 - H)) as shorter waves are added.

    Examples
    --------
    >>> round(bandwidth_order(0.8), 12)
    0.4
    """
    return 2 * (1 - hurst)


@dataclass(frozen=True, kw_only=True)
class Rungs:
    """A straight line in step^order through the rungs of a ladder.

    Attributes
    ----------
    limit : float
        Value at step -> 0.
    half_width : float
        Of its 95 % interval: scatter of the samples, and by how much it moves without the coarsest rung.
    slope, slope_half_width : float
        Of the line against step^order.
    order : float
    reach : float
        Distance of the limit from the finest rung, over the span of all rungs, along step^order.
    """

    limit: float
    half_width: float
    slope: float
    slope_half_width: float
    order: float
    reach: float

    @property
    def determinable(self) -> bool:
        """Whether the rungs come near enough to their limit."""
        return self.reach <= _REACH

    def shift(self, step: float) -> float:
        """By how much the value at a step exceeds the limit."""
        return float(self.slope * step**self.order)

    def shift_half_width(self, step: float) -> float:
        """Half of the 95 % interval of `shift`."""
        return float(self.slope_half_width * step**self.order)


def rungs_limit(
    rungs: Sequence[ArrayLike], steps: Sequence[float], *, order: float, common: bool = False
) -> Rungs:
    """Extrapolate the rungs of a ladder with a fixed order.

    Parameters
    ----------
    rungs : sequence of (n_i,) arrays
        Independent samples on each rung.
    steps : sequence of float
        What goes to zero, falling.
    order : float
        Fixed: an order fitted to a few rungs would make any limit possible.
    common : bool
        Whether sample k is the same surface on every rung, whose scatter then cancels in differences.

    Examples
    --------
    >>> found = rungs_limit([[2.4, 2.6], [2.2, 2.4], [2.1, 2.3]], (0.4, 0.2, 0.1), order=1.0, common=True)
    >>> round(found.limit, 12), round(found.slope, 12)
    (2.1, 1.0)
    """
    samples = [np.asarray(rung, dtype=float) for rung in rungs]
    x = np.asarray(steps, dtype=float) ** order
    line = _line(samples, x, common=common)
    (limit, slope), (limit_error, slope_error) = line
    drift = slope_drift = 0.0
    if x.size > 2:
        (shorter_limit, shorter_slope), _ = _line(samples[1:], x[1:], common=common)
        drift, slope_drift = abs(shorter_limit - limit), abs(shorter_slope - slope)
    return Rungs(
        limit=limit,
        half_width=combined(limit_error, drift),
        slope=slope,
        slope_half_width=combined(slope_error, slope_drift),
        order=order,
        reach=float(x[-1] / (x[0] - x[-1])),
    )


def _line(
    samples: Sequence[NDArray[np.float64]], x: NDArray[np.float64], *, common: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Intercept and slope, and the half widths of their 95 % intervals."""
    errors = np.array([rung.std(ddof=1) / np.sqrt(rung.size) for rung in samples])
    # Rungs of common surfaces scatter together: there equal weights lose nothing.
    weight = np.ones_like(x) if common else 1 / np.maximum(errors, 1e-3 * errors.max() + 1e-300)
    solve = np.linalg.pinv(np.stack([np.ones_like(x), x], axis=1) * weight[:, None]) * weight
    values = solve @ np.array([rung.mean() for rung in samples])
    freedom = min(rung.size for rung in samples) - 1
    factor = float(scipy.stats.t.ppf(0.975, freedom))
    if common:
        spread = (solve @ np.stack(samples)).std(axis=1, ddof=1) / np.sqrt(samples[0].size)
    else:
        spread = np.sqrt(solve**2 @ errors**2)
    return (float(values[0]), float(values[1])), (float(factor * spread[0]), float(factor * spread[1]))
