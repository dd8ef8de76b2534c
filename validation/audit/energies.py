"""Elastic energies from stored fields."""

from __future__ import annotations

import numpy as np

from validation.audit.stored import Stored, wavevectors

__all__ = ["full_energy", "stored_energy"]


def full_energy(one: Stored) -> float:
    """Energy of full contact per area [J/m^2]: sum over the waves of E* q |h(q)|^2 / 4."""
    power = np.abs(np.fft.fft2(one.h)) ** 2 / one.h.size**2
    nx, ny = one.grid
    if nx % 2 == 0:
        power[nx // 2, :] /= 2
    if ny % 2 == 0:
        power[:, ny // 2] /= 2
    return float(np.sum(one.modulus / 4 * wavevectors(one.grid, one.lengths) * power))


def stored_energy(one: Stored) -> float:
    """Energy that the solid stores per area [J/m^2]: half of the mean of p u, both without their means."""
    p, u = one.p - one.p.mean(), one.u - one.u.mean()
    return 0.5 * float(np.sum(one.weights * p * u) / p.size)
