"""Variants of the theory, mean separation, macroasperities and graded solids."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.special import erf

from persson import ExponentialLayers, GradedModulus, Scale, SelfAffine, Stretched, SurfaceLayer, Tabulated
from persson.elastic import KAPPA_PERSSON, contact_area
from persson.errors import OutsideTheory
from persson.separation import macroasperity_magnification, mean_separation
from persson.variants import corrected_contact_area, light_load_kappa

STEEL = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e9, rolloff="smooth", q_min=1e3)


def test_xu_solves_its_own_equation():
    full = np.geomspace(0.01, 1e8, 9)
    area = corrected_contact_area(0.4, stress_variance=full, variant="xu")
    assert area == pytest.approx(erf(0.4 / np.sqrt(2 * full * (0.42 + 0.58 * area))), rel=1e-12)


@pytest.mark.parametrize("variant", ["persson", "yang_persson", "wang_mueser", "xu"])
def test_variants_reach_their_light_load_limit_and_full_contact(variant):
    """The correction dies out like the logarithm of the load over the load: 1e-3 at p* = 1e-5."""
    p = 1e-5
    area = corrected_contact_area(p, stress_variance=0.25, variant=variant)
    assert area / p == pytest.approx(light_load_kappa(variant), rel=2e-3)
    assert corrected_contact_area(3.0, stress_variance=0.25, variant=variant) == pytest.approx(1, abs=1e-8)
    lighter = np.array([1e-60, 1e-90, 1e-140])
    area = corrected_contact_area(lighter, stress_variance=0.25, variant=variant)
    np.testing.assert_allclose(area / lighter, light_load_kappa(variant), rtol=1e-8)
    area = corrected_contact_area(lighter, stress_variance=2.5e59, variant=variant)
    np.testing.assert_allclose(area / lighter * 1e30, light_load_kappa(variant), rtol=1e-8)
    plain = contact_area([0.01, 0.1, 1.0], stress_variance=0.25)
    assert np.all(corrected_contact_area([0.01, 0.1, 1.0], stress_variance=0.25, variant=variant) >= plain)
    assert corrected_contact_area(0.0, stress_variance=0.25, variant=variant) == 0
    assert corrected_contact_area(1.0, stress_variance=0.0, variant=variant) == 1
    assert light_load_kappa("persson") == KAPPA_PERSSON


@pytest.mark.parametrize("ratio", [1.0, 0.45])
def test_work_of_the_load_is_the_elastic_energy(ratio):
    """p du = -dU: both by central differences, whose error is of order (step/p)^2 = 1e-4."""
    scale = Scale(STEEL, contact_modulus=1e11)
    t = np.linspace(-30, 0, 40001)
    variance = float(scale.variance(scale.q_short)) * np.exp(t)
    length = variance / (1e11 * scale.wavevector(variance))

    def energy(p):
        share = erf(p / np.sqrt(2 * variance))
        return trapezoid(length * share * (ratio + (1 - ratio) * share**2), t)

    p, step = 2e9, 2e7
    du = np.diff(mean_separation([p - step, p + step], scale=scale, energy_ratio=ratio))[0]
    assert p * du == pytest.approx(-(energy(p + step) - energy(p - step)), rel=1e-3)


def test_macroasperities_appear_at_magnification_one_to_five():
    """Persson 2006, Sec. 3.6, polished steel at 10 MPa."""
    zeta = macroasperity_magnification(STEEL, pressure=10e6, contact_modulus=1e11 / 0.91, q_reference=1e5)
    assert 0.2 < zeta < 5
    sharp = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e9)
    q = np.geomspace(1e5, 1e9, 30)
    for kinked in (sharp, Stretched(spectrum=sharp, factor=3), Tabulated(wavevectors=q, power=STEEL(q))):
        with pytest.raises(OutsideTheory, match="kink"):
            macroasperity_magnification(kinked, pressure=10e6, contact_modulus=1e11, q_reference=1e5)
    along = Stretched(spectrum=STEEL, factor=1)
    given = {"pressure": 10e6, "contact_modulus": 1e11 / 0.91, "q_reference": 1e5}
    # Second differences over steps of 3e-3 lift the 1e-12 of an average over directions to 1e-7 of the bend.
    assert macroasperity_magnification(along, **given) == pytest.approx(zeta, rel=1e-7)


def test_quadrature_over_depth_equals_the_closed_forms():
    q = np.geomspace(1.0, 1e7, 15)
    layers = ExponentialLayers(bulk=1e9, excess=(4e9, -2e8), depths=(1e-3, 1e-5), poisson=0.3)
    assert GradedModulus(young=layers.young, poisson=0.3)(q) == pytest.approx(layers(q), rel=1e-10)
    coat = SurfaceLayer(layer=7e9, bulk=1e9, thickness=2e-4, poisson=0.4)
    step = GradedModulus(
        young=lambda z: np.where(z < 2e-4, 7e9, 1e9), poisson=0.4, breaks=(z for z in [2e-4])
    )
    assert step(q) == pytest.approx(coat(q), rel=1e-12)


def test_uniform_grading_is_no_grading():
    uniform = ExponentialLayers(bulk=1e9 * 0.91, excess=(), depths=(), poisson=0.3)
    q = np.geomspace(1.1e3, 9e8, 20)
    plain, graded = (Scale(STEEL, contact_modulus=one).variance(q) for one in (1e9, uniform))
    assert graded == pytest.approx(plain, rel=1e-12)
