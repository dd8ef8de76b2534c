"""Energy, stiffness and gaps of an elastic contact: limits, derivatives, integrals."""

import math
from typing import get_args

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf, erfinv

from persson import Scale, contact_area, contact_stiffness, elastic_energy, gap_distribution, mean_separation
from persson.spectrum import SelfAffine
from persson.variants import EnergyReading, corrected_contact_area, energy_share

ROUGH = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2e5, q_short=2e7)
SCALE = Scale(ROUGH, contact_modulus=3e9)
UNIT = 3e8  # E* h'_rms
TOP = float(SCALE.variance(ROUGH.q_short))


def full_energy():
    """E*/4 int d^2q q C, by a quadrature in ln q."""
    ends = math.log(2e5), math.log(2e7)
    value, _ = quad(lambda x: math.exp(3 * x) * float(ROUGH(math.exp(x))), *ends, epsrel=1e-10)
    return 3e9 / 4 * 2 * math.pi * value


READINGS = get_args(EnergyReading)


@pytest.mark.parametrize("energy", READINGS)
def test_every_reading_stores_the_energy_of_full_contact_there(energy):
    assert elastic_energy(20 * UNIT, scale=SCALE, energy=energy) == pytest.approx(full_energy(), rel=1e-6)


def test_energy_is_equation_43():
    """By a quadrature over C(q) that knows no V: 2 pi q^2 C P E*/4."""
    load = 0.1 * UNIT

    def added(x):
        q = math.exp(x)
        return math.exp(3 * x) * float(ROUGH(q)) * erf(load / math.sqrt(2 * float(SCALE.variance(q))))

    value, _ = quad(added, math.log(2e5 * (1 + 1e-12)), math.log(2e7), epsrel=1e-9)
    assert elastic_energy(load, scale=SCALE) == pytest.approx(3e9 / 4 * 2 * math.pi * value, rel=1e-5)


@pytest.mark.parametrize("reduced", [0.02, 0.3, 1.0])
def test_improved_energy_is_equation_48(reduced):
    """P~ = [sigma_0^2 (P - 1) + int P dV] / V summed over V by the trapezoidal rule."""
    load = reduced * UNIT
    variance = TOP * np.exp(np.linspace(-34, 0, 20001))
    area = erf(load / np.sqrt(2 * variance))
    pieces = (area[1:] + area[:-1]) / 2 * np.diff(variance)
    integral = variance[0] + np.concatenate([[0.0], np.cumsum(pieces)])
    share = (load**2 * (area - 1) + integral) / variance
    density = share * variance / (3e9 * SCALE.wavevector(variance))
    energy = np.trapezoid(density, np.log(variance))
    assert elastic_energy(load, scale=SCALE, energy="improved") == pytest.approx(energy, rel=1e-4)


def test_energy_of_equation_50_is_the_mean_of_the_area_over_the_waves_so_far():
    """Eq. 50 without adhesion, int P dV / V, by quadrature; Eq. 48 has sigma_0^2 (P - 1) / V beside it."""
    for load, variance in ((0.2, 0.7), (1.3, 0.4), (0.01, 30.0)):
        # In ln V; what lies below e^-40 of V is contact.
        inner = lambda t, p=load: math.exp(t) * erf(p / math.sqrt(2 * math.exp(t)))  # noqa: E731
        mean, _ = quad(inner, math.log(variance) - 40, math.log(variance), epsrel=1e-12, limit=200)
        printed = energy_share(load, stress_variance=variance, energy="as_printed")
        assert printed == pytest.approx(mean / variance, rel=1e-9)
        lost = load**2 * (1 - erf(load / math.sqrt(2 * variance))) / variance
        improved = energy_share(load, stress_variance=variance, energy="improved")
        assert improved == pytest.approx(printed - lost, rel=1e-9)


def test_variants_store_their_area_times_the_growth_of_their_own_variance():
    """P dV_p/dV_full, V_p = (p0 / erfinv(P))^2 / 2 from the area alone, by central differences of 1e-4."""
    load = 0.3
    for variant in ("wang_mueser", "xu"):
        for full in (0.02, 0.3, 6.0):
            near = full * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
            area = corrected_contact_area(load, stress_variance=near, variant=variant)
            own = (load / erfinv(area)) ** 2 / 2
            share = area[1] * (own[2] - own[0]) / (near[2] - near[0])
            assert energy_share(load, stress_variance=full, energy=variant) == pytest.approx(share, rel=1e-6)


def test_light_contact_stores_the_share_that_each_reading_says():
    """1, 2, 2, .45, 5/9, .42, .42 of the area of its variant; the first correction is of order p* = 1e-6."""
    area_of = {"wang_mueser": "wang_mueser", "xu": "xu", "xu_hybrid": "xu"}
    for reading, share in zip(READINGS, (1, 2, 2, 0.45, 5 / 9, 0.42, 0.42), strict=True):
        area = corrected_contact_area(1e-6, stress_variance=1.0, variant=area_of.get(reading, "persson"))
        found = energy_share(1e-6, stress_variance=1.0, energy=reading)
        assert found / area == pytest.approx(share, rel=1e-5)
        ends = energy_share([0.0, 1.0], stress_variance=0.0, energy=reading)
        assert ends == pytest.approx([0, 1], abs=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 0.45])
def test_stiffness_is_minus_the_slope_of_the_mean_separation(ratio):
    """By central differences of relative step 1e-3, whose error is of order 1e-6."""
    for load in UNIT * np.array([1e-3, 0.1, 0.5]):
        near = load * np.array([1 - 1e-3, 1 + 1e-3])
        slope = np.diff(near)[0] / np.diff(mean_separation(near, scale=SCALE, energy_ratio=ratio))[0]
        found = contact_stiffness(load, scale=SCALE, energy_ratio=ratio)
        assert found == pytest.approx(-slope, rel=1e-5)


@pytest.mark.parametrize("reduced", [0.01, 0.1, 0.5])
def test_gap_distribution_holds_the_area_out_of_contact(reduced):
    """It has an integrable peak at u = 0: u = x^2 takes it away. The rest is the trapezoidal rule's."""
    load = reduced * UNIT
    h = ROUGH.moments().rms_height
    x = np.linspace(0, math.sqrt(12 * h), 4001)
    density = gap_distribution(x * x, pressure=load, scale=SCALE, energy_ratio=0.45)
    out = 1 - float(contact_area(load, stress_variance=TOP))
    assert np.trapezoid(density * 2 * x, x) == pytest.approx(out, rel=2e-4)
    mean = np.trapezoid(density * 2 * x**3, x)
    assert mean > mean_separation(load, scale=SCALE, energy_ratio=0.45)


def test_mean_of_the_gap_distribution_is_the_mean_separation_at_light_load():
    """What the folding adds falls with the load: 2 % at p* = .01, less below."""
    excess = []
    for reduced in (1e-2, 1e-4):
        load = reduced * UNIT
        u = np.linspace(0, 20 * ROUGH.moments().rms_height, 4001)
        density = gap_distribution(u, pressure=load, scale=SCALE)
        mean = np.trapezoid(density * u, u)
        excess.append(mean / float(mean_separation(load, scale=SCALE)) - 1)
    assert 0 < excess[0] < 0.06
    assert abs(excess[1]) < 2e-3


def test_there_is_no_gap_below_zero_nor_at_full_contact():
    assert gap_distribution(-1e-9, pressure=0.1 * UNIT, scale=SCALE) == 0
    assert np.all(gap_distribution([0.0, 1e-9], pressure=30 * UNIT, scale=SCALE) == 0)
