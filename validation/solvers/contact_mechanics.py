"""The constrained conjugate gradients of ContactMechanics, by FFT boundary elements."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from validation.arrays import Array
from validation.solvers.external import ExternalSolver

#: Its tolerance is the largest penetration, a length, and says nothing of the points that are pulled.
_SAFETY = 0.1


class ContactMechanics(ExternalSolver):
    """Polonsky and Keer's conjugate gradients of ContactMechanics, on half-space and bonded layer."""

    name = "contact_mechanics"
    label = "ContactMechanics"
    package = "ContactMechanics"
    slots = frozenset({"pressure bound", "response"})
    locates_edges = True
    papers = ("ContactMechanics: https://github.com/ContactEngineering/ContactMechanics.",)


def solve(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float | None,
    tolerance: float,
    offset: float | None = None,
    hardness: float | None = None,
    thickness: float | None = None,
    poisson: float = 0.0,
    max_iterations: int = 20_000,
) -> dict[str, Any]:
    """Return pressures [Pa], iterations and its word; E* = 1 and the longer period 1 go in."""
    import ContactMechanics
    import SurfaceTopography

    warnings.simplefilter("ignore")
    scale = max(lengths)
    sides = (lengths[0] / scale, lengths[1] / scale)
    surface = (heights - heights.mean()) / scale
    # The mean displacement of a half-space is left out; a layer has one.
    solid: dict[str, float] = {"stiffness_q0": 0.0} if mean_pressure is None else {}
    young = 1.0
    if thickness is not None:
        solid = {"thickness": thickness / scale, "poisson": poisson}
        young = 1 - poisson**2
    substrate = ContactMechanics.PeriodicFFTElasticHalfSpace(
        heights.shape, young, sides, fft="numpy", **solid
    )
    topography = SurfaceTopography.Topography(surface, sides, periodic=True)
    # Forces are per point there.
    cell = sides[0] * sides[1] / heights.size
    load: dict[str, float] = {}
    if mean_pressure is None and offset is not None:
        load["offset"] = -(offset - heights.mean()) / scale
    elif mean_pressure is not None:
        load["external_force"] = mean_pressure / contact_modulus * heights.size * cell
    if hardness is not None:
        load["hardness"] = hardness / contact_modulus * cell
    outcome = ContactMechanics.make_system(substrate=substrate, surface=topography).minimize_proxy(
        pentol=_SAFETY * tolerance * (float(np.std(surface)) or 1.0), maxiter=max_iterations, **load
    )
    return {
        "pressure": np.array(outcome.jac) / cell * contact_modulus,
        "iterations": int(outcome.nit),
        "converged": bool(outcome.success),
    }
