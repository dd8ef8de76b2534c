"""Asperity theories: Greenwood-Williamson, Nayak, Bush-Gibson-Thomas, Fuller-Tabor."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from persson import FullerTabor, InvalidInput, SelfAffine, bush_gibson_thomas
from persson.asperities import Asperities, yielding_asperities
from persson.elastic import KAPPA_BGT

BUMPS = Asperities(density=1e9, radius=2e-5, rms_height=3e-7)


@pytest.mark.parametrize("height", [-40.0, -12.001, -3.0, 0.0, 2.0, 6.0])
def test_greenwood_williamson_integrals_equal_quadrature(height):
    """Persson 2006, Eqs. 10-12."""
    found = BUMPS.contact(height * 3e-7, contact_modulus=1e9)

    def integral(power):
        low, how = max(height, -12.0), {"epsabs": 0, "epsrel": 1e-11, "limit": 200}
        density = lambda x: (x - height) ** power * math.exp(-x * x / 2) / math.sqrt(2 * math.pi)  # noqa: E731
        return quad(density, low, low + 24, points=[low + 0.5, low + 2], **how)[0]

    assert found.density == pytest.approx(1e9 * integral(0), rel=1e-9)
    assert found.area == pytest.approx(math.pi * 1e9 * 2e-5 * 3e-7 * integral(1), rel=1e-9)
    expected = 4 / 3 * 1e9 * 1e9 * math.sqrt(2e-5) * 3e-7**1.5 * integral(1.5)
    assert found.pressure == pytest.approx(expected, rel=1e-9)
    assert found.patch_area == pytest.approx(math.pi * 2e-5 * 3e-7 * integral(2) / integral(1), rel=1e-9)


@pytest.mark.parametrize("height", [-40.0, -300.0, -1e4])
def test_asperities_that_hardly_yield_bear_what_elastic_ones_do(height):
    """Heights far below all summits, too: where these are alike each is pressed in as far."""
    pressed = {"asperities": BUMPS, "contact_modulus": 1e9}
    found = yielding_asperities(height * 3e-7, hardness=1e16, **pressed)
    assert found.area_plastic == 0
    assert found.pressure == pytest.approx(
        BUMPS.contact(height * 3e-7, contact_modulus=1e9).pressure, rel=1e-9
    )


def test_contact_at_a_pressure_carries_it_and_area_is_nearly_linear():
    found = [BUMPS.contact_at(p, contact_modulus=1e9) for p in (1e2, 1e4)]
    assert found[0].pressure == pytest.approx(1e2, rel=1e-10)
    exponent = math.log(found[1].area / found[0].area) / math.log(100)
    assert 0.9 < exponent < 1
    assert found[1].patch_area > found[0].patch_area
    with pytest.raises(InvalidInput, match="pressure"):
        BUMPS.contact_at(1e-300, contact_modulus=1e9)


def test_bush_gibson_thomas_tends_to_its_asymptote():
    """A/A0 = sqrt(2 pi) p0/(E* h').

    Reached at vanishing load, from below, the later the broader the spectrum.
    """
    distance = []
    for ratio in (10.0, 1000.0):
        moments = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e4, q_short=1e4 * ratio).moments()
        separation = math.sqrt(moments.m0) * np.array([2.0, 6.0, 12.0])
        found = bush_gibson_thomas(separation, moments=moments, contact_modulus=1e9)
        kappa = found.area / (found.pressure / (1e9 * 0.1))
        assert np.all(np.diff(kappa) > 0)
        assert np.all(kappa < KAPPA_BGT)
        distance.append(1 - kappa / KAPPA_BGT)
    assert distance[0][-1] < 0.02
    assert np.all(distance[1] > distance[0])


def test_bush_gibson_thomas_at_finite_load_has_left_the_asymptote():
    """Carbone and Bottiglione (2008) find linearity for vanishing areas only; here at 3 % and alpha > 10."""
    moments = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e4, q_short=1e6).moments()
    assert moments.nayak > 10
    separation = np.linspace(0, 3, 40) * math.sqrt(moments.m0)
    found = bush_gibson_thomas(separation, moments=moments, contact_modulus=1e9)
    kappa = float(np.interp(-0.03, -found.area, found.area / (found.pressure / 1e8)))
    assert 1.0 < kappa < 0.85 * KAPPA_BGT


def test_without_adhesion_fuller_tabor_is_greenwood_williamson():
    stiff = FullerTabor(asperities=BUMPS, contact_modulus=1e12, work_of_adhesion=1e-7)
    d = 3e-7 * np.array([0.0, 1.0, 2.0])
    assert stiff.pressure(d) == pytest.approx(BUMPS.contact(d, contact_modulus=1e12).pressure, rel=2e-3)


def test_smooth_asperities_pull_off_together():
    even = Asperities(density=1e9, radius=2e-5, rms_height=1e-11)
    soft = FullerTabor(asperities=even, contact_modulus=1e7, work_of_adhesion=0.05)
    assert even.rms_height < 1e-3 * soft.stretch
    # n_0 3/2 pi w R
    assert soft.pull_off() == pytest.approx(1e9 * 1.5 * np.pi * 0.05 * 2e-5, rel=1e-3)


def test_adhesion_is_lost_when_roughness_exceeds_the_stretch():
    """Fuller and Tabor 1975, Fig. 3.

    The relative pull-off force has fallen to a few per cent at h*/delta_c = 2-3.
    """
    relative = []
    for h in (0.1, 1.0, 3.0):
        stretch = FullerTabor(asperities=BUMPS, contact_modulus=1e7, work_of_adhesion=0.05).stretch
        rough = Asperities(density=1e9, radius=2e-5, rms_height=h * stretch)
        contact = FullerTabor(asperities=rough, contact_modulus=1e7, work_of_adhesion=0.05)
        relative.append(contact.pull_off() / (1e9 * 1.5 * np.pi * 0.05 * 2e-5))
    assert relative[0] > 0.85
    assert relative[0] > relative[1] > relative[2]
    assert relative[2] < 0.1
