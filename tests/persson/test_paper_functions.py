"""What the paper says in passing: hierarchy, heights, yielding asperities, plates, foams, sliding."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, quad_vec
from scipy.special import erfc

from persson import ElasticPlate, archard_hierarchy, height_distribution, maximum_height, solve_diffusion
from persson.asperities import Asperities, yielding_asperities
from persson.elastic import contact_area
from persson.errors import InvalidInput, OutsideTheory
from persson.percolation import MEASURED_THRESHOLD, percolation_magnification
from persson.scale import Scale
from persson.sliding import adhesional_pressure, local_shear_stress, nominal_shear_stress, slip_energy
from persson.soft_structures import fibre_modulus, foam_modulus
from persson.spectrum import SelfAffine
from persson.spheres import hertz
from persson.tensile import adhesion_load


def test_one_level_of_archard_is_hertz():
    found = archard_hierarchy(3.0, radii=[0.01], densities=[], contact_modulus=1e9)
    ball = hertz(3.0, radius=0.01, contact_modulus=1e9)
    assert found.area == pytest.approx(math.pi * ball.radius**2, rel=1e-13)
    assert found.exponent == pytest.approx(2 / 3, rel=1e-14)


def test_two_levels_of_archard_are_the_integral_over_the_pressure_of_hertz():
    big = hertz(3.0, radius=0.01, contact_modulus=1e9)

    def ring(r):
        load = float(big.pressure(r)) / 1e12
        return 2 * math.pi * r * 1e12 * math.pi * (0.75 * 1e-6 * load / 1e9) ** (2 / 3)

    area, _ = quad(ring, 0, big.radius, epsabs=0, epsrel=1e-10)
    found = archard_hierarchy(3.0, radii=[0.01, 1e-6], densities=[1e12], contact_modulus=1e9)
    assert found.area == pytest.approx(area, rel=1e-8)


def test_heights_are_gaussian_and_their_highest_point_is_that_of_appendix_a():
    z = np.linspace(-9, 9, 2001)
    density = height_distribution(z * 2e-9, rms_height=2e-9)
    assert np.trapezoid(density, z * 2e-9) == pytest.approx(1, rel=1e-12)
    assert np.trapezoid(density * z**2, z * 2e-9) == pytest.approx(1, rel=1e-10)
    # App. A: the share above h_1 is about 1/N; its formula is the tail's leading term, 3 % above at 5.6.
    assert 0.5 * erfc(maximum_height(1e8) / math.sqrt(2)) == pytest.approx(1e-8, rel=0.04)


def test_yielding_asperities_are_the_sum_over_heights():
    """The approach at yield is that at which Hertz's mean pressure is H; beyond it A = pi R (2 s - s_c)."""
    bumps = Asperities(density=1e10, radius=1e-6, rms_height=1e-8)
    modulus, hardness = 1e9, 4e7
    onset = bumps.radius * (0.75 * math.pi * hardness / modulus) ** 2
    assert 0.1 < onset / bumps.rms_height < 10
    d = 1e-8

    def per_height(height):
        s = height - d
        if s > onset:
            area = math.pi * bumps.radius * (2 * s - onset)
            return np.array([area, area, hardness * area])
        area = math.pi * bumps.radius * s
        return np.array([area, 0.0, 4 / 3 * modulus * math.sqrt(bumps.radius) * s**1.5])

    totals = np.zeros(3)
    for low, high in ((d, d + onset), (d + onset, 12e-8)):
        weighed = lambda z: per_height(z) * float(height_distribution(z, rms_height=1e-8))  # noqa: E731
        totals += 1e10 * quad_vec(weighed, low, high, epsrel=1e-10)[0]
    found = yielding_asperities(d, asperities=bumps, contact_modulus=modulus, hardness=hardness)
    assert [found.area, found.area_plastic, found.pressure] == pytest.approx(totals, rel=1e-7)


def test_a_plate_is_the_strip_of_its_stress_function():
    """Four constants of the stress function from the two faces; normal displacement of the loaded one."""
    plate = ElasticPlate(young=2e9, poisson=0.3, thickness=1e-3)
    modulus = 2e9 / 0.91
    for x in (0.05, 0.29, 0.31, 1.0, 4.0):
        # f(z) e^{iqx}, q = 1: szz = -f, sxz ~ f', sxx = f''; at 0 szz = -1 and sxz = 0, at z = x both vanish.
        def rows(z):
            e, m = math.exp(z), math.exp(-z)
            f = [e, m, z * e, z * m]
            df = [e, -m, (1 + z) * e, (1 - z) * m]
            d3 = [e, -m, (3 + z) * e, (3 - z) * m]
            return np.array([f, df, d3])

        top, bottom = rows(0.0), rows(x)
        c = np.linalg.solve(np.array([top[0], top[1], bottom[0], bottom[1]]), [1.0, 0, 0, 0])
        # Plane strain, E* u_z = f''' - (2 + n) f' at the face up to sign, and f' = 0 there.
        displacement = abs(float(top[2] @ c)) / modulus
        assert plate(x / 1e-3) == pytest.approx(2 / displacement, rel=1e-7)


