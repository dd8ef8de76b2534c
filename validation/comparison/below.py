"""What a run says of the solid below the contact: where it is strained most, how stress fades with depth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.contact import ContactResult
from validation.effects.base import Slots
from validation.methods import find_method
from validation.report.table import WordTable
from validation.report.words import significant

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.response import Response
    from validation.comparison.compared import Comparison
    from validation.scenes.scene import Scene
    from validation.solves.press import Press

__all__ = ["Below", "below", "below_data", "below_findings", "below_table", "write_below"]


@dataclass(frozen=True, kw_only=True)
class Below:
    """The point below one contact where the von Mises stress is largest.

    Attributes
    ----------
    method : str
    grid : tuple of int
    von_mises : float
        [Pa].
    depth : float
        [m].
    place : tuple of float
        x and y [m].
    """

    method: str
    grid: tuple[int, int]
    von_mises: float
    depth: float
    place: tuple[float, float]


def below(scene: Scene, results: Mapping[Press, ContactResult]) -> tuple[Below, ...]:
    """Find it under the scene's own surface on every grid; nothing unless the scene asks."""
    if scene.subsurface is None:
        return ()
    from fem_contact.subsurface import strongest_point

    found = []
    for solve in _asked(scene, results):
        point = strongest_point(results[solve], _response(solve), depths=_positive(scene))
        found.append(
            Below(
                method=solve.method,
                grid=solve.grid,
                von_mises=point.von_mises,
                depth=point.depth,
                place=point.place,
            )
        )
    return tuple(found)


def _asked(scene: Scene, results: Mapping[Press, Any]) -> list[Press]:
    """List the solves whose pressures lie on the response of a solid: a mesh has a stress of its own."""
    grids = {
        name: options.grids for name in scene.methods.solvers if (options := scene.methods.options(name))
    }
    return [
        solve
        for solve in results
        if solve.is_own and solve.grid in grids[solve.method] and not solve.solver.sinks
    ]


def _response(solve: Press) -> Response:
    return Slots.filled(solve.realised.elastic, solve.effects).felt_response


def _positive(scene: Scene) -> tuple[float, ...] | None:
    """Depths to search: at the surface the edges of the contact ring."""
    assert scene.subsurface is not None
    given = scene.subsurface.depths
    return None if given is None else tuple(depth for depth in given if depth > 0)


def _finest(scene: Scene, results: Mapping[Press, Any]) -> list[Press]:
    """Return the finest of them for each method."""
    return list({solve.method: solve for solve in _asked(scene, results)}.values())


def write_below(scene: Scene, results: Mapping[Press, ContactResult], folder: Path) -> Iterator[Path]:
    """Write the fields below the finest grid of each method, where the scene asks for them."""
    if scene.subsurface is None or not scene.subsurface.vtu:
        return
    from fem_contact.export import write_subsurface
    from fem_contact.subsurface import fields_below

    folder.mkdir(exist_ok=True)
    for solve in _finest(scene, results):
        target = folder / f"{solve.prefix}-below.vtu"
        fields = fields_below(results[solve], _response(solve), depths=scene.subsurface.depths)
        write_subsurface(target, fields)
        yield target


def below_table(c: Comparison) -> WordTable:
    """Return one row for each grid."""
    unit = c.contact_modulus * c.rms_gradient
    return WordTable(
        title="Below the surface",
        columns=(
            "method",
            "grid",
            "von Mises / (E* h'_rms)",
            "von Mises [MPa]",
            "depth / lambda_short",
            "depth [m]",
        ),
        rows=tuple(
            (
                find_method(row.method).label,
                f"{row.grid[0]} x {row.grid[1]}",
                significant(row.von_mises / unit),
                significant(row.von_mises / 1e6),
                significant(row.depth / c.realised.shortest, 3),
                f"{row.depth:.4g}",
            )
            for row in c.below
        ),
        left=frozenset({"method", "grid"}),
        note="The largest von Mises stress below the contact and its depth, from the pressures of each grid. "
        "The surface itself is left out, where the edges of the contact ring. The solid is elastic whatever "
        "its hardness.",
    )


def below_findings(c: Comparison) -> list[str]:
    """Say where it yields first, and what the last refinement changed."""
    sentences = []
    for method in dict.fromkeys(row.method for row in c.below):
        rows = [row for row in c.below if row.method == method]
        last = rows[-1]
        reduced = last.von_mises / (c.contact_modulus * c.rms_gradient)
        text = (
            f"The largest von Mises stress below the surface is {significant(last.von_mises / 1e6)} MPa, "
            f"{significant(reduced)} E* h'_rms, at a depth of {last.depth:.3g} m "
            f"({find_method(method).label} on {last.grid[0]} x {last.grid[1]}); there the solid yields first."
        )
        if len(rows) > 1:
            change = 100 * (last.von_mises / rows[-2].von_mises - 1)
            text += f" The grid before differs by {-change:+.2g} %."
        sentences.append(text)
    return sentences


def below_data(c: Comparison, results: Mapping[Press, ContactResult]) -> xr.Dataset:
    """Von Mises stress over depth below the finest grid of each method: largest, and root mean square."""
    import xarray as xr

    from fem_contact.subsurface import planes_below

    assert c.scene.subsurface is not None
    solves, rows = [], []
    for solve in _finest(c.scene, results):
        for plane in planes_below(results[solve], _response(solve), depths=c.scene.subsurface.depths):
            stress = plane.von_mises
            solves.append(solve.label)
            rows.append((plane.depth, float(stress.max()), float(np.sqrt(np.mean(stress**2)))))
    depth, largest, rms = (list(column) for column in zip(*rows, strict=True))
    return xr.Dataset(
        {
            "solver": ("plane", solves, {"long_name": "solver and grid"}),
            "depth": ("plane", depth, {"units": "m", "long_name": "distance from the surface"}),
            "largest": ("plane", largest, {"units": "Pa", "long_name": "largest von Mises stress"}),
            "rms": ("plane", rms, {"units": "Pa", "long_name": "root mean square von Mises stress"}),
        },
        attrs={"lambda_short": c.realised.shortest, "unit": c.contact_modulus * c.rms_gradient},
    )
