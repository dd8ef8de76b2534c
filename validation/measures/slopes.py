"""One surface made steeper and steeper in a block of finite strain, beside the linear block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.errors import NotConverged
from validation.measures.single_solve import SingleSolve
from validation.solves.solve import Prediction

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.block import FiniteStrain

__all__ = ["SlopeMeasurement"]

#: What is measured of every slope.
_NAMES = {
    "area": "A/A0 projected on the plane where the nodes are now, nodes counted",
    "material_area": "share of the undeformed surface in contact, nodes counted",
    "true_area": "area along the rigid surface over A0, nodes counted",
    "square_pressure": "int p^2 dA / (p0^2 A0), p over the projected area",
    "residual": "forces that nothing balances over those of the contact",
    "sideways": "mean force along the plane over the load",
}


@dataclass(frozen=True, kw_only=True)
class SlopeMeasurement(SingleSolve):
    """A surface at one p0 / (E* h'_rms) with rising slopes, where the solid is neo-Hookean.

    Attributes
    ----------
    realised : Realised
    grid : tuple of int
    slopes : tuple of float
        h'_rms to which the heights are scaled, rising.
    depth : float
        Of the block, in periods.
    growth : float
        Of the layers with depth.
    """

    kind, words = "slopes", "finite strain"
    version = 1

    slopes: tuple[float, ...]
    depth: float = 1.0
    growth: float = 1.3

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost: some four Newton steps for each slope."""
        unknowns = int(3 * self.points * 3 * np.log(self.points))
        return Prediction(
            seconds=0.5 + 4e-5 * unknowns * len(self.slopes), peak_bytes=9000 * unknowns, unknowns=unknowns
        )

    def measure(self) -> xr.Dataset:
        """Return areas and the mean square pressure by slope; NaN, with the reason, where Newton's method ends."""
        import xarray as xr
        from threadpoolctl import threadpool_limits

        from fem_contact import block

        field, solid = self.heights(), self.realised.elastic
        pressure = self.realised.reduced_pressure * solid.contact_modulus * field.rms_gradient
        mesh: Any = {"depth": self.depth * max(field.lengths), "growth": self.growth}
        found = {name: np.full(len(self.slopes), np.nan) for name in _NAMES}
        ended = ""
        with threadpool_limits(limits=1, user_api="blas"):
            linear = block.solve(field, solid, mean_pressure=pressure, **mesh).contact.checked()
            try:
                for k, each in enumerate(
                    block.solve_slopes(field, solid, mean_pressure=pressure, slopes=self.slopes, **mesh)
                ):
                    for name, value in _read_off(each).items():
                        found[name][k] = value
            except NotConverged as error:
                ended = str(error)
        return xr.Dataset(
            {name: ("slope", values, {"long_name": _NAMES[name]}) for name, values in found.items()}
            | {
                "linear_area": ((), float(np.mean(linear.in_contact))),
                "linear_square_pressure": ((), float(np.mean(linear.pressure**2)) / linear.mean_pressure**2),
            },
            coords={"slope": list(self.slopes)},
            attrs={"ended": ended},
        )


def _read_off(found: FiniteStrain) -> dict[str, float]:
    return {
        "area": found.area,
        "material_area": found.material_area,
        "true_area": found.true_area,
        "square_pressure": float(np.mean(found.shares * found.pressure**2)) / found.mean_pressure**2,
        "residual": found.residual,
        "sideways": found.sideways,
    }
