"""The theory's own numbers: limits of kappa, conservation in P(sigma), figures that Persson (2006) prints."""

from __future__ import annotations

import math

from persson import elastic
from persson.asperities import bush_gibson_thomas
from persson.spectrum import SelfAffine
from validation.cases import Checks, case, relative
from validation.cases._closed_forms import integral


@case("theory-light-load", source="[bush1975]", tolerance="estimate")
def _light_load() -> Checks:
    """At light load kappa of independent asperities is sqrt(2 pi)."""
    moments = SelfAffine.from_rms_gradient(1.0, hurst=0.8, q_long=1.0, q_short=2.0).moments()
    asperities = []
    for deviations in (6, 12):
        contact = bush_gibson_thomas(deviations * moments.rms_height, moments=moments, contact_modulus=1.0)
        asperities.append(float(contact.area) / float(contact.pressure))
    limit = math.sqrt(2 * math.pi)
    # The first correction is of the order of one over the square of the separation in standard deviations.
    approach = (limit - asperities[0]) / (limit - asperities[1])
    words = "kappa of independent asperities at 12 standard deviations"
    yield relative(words, asperities[1], limit, 0.5 / 144)
    yield relative("its distance to sqrt(2 pi) at 6 over that at 12", approach, 4.0, 0.1)


@case("theory-distribution", source="Persson 2006, Eqs. 16-20")
def _distribution() -> Checks:
    """P(sigma) integrates to A/A0 = erf(p0 / sqrt(2 V)) and carries the load."""
    variance = 0.25
    for pressure in (0.01, 0.3, 1.0):

        def density(stress: float, pressure: float = pressure) -> float:
            return float(elastic.pressure_distribution(stress, pressure=pressure, stress_variance=variance))

        top = pressure + 12 * math.sqrt(variance)
        area = integral(density, 0, top)
        load = integral(lambda stress: stress * density(stress), 0, top)
        exact = math.erf(pressure / math.sqrt(2 * variance))
        closed = elastic.contact_area(pressure, stress_variance=variance)
        yield relative(f"A/A0 at p0 = {pressure}", closed, exact, 1e-14)
        yield relative(f"integral of P at p0 = {pressure}", area, exact, 1e-9)
        yield relative(f"first moment of P at p0 = {pressure}", load, pressure, 1e-9)


@case("theory-variance", source="Persson 2006, Eq. 21")
def _variance() -> Checks:
    """V is twice G p0^2, with G by quadrature over C(q)."""
    spectrum = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=1e5, q_short=1e8)
    modulus, pressure = 2e6, 1e4
    # Eq. 21: G(q) = (pi/4) (E* / p0)^2 int q^3 C dq, and V = 2 G p0^2.
    ends = math.log(1e5), math.log(1e8)
    third_moment = integral(lambda x: math.exp(4 * x) * float(spectrum(math.exp(x))), *ends)
    g = math.pi / 4 * (modulus / pressure) ** 2 * third_moment
    variance = elastic.stress_variance(spectrum.m2(), contact_modulus=modulus)
    yield relative("V = 2 G p0^2 [Pa^2]", variance, 2 * g * pressure**2, 1e-9)
