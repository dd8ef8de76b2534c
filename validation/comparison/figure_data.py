"""The numbers behind the figures of a comparison, as datasets with units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.stress import pressure_distribution
from validation.arrays import Array
from validation.methods.theory import stress_distribution

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult
    from validation.comparison.compared import Comparison

__all__ = ["area_data", "cost_data", "largest_pressure", "pressure_at_zero_data", "pressure_maps_data"]

#: Range of the figure of P(sigma), in E* h'_rms.
NEAR_ZERO = 0.6


def _table(dimension: str, columns: dict[str, tuple[Any, str, str]], **attributes: Any) -> xr.Dataset:
    """Return a dataset of one dimension from columns of values, unit and words."""
    import xarray as xr

    data = {
        name: (dimension, np.asarray(values), {"units": unit, "long_name": words})
        for name, (values, unit, words) in columns.items()
    }
    return xr.Dataset(data, attrs={name: value for name, value in attributes.items() if value is not None})


def area_data(c: Comparison) -> xr.Dataset:
    """Areas of every method and grid; limit and theory as attributes."""
    limit, theory = c.limit, c.theory
    return _table(
        "row",
        {
            "method": ([row.method for row in c.rows], "1", "method"),
            "nx": ([row.grid[0] for row in c.rows], "1", "points along x"),
            "ny": ([row.grid[1] for row in c.rows], "1", "points along y"),
            "spacing": ([1 / row.points_per_wave for row in c.rows], "1", "dx / lambda_short"),
            "pixel": ([row.pixel for row in c.rows], "1", "A/A0, contact points counted"),
            "pixel_error": ([row.pixel_scatter for row in c.rows], "1", "standard error over shifts"),
            "perimeter": ([row.perimeter for row in c.rows], "1", "A/A0, perimeter-corrected"),
        },
        limit=None if limit is None else limit.value,
        limit_error=None if limit is None else limit.uncertainty,
        persson=None if theory is None or not theory.answers else theory.area,
        persson_from_spectrum=None if theory is None else theory.ensemble_area,
    )


def cost_data(c: Comparison) -> xr.Dataset:
    """Error of every area against the limit, and the seconds it took."""
    ways = [(row, name) for row in c.rows for name in ("pixel", "perimeter")]
    limit = np.nan if c.limit is None or c.limit.value == 0 else c.limit.value
    return _table(
        "way",
        {
            "method": ([row.method for row, _ in ways], "1", "method"),
            "nx": ([row.grid[0] for row, _ in ways], "1", "points along x"),
            "ny": ([row.grid[1] for row, _ in ways], "1", "points along y"),
            "area": ([name for _, name in ways], "1", "definition of the contact area"),
            "seconds": ([row.seconds for row, _ in ways], "s", "wall time of the solves"),
            "error": ([getattr(row, name) / limit - 1 for row, name in ways], "1", "A / A_limit - 1"),
        },
    )


def pressure_at_zero_data(
    c: Comparison, results: dict[str, list[ContactResult]], *, top: float = NEAR_ZERO
) -> xr.Dataset:
    """P(sigma) from zero to `top` on each grid, in bins whose number follows the points, and Persson's.

    With adhesion it begins at the most negative pressure of a contact point, since some are pulled.

    Parameters
    ----------
    c : Comparison
    results : dict of str to list of ContactResult
        Solves by label, coarse to fine; the shifts of one grid are averaged.
    top : float
        Where it ends, in E* h'_rms.
    """
    unit = c.contact_modulus * c.rms_gradient
    labels, lower, upper, density = [], [], [], []
    lowest = {label: _lowest(solves) / unit if c.adhesive else 0.0 for label, solves in results.items()}
    for label, solves in results.items():
        points = sum(np.count_nonzero(result.in_contact) for result in solves)
        bins = min(48, max(8, int(np.sqrt(points) / 2)))
        edges = np.linspace(lowest[label], top, bins + 1)
        found = np.mean([pressure_distribution(result, edges * unit).density for result in solves], axis=0)
        labels += [label] * bins
        lower += list(edges[:-1])
        upper += list(edges[1:])
        density += list(found * unit)
    stress = np.linspace(min(lowest.values(), default=0.0), top, 401)
    exact = _theory(c, stress * unit)
    if exact is not None:
        labels += ["Persson"] * stress.size
        lower += list(stress)
        upper += list(stress)
        density += list(exact * unit)
    return _table(
        "bin",
        {
            "curve": (labels, "1", "solver and grid, or theory"),
            "lower": (lower, "1", "lower edge of the bin, sigma / (E* h'_rms)"),
            "upper": (upper, "1", "upper edge of the bin, sigma / (E* h'_rms)"),
            "density": (density, "1", "P(sigma) E* h'_rms per nominal area"),
        },
        stress_unit_Pa=unit,
    )


def _theory(c: Comparison, stress: Array) -> Array | None:
    """P(sigma) by the theory with the effects of the scene; None where it is not asked or has no answer."""
    if c.theory is None or not c.theory.answers:
        return None
    return stress_distribution(c.realised, c.scene.effects, c.scene.methods.options("theory"), stress)


def largest_pressure(c: Comparison, results: dict[str, list[ContactResult]]) -> float:
    """Where P(sigma) ends, in E* h'_rms: the largest pressure, or three deviations of the theory above p0."""
    ends = [1.02 * float(result.pressure.max()) for solves in results.values() for result in solves]
    if c.theory is not None and c.theory.answers and all(e.slot != "pressure bound" for e in c.scene.effects):
        ends.append(c.pressure + 3 * math.sqrt(c.theory.stress_variance))
    return max(ends) / (c.contact_modulus * c.rms_gradient)


def _lowest(solves: Sequence[ContactResult]) -> float:
    """Most negative pressure of the contact points, 0 where none is pulled [Pa]."""
    return min(0.0, *(float(result.pressure[result.in_contact].min(initial=0.0)) for result in solves))


def pressure_maps_data(results: dict[str, ContactResult]) -> xr.Dataset:
    """Pressure [Pa] of each solver at its points, one after the other; NaN outside contact."""
    solvers: list[str] = []
    x, y, pressure = [], [], []
    for label, result in results.items():
        (nx, ny), (dx, dy) = result.shape, result.spacing
        solvers += [label] * (nx * ny)
        x.append(np.repeat(np.arange(nx) * dx, ny))
        y.append(np.tile(np.arange(ny) * dy, nx))
        pressure.append(np.where(result.in_contact, result.pressure, np.nan).ravel())
    return _table(
        "point",
        {
            "solver": (solvers, "1", "solver and grid"),
            "x": (np.concatenate(x), "m", "position"),
            "y": (np.concatenate(y), "m", "position"),
            "pressure": (np.concatenate(pressure), "Pa", "contact pressure, none where there is no contact"),
        },
    )
