"""What the theory cannot be asked is refused by name."""

from functools import partial

import numpy as np
import pytest
from refusing import refused

from persson import Interface, Scale, bush_gibson_thomas, nayak_asperities, solve_adhesion, solve_diffusion
from persson.capillary import CapillaryWaves, maximum_height
from persson.errors import InvalidInput, NotConverged, OutsideTheory
from persson.flaw_tolerance import optimal_modulus
from persson.graded import ExponentialLayers
from persson.hardness import constant_hardness, size_dependent_hardness
from persson.leakage import effective_medium
from persson.separation import macroasperity_magnification
from persson.sliding import rubber_friction
from persson.spectrum import Moments, SelfAffine
from persson.spheres import DoubleHertz
from persson.tabulated import Tabulated, smoothed
from persson.viscoelastic import StandardSolid, crack_dissipation

ROUGH = SelfAffine.from_rms_gradient(0.3, hurst=0.8, q_long=1e4, q_short=1e7)
RAGGED = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e6, q_short=1e10)
SCALE = Scale(ROUGH, contact_modulus=1.0)
STEEL = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=8e5, rolloff="smooth", q_min=1e4)
RUBBER = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)

LIMIT = {"pressure": 0.0, "tensile_limit": 5e7, "interface": Interface(work_of_adhesion=0.05)}

affine = partial(SelfAffine, hurst=0.8, q_long=2.0, q_short=20.0, amplitude=1.0)
waves = partial(CapillaryWaves, temperature=1, surface_tension=1, q_bend=1)
layers = partial(ExponentialLayers, bulk=1.0, poisson=0.3)
friction = partial(rubber_friction, ROUGH, velocity=1.0, pressure=1e5, poisson=0.5)
stick = partial(solve_adhesion, SCALE, interface=Interface(work_of_adhesion=1e-7))
harden = partial(size_dependent_hardness, SCALE, pressure=0.1, wavevectors=[1e5, 1e7])
crack = partial(crack_dissipation, 1.0, loss_compliance=RUBBER.loss_compliance, tip_radius=1e-9)
macroasperities = partial(macroasperity_magnification, STEEL, contact_modulus=1e10, q_reference=1e5)

REFUSED = {
    InvalidInput: [
        (lambda: affine(q_short=1.0), "q_short"),
        (lambda: affine(q_min=1.0), "q_min"),
        (lambda: affine(q_min=9.0, rolloff="plateau"), "q_min"),
        (lambda: SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=5.0, q_short=5.0), "q_short"),
        (lambda: Tabulated(wavevectors=[1.0], power=[1.0]), "n >= 2"),
        (lambda: Tabulated(wavevectors=[2.0, 1.0], power=[1.0, 1.0]), "increasing"),
        (lambda: Tabulated(wavevectors=[1.0, 2.0], power=[1.0, 0.0]), "power"),
        (lambda: smoothed(ROUGH, wavevectors=[1e5, 1e6], yielded=[0.5, 1.5]), "yielded"),
        (lambda: maximum_height(2.0), "independent_points"),
        (lambda: waves(q_min=3, q_short=2), "q_short"),
        (lambda: waves(q_min=1, q_short=2, q_gravity=0.6), "q_gravity"),
        (lambda: layers(excess=(1.0,), depths=()), "depths"),
        (lambda: layers(excess=(-2.0,), depths=(1.0,)), "excess"),
        (lambda: Scale(ROUGH, contact_modulus=lambda q: -q), "contact_modulus"),
        (lambda: bush_gibson_thomas(0.0, moments=Moments(m0=1, m2=1, m4=1), contact_modulus=1.0), "Nayak"),
        (lambda: nayak_asperities(Moments(m0=0, m2=0, m4=0)), "flat"),
        (lambda: nayak_asperities(Moments(m0=1, m2=1, m4=0.9)), "m0 m4 below m2"),
        (lambda: DoubleHertz(peak_pressure=1.0, tensile_limit=0.1, eta=1.0), "eta"),
        (lambda: effective_medium([1.0, 2.0], [1.0]), "one length"),
        (lambda: crack(relaxed=1e8), "one solid"),
        (lambda: friction(modulus=lambda w: 1e6 - 1e5j + 0 * w), "no negative loss part"),
        (lambda: solve_diffusion([2.0, 1.0], pressure=1.0), "variance"),
        (lambda: solve_diffusion([1.0], pressure=1.0, tensile_limit=lambda v: v * np.nan), "tensile_limit"),
    ],
    OutsideTheory: [
        (lambda: smoothed(ROUGH, wavevectors=[1e5, 1e6], yielded=[1.0, 1.0]), "all roughness has yielded"),
        (lambda: solve_diffusion([1.0], pressure=0.0), "nothing presses"),
        (lambda: solve_diffusion([1.0], pressure=-2.0, tensile_limit=1.0), "tension"),
        (lambda: solve_diffusion([1.0], pressure=2.0, yield_stress=1.0), "yield stress"),
        (lambda: harden(yield_stress=lambda k: 2 / (1 + k / 1e5)), "negative"),
        (lambda: constant_hardness(2.0, stress_variance=1.0, yield_stress=2.0), "yield_stress"),
        (lambda: stick(pressure=0.2, yield_stress=0.1), "yield stress"),
        (lambda: macroasperities(pressure=1e9), "no macroasperity scale"),
        (lambda: optimal_modulus(RAGGED, **LIMIT), "no profile"),
    ],
    NotConverged: [(lambda: stick(pressure=1e-3, rounds=2).checked(), "rounds")],
}


EACH = [(kind, *row) for kind, rows in REFUSED.items() for row in rows]


@pytest.mark.parametrize(("kind", "call", "words"), EACH)
def test_what_the_theory_cannot_be_asked_is_refused_by_name(kind, call, words):
    with refused(kind, words):
        call()
