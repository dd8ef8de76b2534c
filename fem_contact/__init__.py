"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary and by finite elements.

>>> from fem_contact import HalfSpace, HeightField, Solid, bem, contact_areas, random_surface
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from fem_contact._environment import settle

if TYPE_CHECKING:
    from fem_contact import adhesion, bem, block
    from fem_contact.area import ContactAreas, Limit, contact_areas, mean_areas, subcell_area, subgrid_shifts
    from fem_contact.conductance import FrozenContact, contact_conductance, frozen_contact
    from fem_contact.contact import ContactResult, Cost, Residuals, Status, measure_residuals
    from fem_contact.errors import (
        FemContactError,
        InsufficientMemory,
        InvalidInput,
        NotConverged,
        UnsupportedEffect,
    )
    from fem_contact.export import render_section, render_surface, write_block
    from fem_contact.extrapolation import located_limit, perimeter_limit
    from fem_contact.graded import ExponentialSolid, LayeredSolid
    from fem_contact.hardness import Hardness, YieldedContact, press, unload, yielded
    from fem_contact.leak import GapFlow, critical_gap, flow_conductance, open_gap, percolates
    from fem_contact.patches import Patches, find_patches
    from fem_contact.response import BondedLayer, FrictionlessLayer, GivenResponse, HalfSpace, Response
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
    )
    from fem_contact.surface import (
        HeightField,
        RadialSpectrum,
        estimate_spectrum,
        radial_spectrum,
        random_surface,
        resolves,
    )

__all__ = [
    "BondedLayer",
    "ContactAreas",
    "ContactResult",
    "Cost",
    "ExponentialSolid",
    "FemContactError",
    "FrictionlessLayer",
    "FrozenContact",
    "GapFlow",
    "GivenResponse",
    "HalfSpace",
    "Hardness",
    "HeightField",
    "InsufficientMemory",
    "InvalidInput",
    "LayeredSolid",
    "Limit",
    "NotConverged",
    "Patches",
    "RadialSpectrum",
    "Residuals",
    "Response",
    "Solid",
    "Status",
    "UnsupportedEffect",
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
    "open_gap",
    "percolates",
    "perimeter_limit",
    "press",
    "pressure_distribution",
    "radial_spectrum",
    "random_surface",
    "render_section",
    "render_surface",
    "resolves",
    "subcell_area",
    "subgrid_shifts",
    "unload",
    "write_block",
    "yielded",
]

settle()

#: Where each name lives: it is imported when first asked for, so that `import fem_contact` costs nothing.
_HOMES = {
    "BondedLayer": "fem_contact.response",
    "ContactAreas": "fem_contact.area",
    "ContactResult": "fem_contact.contact",
    "Cost": "fem_contact.contact",
    "ExponentialSolid": "fem_contact.graded",
    "FemContactError": "fem_contact.errors",
    "FrictionlessLayer": "fem_contact.response",
    "FrozenContact": "fem_contact.conductance",
    "GapFlow": "fem_contact.leak",
    "GivenResponse": "fem_contact.response",
    "HalfSpace": "fem_contact.response",
    "Hardness": "fem_contact.hardness",
    "HeightField": "fem_contact.surface",
    "InsufficientMemory": "fem_contact.errors",
    "InvalidInput": "fem_contact.errors",
    "LayeredSolid": "fem_contact.graded",
    "Limit": "fem_contact.area",
    "NotConverged": "fem_contact.errors",
    "Patches": "fem_contact.patches",
    "RadialSpectrum": "fem_contact.surface",
    "Residuals": "fem_contact.contact",
    "Response": "fem_contact.response",
    "Solid": "fem_contact.solid",
    "Status": "fem_contact.contact",
    "UnsupportedEffect": "fem_contact.errors",
    "YieldedContact": "fem_contact.hardness",
    "composite_modulus": "fem_contact.solid",
    "contact_areas": "fem_contact.area",
    "contact_conductance": "fem_contact.conductance",
    "contact_stiffness": "fem_contact.stress",
    "critical_gap": "fem_contact.leak",
    "density_at_zero": "fem_contact.stress",
    "elastic_energy": "fem_contact.stress",
    "estimate_spectrum": "fem_contact.surface",
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
    "open_gap": "fem_contact.leak",
    "percolates": "fem_contact.leak",
    "perimeter_limit": "fem_contact.extrapolation",
    "press": "fem_contact.hardness",
    "pressure_distribution": "fem_contact.stress",
    "radial_spectrum": "fem_contact.surface",
    "random_surface": "fem_contact.surface",
    "render_section": "fem_contact.export",
    "render_surface": "fem_contact.export",
    "resolves": "fem_contact.surface",
    "subcell_area": "fem_contact.area",
    "subgrid_shifts": "fem_contact.area",
    "unload": "fem_contact.hardness",
    "write_block": "fem_contact.export",
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
