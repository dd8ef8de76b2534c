"""One surface that slides at several velocities, on several grids, reduced to numbers, and what the theory says of it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import contact_areas
from fem_contact.sliding import SlidingContact, slide
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from persson.sliding import friction_of_waves
from persson.variants import corrected_contact_area
from validation.arrays import Array, Grid
from validation.measures.theory import VARIANTS
from validation.scenes.realised import Realised
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SHARES", "Rubber", "SlideSolve", "slid_of"]

Rubber = PronySolid | TabulatedSolid

#: Shares g of the full energy that the theory's friction stores at vanishing contact, S = g + (1 - g) P^2.
SHARES = {"full_energy": 1.0, "half_energy": 0.5}
#: What is read off every solve: friction mu / h'_rms by the pressure on the slopes and by what the solid loses, A/A0 with
#: the edge located inside the cells, the factor by which a plain step of the solver shrinks the error, and costs.
QUANTITIES = ("friction", "dissipation", "area", "contraction", "steps", "fft_pairs", "residual")


@dataclass(frozen=True, kw_only=True)
class SlideSolve(NumbersSolve):
    """One surface under its load at rising velocities, each started from the one before, on nested grids.

    Attributes
    ----------
    realised : Realised
        Surface and load; its solid is the relaxed one.
    rubber : PronySolid or TabulatedSolid
    velocities : tuple of float
        v [m/s] along x.
    grids : tuple of (int, int)
    """

    realised: Realised
    rubber: Rubber
    velocities: tuple[float, ...]
    grids: tuple[Grid, ...]

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        solid = {part.name: getattr(self.rubber, part.name) for part in fields(self.rubber) if part.init}
        return {
            **self.realised.recipe,
            "rubber": {name: list(v) if isinstance(v, tuple) else v for name, v in solid.items()},
            "velocities": list(self.velocities),
            "grids": [list(grid) for grid in self.grids],
            "edges": LOCATED_EDGES,
            "version": 1,
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"slide-{max(self.grids)[0]}x{max(self.grids)[1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        nx, ny = max(self.grids)
        return f"slide, surface {self.realised.realisation + 1}, to {nx}x{ny}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost: some three hundred pairs of transforms for each velocity and grid."""
        points = [nx * ny for nx, ny in self.grids]
        return Prediction(
            seconds=len(self.velocities) * sum(0.03 + 1.2e-5 * n for n in points),
            peak_bytes=600 * max(points),
            unknowns=max(points),
        )

    def measure(self) -> xr.Dataset:
        """Solve everything and keep the numbers; dimensions (grid, velocity)."""
        import xarray as xr

        values = {name: np.empty((len(self.grids), len(self.velocities))) for name in QUANTITIES}
        for i, grid in enumerate(self.grids):
            heights, start = self.realised.heights(grid), None
            for k, velocity in enumerate(self.velocities):
                found = slide(
                    heights,
                    self.rubber,
                    velocity=velocity,
                    mean_pressure=self.realised.pressure,
                    start=start,
                    threads=1,
                ).checked()
                start = found.contact.pressure
                for name, value in self._read_off(found).items():
                    values[name][i, k] = value
        return xr.Dataset({name: (("grid", "velocity"), values[name]) for name in QUANTITIES})

    def _read_off(self, found: SlidingContact) -> dict[str, float]:
        """Return every one of `QUANTITIES` of one solve."""
        gradient, contact = self.realised.field.rms_gradient, found.contact
        located = contact_areas(contact, subcell=True).subcell
        assert located is not None
        return {
            "friction": found.slopes / gradient,
            "dissipation": found.dissipation / gradient,
            "area": located,
            "contraction": found.contraction,
            "steps": contact.cost.iterations,
            "fft_pairs": contact.cost.fft_pairs,
            "residual": contact.residuals.worst,
        }


def slid_of(measured: xr.Dataset, solve: SlideSolve) -> xr.Dataset:
    """Reduce one `SlideSolve` to numbers over (velocity) on its finest grid, with what each grid gave, and the theory's.

    Returns
    -------
    xarray.Dataset
        ``friction_each``, whose drift is its distance to ``friction_dissipated_each``, and ``area_each``, whose drift is
        its step from the grid before; ``_grid_each`` over (grid, velocity); friction by the shares of the full energy and
        area by the variants of the theory, told the realised waves.
    """
    import xarray as xr

    on_grids = {"friction": "friction", "friction_dissipated": "dissipation", "area": "area"}
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_grid_each": measured[of] for name, of in on_grids.items()}
    numbers |= {f"{name}_each": fine[of] for name, of in on_grids.items()}
    numbers |= {f"{name}_each": measured[name] for name in QUANTITIES[3:]}
    numbers["friction_each_drift"] = fine.friction - fine.dissipation
    numbers["area_each_drift"] = fine.area - before.area
    friction, area = _theory(solve.realised, solve.rubber, solve.velocities)
    numbers |= {f"friction_{name}_each": ("velocity", friction[:, k]) for k, name in enumerate(SHARES)}
    numbers |= {f"area_{name}_each": ("velocity", area[:, k]) for k, name in enumerate(VARIANTS)}
    return xr.Dataset(numbers, attrs={"solve": measured.attrs["solve"]})


def _theory(case: Realised, rubber: Rubber, velocities: tuple[float, ...]) -> tuple[Array, Array]:
    """Friction over (velocity, share) and area over (velocity, variant), told the realised waves."""
    field = case.field
    waves = np.fft.fft2(field.heights, norm="forward")
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(field.shape, field.spacing, strict=True))
    power = np.abs(waves) ** 2
    power[0, 0] = 0
    there = power > 1e-20 * power.max()
    x, y = (part[there] for part in np.broadcast_arrays(qx[:, None], qy[None, :]))
    friction = np.empty((len(velocities), len(SHARES)))
    area = np.empty((len(velocities), len(VARIANTS)))
    for k, velocity in enumerate(velocities):
        for j, share in enumerate(SHARES.values()):
            said = friction_of_waves(
                x,
                y,
                power=power[there],
                pressure=case.pressure,
                velocity=velocity,
                modulus=rubber.modulus,
                poisson=rubber.poisson,
                energy_ratio=share,
            )
            friction[k, j] = said.friction / field.rms_gradient
        for j, variant in enumerate(VARIANTS):
            area[k, j] = corrected_contact_area(
                case.pressure, stress_variance=said.stress_variance, variant=variant
            )
    return friction, area
