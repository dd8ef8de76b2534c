"""The table of parts: cells that were made apart, and what the size of the sample leaves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.errors import UsageError
from validation.measures.ensemble import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["joined", "with_size"]


def joined(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return one table of parts with some of its Hurst exponents and bandwidths; NaN where nobody made a cell.

    Parameters
    ----------
    parts : sequence of xarray.Dataset
        Of `fem-contact study reference`, each with the same loads and `periods`.

    Raises
    ------
    UsageError
        For parts that were not made alike.
    """
    import xarray as xr

    for name in ("periods", "points_per_wave", "tolerance", "seed", "unsolved"):
        found = sorted({str(part.attrs.get(name)) for part in parts})
        if len(found) != 1:
            raise UsageError(f"{name} = {', '.join(found)}: the parts of a table have one")
    whole = xr.merge([part.drop_attrs(deep=False) for part in parts], join="outer", compat="no_conflicts")
    pairs = dict(entry.split(": ") for part in parts for entry in part.attrs["pairs"].split("; "))
    listed = "; ".join(f"{key}: {pairs[key]}" for key in sorted(pairs, key=float))
    return whole.sortby(["hurst", "bandwidth", "reduced_pressure"]).assign_attrs(
        {**parts[0].attrs, "pairs": listed}
    )


def with_size(table: xr.Dataset, others: Sequence[xr.Dataset]) -> xr.Dataset:
    r"""Add what the size of the sample leaves to a table, from the same spectra on samples of another size.

    .. math:: s = \max(|\bar d|, w), \qquad d = Q_\mathrm{other} / Q_\mathrm{table} - 1

    The mean of d is over the cells that both have, weighed by the surfaces' variances, and w half of its 95 % interval;
    the grids are off alike on both and leave d. One s for each quantity and load goes, in quadrature, into every
    `_error`.

    Parameters
    ----------
    table : xarray.Dataset
        Of `joined`.
    others : sequence of xarray.Dataset
        Cells on larger samples.
    """
    whole = table.copy()
    for name in QUANTITIES:
        pairs = [_of_same_cell(table, other, name) for other in others]
        change = np.array([one for one, _ in pairs])
        weights = 1 / np.array([width for _, width in pairs]) ** 2
        mean = (weights * change).sum(axis=0) / weights.sum(axis=0)
        share = np.maximum(np.abs(mean), 1 / np.sqrt(weights.sum(axis=0)))
        size = np.abs(table[name]) * share
        total = np.hypot(table[f"{name}_error"], size)
        whole[f"{name}_size"] = size.assign_attrs(
            long_name="half of the 95 % interval of the size of the sample"
        )
        whole[f"{name}_error"] = total.assign_attrs(
            long_name="half of the 95 % interval: surfaces, grid, solver, size of the sample"
        )
    return whole.assign_attrs(sizes=", ".join(f"{n:g}" for n in sorted({o.attrs["periods"] for o in others})))


def _of_same_cell(table: xr.Dataset, other: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the relative change from a cell of the table to that of another size, and half of its 95 % interval."""
    other = other.squeeze(["hurst", "bandwidth"])
    own = table.sel(hurst=float(other.hurst), bandwidth=float(other.bandwidth))
    value = own[name].values
    widths = np.hypot(own[f"{name}_half_width"].values, other[f"{name}_half_width"].values)
    return other[name].values / value - 1, widths / np.abs(value)
