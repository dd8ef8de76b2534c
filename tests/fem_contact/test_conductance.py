"""Stiffness and conductance of a contact whose set stays."""

import numpy as np
import pytest
from surfaces import rough_surface

from fem_contact import HalfSpace, Solid, bem, frozen_contact

SOLID = Solid(young=1.0, poisson=0.2)
HALF_SPACE = HalfSpace(solid=SOLID)


def rough(n):
    return rough_surface((n, n), seed=7, waves=8, longest=2, gradient=0.02)


def test_the_displacement_of_the_contact_set_is_the_approach_and_no_pressure_lies_outside():
    surface = rough(48)
    result = bem.solve(surface, HALF_SPACE, mean_pressure=0.1 * surface.rms_gradient)
    found = frozen_contact(result, HALF_SPACE, tolerance=1e-8)
    spectrum = np.fft.rfft2(found.pressure)
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(48, 1 / 48)[:, None], np.fft.rfftfreq(48, 1 / 48))
    with np.errstate(divide="ignore"):
        compliance = np.where(q > 0, 2 / (SOLID.contact_modulus * q), 0.0)
    moved = np.fft.irfft2(spectrum * compliance, s=(48, 48))
    assert np.max(np.abs(moved[result.in_contact] - 1)) < 2e-8
    assert not found.pressure[~result.in_contact].any()


def test_yielded_points_carry_nothing_more():
    surface = rough(48)
    load = 0.1 * surface.rms_gradient
    hard = bem.solve(surface, HALF_SPACE, mean_pressure=load, pressure_bound=4 * load)
    assert hard.at_bound.any()
    found = frozen_contact(hard, HALF_SPACE)
    assert not found.pressure[hard.at_bound].any()
    assert found.pressure.mean() == pytest.approx(found.stiffness)
