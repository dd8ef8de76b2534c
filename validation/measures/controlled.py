"""Means over surfaces from few fine grids and many coarse ones: the coarse area as a control variate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.stats
from numpy.typing import ArrayLike, NDArray

from validation.measures.statistics import Estimate

__all__ = ["Controlled", "controlled_mean"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Controlled:
    """A mean over surfaces, and what it owes to the control.

    Attributes
    ----------
    estimate : Estimate
        The mean with its 95 % interval; `samples` counts those that were solved finely.
    coefficient : float
        Mean of the fitted coefficients of the control.
    left : float
        Share of the variance between samples that the control leaves.
    """

    estimate: Estimate
    coefficient: float
    left: float


def controlled_mean(fine: ArrayLike, control: ArrayLike, others: ArrayLike) -> Controlled:
    r"""Mean of a dear quantity, from its values on few samples and a cheap companion on many more.

    .. math:: \hat Y = \frac1n \sum_i \bigl[ Y_i - \beta_{-i} (X_i - \bar X') \bigr]

    The coefficient that is applied to a sample is fitted on the others alone, so that the mean is unbiased.

    Parameters
    ----------
    fine : (n,) array
        Y, at least four: of surfaces, or of means of pairs +h, -h.
    control : (n,) array
        X of the same samples, such as the area on a coarse grid.
    others : (m,) array
        X of other, independent samples.

    Raises
    ------
    ValueError
        For fewer than four fine samples, fewer than two others, or numbers that are not finite.

    Notes
    -----
    Variance: that of the n residuals, and that of the mean of X' times the coefficient squared; Student's factor with
    the degrees of freedom of Welch and Satterthwaite, one fewer for the fit. The residuals share the fitted
    coefficients, which adds about 1/(n - 2) of the first part.

    Examples
    --------
    >>> rng = np.random.default_rng(3)
    >>> x, more = rng.normal(size=8), rng.normal(size=1000)
    >>> found = controlled_mean(5 + 2 * x, x, more)
    >>> bool(abs(found.estimate.value - 5) < 0.2), round(found.coefficient, 12)
    (True, 2.0)
    """
    y, x, more = (np.asarray(values, dtype=float) for values in (fine, control, others))
    if y.ndim != 1 or x.shape != y.shape or y.size < 4 or more.ndim != 1 or more.size < 2:
        raise ValueError(
            f"{y.size} fine samples, {x.size} controls, {more.size} others: needs four, as many, and two"
        )
    if not all(np.all(np.isfinite(values)) for values in (y, x, more)):
        raise ValueError("a sample is not a finite number")
    beta = _left_out(y, x)
    aim = float(more.mean())
    residuals = y - beta * (x - aim)
    coefficient = float(beta.mean())
    n, m = y.size, more.size
    own = float(residuals.var(ddof=1)) / n * (1 + 1 / (n - 2))
    known = coefficient**2 * float(more.var(ddof=1)) / m
    total = own + known
    freedom = total**2 / (own**2 / (n - 2) + known**2 / (m - 1)) if total > 0 else n - 2
    error = float(np.sqrt(total))
    scatter = float(y.var(ddof=1))
    return Controlled(
        estimate=Estimate(
            value=float(residuals.mean()),
            standard_error=error,
            half_width=float(scipy.stats.t.ppf(0.975, freedom)) * error,
            samples=n,
        ),
        coefficient=coefficient,
        left=float(residuals.var(ddof=1)) / scatter if scatter > 0 else 0.0,
    )


def _left_out(y: Array, x: Array) -> Array:
    """Return the slope of y over x without each sample in turn; 0 where the others have one x."""
    n = y.size
    dx, dy = x - x.mean(), y - y.mean()
    # Sums over all but one, about the means of all but one.
    sxx = np.sum(dx * dx) - dx * dx * n / (n - 1)
    sxy = np.sum(dx * dy) - dx * dy * n / (n - 1)
    return np.asarray(np.divide(sxy, sxx, out=np.zeros(n), where=sxx > 1e-12 * np.sum(dx * dx)))
