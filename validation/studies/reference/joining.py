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

#: Of relative intervals: below it two numbers are the same.
_SURE = 1e-12


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

    for name in ("study", "periods", "tolerance"):
        found = sorted({str(part.attrs.get(name)) for part in parts})
        if len(found) != 1:
            raise UsageError(f"{name} = {', '.join(found)}: the parts of a table have one")
    whole = xr.merge([part.drop_attrs(deep=False) for part in parts], join="outer", compat="no_conflicts")
    whole["pairs"] = whole.pairs.fillna("")
    return whole.sortby(["hurst", "bandwidth", "reduced_pressure"]).assign_attrs(parts[0].attrs)


def with_size(table: xr.Dataset, larger: xr.Dataset) -> xr.Dataset:
    r"""Add what the size of the sample leaves to a table, from some of its spectra on samples of another size.

    .. math:: s = \max(|\bar d|, w), \qquad d = Q_\mathrm{larger} / Q_\mathrm{table} - 1

    The mean of d is over the cells that both have, weighed by the surfaces' variances, and w half of its 95 % interval;
    the grids are off alike on both and leave d. One s for each of `QUANTITIES` and load goes, in quadrature, into its
    `_error`.
    """
    whole, cells = table.copy(), ("hurst", "bandwidth")
    same = table.sel({name: larger[name] for name in cells})
    for name in QUANTITIES:
        own, other, width = same[name], larger[name], same[f"{name}_half_width"]
        # Nothing gives way in full contact, on samples of any size.
        scale = abs(own).where(own != 0, 1.0)
        weight = ((width**2 + larger[f"{name}_half_width"] ** 2) / scale**2).clip(min=_SURE**2) ** -1.0
        mean = (weight * (other - own) / scale).sum(cells) / weight.sum(cells)
        share = np.maximum(abs(mean), weight.sum(cells) ** -0.5)
        size = (abs(table[name]) * share).transpose(*table[name].dims)
        total = (table[f"{name}_error"] ** 2 + size**2) ** 0.5
        whole[f"{name}_size"] = size.assign_attrs(
            long_name="half of the 95 % interval of the size of the sample"
        )
        whole[f"{name}_error"] = total.assign_attrs(table[f"{name}_error"].attrs)
    return whole.assign_attrs(larger_periods=larger.attrs["periods"])
