"""Hard cases of the effects: yielding, adhesion, both, coatings, and the theory of a yielding solid."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.measurements.hard_cases.cases import (
    HALF_SPACE,
    HardCase,
    Measured,
    judged,
    load_errors,
    rough,
)

_LOAD = 0.01


def _hard(ratio: float) -> Measured:
    from fem_contact.hardness import Hardness, press_yielding

    hardness = ratio * _LOAD
    result = press_yielding(
        rough(), HALF_SPACE, hardness=Hardness(pressure=hardness), mean_pressure=_LOAD, threads=1
    )
    return judged(result, load_errors(result, load=_LOAD, hardness=hardness))


def _sticky(maugis: float) -> Measured:
    from fem_contact.adhesion import path as adhesion_path
    from fem_contact.adhesion.laws import Dugdale
    from persson.spheres import maugis_pull_off

    points, length, radius, stiffness = 96, 12.0, 100.0, 4 / 3
    work = stiffness / (math.pi * radius**2)
    strength = maugis / 2 * (math.pi * work * stiffness**2 / radius) ** (1 / 3)
    x = (np.arange(points) - points // 2) * length / points
    surface = HeightField(
        heights=-(x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius), lengths=(length, length)
    )
    path = adhesion_path.follow(
        surface,
        HALF_SPACE,
        law=Dugdale(work=work, reach=work / strength),
        offsets=np.arange(-0.3, 1.0, 0.05) / radius,
        threads=1,
    )
    force = path.greatest_tension * length**2 / (math.pi * work * radius)
    contact = path.last.contact
    return judged(contact, abs(force / maugis_pull_off(maugis / 1.157) - 1))


def _contrast(ratio: float) -> Measured:
    from fem_contact.graded import LayeredSolid

    coating, q = Solid(young=ratio, poisson=0.3), np.geomspace(1e-2, 1e3, 200)
    base = Solid(young=1.0, poisson=0.3)
    layered = LayeredSolid(layers=[coating], thicknesses=[0.1], base=base)
    cut = LayeredSolid(layers=[coating] * 3, thicknesses=[0.02, 0.05, 0.03], base=base)
    compliance, two = layered.compliance(q, 0 * q), cut.compliance(q, 0 * q)
    result = bem.solve(rough(), layered, mean_pressure=1e-4 * min(ratio, 1.0), threads=1)
    return judged(result, float(np.max(np.abs(two / compliance - 1))))


def _yielding_under_adhesion(ratio: float) -> Measured:
    from fem_contact import adhesion
    from fem_contact.adhesion.laws import Exponential

    work, points, hardness = 1e-4, 64, ratio * _LOAD
    state = adhesion.solve(
        rough(points),
        HALF_SPACE,
        law=Exponential(work=work, reach=math.sqrt(3 / points * work)),
        hardness=hardness,
        mean_pressure=_LOAD,
        tolerance=1e-10,
        threads=1,
    )
    return judged(state.contact, load_errors(state.contact, load=_LOAD, hardness=hardness))


def _diffusion(ratio: float) -> Measured:
    from persson.diffusion import solve_diffusion
    from persson.hardness import constant_hardness

    pressure, hardness = 0.1, 1.0
    variance = np.array([ratio * hardness**2])
    diffused = solve_diffusion(variance, pressure=pressure, yield_stress=hardness)
    exact = constant_hardness(pressure, stress_variance=variance, yield_stress=hardness)
    error = abs(float(diffused.area_plastic[0] - exact.plastic[0]))
    return Measured(error=error, residual=float(diffused.load_residual[0]))


EFFECTS = (
    HardCase(
        name="hardness",
        method="bem",
        varied="H / p0, from hard to barely carrying",
        values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
        reference="loads add up, none above the bound; relative to the load",
        bound=1e-9,
        limit="below 1 nothing carries the load",
        refusable=lambda value: value < 1,
        measure=_hard,
    ),
    HardCase(
        name="adhesion",
        method="bem",
        varied="Maugis's lambda of a sphere, from weak and far to sticky and near",
        values=(0.1, 0.3, 1.0, 1.5, 1.9, 3.0),
        reference="Maugis's pull-off force; relative",
        bound=0.02,
        limit="above 1.9 the process zone is below 2 cells",
        refusable=lambda value: value > 1.9,
        measure=_sticky,
    ),
    HardCase(
        name="contrast",
        method="bem",
        varied="modulus of a coating over the base's",
        values=(1.0, 0.1, 10.0, 0.01, 100.0, 1e-3, 1e3, 1e-4, 1e4, 1e-8, 1e8),
        reference="the same coating cut in three; relative change of the compliance",
        bound=1e-7,
        measure=_contrast,
    ),
)

DIFFUSION = HardCase(
    name="decades",
    method="theory",
    varied="V / sigma_Y^2",
    values=tuple(np.geomspace(1e-20, 1e20, 11).tolist()),
    reference="closed form of constant hardness; A_pl/A0",
    bound=1e-5,
    measure=_diffusion,
)

YIELDING_UNDER_ADHESION = HardCase(
    name="yielding-adhesion",
    method="bem",
    varied="H / p0 under adhesion, from hard to barely carrying",
    values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
    reference="loads add up, none above the bound; relative to load and bound",
    # The imbalance asked for is 1e-10 of the law's strength, which is some seven times the load.
    bound=1e-8,
    limit="at 1 and below nothing carries the load",
    refusable=lambda value: value <= 1,
    measure=_yielding_under_adhesion,
)
