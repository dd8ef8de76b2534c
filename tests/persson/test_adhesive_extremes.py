"""Viscoelastic cracks, flaw tolerance, spheres squeezed until they yield; what adhesion tells."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from persson import CapillaryWaves, GradedModulus, Interface, Scale, solve_adhesion
from persson.flaw_tolerance import crack_stress, flaw_tolerant_gradient, optimal_modulus
from persson.interface import detachment_stress
from persson.spectrum import SelfAffine, area_factor
from persson.spheres import derjaguin_pull_off, hertz
from persson.squeezed_spheres import hertz_pressure, roughness_barrier, yielded_pull_off, yielded_share
from persson.viscoelastic import StandardSolid, crack_dissipation

RUBBER = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)
CRACK = {"loss_compliance": RUBBER.loss_compliance, "relaxed": 1e6, "tip_radius": 1e-9}


def test_dissipation_solves_the_equation_of_the_blunted_tip():
    """1 + f = 1 / (1 - integral) with a = a_0 (1 + f), by a quadrature over the frequency."""
    velocity = 1e-4
    f = crack_dissipation(velocity, **CRACK)
    top = 2 * math.pi * velocity / (1e-9 * (1 + f))

    def density(x):
        ratio = math.exp(x) / top
        return math.sqrt(1 - ratio * ratio) * float(RUBBER.loss_compliance(math.exp(x)))

    value, _ = quad(density, math.log(top) - 60, math.log(top), epsabs=0, epsrel=1e-10, limit=400)
    assert 1 + f == pytest.approx(1 / (1 - 2 / math.pi * 1e6 * value), rel=1e-6)


def test_a_contact_smaller_than_the_dissipative_region_takes_its_work_away():
    """D = 1 um: as for the infinite crack while 2 pi v tau < D, v < .16 mm/s; then f falls."""
    slow, fast, faster = (crack_dissipation(v, **CRACK, contact_size=1e-6) for v in (1e-7, 1e-2, 1e-1))
    assert slow == pytest.approx(crack_dissipation(1e-7, **CRACK), rel=0.01)
    assert faster < fast < 0.05 * crack_dissipation(1e-2, **CRACK)
    assert crack_dissipation(1e-3, **CRACK, contact_size=1e-9) == 0


def test_a_linear_profile_makes_smooth_surfaces_flaw_tolerant():
    """Persson 2006, Sec. 8.5, with E~ by quadrature over depth and sigma_a of Eq. 36."""
    gradient = flaw_tolerant_gradient(0.05, ideal_strength=5e8, poisson=0.3)
    modulus = GradedModulus(young=lambda z: gradient * z, poisson=0.3)
    q = np.geomspace(1e4, 1e10, 7)
    told = {"interface": Interface(work_of_adhesion=0.05), "contact_modulus": modulus(q), "wavevector": q}
    assert detachment_stress(0.05, **told) == pytest.approx(np.full(7, 5e8), rel=1e-9)


def test_rough_surfaces_need_a_modulus_that_grows_faster_and_get_one():
    """gamma_eff falls towards long waves; by diffusion, too, sigma_a is then the same everywhere."""
    rough = SelfAffine.from_rms_height(1e-9, hurst=0.8, q_long=1e6, q_short=1e10)
    interface = Interface(work_of_adhesion=0.05)
    found = optimal_modulus(rough, pressure=0.0, tensile_limit=5e7, interface=interface)
    assert found.growth[1] > 1.3
    assert found.growth[-2] == pytest.approx(1, abs=1e-3)
    assert np.all(np.diff(found.work) > -1e-5)
    table = (np.log(found.wavevectors), np.log(found.modulus))

    def modulus(q):
        return np.exp(np.interp(np.log(q), *table))

    # The table is linear in logarithms between 300 nodes: (ln q step)^2 = 1e-3.
    state = solve_adhesion(Scale(rough, contact_modulus=modulus), pressure=1.0, interface=interface).checked()
    inside = state.wavevectors < 0.999e10
    assert state.tensile_limit[inside] == pytest.approx(np.full(inside.sum(), 5e7), rel=0.02)
    assert state.real_area == pytest.approx(found.area[-1], rel=0.01)


def test_equation_51_gives_the_ideal_strength_at_the_atomic_distance():
    """Sec. 8.4: with gamma = E a, sqrt(gamma E / a) = gamma / a."""
    work, a = 0.1, 1e-10
    assert crack_stress(work, contact_modulus=work / a, length=a) == pytest.approx(work / a, rel=1e-14)


PYREX = {"radius": 1.8e-3, "contact_modulus": 32e9 / 2 / (1 - 0.2**2)}


def test_nominal_pressure_is_that_of_hertz():
    contact = hertz(2.16e-4, **PYREX)
    assert hertz_pressure(2.16e-4, **PYREX) == pytest.approx(2 / 3 * contact.peak_pressure, rel=1e-12)


def test_pull_off_of_yielded_spheres_is_the_line_of_the_pyrex_figure():
    """Eq. 56 with gamma_sl = .43 at F^(1/3) = .06 N^(1/3): 16.5 uN for E = 32 GPa, 26.3 uN for 64."""
    told = {"hardness": 6e9, "work_of_adhesion": 0.86}
    found = yielded_pull_off(0.06**3, **PYREX, **told)
    stiff = 2 * 32e9 / (3 * (1 - 0.2**2))
    assert found == pytest.approx(4 * 0.43 / 6e9 * (1.8e-3 * stiff**2) ** (1 / 3) * 0.06, rel=1e-12)
    assert found == pytest.approx(16.5e-6, abs=0.05e-6)
    hard = PYREX | {"contact_modulus": 64e9 / 2 / (1 - 0.2**2)}
    assert yielded_pull_off(0.06**3, **hard, **told) == pytest.approx(26.3e-6, abs=0.06e-6)
    smooth = derjaguin_pull_off(1.8e-3, work_of_adhesion=0.86)
    assert found / smooth == pytest.approx(float(yielded_share(0.06**3, **PYREX, hardness=6e9)), rel=1e-12)


def test_squeezing_lifts_the_roughness_barrier_of_pyrex():
    """Sec. 10.2, two surfaces added coherently: none before, about half of Delta gamma after."""
    band = {"q_bend": 0.5e10, "q_min": 2e6 * math.pi, "q_short": 1e10}
    waves = CapillaryWaves(temperature=1100.0, surface_tension=1.0, **band, multiple=4.0)
    asked = {"contact_modulus": 32e9 / 0.96, "pressure": 20e6, "yield_stress": 6e9}
    sticky = Interface(work_of_adhesion=0.43, energy="old")
    squeezed = roughness_barrier(waves, interface=sticky, **asked)
    assert squeezed.holds
    assert squeezed.before.real_area == 0
    assert squeezed.after.macroscopic_work / 0.43 == pytest.approx(0.452, abs=2e-3)
    assert squeezed.after.real_area == pytest.approx(0.936, abs=2e-3)
    assert squeezed.flattened == pytest.approx(20e6 / 6e9, rel=2e-3)
    # The longest waves have yielded nowhere.
    assert (squeezed.spectrum.q_min, squeezed.spectrum.q_short) == (waves.q_min, waves.q_short)
    assert squeezed.spectrum(waves.q_min) == pytest.approx(waves(waves.q_min), rel=1e-6)
    assert squeezed.work == pytest.approx(squeezed.flattened * squeezed.after.macroscopic_work, rel=1e-12)


RIM = SelfAffine.from_rms_height(0.5e-6, hurst=0.8, q_long=1e5, q_short=1e10)
MODULUS = 10e6 / (1 - 0.5**2)


@pytest.fixture(scope="module")
def rim():
    scale, interface = Scale(RIM, contact_modulus=MODULUS), Interface(work_of_adhesion=0.05)
    return solve_adhesion(scale, pressure=0.5e6, interface=interface).checked()


def test_force_in_the_contact_grows_by_the_detachment_stress_of_the_area_that_leaves(rim):
    """Eq. 40 integrated, dF = -sigma_a dA, by the trapezoidal rule on the nodes: good to 1e-2."""
    gained = np.cumsum(-np.diff(rim.area) * (rim.tensile_limit[1:] + rim.tensile_limit[:-1]) / 2)
    force = rim.contact_force - 0.5e6
    assert force[0] == pytest.approx(0, abs=1e-6 * 0.5e6)
    assert np.all(np.diff(rim.contact_force) > -1e-6 * rim.contact_force[-1])
    assert gained[-1] == pytest.approx(force[-1], rel=0.02)
    assert rim.contact_force[-1] > 1.05 * 0.5e6


def test_stress_distribution_reaches_into_tension_and_vanishes_at_its_end(rim):
    """Eq. 35: its integral is A/A0; P(-sigma_a) = 0."""
    for index in (rim.area.size // 2, -1):
        limit = float(rim.tensile_limit[index])
        top = 0.5e6 + 8 * math.sqrt(float(rim.variance[index]))
        stress = np.linspace(-limit, top, 40001)
        density = rim.distribution(index, stress)
        assert np.trapezoid(density, stress) == pytest.approx(rim.area[index], rel=1e-5)
        assert np.trapezoid(density * stress, stress) == pytest.approx(rim.contact_force[index], rel=1e-5)
        assert density[0] < 1e-6 * density.max()
        assert density[stress < 0].max() > 0


def test_energy_and_its_share_balance_the_work_of_adhesion(rim):
    """Eq. 37: A* gamma_eff = A*(zeta_1) Delta gamma - U_el; no energy is left at the shortest wave."""
    factor = area_factor(RIM.m2(rim.wavevectors))
    balance = rim.area[-1] * factor[-1] * 0.05 - rim.elastic_energy
    assert rim.area * factor * rim.work == pytest.approx(balance, rel=1e-9, abs=1e-12)
    assert rim.elastic_energy[-1] == pytest.approx(0, abs=1e-15)
    assert np.all(np.diff(rim.elastic_energy) <= 1e-12)
    assert np.all((rim.energy_share > 0) & (rim.energy_share < 1.0001))
