"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary and by finite elements.

>>> from fem_contact import HalfSpace, HeightField, Solid, bem, contact_areas, random_surface
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from fem_contact._environment import settle

if TYPE_CHECKING:
    from fem_contact import adhesion, bem, block
    from fem_contact.area import ContactAreas, contact_areas, mean_areas, subcell_area, subgrid_shifts
    from fem_contact.conductance import FrozenContact, contact_conductance, frozen_contact
    from fem_contact.contact import ContactResult, Cost, Residuals, Status, measure_residuals
    from fem_contact.errors import (
        FemContactError,
        InsufficientMemory,
        InvalidInput,
        NotConverged,
        UnsupportedEffect,
    )
    from fem_contact.export import render_section, render_surface, write_block, write_subsurface
    from fem_contact.extrapolation import Limit, located_limit, perimeter_limit
    from fem_contact.graded import ExponentialSolid, LayeredSolid
    from fem_contact.hardness import Hardness, YieldedContact, press, unload, yielded
    from fem_contact.leak import GapFlow, critical_gap, flow_conductance, open_gap, percolates
    from fem_contact.patches import Patches, find_patches
    from fem_contact.response import (
        BondedLayer,
        FreeHalfSpace,
        FrictionlessLayer,
        GivenResponse,
        HalfSpace,
        Response,
    )
    from fem_contact.sliding import SlidingContact, slide
    from fem_contact.solid import Solid, composite_modulus
    from fem_contact.stress import (
        contact_stiffness,
        density_at_zero,
        elastic_energy,
        gap_distribution,
        initial_slope,
        limit_density,
        loading_work,
        pressure_distribution,
        von_mises,
    )
    from fem_contact.subsurface import (
        AtDepth,
        Strongest,
        Subsurface,
        fields_below,
        planes_below,
        strongest_point,
    )
    from fem_contact.surface import (
        HeightField,
        Lay,
        Patch,
        RadialSpectrum,
        estimate_spectrum,
        measured_lay,
        radial_spectrum,
        random_surface,
        resolves,
    )
    from fem_contact.viscoelastic import PronySolid, TabulatedSolid, ViscoelasticSolid

__all__ = [
    "AtDepth",
    "BondedLayer",
    "ContactAreas",
    "ContactResult",
    "Cost",
    "ExponentialSolid",
    "FemContactError",
    "FreeHalfSpace",
    "FrictionlessLayer",
    "FrozenContact",
    "GapFlow",
    "GivenResponse",
    "HalfSpace",
    "Hardness",
    "HeightField",
    "InsufficientMemory",
    "InvalidInput",
    "Lay",
    "LayeredSolid",
    "Limit",
    "NotConverged",
    "Patch",
    "Patches",
    "PronySolid",
    "RadialSpectrum",
    "Residuals",
    "Response",
    "SlidingContact",
    "Solid",
    "Status",
    "Strongest",
    "Subsurface",
    "TabulatedSolid",
    "UnsupportedEffect",
    "ViscoelasticSolid",
    "YieldedContact",
    "adhesion",
    "bem",
    "block",
    "composite_modulus",
    "contact_areas",
    "contact_conductance",
    "contact_stiffness",
    "critical_gap",
    "density_at_zero",
    "elastic_energy",
    "estimate_spectrum",
    "fields_below",
    "find_patches",
    "flow_conductance",
    "frozen_contact",
    "gap_distribution",
    "initial_slope",
    "limit_density",
    "loading_work",
    "located_limit",
    "mean_areas",
    "measure_residuals",
    "measured_lay",
    "open_gap",
    "percolates",
    "perimeter_limit",
    "planes_below",
    "press",
    "pressure_distribution",
    "radial_spectrum",
    "random_surface",
    "render_section",
    "render_surface",
    "resolves",
    "slide",
    "strongest_point",
    "subcell_area",
    "subgrid_shifts",
    "unload",
    "von_mises",
    "write_block",
    "write_subsurface",
    "yielded",
]

settle()

