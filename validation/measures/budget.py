"""What is uncertain about a number of a study, source by source, and added up."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import LEAST_POINTS_PER_WAVE
from validation.measures.measurement import area_limits
from validation.measures.statistics import combined
from validation.report.table import ResultTable

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike, NDArray

__all__ = ["SOURCES", "Budget", "budget_table", "grid_drift", "grid_share", "solver_error"]

#: What belongs to the step from one spectrum and period to all of them.
_SPECTRAL = ("finite size", "bandwidth")

#: Where uncertainty comes from, in the order in which it is listed.
SOURCES = ("grid", "solver", "surfaces", "finite size", "bandwidth", "depth")


@dataclass(frozen=True, kw_only=True)
class Budget:
    """One number with the half widths of its 95 % intervals, source by source.

    Attributes
    ----------
    quantity : str
        What it is, in words.
    value : float
    shares : mapping of str to float
        Half width relative to the value for each of `SOURCES` that was looked at. A source that does not enter (the
        depth of a half-space) is left out; one that enters and is unknown is NaN, and so is the total.

    Examples
    --------
    >>> Budget(quantity="kappa", value=2.0, shares={"grid": 0.03, "surfaces": 0.04}).total
    0.05
    """

    quantity: str
    value: float
    shares: Mapping[str, float]

    @property
    def total(self) -> float:
        """Root sum of squares of the shares: they have different causes."""
        return combined(*self.shares.values())

    @property
    def own(self) -> float:
        """The same without finite size and bandwidth: what is uncertain about the value for its own spectrum."""
        return combined(*(share for name, share in self.shares.items() if name not in _SPECTRAL))


def budget_table(budgets: Sequence[Budget]) -> ResultTable:
    """Return one row for each number: its shares in per cent, words where a source does not enter, and their sum."""
    rows: list[tuple[float | str, ...]] = []
    for budget in budgets:
        shares = [
            _per_cent(budget.shares[name]) if name in budget.shares else "does not enter" for name in SOURCES
        ]
        rows.append((budget.quantity, budget.value, *shares, _per_cent(budget.own), _per_cent(budget.total)))
    columns = (
        "number",
        "value",
        *(f"{name} [%]" for name in SOURCES),
        "for this spectrum and period [%]",
        "for any [%]",
    )
    return ResultTable.of(columns, rows)


def _per_cent(share: float) -> float | str:
    return 100 * abs(share) if math.isfinite(share) else "not determinable"


def grid_drift(dataset: xr.Dataset) -> NDArray[np.float64]:
    """By how much the limit of one measurement moves without its coarsest resolved grid, for each load; signed.

    The order of a fit is a systematic error: it does not average out over surfaces, and its sign is kept so that what does
    may. It is 0 where too few grids are resolved to leave one out.
    """
    resolved = np.flatnonzero(dataset.points_per_wave.values >= LEAST_POINTS_PER_WAVE * (1 - 1e-9))
    if resolved.size < 3 or (resolved.size - 1) * dataset.sizes["shift"] < 3:
        return np.zeros(dataset.sizes["load"])
    whole, _ = area_limits(dataset.isel(grid=resolved))
    finer, _ = area_limits(dataset.isel(grid=resolved[1:]))
    return np.asarray(finer - whole)


def grid_share(values: ArrayLike, *, errors: ArrayLike, drifts: ArrayLike) -> float:
    """Relative 95 % half width that the grids leave on a mean over surfaces.

    Parameters
    ----------
    values, errors, drifts : (n,) arrays
        Limits of the surfaces, their standard errors, and how they move without the coarsest grid.
    """
    squares = np.square(np.asarray(errors, dtype=float))
    random = 2 * float(np.sqrt(squares.mean() / squares.size))
    return combined(random, float(np.asarray(drifts, dtype=float).mean())) / float(
        np.asarray(values, dtype=float).mean()
    )


def solver_error(usual: xr.Dataset, strict: xr.Dataset) -> float:
    """Relative change of the limits of one surface when the residual of its solves is made smaller; the largest load counts.

    Less than one contact point on the finest grid cannot be seen, and counts as one.
    """
    first, second = area_limits(usual)[0], area_limits(strict)[0]
    one = 1 / float(usual.cells[-1]) / usual.sizes["shift"]
    return float(np.max(np.maximum(np.abs(first - second), one) / second))
