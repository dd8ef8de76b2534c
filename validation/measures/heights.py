"""How a surface's heights are distributed, and its contact area under given loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from validation.measures.flow import located_area
from validation.measures.single_solve import SingleSolve, Takes

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["HEIGHT_EDGES", "HeightStatistics"]

#: Edges of the bins of h/h_rms.
HEIGHT_EDGES = np.linspace(-4.0, 4.0, 65)


@dataclass(frozen=True, kw_only=True)
class HeightStatistics(SingleSolve):
    """Heights of one surface, and its contact area under given loads.

    Attributes
    ----------
    realised : Realised
        Surface and solid.
    grid : tuple of int
    pressures : tuple of float
        p0 [Pa], rising; none for the heights alone.
    """

    kind, words = "heights", "heights"
    located, version = True, 2
    takes = Takes(once=1e-2, seconds=2e-3, each_point=8e-7, bytes=200)

    pressures: tuple[float, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers; the loads are its own."""
        return {name: value for name, value in super().recipe.items() if name != "load"}

    @property
    def problems(self) -> int:
        """One for each load."""
        return len(self.pressures)

    def measure(self) -> xr.Dataset:
        """Read off the heights over the realised rms height, and press; dimensions (bin) and (load)."""
        import xarray as xr

        from fem_contact import bem

        field, start, areas = self.heights(), None, []
        for pressure in self.pressures:
            solved = bem.solve(
                field, self.half_space, mean_pressure=pressure, start=start, threads=1
            ).checked()
            start = solved.pressure
            areas.append(located_area(solved))
        z = np.sort(field.heights.ravel() / self.realised.field.rms_height)
        share = (np.arange(z.size) + 0.5) / z.size
        density = np.histogram(z, bins=HEIGHT_EDGES)[0] / (z.size * np.diff(HEIGHT_EDGES))
        return xr.Dataset(
            {
                "height_density_each": ("bin", density),
                "area_each": ("load", areas),
                "skewness_each": float(np.mean(z**3)),
                "excess_kurtosis_each": float(np.mean(z**4) - 3),
                "height_distance_each": float(np.max(np.abs(ndtr(z) - share))),
                "highest_each": float(z[-1]),
                "rms_height_each": self.realised.field.rms_height,
                "rms_gradient_each": self.realised.field.rms_gradient,
            }
        )
