"""Between the nodes of the reference table, and no farther."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from persson import elastic
from validation.arrays import Array
from validation.errors import UsageError
from validation.reference.theory import lowest_wave, theory_at_nodes
from validation.report.estimates import total_error
from validation.report.quantities import quantity

#: What the table has.
QUANTITIES = ("area", "gap", "compliance", "energy_ratio", "density_slope", "patch_density")
#: Of interpolations over their difference, so that 95 % of nodes that are left out lie within.
_SAFETY = 1.5
#: Nodes along an axis, and the point between them: H, and logarithms of the others.
Place = tuple[Array, float]
_AXES = {"hurst": "H", "bandwidth": "lambda_long/lambda_short", "reduced_pressure": "p*"}


@dataclass(frozen=True, kw_only=True)
class ReferenceValue:
    """A number of the table, or between its nodes."""

    quantity: str
    meaning: str
    value: float
    uncertainty: float  # Half of the 95 % interval: surfaces, grid, solver, and interpolation
    interpolation: float  # Its part that interpolation has; 0 at a node


def interpolated(data: xr.Dataset, name: str, point: Mapping[str, float]) -> ReferenceValue:
    """Interpolate a quantity of a table of one kind of amplitudes, as `lookup` describes.

    Parameters
    ----------
    data : xarray.Dataset
        Over (hurst, bandwidth, reduced_pressure).
    name : str
        Of a variable that has one named `_error` beside it.
    point : mapping
        hurst, bandwidth, reduced_pressure.

    Raises
    ------
    UsageError
        Outside of the table, and beside cells that it has not.
    """
    for axis in ("hurst", "bandwidth"):
        _check_within(data, axis, point)
    data = _whole_part(data, point["hurst"], point["bandwidth"])
    _check_within(data, "reduced_pressure", point)  # of which not every spectrum has all
    values = data[name].transpose(*_AXES).values
    places = [_place(data, axis, point) for axis in _AXES]
    # Over a theory little is left that bends.
    lowest = lowest_wave(**data.attrs)
    over = _theory(name, lowest, *(tuple(data[axis].values.tolist()) for axis in _AXES))
    at = float(_theory(name, lowest, *((point[axis],) for axis in _AXES)).item())
    ratio = name == "area"
    shown = smooth = values / over if ratio else np.log(values / over)
    for nodes, to in places:  # by monotone cubics along one axis after the other, by a line between two nodes
        smooth = PchipInterpolator(nodes, smooth, axis=0)(to) if nodes.size > 1 else smooth[0]
    value = at * float(smooth if ratio else np.exp(smooth))
    error = total_error(data, name)
    assert error is not None
    relative = error.transpose(*_AXES).values / values
    apart = max(abs(float(smooth) - _straight(shown, places)), _curvature(shown, places))
    interpolation = _SAFETY * (at if ratio else value) * apart
    return ReferenceValue(
        quantity=name,
        meaning=quantity(name).meaning,
        value=value,
        uncertainty=float(np.hypot(value * _straight(relative, places), interpolation)),
        interpolation=interpolation,
    )


def _check_within(data: xr.Dataset, axis: str, point: Mapping[str, float]) -> None:
    low, high, value = float(data[axis][0]), float(data[axis][-1]), point[axis]
    if not low * (1 - 1e-12) <= value <= high * (1 + 1e-12):
        raise UsageError(
            f"{axis} = {value!r}: the table of {_AXES[axis]} goes from {low:g} to {high:g}, "
            "and is not extrapolated"
        )


def _whole_part(data: xr.Dataset, hurst: float, bandwidth: float) -> xr.Dataset:
    """Return the largest part of the table around a spectrum that lacks no cell, at the loads made there."""
    made = np.isfinite(data.area.transpose(*_AXES).values)
    rows, columns = _around(data.hurst.values, hurst), _around(data.bandwidth.values, bandwidth)
    there, loads = made.any(axis=2), made[np.ix_(rows, columns)].all(axis=(0, 1))
    if not loads.any():
        i, j = np.argwhere(~there[np.ix_(rows, columns)])[0]
        cells = [
            f"H = {h:g} at {', '.join(f'{b:g}' for b in data.bandwidth.values[has])}"
            for h, has in zip(data.hurst.values, there, strict=True)
            if has.any()
        ]
        raise UsageError(
            f"hurst = {hurst:g}, bandwidth = {bandwidth:g}: the table has no cell at H = "
            f"{float(data.hurst[rows[i]]):g}, lambda_long/lambda_short = "
            f"{float(data.bandwidth[columns[j]]):g}, and is not extrapolated; it has {'; '.join(cells)}"
        )
    whole = made[:, :, loads].all(axis=2)
    nodes = whole[rows].all(axis=0)
    return data.isel(reduced_pressure=loads, bandwidth=nodes, hurst=whole[:, nodes].all(axis=1))


def _around(nodes: Array, at: float) -> list[int]:
    """Return the node that a value is at, or the two that it is between."""
    close = np.flatnonzero(np.abs(nodes - at) <= 1e-12 * np.abs(nodes))
    if close.size:
        return [int(close[0])]
    above = int(np.searchsorted(nodes, at))
    return [above - 1, above]


def _theory(name: str, lowest: float, *nodes: tuple[float, ...]) -> Array:
    """Return Persson's quantity over (hurst, bandwidth, load), or one where his theory has none."""
    if name == "area":
        return np.asarray(elastic.contact_area(np.array(nodes[2]), stress_variance=0.25))
    return theory_at_nodes(*nodes, lowest=lowest).get(name, np.ones(len(nodes[2])))


def _place(data: xr.Dataset, name: str, point: Mapping[str, float]) -> Place:
    nodes, at = data[name].values.astype(float), point[name]
    if name != "hurst":
        nodes, at = np.log(nodes), float(np.log(at))
    return nodes, float(np.clip(at, nodes[0], nodes[-1]))


def _straight(values: Array, places: Sequence[Place]) -> float:
    """Interpolate by straight lines along one axis after the other; of two nodes the nearest."""
    for nodes, at in places:
        k = int(np.clip(np.searchsorted(nodes, at), 1, max(nodes.size - 1, 1)))
        share = (at - nodes[k - 1]) / (nodes[k] - nodes[k - 1]) if nodes.size > 1 else 0.0
        share = round(share) if nodes.size == 2 else share
        values = (1 - share) * values[k - 1] + (share * values[k] if share else 0.0)
    return float(values)


def _curvature(values: Array, places: Sequence[Place]) -> float:
    """Sum over the axes of how far a parabola through three nodes is from the straight line."""
    total = 0.0
    for axis, (nodes, at) in enumerate(places):
        if nodes.size < 3:
            continue
        line = [_straight(values, [*places[:axis], (nodes, x), *places[axis + 1 :]]) for x in nodes]
        second = np.diff(np.diff(line) / np.diff(nodes)) / (nodes[2:] - nodes[:-2])
        k = int(np.clip(np.searchsorted(nodes, at), 1, nodes.size - 1))
        total += (at - nodes[k - 1]) * (nodes[k] - at) * float(np.max(np.abs(second[max(k - 2, 0) : k])))
    return total