#: Where each name lives: it is imported when first asked for, so that `import fem_contact` costs nothing.
_HOMES = {
    "AtDepth": "fem_contact.subsurface",
    "BondedLayer": "fem_contact.response",
    "ContactAreas": "fem_contact.area",
    "ContactResult": "fem_contact.contact",
    "Cost": "fem_contact.contact",
    "ExponentialSolid": "fem_contact.graded",
    "FemContactError": "fem_contact.errors",
    "FreeHalfSpace": "fem_contact.response",
    "FrictionlessLayer": "fem_contact.response",
    "FrozenContact": "fem_contact.conductance",
    "GapFlow": "fem_contact.leak",
    "GivenResponse": "fem_contact.response",
    "HalfSpace": "fem_contact.response",
    "Hardness": "fem_contact.hardness",
    "HeightField": "fem_contact.surface",
    "InsufficientMemory": "fem_contact.errors",
    "InvalidInput": "fem_contact.errors",
    "Lay": "fem_contact.surface",
    "LayeredSolid": "fem_contact.graded",
    "Limit": "fem_contact.extrapolation",
    "NotConverged": "fem_contact.errors",
    "Patch": "fem_contact.surface",
    "Patches": "fem_contact.patches",
    "PronySolid": "fem_contact.viscoelastic",
    "RadialSpectrum": "fem_contact.surface",
    "Residuals": "fem_contact.contact",
    "Response": "fem_contact.response",
    "SlidingContact": "fem_contact.sliding",
    "Solid": "fem_contact.solid",
    "Status": "fem_contact.contact",
    "Strongest": "fem_contact.subsurface",
    "Subsurface": "fem_contact.subsurface",
    "TabulatedSolid": "fem_contact.viscoelastic",
    "UnsupportedEffect": "fem_contact.errors",
    "ViscoelasticSolid": "fem_contact.viscoelastic",
    "YieldedContact": "fem_contact.hardness",
    "composite_modulus": "fem_contact.solid",
    "contact_areas": "fem_contact.area",
    "contact_conductance": "fem_contact.conductance",
    "contact_stiffness": "fem_contact.stress",
    "critical_gap": "fem_contact.leak",
    "density_at_zero": "fem_contact.stress",
    "elastic_energy": "fem_contact.stress",
    "estimate_spectrum": "fem_contact.surface",
    "fields_below": "fem_contact.subsurface",
    "find_patches": "fem_contact.patches",
    "flow_conductance": "fem_contact.leak",
    "frozen_contact": "fem_contact.conductance",
    "gap_distribution": "fem_contact.stress",
    "initial_slope": "fem_contact.stress",
    "limit_density": "fem_contact.stress",
    "loading_work": "fem_contact.stress",
    "located_limit": "fem_contact.extrapolation",
    "mean_areas": "fem_contact.area",
    "measure_residuals": "fem_contact.contact",
    "measured_lay": "fem_contact.surface",
    "open_gap": "fem_contact.leak",
    "percolates": "fem_contact.leak",
    "planes_below": "fem_contact.subsurface",
    "perimeter_limit": "fem_contact.extrapolation",
    "press": "fem_contact.hardness",
    "pressure_distribution": "fem_contact.stress",
    "radial_spectrum": "fem_contact.surface",
    "random_surface": "fem_contact.surface",
    "render_section": "fem_contact.export",
    "render_surface": "fem_contact.export",
    "resolves": "fem_contact.surface",
    "strongest_point": "fem_contact.subsurface",
    "slide": "fem_contact.sliding",
    "subcell_area": "fem_contact.area",
    "subgrid_shifts": "fem_contact.area",
    "unload": "fem_contact.hardness",
    "von_mises": "fem_contact.stress",
    "write_block": "fem_contact.export",
    "write_subsurface": "fem_contact.export",
    "yielded": "fem_contact.hardness",
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
    return sorted(
        {*globals(), *__all__, "__version__"} - {"TYPE_CHECKING", "annotations", "importlib", "settle"}
    )
