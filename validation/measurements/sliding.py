"""One surface that slides at several velocities, on several grids, reduced to numbers, and what the theory says of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.sliding import slide
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from persson.sliding import friction_of_waves
from validation.arrays import Grid
from validation.execution.measurement import Call, measurement
from validation.measurements.theory import variant_areas, wave_powers
from validation.scenes.problem import ContactProblem

Rubber = PronySolid | TabulatedSolid

#: Shares g of the full energy that the theory's friction stores at vanishing contact, S = g + (1 - g) P^2.
SHARES = {"full_energy": 1.0, "half_energy": 0.5}
#: What is read off every solve: friction mu / h'_rms by the pressure on the slopes and by what the solid loses, A/A0
#: corrected at its edge, the factor by which a plain step of the solver shrinks the error, and costs. (Where it slides the
#: pressure at the edge is not that by which a located edge is found.)
QUANTITIES = ("friction", "dissipation", "area", "contraction", "steps", "fft_pairs", "residual")


@measurement(
    "slide-{size}",
    kind="SlideSolve",
    words="slide, to",
    version=2,
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
            values[:, i, k] = *friction, contact_areas(contact).perimeter, sliding.contraction, *costs
    return xr.Dataset({name: (("grid", "velocity"), values[q]) for q, name in enumerate(QUANTITIES)})


def slid_of(measured: xr.Dataset, solve: Call) -> xr.Dataset:
    """Reduce what one of `slides` left to (velocity) on its finest grid, with what each grid gave, and the theory's.

    Drifts are steps from the grid before; of a friction its distance to the other if that is larger, since
    steps change their sign along the velocities. ``_grid_each`` is over (grid, velocity).
    """
    on_grids = {"friction": "friction", "friction_dissipated": "dissipation", "area": "area"}
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_grid_each": measured[of] for name, of in on_grids.items()}
    apart = {"friction": fine.friction - fine.dissipation, "dissipation": fine.dissipation - fine.friction}
    for name, of in on_grids.items():
        step = fine[of] - before[of]
        other = apart.get(of, step)
        numbers |= {f"{name}_each": fine[of], f"{name}_each_drift": step.where(abs(step) > abs(other), other)}
    numbers |= {f"{name}_each": measured[name] for name in QUANTITIES[3:]}
    return xr.Dataset(numbers | _theory(solve["problem"], solve["rubber"], solve["velocities"]))


def _theory(case: ContactProblem, rubber: Rubber, velocities: tuple[float, ...]) -> dict[str, Any]:
    """Friction over h'_rms for either energy, and A/A0 by every variant, (velocity)."""
    field = case.field
    x, y, power = wave_powers(field.heights, field.spacing)
    power[0, 0] = 0
    there = power > 1e-20 * power.max()
    rows: list[dict[str, Any]] = []
    for velocity in velocities:
        told = {
            name: friction_of_waves(
                x[there],
                y[there],
                power=power[there],
                pressure=case.pressure,
                velocity=velocity,
                modulus=rubber.modulus,
                poisson=rubber.poisson,
                energy_ratio=share,
            )
            for name, share in SHARES.items()
        }
        variance = told["full_energy"].stress_variance
        frictions = {f"friction_{name}": each.friction / field.rms_gradient for name, each in told.items()}
        rows.append(frictions | variant_areas(case.pressure, stress_variance=variance))
    return {f"{name}_each": ("velocity", [row[name] for row in rows]) for name in rows[0]}
