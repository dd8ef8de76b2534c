"""Persson's theory of contact mechanics: functions of the power spectrum C(q), a solid and a load.

>>> from persson import SelfAffine, contact_area, elastic, stress_variance
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from persson import adhesion, asperities, diffusion, elastic, graded, hardness, limits, spheres
    from persson.adhesion import Interface, solve_adhesion
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
    from persson.errors import InvalidInput, PerssonError
    from persson.graded import ExponentialLayers, GradedModulus, SurfaceLayer
    from persson.hardness import constant_hardness, nix_gao_hardness, size_dependent_hardness
    from persson.leakage import effective_medium
    from persson.limits import critical_roughness, pull_off_stress
    from persson.scale import Scale
    from persson.separation import mean_separation
    from persson.sine import SineExpansion, sine_expansion
    from persson.spectrum import Moments, SelfAffine, Spectrum, SpectrumMoments
    from persson.spheres import hertz, jkr_load, jkr_pull_off, tabor_parameter
    from persson.tabulated import Tabulated, smoothed
    from persson.variants import corrected_contact_area

__all__ = [
    "CapillaryWaves",
    "Diffusion",
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
    "Spectrum",
    "SpectrumMoments",
    "SurfaceLayer",
    "Tabulated",
    "Wall",
    "adhesion",
    "area_against_magnification",
    "asperities",
    "bush_gibson_thomas",
    "constant_hardness",
    "contact_area",
    "corrected_contact_area",
    "critical_roughness",
    "diffusion",
    "effective_medium",
    "elastic",
    "graded",
    "hardness",
    "hertz",
    "jkr_load",
    "jkr_pull_off",
    "kappa",
    "limits",
    "maximum_height",
    "mean_separation",
    "nayak_asperities",
    "nix_gao_hardness",
    "pressure_distribution",
    "pressure_for_area",
    "pull_off_stress",
    "reduced_pressure",
    "sine_expansion",
    "size_dependent_hardness",
    "smoothed",
    "solve_adhesion",
    "solve_diffusion",
    "spheres",
    "stress_variance",
    "tabor_parameter",
]

#: Where each name lives: it is imported when first asked for, so that `import persson` costs nothing.
_HOMES = {
    "CapillaryWaves": "persson.capillary",
    "Diffusion": "persson.diffusion",
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
    "Spectrum": "persson.spectrum",
    "SpectrumMoments": "persson.spectrum",
    "SurfaceLayer": "persson.graded",
    "Tabulated": "persson.tabulated",
    "Wall": "persson.diffusion",
    "area_against_magnification": "persson.elastic",
    "bush_gibson_thomas": "persson.asperities",
    "constant_hardness": "persson.hardness",
    "contact_area": "persson.elastic",
    "corrected_contact_area": "persson.variants",
    "critical_roughness": "persson.limits",
    "effective_medium": "persson.leakage",
    "hertz": "persson.spheres",
    "jkr_load": "persson.spheres",
    "jkr_pull_off": "persson.spheres",
    "kappa": "persson.elastic",
    "maximum_height": "persson.capillary",
    "mean_separation": "persson.separation",
    "nayak_asperities": "persson.asperities",
    "nix_gao_hardness": "persson.hardness",
    "pressure_distribution": "persson.elastic",
    "pressure_for_area": "persson.elastic",
    "pull_off_stress": "persson.limits",
    "reduced_pressure": "persson.elastic",
    "sine_expansion": "persson.sine",
    "size_dependent_hardness": "persson.hardness",
    "smoothed": "persson.tabulated",
    "solve_adhesion": "persson.adhesion",
    "solve_diffusion": "persson.diffusion",
    "stress_variance": "persson.elastic",
    "tabor_parameter": "persson.spheres",
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
