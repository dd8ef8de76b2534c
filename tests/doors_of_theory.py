"""Every public door of `persson`, with arguments it accepts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from doors import Door

from persson import adhesion as theory_adhesion
from persson import (
    archard,
    asperities,
    capillary,
    diffusion,
    elastic,
    elastoplastic_asperities,
    flaw_tolerance,
    gaps,
    heights,
    leakage,
    limits,
    percolation,
    plate,
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
from persson import graded as theory_graded
from persson import hardness as theory_hardness


def paper_doors(one: Any, rough: Any, bent: Any, summits: Any, sticky: Any) -> dict[str, Door]:
    """Doors to what the paper says in passing."""
    rubber = {"relaxed": 1e6, "unrelaxed": 1e9, "time": 1e-3}
    sphere = {"force": 1e-4, "radius": 1e-3, "contact_modulus": 1e10}
    told = {"pressure": 1e6, "scale": one, "energy_ratio": 0.5}
    hard = viscoelastic.StandardSolid(**rubber)
    thin = {"young": 1e9, "poisson": 0.3, "thickness": 1e-6}
    smooth = rough.scaled(1e-4)
    return {
        "elastic_energy": (separation.elastic_energy, told | {"energy": "old"}),
        "contact_stiffness": (separation.contact_stiffness, told),
        "gap_distribution": (gaps.gap_distribution, told | {"gap": 1e-8}),
        "macroasperity_pressure": (
            separation.macroasperity_pressure,
            {"spectrum": bent, "pressure": 1e6, "contact_modulus": 1e9, "q_reference": 1e5},
        ),
        "adhesion_load": (
            tensile.adhesion_load,
            {"pressure": 1e5, "stress_variance": 1e12, "tensile_limit": 1e6},
        ),
        "archard_hierarchy": (
            archard.archard_hierarchy,
            {"force": 1.0, "radii": [1e-2, 1e-4], "densities": [1e8], "contact_modulus": 1e9},
        ),
        "height_distribution": (heights.height_distribution, {"height": 1e-9, "rms_height": 1e-9}),
        "yielding_asperities": (
            elastoplastic_asperities.yielding_asperities,
            {"separation": 1e-7, "asperities": summits, "contact_modulus": 1e9, "hardness": 1e8},
        ),
        "percolation_magnification": (
            percolation.percolation_magnification,
            {"scale": one, "pressure": 1e6, "q_reference": 1e5, "threshold": 0.3},
        ),
        "ElasticPlate": (plate.ElasticPlate, thin),
        "ElasticPlate()": (plate.ElasticPlate(**thin), {"wavevector": 1e6}),
        "crack_stress": (
            flaw_tolerance.crack_stress,
            {"work": 0.05, "contact_modulus": 1e9, "length": 1e-9},
        ),
        "flaw_tolerant_gradient": (
            flaw_tolerance.flaw_tolerant_gradient,
            {"work_of_adhesion": 0.05, "ideal_strength": 1e8, "poisson": 0.3, "alpha": 1.0},
        ),
        "optimal_modulus": (
            flaw_tolerance.optimal_modulus,
            {
                "spectrum": smooth,
                "pressure": 0.0,
                "tensile_limit": 1e5,
                "interface": sticky,
                "nodes": 40,
                "tolerance": 1e-3,
            },
        ),
        "StandardSolid": (viscoelastic.StandardSolid, rubber),
        "StandardSolid.loss_compliance": (hard.loss_compliance, {"frequency": 10.0}),
        "crack_dissipation": (
            viscoelastic.crack_dissipation,
            {
                "velocity": 1e-3,
                "loss_compliance": hard.loss_compliance,
                "relaxed": 1e6,
                "tip_radius": 1e-9,
                "contact_size": 1e-5,
            },
        ),
        "foam_modulus": (
            soft_structures.foam_modulus,
            {"young": 1e9, "wall": 1e-7, "cell": 1e-6, "factor": 1.0},
        ),
        "fibre_modulus": (
            soft_structures.fibre_modulus,
            {"young": 1e9, "radius": 1e-6, "length": 1e-4, "density": 1e10, "angle": 0.7},
        ),
        "nominal_shear_stress": (
            sliding.nominal_shear_stress,
            {"area": 0.1, "local_shear_stress": 1e7},
        ),
        "local_shear_stress": (
            sliding.local_shear_stress,
            {"nominal": 1e6, "pressure": 1e7, "hardness": 1e8},
        ),
        "StandardSolid.modulus": (hard.modulus, {"frequency": 1.0}),
        "rubber_friction": (
            sliding.rubber_friction,
            {
                "spectrum": smooth,
                "pressure": 1e6,
                "velocity": 0.1,
                "modulus": hard.modulus,
                "poisson": 0.3,
                "energy_ratio": 0.5,
            },
        ),
        "friction_of_waves": (
            sliding.friction_of_waves,
            {
                "qx": [1e6, -1e6],
                "qy": [0.0, 0.0],
                "power": [1e-18, 1e-18],
                "pressure": 1e6,
                "velocity": 0.1,
                "modulus": hard.modulus,
                "poisson": 0.3,
                "energy_ratio": 0.5,
            },
        ),
        "slip_energy": (sliding.slip_energy, {"shear_stress": 1e7, "slip": 3e-10}),
        "adhesional_pressure": (sliding.adhesional_pressure, {"barrier": 0.016, "lift": 1e-12}),
        "hertz_pressure": (squeezed_spheres.hertz_pressure, sphere),
        "yielded_share": (squeezed_spheres.yielded_share, sphere | {"hardness": 1e9}),
        "yielded_pull_off": (
            squeezed_spheres.yielded_pull_off,
            sphere | {"hardness": 1e9, "work_of_adhesion": 0.05},
        ),
        "roughness_barrier": (
            squeezed_spheres.roughness_barrier,
            {
                "spectrum": smooth,
                "contact_modulus": 1e9,
                "pressure": 1e6,
                "yield_stress": 1e8,
                "interface": sticky,
                "nodes": 40,
            },
        ),
    }


def theory_doors() -> dict[str, Door]:
    """The doors of `persson`."""
    rough = spectrum.SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e6)
    bent = spectrum.SelfAffine.from_rms_gradient(
        0.1, hurst=0.8, q_long=1e5, q_short=1e7, rolloff="smooth", q_min=1e4
    )
    table = tabulated.Tabulated(wavevectors=[1e5, 2e5, 1e6], power=[3e-28, 2e-28, 1e-29])
    waves = {
        "temperature": 370.0,
        "surface_tension": 0.04,
        "q_bend": 1.7e9,
        "q_min": 6.28e4,
        "q_short": 7e9,
        "q_gravity": 0.0,
        "multiple": 1.0,
    }
    moments = rough.moments()
    summits = asperities.nayak_asperities(moments)
    one = scale.Scale(rough, contact_modulus=1e9)
    sticky = theory_adhesion.Interface(work_of_adhesion=0.05)
    pressed = theory_adhesion.solve_adhesion(one, pressure=1e6, interface=sticky)
    diffused = diffusion.solve_diffusion([1.0, 4.0], pressure=1.0)
    sines = sine.sine_expansion(1.0, pressure=1.0, tensile_limit=0.5, yield_stress=4.0, modes=20)
    double = spheres.DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    hertz = spheres.hertz(1.0, radius=1e-2, contact_modulus=1e9)
    tabor = asperities.FullerTabor(asperities=summits, contact_modulus=1e9, work_of_adhesion=0.05)
    power = {"hurst": 0.8, "q_long": 1e5, "q_short": 1e6, "rolloff": "smooth", "q_min": 1e4}
    load = {"pressure": 1.0, "stress_variance": 2.0}
    layers = {"bulk": 1e9, "excess": [1e9], "depths": [1e-6], "poisson": 0.3}
    single = {"layer": 1e9, "bulk": 2e9, "thickness": 1e-6, "poisson": 0.3}
    deep = {"young": lambda z: 1e9 * np.exp(0 * z), "poisson": 0.3, "breaks": (1e-6,)}
    doors: dict[str, Door] = {
        "SelfAffine": (spectrum.SelfAffine, power | {"amplitude": 1e-27}),
        "SelfAffine.from_rms_height": (spectrum.SelfAffine.from_rms_height, power | {"rms_height": 1e-6}),
        "SelfAffine.from_rms_gradient": (
            spectrum.SelfAffine.from_rms_gradient,
            power | {"rms_gradient": 0.1},
        ),
        "CapillaryWaves": (capillary.CapillaryWaves, waves),
        "maximum_height": (capillary.maximum_height, {"independent_points": 1e6}),
        "Stretched": (
            stretched.Stretched,
            {"spectrum": spectrum.SelfAffine(**power, amplitude=1.0), "factor": 2.0},
        ),
        "Stretched.directional": (
            stretched.Stretched(spectrum=spectrum.SelfAffine(**power, amplitude=1.0), factor=2.0).directional,
            {"qx": 1e5, "qy": np.array([1e5, 2e5])},
        ),
        "Stretched.m2": (
            stretched.Stretched(spectrum=spectrum.SelfAffine(**power, amplitude=1.0), factor=2.0).m2,
            {"q_upper": 2e5},
        ),
        "Tabulated": (tabulated.Tabulated, {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]}),
        "Tabulated.from_areal_psd": (
            tabulated.Tabulated.from_areal_psd,
            {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]},
        ),
        "smoothed": (
            tabulated.smoothed,
            {
                "spectrum": rough,
                "wavevectors": [1e5, 2e5, 5e5],
                "yielded": [0.0, 0.2, 0.6],
                "form": "gradual",
            },
        ),
        "area_factor": (spectrum.area_factor, {"m2": 0.1}),
        "stress_variance": (elastic.stress_variance, {"m2": 0.1, "contact_modulus": 1e9}),
        "diffusion_parameter": (elastic.diffusion_parameter, load),
        "contact_area": (elastic.contact_area, load),
        "non_contact_area": (elastic.non_contact_area, load),
        "pressure_for_area": (elastic.pressure_for_area, {"area": 0.1, "stress_variance": 1.0}),
        "area_against_magnification": (
            elastic.area_against_magnification,
            {
                "spectrum": rough,
                "pressure": 1e6,
                "contact_modulus": 1e9,
                "magnification": 5.0,
                "q_reference": 1e5,
            },
        ),
        "pressure_distribution": (elastic.pressure_distribution, load | {"stress": 1.0}),
        "initial_slope": (elastic.initial_slope, load),
        "reduced_pressure": (
            elastic.reduced_pressure,
            {"pressure": 1.0, "contact_modulus": 1e3, "rms_gradient": 0.1},
        ),
        "kappa": (elastic.kappa, {"area": 0.1, "reduced_pressure": 0.05}),
        "persson_kappa": (elastic.persson_kappa, {"reduced_pressure": 0.05}),
        "Scale": (scale.Scale, {"spectrum": rough, "contact_modulus": 1e9}),
        "Scale graded": (scale.Scale, {"spectrum": rough, "contact_modulus": lambda q: 1e9 + 0 * q}),
        "Scale.modulus": (one.modulus, {"q": 2e5}),
        "Scale.variance": (one.variance, {"q": 2e5}),
        "Scale.wavevector": (one.wavevector, {"variance": 1e14}),
        "mean_separation": (separation.mean_separation, {"pressure": 1e6, "scale": one, "energy_ratio": 0.5}),
        **paper_doors(one, rough, bent, summits, sticky),
        "macroasperity_magnification": (
            separation.macroasperity_magnification,
            {"spectrum": bent, "pressure": 1e6, "contact_modulus": 1e9, "q_reference": 1e5},
        ),
        "energy_factor": (
            variants.energy_factor,
            {"area": 0.1, "variant": "yang_persson", "energy_ratio": 0.4},
        ),
        "energy_share": (variants.energy_share, load | {"energy": "xu"}),
        "energy_share of Eq. 48": (variants.energy_share, load | {"energy": "improved"}),
        "light_load_kappa": (variants.light_load_kappa, {"variant": "xu", "energy_ratio": 0.4}),
        "corrected_contact_area": (
            variants.corrected_contact_area,
            load | {"variant": "wang_mueser", "energy_ratio": 0.4},
        ),
        "corrected_contact_area of Xu": (
            variants.corrected_contact_area,
            load | {"variant": "xu", "energy_ratio": 0.4},
        ),
        "constant_hardness": (theory_hardness.constant_hardness, load | {"yield_stress": 5.0}),
        "size_dependent_hardness": (
            theory_hardness.size_dependent_hardness,
            {
                "scale": one,
                "pressure": 1e6,
                "yield_stress": lambda q: 1e9 + 0 * q,
                "wavevectors": [2e5, 1e6],
                "tolerance": 1e-4,
            },
        ),
        "nix_gao_hardness": (theory_hardness.nix_gao_hardness, {"depth": 1e-6, "bulk": 1e8, "length": 1e-6}),
        "solve_diffusion": (
            diffusion.solve_diffusion,
            {
                "variance": [1.0, 4.0],
                "pressure": 1.0,
                "tensile_limit": 0.5,
                "yield_stress": 9.0,
                "breaks": (2.0,),
                "tolerance": 1e-4,
                "modes": None,
                "step": None,
            },
        ),
        "solve_diffusion on given steps": (
            diffusion.solve_diffusion,
            {
                "variance": [1.0, 4.0],
                "pressure": 1.0,
                "tensile_limit": lambda v: 0.5 + 0 * v,
                "modes": 30,
                "step": 0.1,
            },
        ),
        "Diffusion.distribution": (diffused.distribution, {"index": 0, "stress": 1.0}),
        "sine_expansion": (
            sine.sine_expansion,
            {
                "variance": 1.0,
                "pressure": 1.0,
                "tensile_limit": 0.5,
                "yield_stress": 4.0,
                "modes": 20,
                "tolerance": 1e-6,
            },
        ),
        "sine_expansion of moving walls": (
            sine.sine_expansion,
            {
                "variance": 1.0,
                "pressure": 1.0,
                "tensile_limit": lambda v: 0.5,
                "yield_stress": lambda v: 4.0,
                "modes": 10,
            },
        ),
        "SineExpansion.distribution": (sines.distribution, {"stress": 1.0}),
        "Interface": (
            theory_adhesion.Interface,
            {"work_of_adhesion": 0.05, "energy": "old", "area": "star", "alpha": 1.0, "ideal_strength": 1e9},
        ),
        "detachment_stress": (
            theory_adhesion.detachment_stress,
            {"work": 0.05, "contact_modulus": 1e9, "wavevector": 1e6, "interface": sticky},
        ),
        "crossover_length": (
            theory_adhesion.crossover_length,
            {"work_of_adhesion": 0.05, "contact_modulus": 1e11, "atomic_distance": 7e-10},
        ),
        "opening_work": (theory_adhesion.opening_work, {"work_of_adhesion": 0.05, "dissipation": 1.0}),
        "closing_work": (theory_adhesion.closing_work, {"work_of_adhesion": 0.05, "dissipation": 1.0}),
        "solve_adhesion": (
            theory_adhesion.solve_adhesion,
            {
                "scale": one,
                "pressure": 1e6,
                "interface": sticky,
                "yield_stress": 1e9,
                "start": pressed,
                "tolerance": 1e-3,
                "rounds": 20,
            },
        ),
        "AdhesiveContact.distribution": (pressed.distribution, {"index": 3, "stress": 1.0}),
        "AdhesiveContact.area_at": (pressed.area_at, {"wavevector": 2e5}),
        "AdhesiveContact.work_at": (pressed.work_at, {"wavevector": 2e5}),
        "effective_medium": (
            leakage.effective_medium,
            {"conductances": [0.0, 1.0, 2.0], "shares": [0.2, 0.5, 0.3]},
        ),
        "pull_off_stress": (limits.pull_off_stress, {"scale": one, "interface": sticky, "tolerance": 0.1}),
        "critical_roughness": (
            limits.critical_roughness,
            {"spectrum": rough, "contact_modulus": 1e6, "interface": sticky, "tolerance": 0.5},
        ),
        "GradedModulus": (theory_graded.GradedModulus, deep),
        "GradedModulus()": (theory_graded.GradedModulus(**deep), {"wavevector": 1e6}),
        "ExponentialLayers": (theory_graded.ExponentialLayers, layers),
        "ExponentialLayers()": (theory_graded.ExponentialLayers(**layers), {"wavevector": 1e6}),
        "ExponentialLayers.young": (theory_graded.ExponentialLayers(**layers).young, {"depth": 1e-6}),
        "SurfaceLayer": (theory_graded.SurfaceLayer, single),
        "SurfaceLayer()": (theory_graded.SurfaceLayer(**single), {"wavevector": 1e6}),
        "Asperities": (asperities.Asperities, {"density": 1e10, "radius": 1e-6, "rms_height": 1e-7}),
        "Asperities.contact": (summits.contact, {"separation": 1e-7, "contact_modulus": 1e9}),
        "Asperities.contact_at": (summits.contact_at, {"pressure": 1e6, "contact_modulus": 1e9}),
        "ring_asperities": (asperities.ring_asperities, {"wavevector": 1e6, "rms_height": 1e-7}),
        "nayak_asperities": (asperities.nayak_asperities, {"moments": moments}),
        "bush_gibson_thomas": (
            asperities.bush_gibson_thomas,
            {"separation": 1e-7, "moments": moments, "contact_modulus": 1e9},
        ),
        "FullerTabor": (
            asperities.FullerTabor,
            {"asperities": summits, "contact_modulus": 1e9, "work_of_adhesion": 0.05},
        ),
        "FullerTabor.pressure": (tabor.pressure, {"separation": 1e-7}),
        "effective_radius": (spheres.effective_radius, {"first": 1.0, "second": 2.0}),
        "hertz": (spheres.hertz, {"force": 1.0, "radius": 1e-2, "contact_modulus": 1e9}),
        "HertzContact.pressure": (hertz.pressure, {"distance": 1e-5}),
        "hertz_pressure_distribution": (
            spheres.hertz_pressure_distribution,
            {"stress": 1.0, "peak_pressure": 2.0},
        ),
        "jkr_load": (
            spheres.jkr_load,
            {"contact_radius": 1e-3, "radius": 1.0, "contact_modulus": 1e6, "work_of_adhesion": 0.05},
        ),
        "jkr_pull_off": (spheres.jkr_pull_off, {"radius": 1.0, "work_of_adhesion": 0.05}),
        "derjaguin_pull_off": (spheres.derjaguin_pull_off, {"radius": 1.0, "work_of_adhesion": 0.05}),
        "tabor_parameter": (
            spheres.tabor_parameter,
            {"radius": 1.0, "contact_modulus": 1e6, "work_of_adhesion": 0.05, "range_": 1e-9},
        ),
        "maugis_pull_off": (spheres.maugis_pull_off, {"tabor": 1.0}),
        "DoubleHertz": (spheres.DoubleHertz, {"peak_pressure": 1.0, "tensile_limit": 0.3, "eta": 1.1}),
        "DoubleHertz.pressure": (double.pressure, {"distance": 0.5}),
        "DoubleHertz.load": (double.load, {"contact_radius": 1.0}),
        "DoubleHertz.contact_force": (double.contact_force, {"contact_radius": 1.0}),
        "DoubleHertz.distribution": (double.distribution, {"stress": 0.5}),
    }
    for name, kind in (
        ("SelfAffine", bent),
        ("CapillaryWaves", capillary.CapillaryWaves(**waves)),
        ("Tabulated", table),
    ):
        doors |= {
            f"{name}()": (kind, {"q": 2e5}),
            f"{name}.truncated": (kind.truncated, {"q_max": math.sqrt(kind.q_long * kind.q_short)}),
            f"{name}.scaled": (kind.scaled, {"factor": 2.0}),
            f"{name}.m0": (kind.m0, {"q_upper": 2e5}),
            f"{name}.m2": (kind.m2, {"q_upper": 2e5}),
            f"{name}.m4": (kind.m4, {"q_upper": 2e5}),
            f"{name}.moments": (kind.moments, {"q_upper": 2e5}),
        }
    return doors
