"""Adhesion of solvers: the laws of the gap, the balance of a state, its stability, and what a loop loses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.integrate import quad

from fem_contact import adhesion
from fem_contact.adhesion import Dugdale, Exponential, GapLaw
from fem_contact.contact import Status
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.cases import Check, below, case, holds, near, relative, within

_BODY = HalfSpace(solid=Solid(young=1.0, poisson=0.0))


@case(
    "adhesion-laws",
    "Attraction is the slope of the energy of the gap, and parting flat surfaces takes w.",
    source="definition; D. Maugis, J. Colloid Interface Sci. 150, 243 (1992)",
)
def _laws() -> Iterator[Check]:
    """Pull flat surfaces apart: attraction is the slope of the energy, and its work is w."""
    laws: dict[str, GapLaw] = {
        "exponential": Exponential(work=2e-3, reach=0.05),
        "Dugdale": Dugdale(work=2e-3, reach=0.05),
        "Dugdale with a ramp": Dugdale(work=2e-3, reach=0.05, ramp=0.8),
    }
    for name, law in laws.items():
        gap, step = np.array([0.004, 0.021, 0.043, 0.058, 0.2]), 1e-5
        energy = (law.energy(gap + step) - law.energy(gap - step)) / (2 * step)
        fall = (law.traction(gap + step) - law.traction(gap - step)) / (2 * step)
        off = float(np.max(np.abs(energy - law.traction(gap)))) / law.strength
        steep = float(np.max(np.abs(fall - law.slope(gap)))) / law.strength * law.reach
        work = quad(
            lambda g, law=law: float(law.traction(np.array(g))), 0, 2.0, points=[0.03, 0.05, 0.07], limit=200
        )[0]
        yield below(f"tau - d phi / d g over the strength, {name}", off, 1e-6)
        yield below(f"slope - d tau / d g over strength and reach, {name}", steep, 1e-6)
        yield relative(f"work of separation, {name} [J/m^2]", work, 2e-3, 1e-6)
        yield relative(f"energy in contact, {name} [J/m^2]", -law.energy(np.zeros(1))[0], 2e-3, 1e-12)
    steepest = laws["exponential"].steepest
    yield relative("steepest fall, exponential [Pa/m]", steepest, 2e-3 / 0.05**2, 1e-12)
    cells = adhesion.cells_in_process_zone(laws["exponential"], spacing=0.1, contact_modulus=5.0)
    yield relative("cells of a process zone, E* w / strength^2 dx", cells, 62.5, 1e-12)


def _wave(n: int = 24) -> HeightField:
    x = 2 * math.pi * np.arange(n) / n
    return HeightField(heights=0.02 * np.cos(x)[:, None] * np.cos(x)[None, :], lengths=(1.0, 1.0))


_LAW = Exponential(work=8e-4, reach=0.02)


@case(
    "adhesion-balance",
    "In an adhesive state forces balance, the gap closes, and its energy is the sum of both parts.",
    source="half-space, wave by wave",
    tolerance="solver",
)
def _balance() -> Iterator[Check]:
    """Look at a state with plain sums: forces, gap and energy."""
    surface = _wave()
    state = adhesion.solve(surface, _BODY, law=_LAW, mean_pressure=0.01, tolerance=1e-9).checked()
    contact = state.contact
    geometry = contact.displacement - surface.heights + contact.offset - contact.gap
    apart = ~contact.in_contact
    pull = contact.pressure + _LAW.traction(contact.gap)
    # u-hat = 2 p-hat / (E* q), without its mean.
    q = 2 * math.pi * np.fft.fftfreq(24, 1 / 24)
    size = np.hypot(q[:, None], q[None, :])
    size[0, 0] = np.inf
    moved = np.fft.ifft2(2 / size * np.fft.fft2(contact.pressure)).real
    energy = float(np.mean(0.5 * contact.pressure * moved + _LAW.energy(contact.gap)))
    strain = float(np.max(np.abs(moved - (contact.displacement - contact.displacement.mean()))))
    stopped = adhesion.solve(surface, _BODY, law=_LAW, mean_pressure=0.01, max_iterations=1).contact
    wall = stopped.pressure + _LAW.traction(np.maximum(stopped.gap, 0.0))
    torn = adhesion.solve(surface, _BODY, law=_LAW, mean_pressure=-2 * _LAW.strength).contact
    yield below(
        "gap - (u - h + offset) over h_rms", float(np.max(np.abs(geometry))) / surface.rms_height, 1e-12
    )
    yield below(
        "force on a free point over the strength",
        float(np.max(np.abs(pull[apart]))) / _LAW.strength,
        1e-6,
    )
    yield below("displacement of the pressure, over h_rms", strain / surface.rms_height, 1e-9)
    yield relative("elastic and gap energy [J/m^2]", state.energy, energy, 1e-9)
    yield relative("mean pressure [Pa]", contact.pressure.mean(), 0.01, 1e-6)
    yield holds("stopped after one step: says so", stopped.status is Status.ITERATION_LIMIT)
    yield relative(
        "tension of the walls then, over E* h'_rms",
        stopped.residuals.tension,
        max(-float(wall.min()), 0.0) / surface.rms_gradient,
        1e-9,
    )
    yield holds("that tension is there", stopped.residuals.tension > 1e-6)
    yield holds("pulled beyond the strength: parted", torn.status is Status.SEPARATED)


@case(
    "adhesion-stability",
    "Flat surfaces are unstable where the law falls faster than the longest wave is stiff.",
    source="E* q / 2 against -d tau / d g; exact",
)
def _stability() -> Iterator[Check]:
    """Hold flat surfaces apart: the longest wave gives way where |d tau / d g| exceeds E* q / 2."""
    flat = HeightField(heights=np.zeros((16, 16)), lengths=(1.0, 1.0))
    state = adhesion.solve(flat, _BODY, law=_LAW, offset=0.1, tolerance=1e-9)
    law = replace(_LAW, work=_LAW.work * 4)
    critical = law.reach * math.log(law.steepest / math.pi)
    for distance, stable in ((0.8, False), (1.2, True)):
        gap = np.full((16, 16), distance * critical)
        contact = replace(state.contact, gap=gap, offset=distance * critical)
        found = adhesion.stability(replace(state, contact=contact, law=law), _BODY)
        name = f"at {distance:g} of the critical gap"
        yield holds(f"a minimum {name}", found.is_minimum == stable)
        yield holds(f"curvature of the sign of a minimum {name}", (found.curvature > 0) == stable)
    doubtful = adhesion.Stability(curvature=0.1, uncertainty=0.2)
    yield holds("a curvature within its uncertainty is none", not doubtful.is_minimum)


@case(
    "adhesion-loop",
    "The work of a loop of approach and retraction is what its jumps lose.",
    source="conservation of energy",
    tolerance="estimate",
)
def _loop() -> Iterator[Check]:
    # One peak in a period: two alike would leave it to rounding which of them snaps first.
    x = np.cos(2 * math.pi * np.arange(64) / 64)
    surface = HeightField(heights=0.01 * (x[:, None] + x[None, :]), lengths=(1.0, 1.0))
    # As steep as the grid carries.
    law = Exponential(work=0.95 * 0.02**2 * 32, reach=0.02)
    offsets = np.linspace(0.14, 0.008, 40)
    path = adhesion.follow(
        surface,
        _BODY,
        law=law,
        offsets=[*offsets, *offsets[::-1]],
        resolution=0.01,
        least_jump=0.005,
        tolerance=1e-8,
    )
    work = stored = 0.0
    for one, two in itertools.pairwise(path.points):
        work -= 0.5 * (one.mean_pressure + two.mean_pressure) * (two.offset - one.offset)
        stored += two.energy - one.energy
    kinds = [jump.kind for jump in path.jumps]
    yield holds("snap-in first, pull-off last", (kinds[0], kinds[-1]) == ("snap-in", "pull-off"))
    yield below("energy stored by the loop over w", stored / law.work, 1e-6)
    # Losses that are no jumps, and the trapezoidal rule on the smooth branches, leave .001 w.
    yield near("work of the loop over w", work / law.work, path.dissipated / law.work, 0.0015)
    yield within("loss of the loop over w", path.dissipated / law.work, 0.04, 0.08)
