"""Stiffness and conductance of a contact whose set stays."""

import numpy as np
import pytest

from fem_contact import HalfSpace, Solid, bem, frozen_contact, random_surface

SOLID = Solid(young=1.0, poisson=0.2)
HALF_SPACE = HalfSpace(solid=SOLID)


def rough(n, seed=7):
    q = 2 * np.pi
    return random_surface(
        lambda k: np.where((k >= 2 * q) & (k <= 8 * q), 1e-6 * k**-3.6, 0.0),
        q_short=8 * q,
        lengths=(1.0, 1.0),
        shape=(n, n),
        seed=seed,
    )


def test_the_frozen_stiffness_is_the_slope_of_the_load_over_the_approach():
    surface = rough(64)
    load = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    states = [
        bem.solve(surface, HALF_SPACE, mean_pressure=load * (1 + step), tolerance=1e-12)
        for step in (-1e-6, 0.0, 1e-6)
    ]
    assert all(np.array_equal(state.in_contact, states[1].in_contact) for state in states)
    secant = (states[2].mean_pressure - states[0].mean_pressure) / (states[0].offset - states[2].offset)
    assert frozen_contact(states[1], HALF_SPACE).stiffness == pytest.approx(secant, rel=1e-6)


def test_the_displacement_of_the_contact_set_is_the_approach_and_no_pressure_lies_outside():
    surface = rough(48)
    result = bem.solve(surface, HALF_SPACE, mean_pressure=0.1 * surface.rms_gradient)
    found = frozen_contact(result, HALF_SPACE, tolerance=1e-8)
    spectrum = np.fft.rfft2(found.pressure)
    q = (
        np.hypot(*np.meshgrid(np.fft.fftfreq(48, 1 / 48), np.fft.rfftfreq(48, 1 / 48), indexing="ij"))
        * 2
        * np.pi
    )
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
