"""What hardness does to a surface: what smoothing leaves of its waves."""

from __future__ import annotations

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.hardness import yielded
from fem_contact.surface import HeightField, radial_spectrum
from validation.arrays import Array
from validation.effects.base import TheoryInputs
from validation.effects.smoothing import Smoothing
from validation.measurements.grid_roughness import squared_gradient
from validation.scenes.problem import ContactProblem
from validation.solvers.theory import smoothed_spectrum


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
    squeezed = Smoothing(pressure=problem.pressure, hardness=hardness)
    after = smoothed_spectrum(spectrum, TheoryInputs.by(problem.elastic, (squeezed,)))
    return after(wavevectors) / spectrum(wavevectors)
