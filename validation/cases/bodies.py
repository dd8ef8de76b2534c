"""Solids that change with depth: layers, and a modulus that relaxes."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.response import BondedLayer, FrictionlessLayer, Response
from fem_contact.solid import Solid
from validation.cases import Checks, below, case, order, relative
from validation.cases._closed_forms import periodic


def _felt(response: Response, q: float) -> float:
    """Return C(q) [m/Pa] along x."""
    return float(response.compliance(np.array([[q]]), np.zeros((1, 1)))[0, 0])


@case("bodies-layers", source="K. L. Johnson, Contact Mechanics, Sec. 5.8")
def _layers() -> Checks:
    """A wave is pressed flat on a bonded and on a frictionless layer by its height over their compliance."""
    surface = periodic(0.01 * np.cos(2 * np.pi * np.arange(48) / 48)[:, None] * np.ones(4))
    for poisson in (0.3, 0.5):
        solid = Solid(young=1.0, poisson=poisson)
        a, k = 2 * math.pi * 0.1, 3 - 4 * poisson
        bonded = (k * math.sinh(2 * a) - 2 * a) / (k * math.cosh(2 * a) + 2 * a**2 + (k**2 + 1) / 2)
        sliding = (math.cosh(2 * a) - 1) / (math.sinh(2 * a) + 2 * a)
        for kind, layer, ratio in (
            ("bonded", BondedLayer(solid=solid, thickness=0.1), bonded),
            ("frictionless", FrictionlessLayer(solid=solid, thickness=0.1), sliding),
        ):
            amplitude = np.ptp(bem.solve(surface, layer, mean_pressure=10.0).checked().pressure) / 2
            exact = 0.01 * math.pi * solid.contact_modulus / ratio
            yield relative(f"pressure amplitude, {kind}, nu = {poisson}", amplitude, exact, 1e-10)


@case("bodies-graded", source="exact layer matrices", tolerance="grid")
def _depth() -> Checks:
    """A modulus that relaxes with depth is that of many thin layers, to second order.

    Set 400 thin layers beside an exponential profile, which sums 64 that follow the wave.
    """
    surface = Solid(young=1.0, poisson=0.3)
    edges = np.linspace(0, 12, 401)
    middle = (edges[1:] + edges[:-1]) / 2
    layered = LayeredSolid(
        layers=[Solid(young=5 - 4 * math.exp(-z), poisson=0.3) for z in middle.tolist()],
        thicknesses=np.diff(edges).tolist(),
        base=Solid(young=5.0, poisson=0.3),
    )
    errors = []
    counts = (8, 16, 32, 64)
    for count in counts:
        graded = ExponentialSolid(surface=surface, bulk_young=5.0, depth=1.0, sublayers=count)
        errors.append(max(abs(_felt(graded, q) / _felt(layered, q) - 1) for q in (0.5, 2.0)))
    yield below("error of the usual sublayers at q d = .5 and 2", errors[-1], 3e-4)
    # The last is off by the thin layers that it is held against, too.
    yield order("its observed order", counts[:3], errors[:3], expected=2.0, tolerance=0.3)
    for q, young in ((1e4, 1.0), (1e-5, 5.0)):
        exact = 2 * 0.91 / (young * q)
        yield relative(f"C of a {'short' if q > 1 else 'long'} wave [m/Pa]", _felt(graded, q), exact, 1e-3)
