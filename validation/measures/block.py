"""One finite-element solve beside the boundary elements on the same points, reduced to numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from validation.measures.side_by_side import compared, difference
from validation.measures.single_solve import SingleSolve
from validation.solves.solve import Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BlockMeasurement"]


@dataclass(frozen=True, kw_only=True)
class BlockMeasurement(SingleSolve):
    """A block of finite elements against boundary elements for the half-space and for the bonded layer of its depth.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    grid : tuple of int
        Surface nodes.
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

    version = 2

    method: Literal["full", "reduced"] = "reduced"
    element: str = "Hex1"
    depth: float = 1.0
    growth: float = 1.2
    tolerance: float | None = None

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"block-{self.method}-{self.size}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"FEM {self.method} {self.element} {self.where}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost."""
        from fem_contact.block import estimate

        mesh: Any = {"depth": self.depth, "growth": self.growth, "element": self.element}
        poisson = self.realised.solid.poisson
        size = estimate(self.grid, self._sides, method=self.method, poisson=poisson, **mesh)
        n = self.points
        if self.method == "full":
            return Prediction(seconds=3e-6 * size.unknowns, peak_bytes=size.bytes, unknowns=size.unknowns)
        return Prediction(seconds=0.3 + 8e-6 * n, peak_bytes=400 * n, unknowns=size.unknowns)

    @property
    def _sides(self) -> tuple[float, float]:
        """Periods over the longer of them."""
        lx, ly = self.realised.lengths
        return lx / max(lx, ly), ly / max(lx, ly)

    def measure(self) -> xr.Dataset:
        """Return areas, gaps and pressure differences of the three solves."""
        import xarray as xr

        from fem_contact import block

        fem, half, layer = self._solved()
        data = {
            **compared(
                fem,
                half,
                edge_constant=block.ELEMENTS[self.element].edge_constant,
                rms_height=self.realised.field.rms_height,
            ),
            "pixel_layer": contact_areas(layer).pixel,
            "pressure_layer": difference(fem, layer),
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
