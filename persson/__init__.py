"""Persson's theory of contact mechanics: functions of the power spectrum C(q), a solid and a load.

>>> from persson import SelfAffine, contact_area, elastic, stress_variance
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from persson import adhesion, asperities, diffusion, elastic, graded, hardness, limits, spheres
    from persson.adhesion import Interface, solve_adhesion
    from persson.archard import archard_hierarchy
    from persson.asperities import FullerTabor, bush_gibson_thomas, nayak_asperities
    from persson.capillary import CapillaryWaves, maximum_height
    from persson.diffusion import Diffusion, Wall, solve_diffusion
    from persson.elastic import (
        area_against_magnification,
        contact_area,
        kappa,
        pressure_distribution,
        pressure_for_area,
        reduced_pressure,
        stress_variance,
    )
    from persson.elastoplastic_asperities import yielding_asperities
    from persson.errors import InvalidInput, PerssonError
    from persson.flaw_tolerance import crack_stress, flaw_tolerant_gradient, optimal_modulus
    from persson.gaps import gap_distribution
    from persson.graded import ExponentialLayers, GradedModulus, SurfaceLayer
    from persson.hardness import constant_hardness, nix_gao_hardness, size_dependent_hardness
    from persson.heights import height_distribution
    from persson.leakage import effective_medium
    from persson.limits import critical_roughness, pull_off_stress
    from persson.percolation import percolation_magnification
    from persson.plate import ElasticPlate
    from persson.scale import Scale
    from persson.separation import (
        contact_stiffness,
        elastic_energy,
        macroasperity_magnification,
        macroasperity_pressure,
        mean_separation,
    )
    from persson.sine import SineExpansion, sine_expansion
    from persson.sliding import (
        SlidingFriction,
        adhesional_pressure,
        friction_of_waves,
        local_shear_stress,
        nominal_shear_stress,
        rubber_friction,
        slip_energy,
    )
    from persson.soft_structures import fibre_modulus, foam_modulus
    from persson.spectrum import Moments, SelfAffine, Spectrum, SpectrumMoments
    from persson.spheres import hertz, jkr_load, jkr_pull_off, tabor_parameter
    from persson.squeezed_spheres import hertz_pressure, roughness_barrier, yielded_pull_off, yielded_share
    from persson.stretched import Stretched
    from persson.tabulated import Tabulated, smoothed
    from persson.tensile import adhesion_load
    from persson.variants import corrected_contact_area
    from persson.viscoelastic import StandardSolid, crack_dissipation

__all__ = [
    "CapillaryWaves",
    "Diffusion",
    "ElasticPlate",
    "ExponentialLayers",
    "FullerTabor",
    "GradedModulus",
    "Interface",
    "InvalidInput",
    "Moments",
    "PerssonError",
    "Scale",
    "SelfAffine",
    "SineExpansion",
    "SlidingFriction",
    "Spectrum",
    "SpectrumMoments",
    "StandardSolid",
    "Stretched",
    "SurfaceLayer",
    "Tabulated",
    "Wall",
    "adhesion",
    "adhesion_load",
    "adhesional_pressure",
    "archard_hierarchy",
    "area_against_magnification",
    "asperities",
    "bush_gibson_thomas",
    "constant_hardness",
    "contact_area",
    "contact_stiffness",
    "corrected_contact_area",
    "crack_dissipation",
    "crack_stress",
    "critical_roughness",
    "diffusion",
    "effective_medium",
    "elastic",
    "elastic_energy",
    "fibre_modulus",
    "flaw_tolerant_gradient",
    "foam_modulus",
    "friction_of_waves",
    "gap_distribution",
    "graded",
    "hardness",
    "height_distribution",
    "hertz",
    "hertz_pressure",
    "jkr_load",
    "jkr_pull_off",
    "kappa",
    "limits",
    "local_shear_stress",
    "macroasperity_magnification",
    "macroasperity_pressure",
    "maximum_height",
    "mean_separation",
    "nayak_asperities",
    "nix_gao_hardness",
    "nominal_shear_stress",
    "optimal_modulus",
    "percolation_magnification",
    "pressure_distribution",
    "pressure_for_area",
    "pull_off_stress",
    "reduced_pressure",
    "roughness_barrier",
    "rubber_friction",
    "sine_expansion",
    "size_dependent_hardness",
    "slip_energy",
    "smoothed",
    "solve_adhesion",
    "solve_diffusion",
    "spheres",
    "stress_variance",
    "tabor_parameter",
    "yielded_pull_off",
    "yielded_share",
    "yielding_asperities",
]

#: Where each name lives: it is imported when first asked for, so that `import persson` costs nothing.
_HOMES = {
    "CapillaryWaves": "persson.capillary",
    "Diffusion": "persson.diffusion",
    "ElasticPlate": "persson.plate",
    "ExponentialLayers": "persson.graded",
    "FullerTabor": "persson.asperities",
    "GradedModulus": "persson.graded",
    "Interface": "persson.adhesion",
    "InvalidInput": "persson.errors",
    "Moments": "persson.spectrum",
    "PerssonError": "persson.errors",
    "Scale": "persson.scale",
    "SelfAffine": "persson.spectrum",
    "SineExpansion": "persson.sine",
    "SlidingFriction": "persson.sliding",
    "Spectrum": "persson.spectrum",
    "SpectrumMoments": "persson.spectrum",
    "StandardSolid": "persson.viscoelastic",
    "Stretched": "persson.stretched",
    "SurfaceLayer": "persson.graded",
    "Tabulated": "persson.tabulated",
    "Wall": "persson.diffusion",
    "adhesion_load": "persson.tensile",
    "adhesional_pressure": "persson.sliding",
    "archard_hierarchy": "persson.archard",
    "area_against_magnification": "persson.elastic",
    "bush_gibson_thomas": "persson.asperities",
    "constant_hardness": "persson.hardness",
    "contact_area": "persson.elastic",
    "contact_stiffness": "persson.separation",
    "corrected_contact_area": "persson.variants",
    "crack_dissipation": "persson.viscoelastic",
    "crack_stress": "persson.flaw_tolerance",
    "critical_roughness": "persson.limits",
    "effective_medium": "persson.leakage",
    "elastic_energy": "persson.separation",
    "fibre_modulus": "persson.soft_structures",
    "flaw_tolerant_gradient": "persson.flaw_tolerance",
    "foam_modulus": "persson.soft_structures",
    "friction_of_waves": "persson.sliding",
    "gap_distribution": "persson.gaps",
    "height_distribution": "persson.heights",
    "hertz": "persson.spheres",
    "hertz_pressure": "persson.squeezed_spheres",
    "jkr_load": "persson.spheres",
    "jkr_pull_off": "persson.spheres",
    "kappa": "persson.elastic",
    "local_shear_stress": "persson.sliding",
    "macroasperity_magnification": "persson.separation",
    "macroasperity_pressure": "persson.separation",
    "maximum_height": "persson.capillary",
    "mean_separation": "persson.separation",
    "nayak_asperities": "persson.asperities",
    "nix_gao_hardness": "persson.hardness",
    "nominal_shear_stress": "persson.sliding",
    "optimal_modulus": "persson.flaw_tolerance",
    "percolation_magnification": "persson.percolation",
    "pressure_distribution": "persson.elastic",
    "pressure_for_area": "persson.elastic",
    "pull_off_stress": "persson.limits",
    "reduced_pressure": "persson.elastic",
    "roughness_barrier": "persson.squeezed_spheres",
    "rubber_friction": "persson.sliding",
    "sine_expansion": "persson.sine",
    "size_dependent_hardness": "persson.hardness",
    "slip_energy": "persson.sliding",
    "smoothed": "persson.tabulated",
    "solve_adhesion": "persson.adhesion",
    "solve_diffusion": "persson.diffusion",
    "stress_variance": "persson.elastic",
    "tabor_parameter": "persson.spheres",
    "yielded_pull_off": "persson.squeezed_spheres",
    "yielded_share": "persson.squeezed_spheres",
    "yielding_asperities": "persson.elastoplastic_asperities",
}


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("fem-contact")
    if name in _HOMES:
        value: object = getattr(importlib.import_module(_HOMES[name]), name)
    elif name in __all__:
        value = importlib.import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"} - {"TYPE_CHECKING", "annotations", "importlib"})
