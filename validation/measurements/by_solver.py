"""One solve by any method beside boundary elements on the same points, reduced to numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import xarray as xr

from fem_contact.area import EDGE_CONSTANTS, contact_areas
from fem_contact.contact import ContactResult, Status
from fem_contact.response import BondedLayer
from validation import sandbox
from validation.arrays import Grid
from validation.effects.base import ContactModel
from validation.execution.measurement import measurement
from validation.execution.press import Press
from validation.measurements.edge import distance_to_outside
from validation.measurements.measurement import areas_read, has_square_cells
from validation.measurements.statistics import relative_distance
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec
from validation.solvers import find_solver
from validation.solvers.base import Settings

#: Points closer than this to the edge of either contact, in cells, are left out of the second pressure difference.
_EDGE_CELLS = 1.5

#: Tolerances that a solver is told in turn where its area need be no better than its grid.
_TOLERANCES = tuple(10.0**-k for k in range(2, 12))


@measurement(
    "beside-{method}-{size}",
    kind="ByMethod",
    words="{method}",
    located=True,
    # Boundary elements beside the method are cheap.
    predict=lambda problem, grid, method, settings, effects, pair_seconds: Press(
        method=method, grid=grid, problem=problem, settings=settings, effects=effects
    ).predict(pair_seconds=pair_seconds),
    compiled=lambda method, settings, effects: (("bem", {}, effects), (method, dict(settings), effects)),
)
def beside_bem(
    *,
    problem: ContactProblem,
    grid: Grid,
    method: str,
    settings: Settings = (),
    effects: tuple[EffectSpec, ...] = (),
    layer: bool | None = None,
    grid_share: float | None = None,
) -> xr.Dataset:
    """Press one surface at one load on one grid by a method, beside boundary elements.

    Areas, gap, pressure differences and cost; ``converged`` is 1 where its residuals allow it. NotConverged
    where nothing comes of the method, or boundary elements themselves fail.

    Parameters
    ----------
    layer : bool, optional
        Of a block: compare it with the bonded layer as deep, too; NotConverged where the block is not.
    grid_share : float, optional
        Have another code of boundary elements solve no further than until the area that it counts is this
        part of the grid error from the converged count: equal error, not equal residual. Its memory is that
        of a process of its own, its located area read off by the code that reads ours.
    """
    field, solver, bem, given = problem.heights(grid), find_solver(method), find_solver("bem"), dict(settings)
    model = ContactModel.filled(problem.elastic, effects)
    ours = bem.pressed(field, model, problem.pressure).checked()
    press = partial(solver.pressed, field, model, problem.pressure, **given)
    contact = press() if grid_share is None else _as_good_as_its_grid(press, ours, grid_share)
    constant = solver.edge_constant(contact)
    located = (solver.locates_edges or grid_share is not None) and not effects
    located = located and has_square_cells(problem, grid)
    areas, half = contact_areas(contact, edge_constant=constant, subcell=located), contact_areas(ours)
    data = {
        **areas_read(areas),
        "edge_constant": constant,
        "pixel_bem": half.pixel,
        "perimeter_bem": half.perimeter,
        "pressure_half_space": difference(contact, ours),
        "pressure_inside": difference(contact, ours, inside=True),
        # The mean gap is the offset less C(0) p0 and the mean height: it compares bodies of different depth.
        "gap": (contact.mean_gap - ours.mean_gap) / problem.field.rms_height,
        "residual": contact.residuals.worst,
        "converged": contact.status is Status.CONVERGED,
        "seconds": contact.cost.cpu_seconds,
        "seconds_bem": ours.cost.cpu_seconds,
        **{name: getattr(contact.cost, name) for name in ("peak_bytes", "unknowns", "iterations")},
    }
    if layer:
        depth = float(given.get("depth", max(problem.lengths)))
        response = BondedLayer(solid=problem.elastic, thickness=depth)
        layered = ContactModel(solid=problem.elastic, response=response)
        deep = bem.pressed(field, layered, problem.pressure).checked()
        data["pixel_layer"] = contact_areas(deep).pixel
        data["pressure_layer"] = difference(contact.checked(), deep)
    if grid_share is not None:
        data["tolerance"] = float(contact.provenance["tolerance"])
    return xr.Dataset({name: float(value) for name, value in data.items()})


def _as_good_as_its_grid(
    press: Callable[..., ContactResult], ours: ContactResult, grid_share: float
) -> ContactResult:
    """Return the answer to the loosest tolerance at which the area is off by `grid_share` of what its grid is.

    Else that to the strictest. What a grid is off is told by counting on it as boundary elements do, `ours`.
    The memory is that of all tries.
    """
    areas, most = contact_areas(ours), 0
    sandbox.end()  # its memory shall be its own
    press(tolerance=_TOLERANCES[0])  # not charged with what it imports
    for tolerance in _TOLERANCES:
        contact = press(tolerance=tolerance)
        most = max(most, contact.cost.peak_bytes)
        missed = abs(contact_areas(contact).pixel - areas.pixel)
        if missed <= grid_share * EDGE_CONSTANTS["bem"] * areas.edge_fraction:
            break
    return replace(contact, cost=replace(contact.cost, peak_bytes=most))


def difference(first: ContactResult, second: ContactResult, *, inside: bool = False) -> float:
    """||p1 - p2|| / ||p2||, over all points or away from the edges of both contacts."""
    keep = np.ones(first.shape, dtype=bool)
    for contact in (first.in_contact, second.in_contact) if inside else ():
        keep &= sum(distance_to_outside(part, margin=3) for part in (contact, ~contact)) > _EDGE_CELLS
    return relative_distance(first.pressure[keep], second.pressure[keep])
