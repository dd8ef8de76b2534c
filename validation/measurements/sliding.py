"""One surface that slides at several velocities, on several grids, reduced to numbers, and what the theory says of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from fem_contact.sliding import slide
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from persson.sliding import friction_of_waves
from persson.variants import corrected_contact_area
from validation.arrays import Array, Grid
from validation.execution.measurement import Call, measurement
from validation.measurements.flow import located_area
from validation.measurements.theory import VARIANTS, wave_powers
from validation.scenes.problem import ContactProblem

Rubber = PronySolid | TabulatedSolid

#: Shares g of the full energy that the theory's friction stores at vanishing contact, S = g + (1 - g) P^2.
SHARES = {"full_energy": 1.0, "half_energy": 0.5}
#: What is read off every solve: friction mu / h'_rms by the pressure on the slopes and by what the solid loses, A/A0 with
#: the edge located inside the cells, the factor by which a plain step of the solver shrinks the error, and costs.
QUANTITIES = ("friction", "dissipation", "area", "contraction", "steps", "fft_pairs", "residual")


@measurement(
    "slide-{size}",
    kind="SlideSolve",
    words="slide, to",
    located=True,
    version=1,
    # Some three hundred pairs of transforms for each velocity and grid.
    seconds=lambda grids, velocities: len(velocities) * sum(0.03 + 1.2e-5 * nx * ny for nx, ny in grids),
    bytes=600,
)
def slides(
    *, problem: ContactProblem, rubber: Rubber, velocities: tuple[float, ...], grids: tuple[Grid, ...]
) -> xr.Dataset:
    """Let one surface slide under its load at rising velocities, each started from the one before, on nested grids.

    `QUANTITIES` over (grid, velocity), v [m/s] along x; the solid of `problem` is the relaxed one.
    """
    values, gradient = np.empty((len(QUANTITIES), len(grids), len(velocities))), problem.field.rms_gradient
    for i, grid in enumerate(grids):
        heights, start = problem.heights(grid), None
        for k, velocity in enumerate(velocities):
            sliding = slide(
                heights, rubber, velocity=velocity, mean_pressure=problem.pressure, start=start, threads=1
            ).checked()
            contact = sliding.contact
            start = contact.pressure
            friction = sliding.slopes / gradient, sliding.dissipation / gradient
            costs = contact.cost.iterations, contact.cost.fft_pairs, contact.residuals.worst
            values[:, i, k] = *friction, located_area(contact), sliding.contraction, *costs
    return xr.Dataset({name: (("grid", "velocity"), values[q]) for q, name in enumerate(QUANTITIES)})


def slid_of(measured: xr.Dataset, solve: Call) -> xr.Dataset:
    """Reduce what one of `slides` left to (velocity) on its finest grid, with what each grid gave, and the theory's.

    The drift of ``friction_each`` is its distance to ``friction_dissipated_each``, that of ``area_each``
    its step from the grid before; ``_grid_each`` is over (grid, velocity).
    """
    on_grids = {"friction": "friction", "friction_dissipated": "dissipation", "area": "area"}
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_grid_each": measured[of] for name, of in on_grids.items()}
    numbers |= {f"{name}_each": fine[of] for name, of in on_grids.items()}
    numbers |= {f"{name}_each": measured[name] for name in QUANTITIES[3:]}
    numbers["friction_each_drift"] = fine.friction - fine.dissipation
    numbers["area_each_drift"] = fine.area - before.area
    friction, area = _theory(solve["problem"], solve["rubber"], solve["velocities"])
    numbers |= {f"friction_{name}_each": ("velocity", friction[:, k]) for k, name in enumerate(SHARES)}
    numbers |= {f"area_{name}_each": ("velocity", area[:, k]) for k, name in enumerate(VARIANTS)}
    return xr.Dataset(numbers)


def _theory(case: ContactProblem, rubber: Rubber, velocities: tuple[float, ...]) -> tuple[Array, Array]:
    field = case.field
    x, y, power = wave_powers(field.heights, field.spacing)
    power[0, 0] = 0
    there = power > 1e-20 * power.max()
    friction = np.empty((len(velocities), len(SHARES)))
    area = np.empty((len(velocities), len(VARIANTS)))
    for k, velocity in enumerate(velocities):
        for j, share in enumerate(SHARES.values()):
            friction_of = friction_of_waves(
                x[there],
                y[there],
                power=power[there],
                pressure=case.pressure,
                velocity=velocity,
                modulus=rubber.modulus,
                poisson=rubber.poisson,
                energy_ratio=share,
            )
            friction[k, j] = friction_of.friction / field.rms_gradient
        for j, variant in enumerate(VARIANTS):
            area[k, j] = corrected_contact_area(
                case.pressure, stress_variance=friction_of.stress_variance, variant=variant
            )
    return friction, area
