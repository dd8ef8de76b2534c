"""What a run says of the solid below the contact: where it is strained most, how stress fades with depth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.arrays import padded
from validation.comparison.reductions import grid_name, own_solves
from validation.execution.press import Contacts, Press
from validation.report.estimates import derive, gather
from validation.scenes.scene import Scene


def below(data: xr.Dataset, scene: Scene, results: Contacts) -> xr.Dataset:
    """Add where the von Mises stress under the scene's own surface is largest, if it asks."""
    if scene.subsurface is None:
        return data
    from fem_contact.subsurface import strongest_point

    given = scene.subsurface.depths  # at the surface lie the edges of the contact ring
    depths = None if given is None else tuple(depth for depth in given if depth > 0)
    names = ("von_mises", "von_mises_depth", "von_mises_x", "von_mises_y")
    parts = {("", ""): xr.Dataset(dict.fromkeys(names, np.nan))}
    for solve in _pressed(scene, results):
        point = strongest_point(results[solve], solve.below, depths=depths)
        values = (point.von_mises, point.depth, *point.place)
        parts[solve.method, grid_name(solve.grid)] = xr.Dataset(dict(zip(names, values, strict=True)))
    data = data.assign(gather(parts, solver=data.solver.values, grid=data.grid.values).data_vars)
    before = data.von_mises.shift(grid=1)
    return derive(
        data.assign(von_mises_change=(data.von_mises - before) / before),
        von_mises_reduced="von_mises / pressure_scale",
        von_mises_depth_reduced="von_mises_depth / wave_short",
    )


def _pressed(scene: Scene, results: Mapping[Press, Any]) -> list[Press]:
    """List the solves whose pressures lie on the response of a solid: a mesh has a stress of its own."""
    return [solve for solve in own_solves(scene, results) if solve.is_own and not solve.solver.sinks]


def _finest(scene: Scene, results: Mapping[Press, Any]) -> list[Press]:
    return list({solve.method: solve for solve in _pressed(scene, results)}.values())


def write_below(scene: Scene, results: Contacts, folder: Path) -> Iterator[Path]:
    """Write the fields below the finest grid of each method, where the scene asks for them."""
    if scene.subsurface is None or not scene.subsurface.vtu:
        return
    from fem_contact.export import write_subsurface
    from fem_contact.subsurface import fields_below

    folder.mkdir(exist_ok=True)
    for solve in _finest(scene, results):
        target = folder / f"{solve.prefix}-below.vtu"
        write_subsurface(target, fields_below(results[solve], solve.below, depths=scene.subsurface.depths))
        yield target


def planes(data: xr.Dataset, scene: Scene, results: Contacts) -> xr.Dataset:
    """Add the von Mises stress over depth below the finest grid of each method: largest, and rms."""
    if scene.subsurface is None:
        return data
    from fem_contact.subsurface import planes_below

    rows = {
        solve.method: [
            # A logarithmic axis has no surface.
            (p.depth or np.nan, float(p.von_mises.max()), float(np.sqrt(np.mean(p.von_mises**2))))
            for p in planes_below(results[solve], solve.below, depths=scene.subsurface.depths)
        ]
        for solve in _finest(scene, results)
    }
    units = float(data.wave_short), *2 * [float(data.pressure_scale)]
    planes = {
        name: padded([row[k] / units[k] for row in rows.get(solver, ())] for solver in data.solver.values)
        for k, name in enumerate(("plane_depth", "plane_stress_largest", "plane_stress_rms"))
    }
    return data.assign({name: (("solver", "plane"), values) for name, values in planes.items()})
