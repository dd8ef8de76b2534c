"""The constrained conjugate gradients of ContactMechanics, by FFT boundary elements."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation.methods.base import Settings
from validation.methods.foreign import Foreign
from validation.methods.peers import installed, missing

__all__ = ["ContactMechanics", "solve"]

Array = NDArray[np.float64]

#: Its tolerance is the largest penetration, a length, and says nothing of the points that are pulled.
_SAFETY = 0.1


class ContactMechanics(Foreign):
    """Polonsky and Keer's conjugate gradients of ContactMechanics, on the half-space without effects."""

    name = "contact_mechanics"
    label = "ContactMechanics"
    locates_edges = True
    papers = ("ContactMechanics: https://github.com/ContactEngineering/ContactMechanics.",)

    def available(self) -> str | None:
        """Say what to install."""
        return missing("ContactMechanics")

    def source(self, settings: Mapping[str, Any]) -> Settings:
        """Return its version."""
        return installed("ContactMechanics")

    def call(self, settings: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
        """Return the function below."""
        return f"{__name__}:solve", {}


def solve(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float,
    tolerance: float,
) -> dict[str, Any]:
    """Return pressures [Pa] and iterations; E* = 1 and the longer period 1 go in."""
    import ContactMechanics
    import SurfaceTopography

    warnings.simplefilter("ignore")
    scale = max(lengths)
    sides = (lengths[0] / scale, lengths[1] / scale)
    surface = (heights - heights.mean()) / scale
    substrate = ContactMechanics.PeriodicFFTElasticHalfSpace(heights.shape, 1.0, sides, fft="numpy")
    topography = SurfaceTopography.Topography(surface, sides, periodic=True)
    system = ContactMechanics.make_system(substrate=substrate, surface=topography)
    area = sides[0] * sides[1]
    # Forces are per point there.
    outcome = system.minimize_proxy(
        external_force=mean_pressure / contact_modulus * area,
        pentol=_SAFETY * tolerance * (float(np.std(surface)) or 1.0),
        maxiter=20_000,
    )
    cell = area / heights.size
    return {"pressure": np.array(outcome.jac) / cell * contact_modulus, "iterations": int(outcome.nit)}