def test_a_thin_plate_bends_and_a_thick_one_is_a_solid():
    plate = ElasticPlate(young=2e9, poisson=0.3, thickness=1e-3)
    q = np.array([1e-4, 1e-2, 1.0])
    bending = 2e9 * 1e-9 / (12 * 0.91)
    assert plate(q) / 2 * q == pytest.approx(bending * q**4, rel=1e-6)
    assert plate(np.array([2e4, 1e9])) == pytest.approx(2e9 / 0.91, rel=1e-8)
    either_side = plate(300.0 * np.array([1 - 1e-9, 1 + 1e-9]))
    assert either_side[1] == pytest.approx(either_side[0], rel=1e-8)


def test_adhesion_load_is_the_solution_of_the_diffusion_equation():
    variance = np.array([0.3, 2.0, 40.0])
    solved = solve_diffusion(variance, pressure=0.4, tensile_limit=0.7, tolerance=1e-8).checked()
    found = adhesion_load(0.4, stress_variance=variance, tensile_limit=0.7)
    assert found.area == pytest.approx(solved.area, rel=1e-7)
    assert found.contact_force == pytest.approx(solved.load_elastic, rel=1e-7)
    # Eq. 41.
    assert found.contact_force + 0.7 * found.area == pytest.approx(np.full(3, 1.1), rel=1e-12)
    with pytest.raises(OutsideTheory, match="tension"):
        adhesion_load(-0.8, stress_variance=1.0, tensile_limit=0.7)


def test_gaps_percolate_where_the_area_falls_to_the_threshold():
    rough = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=1e5, q_short=1e8)
    scale = Scale(rough, contact_modulus=1e8)
    asked, thresholds = {"pressure": 1e7, "q_reference": 1e5}, (0.3, MEASURED_THRESHOLD)
    zeta = [percolation_magnification(scale, threshold=threshold, **asked) for threshold in thresholds]
    assert zeta[1] < zeta[0]
    assert contact_area(1e7, stress_variance=scale.variance(zeta[0] * 1e5)) == pytest.approx(0.3, rel=1e-9)
    assert percolation_magnification(scale, pressure=1e10, q_reference=1e5) == math.inf


def test_structure_makes_keratin_softer_than_rubber():
    """Persson 2006, Sec. 8.7: E about 1 GPa, a thousand times that of rubber, and effectively very low."""
    gecko = fibre_modulus(1.5e9, radius=2.1e-6, length=106e-6, density=1.44e10, angle=math.radians(43))
    assert 5e4 < gecko < 2e5
    inertia = math.pi * 2.1e-6**4 / 4
    expected = 3 * 1.5e9 * inertia * 1.44e10 * math.sin(0.75) / (106e-6 * math.cos(0.75)) ** 2
    steep = fibre_modulus(1.5e9, radius=2.1e-6, length=106e-6, density=1.44e10, angle=0.75)
    assert steep == pytest.approx(expected, rel=1e-12)
    assert foam_modulus(1e9, wall=1.0, cell=10.0) == pytest.approx(1e6, rel=1e-12)
    with pytest.raises(InvalidInput, match="wall"):
        foam_modulus(1e9, wall=2.0, cell=1.0)


def test_sliding_stresses_of_section_10():
    """tau_f b = 50 MPa x 3 A = .94 meV/A^2; 1 meV/A^2 over .01 A = 16 GPa."""
    ev = 1.602176634e-19
    barrier = float(slip_energy(50e6, slip=3e-10))
    assert barrier / (1e-3 * ev / 1e-20) == pytest.approx(0.936, abs=1e-3)
    assert float(adhesional_pressure(1e-3 * ev / 1e-20, lift=1e-12)) == pytest.approx(16.02e9, rel=1e-3)
    nominal = nominal_shear_stress(0.1, local_shear_stress=50e6)
    assert local_shear_stress(nominal, pressure=30e6, hardness=300e6) == pytest.approx(50e6, rel=1e-14)
    with pytest.raises(InvalidInput, match="area"):
        nominal_shear_stress(1.5, local_shear_stress=1.0)
