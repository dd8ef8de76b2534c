"""One solve by any method beside boundary elements on the same points, reduced to numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.ndimage

from fem_contact.area import TRAITS, ContactAreas, contact_areas
from fem_contact.contact import ContactResult, Status
from validation.effects.base import Slots
from validation.measures.measurement import has_square_cells
from validation.measures.single_solve import SingleSolve
from validation.methods import find_solver
from validation.methods.base import Job, Settings, Solver
from validation.scenes.scene import EffectSpec
from validation.solves.press import Press
from validation.solves.solve import LOCATED_EDGES, Prediction

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

__all__ = ["ByMethod", "areas_by_method", "compared", "difference"]

#: Points closer than this to the edge of either contact, in cells, are left out of the second pressure difference.
_EDGE_CELLS = 1.5


@dataclass(frozen=True, kw_only=True)
class ByMethod(SingleSolve):
    """One surface at one load on one grid by a method, beside boundary elements.

    Attributes
    ----------
    method : str
        Name of a solver.
    settings : tuple of (str, value)
        What it is told.
    effects : tuple
        Of a scene.
    """

    method: str
    settings: Settings = ()
    effects: tuple[EffectSpec, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {
            **super().recipe,
            "method": self.method,
            "settings": dict(self.settings),
            "effects": [effect.model_dump(mode="json", exclude_none=True) for effect in self.effects],
            "edges": LOCATED_EDGES,
        }

    @property
    def solver(self) -> Solver:
        """The method."""
        return find_solver(self.method)

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"beside-{self.method}-{self.size}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{self.solver.label} {self.where}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict as a scene does."""
        told: dict[str, Any] = {"realised": self.realised, "settings": self.settings, "effects": self.effects}
        return Press(method=self.method, grid=self.grid, **told).predict(pair_seconds=pair_seconds)

    @property
    def code_path(self) -> tuple[str, ...]:
        """Boundary elements, the method and its variant, kinds of effects."""
        variant = self.solver.variant(dict(self.settings))
        return ("bem", self.method, variant, *sorted(effect.kind for effect in self.effects))

    def warm_up(self) -> None:
        """Let both methods run through their compiled passes."""
        find_solver("bem").rehearse(self.effects)
        self.solver.rehearse(self.effects, dict(self.settings))

    def measure(self) -> xr.Dataset:
        """Return areas, gap, pressure differences and cost; `converged` is 1 where its residuals allow it.

        Raises
        ------
        NotConverged
            Where nothing comes of the method, or boundary elements themselves fail.
        """
        import xarray as xr

        field, solver = self.heights(), self.solver

        def solved(by: Solver, settings: Mapping[str, Any]) -> ContactResult:
            slots = Slots.filled(self.realised.elastic, self.effects)
            load = {"mean_pressure": self.realised.pressure}
            return by.solve(Job(field=field, load=load, slots=slots, settings=settings, threads=1)).contact

        found, ours = solved(solver, dict(self.settings)), solved(find_solver("bem"), {}).checked()
        constant = solver.edge_constant(found)
        located = solver.locates_edges and not self.effects and has_square_cells(self.realised, self.grid)
        areas = contact_areas(found, edge_constant=constant, subcell=located)
        data = compared(found, ours, edge_constant=constant, rms_height=self.realised.field.rms_height)
        data |= {
            "subcell": np.nan if areas.subcell is None else areas.subcell,
            "edge_fraction": areas.edge_fraction,
            **{name: getattr(areas, name) for name in TRAITS},
            "edge_constant": constant,
            "converged": float(found.status is Status.CONVERGED),
            "iterations": found.cost.iterations,
        }
        return xr.Dataset({name: ((), float(value)) for name, value in data.items()})


def areas_by_method(data: xr.Dataset, grid: tuple[int, int]) -> ContactAreas:
    """Return the areas of one such solve, as limits take them."""
    nx, ny = grid
    subcell = float(data.subcell)
    return ContactAreas(
        pixel=float(data.pixel),
        perimeter=float(data.perimeter),
        edge_length=np.nan,
        edge_fraction=float(data.edge_fraction),
        edge_constant=float(data.edge_constant),
        spacing=(1 / nx, 1 / ny),
        subcell=None if np.isnan(subcell) else subcell,
        cells=nx * ny,
        **{name: float(data[name]) for name in TRAITS},
    )


def compared(
    found: ContactResult, half: ContactResult, *, edge_constant: float, rms_height: float
) -> dict[str, float]:
    """Return areas, differences and cost of a solve beside boundary elements on the same points.

    Parameters
    ----------
    found, half : ContactResult
        Of the method, and of boundary elements.
    edge_constant : float
        That of the method.
    rms_height : float
        h_rms [m], the unit of the gap.
    """
    areas, ours = contact_areas(found, edge_constant=edge_constant), contact_areas(half)
    return {
        "pixel": areas.pixel,
        "perimeter": areas.perimeter,
        "pixel_bem": ours.pixel,
        "perimeter_bem": ours.perimeter,
        "pressure_half_space": difference(found, half),
        "pressure_inside": difference(found, half, inside=True),
        # The mean gap is the offset less C(0) p0 and the mean height: it compares bodies of different depth.
        "gap": float((found.gap.mean() - half.gap.mean()) / rms_height),
        "residual": found.residuals.worst,
        "seconds": found.cost.cpu_seconds,
        "peak_bytes": found.cost.peak_bytes,
        "seconds_bem": half.cost.cpu_seconds,
        "unknowns": found.cost.unknowns,
    }


def difference(first: ContactResult, second: ContactResult, *, inside: bool = False) -> float:
    """||p1 - p2|| / ||p2||, over all points or away from the edges of both contacts."""
    keep = np.ones(first.shape, dtype=bool)
    if inside:
        keep = _away_from_edge(np.asarray(first.in_contact)) & _away_from_edge(np.asarray(second.in_contact))
    scale = float(np.linalg.norm(second.pressure[keep]))
    return (
        float(np.linalg.norm((first.pressure - second.pressure)[keep]) / scale) if scale > 0 else float("nan")
    )


def _away_from_edge(contact: np.ndarray) -> np.ndarray:
    """Return the points further than 1.5 cells from any change of the contact map."""
    margin = 3
    padded = np.pad(contact, margin, mode="wrap")
    to_edge = np.where(
        padded, scipy.ndimage.distance_transform_edt(padded), scipy.ndimage.distance_transform_edt(~padded)
    )
    return np.asarray(to_edge[margin:-margin, margin:-margin] > _EDGE_CELLS)
