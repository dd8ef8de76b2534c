"""Doors of `persson`."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from persson import adhesion as theory_adhesion
from persson import (
    asperities,
    capillary,
    diffusion,
    elastic,
    limits,
    scale,
    separation,
    sine,
    spectrum,
    spheres,
    tabulated,
    variants,
)
from persson import graded as theory_graded
from persson import hardness as theory_hardness

Door = tuple[Callable[..., Any], dict[str, Any]]


def theory_doors() -> dict[str, Door]:
    """Return all of them."""
    given = _theory_given()
    groups = (
        _theory_of_spectra,
        _theory_of_elastic,
        _theory_of_scales,
        _theory_of_walls,
        _theory_of_adhesion,
        _theory_of_graded,
        _theory_of_asperities,
        _theory_of_spheres,
    )
    doors = {name: door for group in groups for name, door in group(given).items()}
    for name, kind in (
        ("SelfAffine", given.bent),
        ("CapillaryWaves", capillary.CapillaryWaves(**given.waves)),
        ("Tabulated", given.table),
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


def _theory_given() -> SimpleNamespace:
    """Return what the doors are handed, made once."""
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
    return SimpleNamespace(
        bent=bent,
        deep=deep,
        diffused=diffused,
        double=double,
        hertz=hertz,
        layers=layers,
        load=load,
        moments=moments,
        one=one,
        power=power,
        pressed=pressed,
        rough=rough,
        sines=sines,
        single=single,
        sticky=sticky,
        summits=summits,
        table=table,
        tabor=tabor,
        waves=waves,
    )


def _theory_of_spectra(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "SelfAffine": (spectrum.SelfAffine, given.power | {"amplitude": 1e-27}),
        "SelfAffine.from_rms_height": (
            spectrum.SelfAffine.from_rms_height,
            given.power | {"rms_height": 1e-6},
        ),
        "SelfAffine.from_rms_gradient": (
            spectrum.SelfAffine.from_rms_gradient,
            given.power | {"rms_gradient": 0.1},
        ),
        "CapillaryWaves": (capillary.CapillaryWaves, given.waves),
        "maximum_height": (capillary.maximum_height, {"independent_points": 1e6}),
        "Tabulated": (tabulated.Tabulated, {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]}),
        "Tabulated.from_areal_psd": (
            tabulated.Tabulated.from_areal_psd,
            {"wavevectors": [1.0, 2.0], "power": [1.0, 2.0]},
        ),
        "smoothed": (
            tabulated.smoothed,
            {
                "spectrum": given.rough,
                "wavevectors": [1e5, 2e5, 5e5],
                "yielded": [0.0, 0.2, 0.6],
                "form": "gradual",
            },
        ),
        "area_factor": (spectrum.area_factor, {"m2": 0.1}),
    }


def _theory_of_elastic(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "stress_variance": (elastic.stress_variance, {"m2": 0.1, "contact_modulus": 1e9}),
        "diffusion_parameter": (elastic.diffusion_parameter, given.load),
        "contact_area": (elastic.contact_area, given.load),
        "non_contact_area": (elastic.non_contact_area, given.load),
        "pressure_for_area": (elastic.pressure_for_area, {"area": 0.1, "stress_variance": 1.0}),
        "area_against_magnification": (
            elastic.area_against_magnification,
            {
                "spectrum": given.rough,
                "pressure": 1e6,
                "contact_modulus": 1e9,
                "magnification": 5.0,
                "q_reference": 1e5,
            },
        ),
        "pressure_distribution": (elastic.pressure_distribution, given.load | {"stress": 1.0}),
        "initial_slope": (elastic.initial_slope, given.load),
        "reduced_pressure": (
            elastic.reduced_pressure,
            {"pressure": 1.0, "contact_modulus": 1e3, "rms_gradient": 0.1},
        ),
        "kappa": (elastic.kappa, {"area": 0.1, "reduced_pressure": 0.05}),
        "persson_kappa": (elastic.persson_kappa, {"reduced_pressure": 0.05}),
        "mean_separation": (
            separation.mean_separation,
            {"pressure": 1e6, "scale": given.one, "energy_ratio": 0.5},
        ),
        "macroasperity_magnification": (
            separation.macroasperity_magnification,
            {"spectrum": given.bent, "pressure": 1e6, "contact_modulus": 1e9, "q_reference": 1e5},
        ),
        "energy_factor": (
            variants.energy_factor,
            {"area": 0.1, "variant": "yang_persson", "energy_ratio": 0.4},
        ),
        "light_load_kappa": (variants.light_load_kappa, {"variant": "xu", "energy_ratio": 0.4}),
        "corrected_contact_area": (
            variants.corrected_contact_area,
            given.load | {"variant": "wang_mueser", "energy_ratio": 0.4},
        ),
        "corrected_contact_area of Xu": (
            variants.corrected_contact_area,
            given.load | {"variant": "xu", "energy_ratio": 0.4},
        ),
    }


def _theory_of_scales(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "Scale": (scale.Scale, {"spectrum": given.rough, "contact_modulus": 1e9}),
        "Scale graded": (scale.Scale, {"spectrum": given.rough, "contact_modulus": lambda q: 1e9 + 0 * q}),
        "Scale.modulus": (given.one.modulus, {"q": 2e5}),
        "Scale.variance": (given.one.variance, {"q": 2e5}),
        "Scale.wavevector": (given.one.wavevector, {"variance": 1e14}),
    }


def _theory_of_walls(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "constant_hardness": (theory_hardness.constant_hardness, given.load | {"yield_stress": 5.0}),
        "size_dependent_hardness": (
            theory_hardness.size_dependent_hardness,
            {
                "scale": given.one,
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
        "Diffusion.distribution": (given.diffused.distribution, {"index": 0, "stress": 1.0}),
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
        "SineExpansion.distribution": (given.sines.distribution, {"stress": 1.0}),
    }


def _theory_of_adhesion(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "Interface": (
            theory_adhesion.Interface,
            {"work_of_adhesion": 0.05, "energy": "old", "area": "star", "alpha": 1.0, "ideal_strength": 1e9},
        ),
        "detachment_stress": (
            theory_adhesion.detachment_stress,
            {"work": 0.05, "contact_modulus": 1e9, "wavevector": 1e6, "interface": given.sticky},
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
                "scale": given.one,
                "pressure": 1e6,
                "interface": given.sticky,
                "yield_stress": 1e9,
                "start": given.pressed,
                "tolerance": 1e-3,
                "rounds": 20,
            },
        ),
        "AdhesiveContact.area_at": (given.pressed.area_at, {"wavevector": 2e5}),
        "AdhesiveContact.work_at": (given.pressed.work_at, {"wavevector": 2e5}),
        "pull_off_stress": (
            limits.pull_off_stress,
            {"scale": given.one, "interface": given.sticky, "tolerance": 0.1},
        ),
        "critical_roughness": (
            limits.critical_roughness,
            {"spectrum": given.rough, "contact_modulus": 1e6, "interface": given.sticky, "tolerance": 0.5},
        ),
    }


def _theory_of_graded(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "GradedModulus": (theory_graded.GradedModulus, given.deep),
        "GradedModulus()": (theory_graded.GradedModulus(**given.deep), {"wavevector": 1e6}),
        "ExponentialLayers": (theory_graded.ExponentialLayers, given.layers),
        "ExponentialLayers()": (theory_graded.ExponentialLayers(**given.layers), {"wavevector": 1e6}),
        "ExponentialLayers.young": (theory_graded.ExponentialLayers(**given.layers).young, {"depth": 1e-6}),
        "SurfaceLayer": (theory_graded.SurfaceLayer, given.single),
        "SurfaceLayer()": (theory_graded.SurfaceLayer(**given.single), {"wavevector": 1e6}),
    }


def _theory_of_asperities(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "Asperities": (asperities.Asperities, {"density": 1e10, "radius": 1e-6, "rms_height": 1e-7}),
        "Asperities.contact": (given.summits.contact, {"separation": 1e-7, "contact_modulus": 1e9}),
        "Asperities.contact_at": (given.summits.contact_at, {"pressure": 1e6, "contact_modulus": 1e9}),
        "ring_asperities": (asperities.ring_asperities, {"wavevector": 1e6, "rms_height": 1e-7}),
        "nayak_asperities": (asperities.nayak_asperities, {"moments": given.moments}),
        "bush_gibson_thomas": (
            asperities.bush_gibson_thomas,
            {"separation": 1e-7, "moments": given.moments, "contact_modulus": 1e9},
        ),
        "FullerTabor": (
            asperities.FullerTabor,
            {"asperities": given.summits, "contact_modulus": 1e9, "work_of_adhesion": 0.05},
        ),
        "FullerTabor.pressure": (given.tabor.pressure, {"separation": 1e-7}),
    }


def _theory_of_spheres(given: SimpleNamespace) -> dict[str, Door]:
    return {
        "effective_radius": (spheres.effective_radius, {"first": 1.0, "second": 2.0}),
        "hertz": (spheres.hertz, {"force": 1.0, "radius": 1e-2, "contact_modulus": 1e9}),
        "HertzContact.pressure": (given.hertz.pressure, {"distance": 1e-5}),
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
        "DoubleHertz.pressure": (given.double.pressure, {"distance": 0.5}),
        "DoubleHertz.load": (given.double.load, {"contact_radius": 1.0}),
        "DoubleHertz.contact_force": (given.double.contact_force, {"contact_radius": 1.0}),
        "DoubleHertz.distribution": (given.double.distribution, {"stress": 0.5}),
    }
