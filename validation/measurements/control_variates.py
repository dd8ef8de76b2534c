"""Means over surfaces from few fine grids, more coarse ones, and what surfaces tell without a solve: control variates in a chain."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.fft
import scipy.special
import xarray as xr
from numpy.typing import ArrayLike

from fem_contact.surface import HeightField
from fem_contact.surface.heights import wavevectors
from validation.arrays import Array, Grid
from validation.execution.measurement import measurement
from validation.scenes.problem import ContactProblem

#: Shares of the nominal area, for the highest heights and the highest pressures of full contact.
_SHARES = (0.01, 0.03, 0.1, 0.3)
#: p* at which the tension of full contact is read off.
_LOADS = (0.1, 0.2, 0.4, 0.8, 1.5)


def unsolved_statistics(field: HeightField) -> dict[str, float]:
    """Return statistics that the contact area of a surface follows, each the mean of h and -h.

    Of the highest heights, of shares of the nominal area: mean height, slope^2 and full-contact pressure on
    them; the same of the highest full-contact pressures; share and mean of the tension of full contact at
    some loads; fourth moments. Heights, slopes and pressures are divided by their rms. The contact area of
    a surface with few waves is larger than the mean where its summits are less steep than the rest.
    """
    height, slope, pressure = _unit_fields(field)
    statistics: dict[str, float] = {}
    counts = [max(1, round(share * height.size)) for share in _SHARES]
    parts = [*counts, *(height.size - count for count in counts)]
    for name, key in (("height", height), ("pressure", pressure)):
        order = np.argpartition(key, parts)
        for of, values, sign in (("height", height, -1), ("slope", slope, 1), ("pressure", pressure, -1)):
            sorted_by = values[order]
            for share, count in zip(_SHARES, counts, strict=True):
                mean = (sorted_by[-count:].mean() + sign * sorted_by[:count].mean()) / 2
                statistics[f"{of} on the top {share:g} of {name}"] = mean
    for load in _LOADS:
        # The variance of the pressure at full contact is (E* h'_rms)^2 / 4.
        raised = pressure + 2 * load, -pressure + 2 * load
        statistics[f"tension at {load:g}"] = np.mean([np.minimum(p, 0).mean() for p in raised])
        statistics[f"share in tension at {load:g}"] = np.mean([(p < 0).mean() for p in raised])
    h2, p2, hp = height**2, pressure**2, height * pressure
    moments = {
        "hp": hp, "h4": h2 * h2, "p4": p2 * p2, "h2 p2": h2 * p2, "h3 p": h2 * hp, "h p3": hp * p2,
        "s4": slope**2, "h2 s2": h2 * slope, "p2 s2": p2 * slope, "h p s2": hp * slope,
    }  # fmt: skip
    return statistics | {name: values.mean() for name, values in moments.items()}


def _unit_fields(field: HeightField) -> tuple[Array, Array, Array]:
    shape = field.shape
    waves = scipy.fft.rfft2(field.heights - field.heights.mean())
    qx, qy = np.ix_(*wavevectors(shape, field.lengths))
    along_x, along_y = (scipy.fft.irfft2(1j * q * waves, s=shape) for q in (qx, qy))
    slope = along_x**2 + along_y**2
    height, pressure = (scipy.fft.irfft2(w, s=shape).ravel() for w in (waves, np.hypot(qx, qy) * waves))
    return height / height.std(), (slope / slope.mean()).ravel(), pressure / pressure.std()


@measurement(
    "unsolved-{grid[0]}x{grid[1]}",
    kind="UnsolvedPairs",
    words="what {count} surfaces tell without a contact,",
    version=2,
    recipe=lambda made, problem, first, grid: made | problem.further(first).recipe | {"grid": list(grid)},
    left_out=("load", "first", "points"),
    # Five transforms and two sorts for each.
    seconds=lambda points, count: count * (5e-3 + 2e-7 * points),
    bytes=200,
    compiled=lambda: (),
)
def unsolved_pairs(*, problem: ContactProblem, grid: Grid, first: int, count: int) -> xr.Dataset:
    """Return `unsolved_statistics` of `count` surfaces of one spectrum; dimensions (surface, statistic).

    And h'_rms: where amplitudes are random it says what one pressure for all is in p*.
    """
    began = time.process_time()
    fields = (problem.further(k).heights(grid) for k in range(first, first + count))
    statistics = [unsolved_statistics(field) | {"h'_rms": field.rms_gradient} for field in fields]
    return xr.Dataset(
        {"value": (("surface", "statistic"), np.array([list(row.values()) for row in statistics]))},
        # Not a coordinate: to read one of text, xarray loads dask.
        attrs={"seconds": time.process_time() - began, "statistics": "; ".join(statistics[0])},
    )


#: Samples from which on the coefficient of a coarser grid is fitted; below it is 1.
_FITTED = 10
#: Of the coefficients of many controls, each divided by its scatter, per sample. On 48 cases (H = .3, .8, bandwidths
#: 4 to 16, eight loads, 80 to 320 pairs) .1 left least of the variance in most, and never 10 % more than the best.
_RIDGE = 0.1


@dataclass(frozen=True, kw_only=True)
class Known:
    """What is known of the means of some controls, from samples that are independent of those to be controlled."""

    mean: Array  # (k,) array
    covariance: Array  # (k, k): Of these means
    freedom: float  # Degrees of freedom of the covariance

    @classmethod
    def of_samples(cls, samples: ArrayLike) -> Self:
        """Take the means of (m,) or (m, k) samples, at least two."""
        array = _finite(samples, least=2)
        covariance = np.atleast_2d(np.cov(array, rowvar=False)) / len(array)
        return cls(mean=array.mean(axis=0), covariance=covariance, freedom=len(array) - 1.0)


@dataclass(frozen=True, kw_only=True)
class Controlled:
    """A mean over surfaces, and what it owes to its controls."""

    value: float
    standard_error: float  # Of the mean, from the scatter of the samples and of the known means
    half_width: float  # Half of the 95 % interval: standard error times Student's factor
    freedom: float  # Degrees of freedom of its standard error
    coefficients: Array  # (k,): Of the controls, on average
    left: float  # Variance of one sample less its controls [square of the quantity]

    @property
    def known(self) -> Known:
        """The mean as a control of something finer."""
        return Known(
            mean=np.array([self.value]), covariance=np.array([[self.standard_error**2]]), freedom=self.freedom
        )


def controlled_mean(
    values: ArrayLike, controls: ArrayLike, known: Known, *, fitted: bool = True
) -> Controlled:
    r"""Mean of a dear quantity, from its values on few samples and cheap companions whose means are known better.

    .. math:: \hat Y = \frac1n \sum_i \bigl[ Y_i - \beta_{-i} \cdot (X_i - \hat\mu_X) \bigr]

    The coefficients of a sample are fitted on the others alone, so that the mean is unbiased; those of
    several controls by ridge regression. Not `fitted` they are 1, as suits few samples and their like on a
    coarser grid.

    Parameters
    ----------
    values : (n,) array
        Y, at least four, or two without a fit: of surfaces, or of means of pairs +h, -h.
    controls : (n,) or (n, k) array
        X of the same samples; their means are `known` from other, independent ones.

    Raises
    ------
    ValueError
        For too few samples, controls that are not known, or numbers that are not finite.

    Notes
    -----
    Variance: that of the n residuals, and that of the known means times the coefficients; Student's factor with
    the degrees of freedom of Welch and Satterthwaite. The shared coefficients add about 1/(n - 2) of the first part.

    Examples
    --------
    >>> rng = np.random.default_rng(3)
    >>> x, more = rng.normal(size=8), rng.normal(size=1000)
    >>> mean = controlled_mean(5 + 2 * x, x, Known.of_samples(more))
    >>> bool(abs(mean.value - 5) < 0.2), round(float(mean.coefficients[0]), 9)
    (True, 2.0)
    """
    y, x = _finite(values, least=4 if fitted else 2)[:, 0], _finite(controls, least=2)
    if x.shape != (y.size, known.mean.size):
        raise ValueError(f"{x.shape} controls of {y.size} samples, of which {known.mean.size} are known")
    beta = _left_out(y, x) if fitted else np.ones_like(x)
    residuals = y - np.sum(beta * (x - known.mean), axis=1)
    coefficients = beta.mean(axis=0)
    n = y.size
    left = residuals.var(ddof=1)
    scatter = left / n * (1 + 1 / (n - 2) if fitted else 1.0)
    borrowed = coefficients @ known.covariance @ coefficients
    total, degrees = scatter + borrowed, float(n - 2 if fitted else n - 1)
    freedom = total**2 / (scatter**2 / degrees + borrowed**2 / known.freedom) if total > 0 else degrees
    error = np.sqrt(total)
    return Controlled(
        value=residuals.mean(),
        standard_error=error,
        half_width=float(scipy.special.stdtrit(freedom, 0.975)) * error,
        freedom=freedom,
        coefficients=coefficients,
        left=left,
    )


def _finite(samples: ArrayLike, *, least: int) -> Array:
    array = np.asarray(samples, dtype=float)
    if len(array) < least or not np.all(np.isfinite(array)):
        raise ValueError(f"samples of shape {array.shape}: needs {least} or more, all finite")
    return array[:, None] if array.ndim == 1 else array


def _left_out(y: Array, x: Array) -> Array:
    """Return the coefficients of y over x without each sample in turn, (n, k); 0 for controls that never change."""
    n, k = x.shape
    scale = x.std(axis=0)
    changing = scale > 1e-12 * np.max(np.abs(x), axis=0)
    beta = np.zeros((n, k))
    if not changing.any():
        return beta
    scale = scale[changing]
    dx, dy = (x[:, changing] - x[:, changing].mean(axis=0)) / scale, y - y.mean()
    # Sums over all but one, about the means of all but one.
    without = n / (n - 1)
    sxx = dx.T @ dx - without * dx[:, :, None] * dx[:, None, :]
    sxy = dx.T @ dy - without * dx * dy[:, None]
    ridge = _RIDGE * n if k > 1 else 1e-12 * n
    beta[:, changing] = np.linalg.solve(sxx + ridge * np.eye(scale.size), sxy[:, :, None])[:, :, 0] / scale
    return beta


def chained_mean(levels: Iterable[tuple[Array, Array]], known: Known) -> tuple[Controlled, ...]:
    """Means on all grids, coarsest first, each controlled by the one before, the coarsest by what is known.

    A level is a quantity (n,) of the surfaces that end on a grid, and its controls (n,) or (n, k): on the
    coarsest what is known without a solve, on others the quantity on the grid before.
    """
    means: list[Controlled] = []
    for values, controls in levels:
        fitted = not means or values.size >= _FITTED
        means.append(controlled_mean(values, controls, known, fitted=fitted))
        known = means[-1].known
    return tuple(means)


def allocation(parts: Sequence[tuple[float, float]], error: float) -> tuple[int, ...]:
    r"""Return how many samples of each part bring the standard error of a sum to `error` at least cost.

    .. math:: N_l = \varepsilon^{-2} \sqrt{V_l / C_l} \sum_k \sqrt{V_k C_k}

    V and C are variance and cost of one sample (M. B. Giles, Operations Research 56 (2008) 607); at least
    two.

    >>> allocation([(1.0, 1.0), (0.01, 4.0)], 0.1)
    (120, 6)
    """
    total = sum(float(np.sqrt(variance * cost)) for variance, cost in parts)
    counts = (total * float(np.sqrt(variance / cost)) / error**2 for variance, cost in parts)
    return tuple(max(2, int(np.ceil(count - 1e-9))) for count in counts)
