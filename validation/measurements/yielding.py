"""What hardness does to a surface: yielded and elastic area by the theory, and what smoothing leaves of the waves."""

from __future__ import annotations

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.hardness import yielded
from fem_contact.surface import HeightField, radial_spectrum
from persson.elastic import stress_variance
from persson.hardness import constant_hardness
from persson.scale import Scale
from persson.tabulated import smoothed
from validation.arrays import Array
from validation.measurements.grid_roughness import squared_gradient
from validation.scenes.problem import ContactProblem


def yielded_by_theory(problem: ContactProblem, hardness: float) -> tuple[float, float]:
    """A_pl/A0 and A_el/A0 for a constant hardness [Pa], with the gradient of this very surface."""
    variance = stress_variance(problem.field.moments[1], contact_modulus=problem.contact_modulus)
    parts = constant_hardness(problem.pressure, stress_variance=variance, yield_stress=hardness)
    return float(parts.plastic), float(parts.elastic)


def remaining_waves(contact: ContactResult, problem: ContactProblem) -> tuple[Array, Array, float]:
    """Return what yielding and unloading leave of a surface.

    Wavevectors [1/m] (n,) of the spectrum; C(q) after, over that before (n,); <|grad h|^2> after, over that
    before, where the surface yielded.
    """
    before = HeightField(heights=np.array(contact.heights), lengths=contact.lengths)
    after = yielded(contact).surface
    spectrum = problem.spectrum_shape
    rings, left = radial_spectrum(before), radial_spectrum(after)
    band = (rings.q >= spectrum.q_long) & (rings.q <= spectrum.q_short)
    slopes = [squared_gradient(field, 1)[contact.at_bound].mean() for field in (before, after)]
    return rings.q[band], left.power[band] / rings.power[band], float(slopes[1] / slopes[0])


def remaining_by_theory(problem: ContactProblem, hardness: float, wavevectors: Array) -> Array:
    """Share of C(q) that Persson's formula leaves, 1 - A_pl(q)/A_pl (2006, Sec. 10.2)."""
    spectrum = problem.own_spectrum
    fine = np.geomspace(spectrum.q_long, spectrum.q_short, 400)
    variance = Scale(spectrum, contact_modulus=problem.contact_modulus).variance(fine)
    parts = constant_hardness(problem.pressure, stress_variance=variance, yield_stress=hardness)
    share = np.minimum(parts.plastic * hardness / problem.pressure, 1.0)
    after = smoothed(spectrum, wavevectors=fine, yielded=share)
    return after(wavevectors) / spectrum(wavevectors)
