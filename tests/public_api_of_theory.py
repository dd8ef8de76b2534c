"""Every public door of `persson`, with arguments it accepts."""

import numpy as np
from public_api import doors_with

from persson import (
    adhesion,
    archard,
    asperities,
    capillary,
    diffusion,
    elastic,
    flaw_tolerance,
    gaps,
    graded,
    hardness,
    heights,
    leakage,
    limits,
    percolation,
    scale,
    separation,
    sine,
    sliding,
    soft_structures,
    spectrum,
    spheres,
    squeezed_spheres,
    stretched,
    tabulated,
    tensile,
    variants,
    viscoelastic,
)

RUBBER = {"relaxed": 1e6, "unrelaxed": 1e9, "time": 1e-3}
SPHERE = {"force": 1e-4, "radius": 1e-3, "contact_modulus": 1e10}
LAYERS = {"bulk": 1e9, "excess": [1e9], "depths": [1e-6], "poisson": 0.3}
DEEP = {"young": lambda z: 1e9 * np.exp(0 * z), "poisson": 0.3, "breaks": (1e-6,)}
WAVES = {"temperature": 370.0, "surface_tension": 0.04, "q_bend": 1.7e9, "q_min": 6.28e4}
WAVES |= {"q_short": 7e9, "q_gravity": 0.0, "multiple": 1.0}


FIBRES = {"young": 1e9, "radius": 1e-6, "length": 1e-4, "density": 1e10, "angle": 0.7}


