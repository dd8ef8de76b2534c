"""Adhesion of solvers: the laws of the gap, the balance of a state, its stability, and what a loop loses."""

from __future__ import annotations

import itertools
import math

import numpy as np

from fem_contact import adhesion
from fem_contact.adhesion import Exponential
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from validation.cases import Checks, below, case, near, relative, within
from validation.cases._closed_forms import periodic

_BODY = HalfSpace(solid=Solid(young=1.0, poisson=0.0))

_LAW = Exponential(work=8e-4, reach=0.02)


@case("adhesion-balance", source="half-space, wave by wave", tolerance="solver")
def _balance() -> Checks:
    """In an adhesive state forces balance, the gap closes, and its energy is the sum of both parts."""
    x = np.cos(2 * math.pi * np.arange(24) / 24)
    surface = periodic(0.02 * x[:, None] * x[None, :])
    state = adhesion.solve(surface, _BODY, law=_LAW, mean_pressure=0.01, tolerance=1e-9).checked()
    contact = state.contact
    geometry = contact.displacement - surface.heights + contact.offset - contact.gap
    pull = contact.pressure + _LAW.traction(contact.gap)
    # u-hat = 2 p-hat / (E* q), without its mean.
    q = 2 * math.pi * np.fft.fftfreq(24, 1 / 24)
    size = np.hypot(q[:, None], q[None, :])
    size[0, 0] = np.inf
    moved = np.fft.ifft2(2 / size * np.fft.fft2(contact.pressure)).real
    energy = np.mean(0.5 * contact.pressure * moved + _LAW.energy(contact.gap))
    strain = moved - (contact.displacement - contact.displacement.mean())
    pulled = pull[~contact.in_contact] / _LAW.strength
    yield below("gap - (u - h + offset) over h_rms", geometry / surface.rms_height, 1e-12)
    yield below("force on a free point over the strength", pulled, 1e-6)
    yield below("displacement of the pressure, over h_rms", strain / surface.rms_height, 1e-9)
    yield relative("elastic and gap energy [J/m^2]", state.energy, energy, 1e-9)


@case("adhesion-loop", source="conservation of energy", tolerance="estimate")
def _loop() -> Checks:
    """The work of a loop of approach and retraction is what its jumps lose."""
    # One peak in a period: two alike would leave it to rounding which of them snaps first.
    x = np.cos(2 * math.pi * np.arange(64) / 64)
    surface = periodic(0.01 * (x[:, None] + x[None, :]))
    # As steep as the grid carries.
    law = Exponential(work=0.95 * 0.02**2 * 32, reach=0.02)
    offsets = np.linspace(0.14, 0.008, 40)
    there_and_back = [*offsets, *offsets[::-1]]
    path = adhesion.follow(
        surface, _BODY, law=law, offsets=there_and_back, resolution=0.01, least_jump=0.005, tolerance=1e-8
    )
    work = stored = 0.0
    for one, two in itertools.pairwise(path.points):
        work -= 0.5 * (one.mean_pressure + two.mean_pressure) * (two.offset - one.offset)
        stored += two.energy - one.energy
    kinds = [jump.kind for jump in path.jumps]
    told = (kinds[0], kinds[-1]) == ("snap-in", "pull-off")
    yield near("snap-in first, pull-off last", told, 1.0, 0.0)
    yield below("energy stored by the loop over w", stored / law.work, 1e-6)
    # Losses that are no jumps, and the trapezoidal rule on the smooth branches, leave .001 w.
    yield near("work of the loop over w", work / law.work, path.dissipated / law.work, 0.0015)
    yield within("loss of the loop over w", path.dissipated / law.work, 0.04, 0.08)
