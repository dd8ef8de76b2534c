"""One finite-element solve beside the boundary elements on the same points, reduced to numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.ndimage

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from validation.measures.single_solve import SingleSolve
from validation.solves.solve import Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BlockMeasurement"]

#: Points closer than this to the edge of either contact, in cells, are left out of the second pressure difference.
_EDGE_CELLS = 1.5


@dataclass(frozen=True, kw_only=True)
class BlockMeasurement(SingleSolve):
    """A block of finite elements against boundary elements for the half-space and for the bonded layer of its depth.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    points : int
        Surface nodes along each axis.
    method : {"full", "reduced"}
        The whole system, which shares no contact algorithm with the boundary elements, or its exact reduction.
    element : str
    depth : float
        In periods.
    growth : float
        Of the layers with depth.
    tolerance : float, optional
        Of the finite-element solve, if not its own.
    """

    method: Literal["full", "reduced"] = "reduced"
    element: str = "Hex1"
    depth: float = 1.0
    growth: float = 1.2
    tolerance: float | None = None

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        said = {} if self.tolerance is None else {"tolerance": self.tolerance}
        return (
            super().recipe
            | said
            | {
                "method": self.method,
                "element": self.element,
                "depth": self.depth,
                "growth": self.growth,
                "version": 2,
            }
        )

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"block-{self.method}-{self.points}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"FEM {self.method} {self.element} {self.where}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost."""
        from fem_contact.block import estimate

        shape = (self.points, self.points)
        mesh: Any = {"depth": self.depth, "growth": self.growth, "element": self.element}
        poisson = self.realised.solid.poisson
        size = estimate(shape, (1.0, 1.0), method=self.method, poisson=poisson, **mesh)
        n = self.points**2
        if self.method == "full":
            return Prediction(seconds=3e-6 * size.unknowns, peak_bytes=size.bytes, unknowns=size.unknowns)
        return Prediction(seconds=0.3 + 8e-6 * n, peak_bytes=400 * n, unknowns=size.unknowns)

    def measure(self) -> xr.Dataset:
        """Return areas, gaps and pressure differences of the three solves."""
        import xarray as xr

        from fem_contact import block

        fem, half, layer = self._solved()
        data = {
            "pixel": contact_areas(fem).pixel,
            "perimeter": contact_areas(
                fem, edge_constant=block.ELEMENTS[self.element].edge_constant
            ).perimeter,
            "pixel_bem": contact_areas(half).pixel,
            "perimeter_bem": contact_areas(half).perimeter,
            "pixel_layer": contact_areas(layer).pixel,
            "pressure_half_space": _difference(fem, half),
            "pressure_layer": _difference(fem, layer),
            "pressure_inside": _difference(fem, half, inside=True),
            # The mean gap is the offset less C(0) p0 and the mean height: it compares bodies of different depth.
            "gap": float((fem.gap.mean() - half.gap.mean()) / self.realised.field.rms_height),
            "residual": fem.residuals.worst,
            "seconds": fem.cost.cpu_seconds,
            "peak_bytes": fem.cost.peak_bytes,
            "seconds_bem": half.cost.cpu_seconds,
            "unknowns": fem.cost.unknowns,
        }
        return xr.Dataset({name: ((), float(value)) for name, value in data.items()})

    def _solved(self) -> tuple[ContactResult, ContactResult, ContactResult]:
        """Press the block, the half-space, and the layer as deep as the block."""
        from fem_contact import bem, block
        from fem_contact.response import BondedLayer

        solid, field = self.realised.elastic, self.heights()
        pressure, depth = self.realised.pressure, self.depth * max(self.realised.lengths)
        settings: dict[str, Any] = {} if self.tolerance is None else {"tolerance": self.tolerance}
        fem = block.solve(
            field,
            solid,
            mean_pressure=pressure,
            method=self.method,
            element=self.element,
            depth=depth,
            growth=self.growth,
            **settings,
        ).contact
        half, layer = (
            bem.solve(field, response, mean_pressure=pressure, threads=1)
            for response in (self.half_space, BondedLayer(solid=solid, thickness=depth))
        )
        return fem.checked(), half.checked(), layer.checked()


def _difference(first: ContactResult, second: ContactResult, *, inside: bool = False) -> float:
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
