"""Full contact: the pressure is the surface's spectrum times a stiffness, and its variance is Persson's V."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem, block
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson import elastic
from persson.spectrum import SelfAffine
from validation.cases import Check, case

_SOLID = Solid(young=1.0, poisson=0.3)


def _rough(n: int, waves: float) -> HeightField:
    spectrum = SelfAffine.from_rms_gradient(
        0.02, hurst=0.8, q_long=2 * math.pi * 2, q_short=2 * math.pi * waves
    )
    return random_surface(spectrum, q_short=spectrum.q_short, lengths=(1.0, 1.0), shape=(n, n), seed=2718)


@case(
    "full-contact-bem",
    "Where everything touches, p-hat = (E* q / 2) h-hat wave by wave, and its variance is Persson's.",
    source="Persson 2006, Sec. 3.4; exact",
)
def _boundary_elements() -> list[Check]:
    surface, modulus = _rough(64, 12), _SOLID.contact_modulus
    load = 6 * surface.rms_gradient * modulus
    result = bem.solve(surface, HalfSpace(solid=_SOLID), mean_pressure=load).checked()
    nx, ny = surface.shape
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(nx, 1 / nx), np.fft.fftfreq(ny, 1 / ny), indexing="ij"))
    p_hat, h_hat = np.fft.fft2(result.pressure), np.fft.fft2(surface.heights)
    exact = modulus * np.pi * q * h_hat
    exact[0, 0] = load * nx * ny
    variance = float(elastic.stress_variance(surface.moments[1], contact_modulus=modulus))
    return [
        Check.relative("A/A0", result.in_contact.mean(), 1.0, 0.0),
        Check.below(
            "largest error of p-hat(q)", np.max(np.abs(p_hat - exact)) / np.max(np.abs(exact[1:])), 1e-9
        ),
        Check.relative(
            "<(p - p0)^2> against E*^2 m2 / 4 [Pa^2]", float(np.var(result.pressure)), variance, 1e-9
        ),
    ]


@case(
    "full-contact-fem",
    "Where everything touches, the pressure of finite elements has Persson's variance.",
    source="Persson 2006, Sec. 3.4; exact but for the grid",
)
def _finite_elements() -> list[Check]:
    surface, modulus = _rough(48, 4), _SOLID.contact_modulus
    load = 8 * surface.rms_gradient * modulus
    result = block.solve(surface, _SOLID, method="full", mean_pressure=load, growth=1.1).contact.checked()
    variance = float(elastic.stress_variance(surface.moments[1], contact_modulus=modulus))
    # Twelve nodes to the shortest wave: trilinear elements are 3 % too soft there, 1 % at twice the
    # wavelength.
    return [
        Check.relative("A/A0", result.in_contact.mean(), 1.0, 0.0),
        Check.relative(
            "<(p - p0)^2> against E*^2 m2 / 4 [Pa^2]", float(np.var(result.pressure)), variance, 0.06
        ),
    ]