def theory_doors():
    """The public functions of `persson`."""
    rough = spectrum.SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e6)
    bend = {"q_short": 1e7, "rolloff": "smooth", "q_min": 1e4}
    bent = spectrum.SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, **bend)
    smooth = rough.scaled(1e-4)
    table = tabulated.Tabulated(wavevectors=[1e5, 2e5, 1e6], power=[3e-28, 2e-28, 1e-29])
    kinds = (bent, capillary.CapillaryWaves(**WAVES), table)
    power = {"hurst": 0.8, "q_long": 1e5, "q_short": 1e6, "rolloff": "smooth", "q_min": 1e4}
    drawn = stretched.Stretched(spectrum=spectrum.SelfAffine(**power, amplitude=1.0), factor=2.0)
    moments = rough.moments()
    summits = asperities.nayak_asperities(moments)
    one = scale.Scale(rough, contact_modulus=1e9)
    sticky = adhesion.Interface(work_of_adhesion=0.05)
    pressed = adhesion.solve_adhesion(one, pressure=1e6, interface=sticky)
    hard = viscoelastic.StandardSolid(**RUBBER)
    double = spheres.DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    slides = {"pressure": 1e6, "velocity": 0.1, "modulus": hard.modulus, "poisson": 0.3, "energy_ratio": 0.5}
    common = power | {
        **{"spectrum": rough, "scale": one, "interface": sticky, "moments": moments, "asperities": summits},
        **{"contact_modulus": 1e9, "poisson": 0.3, "pressure": 1e6, "stress_variance": 2e12, "stress": 1e6},
        **{"area": 0.1, "reduced_pressure": 0.05, "rms_gradient": 0.1, "energy_ratio": 0.5, "m2": 0.1},
        **{"q": 2e5, "q_upper": 2e5, "wavevector": 1e6, "q_reference": 1e5, "magnification": 5.0},
        **{"work_of_adhesion": 0.05, "dissipation": 1.0, "force": 1.0, "radius": 1e-2, "separation": 1e-7},
        **{"frequency": 10.0, "factor": 2.0},
    }
    sized = {"wavevectors": [2e5, 1e6], "tolerance": 1e-4}
    spread = {"variance": [1.0, 4.0], "pressure": 1.0, "modes": None, "step": None}
    walls = {"tensile_limit": 0.5, "yield_stress": 9.0}
    sines = {"variance": 1.0, "pressure": 1.0, "tensile_limit": 0.5, "yield_stress": 4.0, "modes": 20}
    return doors_with(
        common,
        *kinds,
        *(getattr(kind, name) for kind in kinds for name in ("scaled", "m0", "m2", "m4", "moments")),
        (spectrum.SelfAffine, {"amplitude": 1e-27}),
        (spectrum.SelfAffine.from_rms_height, {"rms_height": 1e-6}),
        spectrum.SelfAffine.from_rms_gradient,
        (capillary.CapillaryWaves, WAVES),
        (capillary.maximum_height, {"independent_points": 1e6}),
        stretched.Stretched,
        (drawn.directional, {"qx": 1e5, "qy": np.array([1e5, 2e5])}),
        drawn.m2,
        (tabulated.Tabulated, {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]}),
        (tabulated.Tabulated.from_areal_psd, {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]}),
        (tabulated.smoothed, {"wavevectors": [1e5, 2e5, 5e5], "yielded": [0.0, 0.2, 0.6], "form": "gradual"}),
        *(spectrum.area_factor, elastic.stress_variance, elastic.diffusion_parameter, elastic.contact_area),
        *(elastic.non_contact_area, elastic.pressure_for_area, elastic.area_against_magnification),
        *(elastic.pressure_distribution, elastic.initial_slope, elastic.reduced_pressure, elastic.kappa),
        elastic.persson_kappa,
        scale.Scale,
        (scale.Scale, {"contact_modulus": lambda q: 1e9 + 0 * q}),
        *(one.modulus, one.variance, (one.wavevector, {"variance": 1e14})),
        separation.mean_separation,
        (separation.elastic_energy, {"energy": "old"}),
        separation.contact_stiffness,
        (gaps.gap_distribution, {"gap": 1e-8}),
        (separation.macroasperity_pressure, {"spectrum": bent}),
        (separation.macroasperity_magnification, {"spectrum": bent}),
        (tensile.adhesion_load, {"pressure": 1e5, "stress_variance": 1e12, "tensile_limit": 1e6}),
        (archard.archard_hierarchy, {"radii": [1e-2, 1e-4], "densities": [1e8]}),
        (heights.height_distribution, {"height": 1e-9, "rms_height": 1e-9}),
        (asperities.yielding_asperities, {"hardness": 1e8}),
        (percolation.percolation_magnification, {"threshold": 0.3}),
        (graded.ElasticPlate, {"young": 1e9, "thickness": 1e-6}),
        graded.ElasticPlate(young=1e9, poisson=0.3, thickness=1e-6),
        (flaw_tolerance.crack_stress, {"work": 0.05, "length": 1e-9}),
        (flaw_tolerance.flaw_tolerant_gradient, {"ideal_strength": 1e8, "alpha": 1.0}),
        (flaw_tolerance.optimal_modulus, {"spectrum": smooth, "pressure": 0.0, "tensile_limit": 1e5}),
        (viscoelastic.StandardSolid, RUBBER),
        *(hard.loss_compliance, hard.modulus),
        (
            viscoelastic.crack_dissipation,
            {"velocity": 1e-3, "loss_compliance": hard.loss_compliance, "relaxed": 1e6}
            | {"tip_radius": 1e-9, "contact_size": 1e-5},
        ),
        (soft_structures.foam_modulus, {"young": 1e9, "wall": 1e-7, "cell": 1e-6}),
        (soft_structures.fibre_modulus, FIBRES),
        (sliding.nominal_shear_stress, {"local_shear_stress": 1e7}),
        (sliding.local_shear_stress, {"nominal": 1e6, "pressure": 1e7, "hardness": 1e8}),
        (sliding.rubber_friction, slides | {"spectrum": smooth}),
        (sliding.friction_of_waves, slides | {"qx": [1e6, -1e6], "qy": [0.0, 0.0], "power": [1e-18, 1e-18]}),
        (sliding.slip_energy, {"shear_stress": 1e7, "slip": 3e-10}),
        (sliding.adhesional_pressure, {"barrier": 0.016, "lift": 1e-12}),
        (squeezed_spheres.hertz_pressure, SPHERE),
        (squeezed_spheres.yielded_share, SPHERE | {"hardness": 1e9}),
        (squeezed_spheres.yielded_pull_off, SPHERE | {"hardness": 1e9}),
        (squeezed_spheres.roughness_barrier, {"spectrum": smooth, "yield_stress": 1e8}),
        (variants.energy_factor, {"variant": "yang_persson"}),
        (variants.energy_share, {"energy": "xu"}),
        (variants.energy_share, {"energy": "improved"}),
        (variants.light_load_kappa, {"variant": "xu"}),
        (variants.corrected_contact_area, {"variant": "wang_mueser"}),
        (variants.corrected_contact_area, {"variant": "xu"}),
        (hardness.constant_hardness, {"yield_stress": 5e6}),
        (hardness.size_dependent_hardness, sized | {"yield_stress": lambda q: 1e9 + 0 * q}),
        (diffusion.solve_diffusion, spread | walls | {"breaks": (2.0,), "tolerance": 1e-4}),
        (diffusion.solve_diffusion, spread | {"tensile_limit": lambda v: 0.5, "modes": 30, "step": 0.1}),
        (diffusion.solve_diffusion([1.0, 4.0], pressure=1.0).distribution, {"index": 0, "stress": 1.0}),
        (sine.sine_expansion, sines | {"tolerance": 1e-6}),
        (sine.sine_expansion, sines | {"tensile_limit": lambda v: 0.5, "yield_stress": lambda v: 4.0}),
        (sine.sine_expansion(**sines).distribution, {"stress": 1.0}),
        (adhesion.Interface, {"energy": "old", "area": "star", "alpha": 1.0, "ideal_strength": 1e9}),
        (adhesion.detachment_stress, {"work": 0.05}),
        (adhesion.crossover_length, {"atomic_distance": 7e-10}),
        *(adhesion.opening_work, adhesion.closing_work),
        (adhesion.solve_adhesion, {"yield_stress": 1e9, "start": pressed, "tolerance": 1e-3, "rounds": 20}),
        (pressed.distribution, {"index": 3, "stress": 1.0}),
        *((pressed.area_at, {"wavevector": 2e5}), (pressed.work_at, {"wavevector": 2e5})),
        (leakage.effective_medium, {"conductances": [0.0, 1.0, 2.0], "shares": [0.2, 0.5, 0.3]}),
        (limits.pull_off_stress, {"tolerance": 0.1}),
        (limits.critical_roughness, {"contact_modulus": 1e6, "tolerance": 0.5}),
        *((graded.GradedModulus, DEEP), graded.GradedModulus(**DEEP)),
        *((graded.ExponentialLayers, LAYERS), graded.ExponentialLayers(**LAYERS)),
        (graded.ExponentialLayers(**LAYERS).young, {"depth": 1e-6}),
        (graded.SurfaceLayer, {"layer": 1e9, "bulk": 2e9, "thickness": 1e-6}),
        graded.SurfaceLayer(layer=1e9, bulk=2e9, thickness=1e-6, poisson=0.3),
        (asperities.Asperities, {"density": 1e10, "radius": 1e-6, "rms_height": 1e-7}),
        *(summits.contact, summits.contact_at, asperities.bush_gibson_thomas, asperities.nayak_asperities),
        (asperities.ring_asperities, {"rms_height": 1e-7}),
        asperities.FullerTabor,
        asperities.FullerTabor(asperities=summits, contact_modulus=1e9, work_of_adhesion=0.05).pressure,
        (spheres.effective_radius, {"first": 1.0, "second": 2.0}),
        spheres.hertz,
        (spheres.hertz(1.0, radius=1e-2, contact_modulus=1e9).pressure, {"distance": 1e-5}),
        (spheres.hertz_pressure_distribution, {"stress": 1.0, "peak_pressure": 2.0}),
        (spheres.jkr_load, {"contact_radius": 1e-3, "radius": 1.0, "contact_modulus": 1e6}),
        *(spheres.jkr_pull_off, spheres.derjaguin_pull_off, (spheres.tabor_parameter, {"range_": 1e-9})),
        (spheres.maugis_pull_off, {"tabor": 1.0}),
        (spheres.DoubleHertz, {"peak_pressure": 1.0, "tensile_limit": 0.3, "eta": 1.1}),
        (double.pressure, {"distance": 0.5}),
        (double.distribution, {"stress": 0.5}),
        *((getattr(double, name), {"contact_radius": 1.0}) for name in ("load", "contact_force")),
    )
