"""Results of many cases as one dataset, and the places of a dataset one after the other."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import xarray as xr

from validation.errors import UsageError


def gather(cases: Mapping[Any, xr.Dataset], *along: str, **dims: Sequence[Any]) -> xr.Dataset:
    """Stack datasets along new dimensions in front; a place that is in no case is NaN.

    A place is a tuple with one value for each of `dims`, or the value itself where there is one; dimensions
    that are only named, `along`, have the values of the cases. Where these are instances of a dataclass its
    fields are coordinates. A coordinate x that differs between the cases gets the new dimensions along which
    it does; where one counts surfaces it becomes ``x_each``, over which means are taken.

    A UsageError where the cases are not alike: other variables, sizes or values along a dimension.

    >>> import xarray as xr
    >>> one = xr.Dataset({"area": ("load", [0.1, 0.2])}, coords={"pressure": ("load", [1.0, 2.0])})
    >>> data = gather({0: one, 1: one.assign_coords(pressure=3 * one.pressure)}, poisson=[0, 1, 2])
    >>> data.area.values.tolist(), data.pressure.dims
    ([[0.1, 0.2], [0.1, 0.2], [nan, nan]], ('poisson', 'load'))
    """
    named = {place if len(along or dims) > 1 else (place,): case for place, case in cases.items()}
    if along:
        dims = {dim: list(dict.fromkeys(place[k] for place in named)) for k, dim in enumerate(along)}
    traits = {place: {*c.sizes.items(), *((n, "") for n in c.variables)} for place, c in cases.items()}
    first, *_ = cases.values()
    for place, own in traits.items():
        if odd := own ^ next(iter(traits.values())):
            words = ", ".join(sorted({str(name) for name, _ in odd}))
            raise UsageError(f"cases to be gathered differ in {words}, as at {place}")
    sizes = {dim: len(values) for dim, values in dims.items()}
    places = dict(zip(itertools.product(*dims.values()), np.ndindex(*sizes.values()), strict=True))
    there = {places[place]: case for place, case in named.items() if place in places}

    def of_all(name: str) -> dict[Any, xr.DataArray]:
        return {k: c[name] if name in c.variables else xr.DataArray(c.attrs[name]) for k, c in there.items()}

    names = [*first.data_vars, *(["solve"] if "solve" in first.attrs else [])]
    stacked = {str(name): _stacked(of_all(str(name)), sizes) for name in names}
    coordinates: dict[Any, Any] = {}
    for name in map(str, first.coords):
        values, left = of_all(name), sizes
        for dim in dims:
            kept = _without(values, list(left).index(dim))
            if kept is not None:
                values, left = kept, {other: n for other, n in left.items() if other != dim}
        single = any(dim.endswith("surface") for dim in left)
        if left and name in first.dims:
            raise UsageError(f"{name!r} differs between the cases along {', '.join(left)}: gather it alike")
        (stacked if single else coordinates)[f"{name}_each" if single else name] = _stacked(values, left)
    for dim, values_of_it in dims.items():
        if len(values_of_it) and is_dataclass(values_of_it[0]):
            parts = (part.name for part in fields(values_of_it[0]))
            coordinates |= {part: (dim, [getattr(v, part) for v in values_of_it]) for part in parts}
        else:
            coordinates[dim] = list(values_of_it)
    return xr.Dataset(stacked, coords=coordinates)


def _without(values: Mapping[Any, xr.DataArray], axis: int) -> dict[Any, xr.DataArray] | None:
    """Values by place less one axis, along which they are the same but for rounding; None where not."""
    kept: dict[Any, xr.DataArray] = {}
    for place, value in values.items():
        known = kept.setdefault((*place[:axis], *place[axis + 1 :]), value)
        a, b = known.values, value.values
        number = a.dtype.kind == "f"
        alike = np.allclose(a, b, rtol=1e-12, atol=0.0, equal_nan=True) if number else np.array_equal(a, b)
        if not alike:
            return None
    return kept


def _stacked(values: Mapping[Any, xr.DataArray], sizes: Mapping[str, int]) -> tuple[Any, Any, Any]:
    """Return dimensions, values and attributes of arrays stacked by place; NaN or "" where none is."""
    like = next(iter(values.values()))
    text = like.dtype.kind in "OU"
    if not sizes:
        return like.dims, like.values, like.attrs
    kind = object if text else np.result_type(like.dtype, float)
    whole = np.full((*sizes.values(), *like.shape), "" if text else np.nan, dtype=kind)
    for place, value in values.items():
        whole[place] = value.values
    return (*sizes, *like.dims), whole.astype(str) if text else whole, like.attrs


def each(data: xr.Dataset, *dims: str) -> Iterator[xr.Dataset]:
    """Yield what a dataset holds at each place along some dimensions, the last of which runs fastest.

    >>> import xarray as xr
    >>> data = xr.Dataset({"area": (("surface", "load"), [[1.0, 2.0], [3.0, 4.0]])})
    >>> [here.area.item() for here in each(data, "load", "surface")]
    [1.0, 3.0, 2.0, 4.0]
    """
    for place in np.ndindex(*(data.sizes[dim] for dim in dims)):
        at = dict(zip(dims, place, strict=True))
        yield data.isel(at).assign_attrs(at={**data.attrs.get("at", {}), **at})


def nearest(values: xr.DataArray, wanted: float) -> int:
    """Return at which place a positive number is nearest to one, by ratio.

    >>> import xarray as xr
    >>> nearest(xr.DataArray([1.0, 4.0, 16.0]), 3.0)
    1
    """
    return int(np.argmin(np.abs(np.log(values.values / wanted))))


def spread(data: xr.Dataset, dim: str, count: int = 3) -> list[int]:
    """Return some places along a dimension, from the first to the last.

    >>> import xarray as xr
    >>> spread(xr.Dataset({"area": ("load", range(8))}), "load")
    [0, 4, 7]
    """
    last = data.sizes[dim] - 1
    return sorted({min(k * (last + 1) // (count - 1), last) for k in range(count)})
