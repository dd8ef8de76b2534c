"""Energy, mean gap, stiffness and gap distribution of the theory beside boundary elements on one surface."""

import math

import numpy as np
import pytest

import fem_contact
from fem_contact import bem, response, stress, surface
from persson import Scale, SelfAffine, contact_stiffness, elastic_energy, gap_distribution, mean_separation

ROUGH = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=6 * math.pi, q_short=48 * math.pi)
SCALE = Scale(ROUGH, contact_modulus=1.0)
LOAD = 0.1 * 0.1  # p* = 0.1


@pytest.fixture(scope="module")
def pressed():
    """Six points per shortest wave, three longest waves along the side: good to some per cent."""
    field = surface.random_surface(
        ROUGH, q_short=ROUGH.q_short, lengths=(1.0, 1.0), shape=(144, 144), seed=7, amplitudes="exact"
    )
    half = response.HalfSpace(solid=fem_contact.Solid(young=1.0, poisson=0.0))
    return [bem.solve(field, half, mean_pressure=LOAD * x).checked() for x in (0.95, 1.0, 1.05)]


def test_with_the_correction_of_yang_and_persson_energy_gap_and_stiffness_are_right_to_a_tenth(pressed):
    """Published and measured: .93, .96 and 1.0 of the theory at p* = .1; one surface scatters by 5 %."""
    told = {"scale": SCALE, "energy_ratio": 0.45}
    stored = elastic_energy(LOAD, scale=SCALE, energy="yang_persson")
    assert stress.elastic_energy(pressed[1]) == pytest.approx(float(stored), rel=0.1)
    assert pressed[1].gap.mean() == pytest.approx(float(mean_separation(LOAD, **told)), rel=0.1)
    assert stress.contact_stiffness(pressed)[1] == pytest.approx(
        float(contact_stiffness(LOAD, **told)), rel=0.1
    )


def test_without_it_the_theory_stores_half_as_much_again(pressed):
    """.596 of Eq. 43 at p* = .1, and still less of Eq. 48, on the average of four surfaces."""
    measured = stress.elastic_energy(pressed[1])
    assert measured / float(elastic_energy(LOAD, scale=SCALE)) == pytest.approx(0.6, abs=0.06)
    assert measured < 0.6 * float(elastic_energy(LOAD, scale=SCALE, energy="improved"))


def test_gaps_are_distributed_as_the_theory_says(pressed):
    """Shares of the nominal area by ranges of the gap, .07 to .16 each, within .02."""
    h = ROUGH.moments().rms_height
    edges = h * np.array([0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0])
    measured = stress.gap_distribution(pressed[1], edges)
    x = np.linspace(0, math.sqrt(2 * h), 3001)
    density = gap_distribution(x * x, pressure=LOAD, scale=SCALE, energy_ratio=0.45) * 2 * x
    below = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(x))])
    told = np.diff(np.interp(np.sqrt(edges), x, below))
    assert measured.density * np.diff(edges) == pytest.approx(told, abs=0.02)
    assert told.sum() > 0.7
