"""What passes through contact and gap: spots, channels and grooves, patchworks, percolation."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem
from fem_contact.conductance import contact_conductance, frozen_contact
from fem_contact.leak import flow_conductance
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.solid import Solid
from validation.arrays import Array
from validation.cases import Checks, below, case, order, relative
from validation.cases._closed_forms import LATTICE_CUBE, LATTICE_MADELUNG, periodic, places

_SOLID = Solid(young=1.0, poisson=0.2)
_HALF_SPACE = HalfSpace(solid=_SOLID)


def _spot(n: int, radius: float) -> float:
    """Resistance of a circular spot in a period of 1 over Holm's with the field of its neighbours."""
    x = places(n, 0.37)
    inside = np.hypot(x[:, None], x[None, :] - 0.24 / n) < radius
    result = bem.solve(periodic(np.where(inside, 0.0, -1.0)), _HALF_SPACE, mean_pressure=1e-3).checked()
    modulus = _SOLID.contact_modulus
    stiffness = frozen_contact(result, _HALF_SPACE).stiffness
    conductance = contact_conductance(stiffness, contact_modulus=modulus, resistivities=(3.0, 1.0))
    width = math.sqrt(result.in_contact.mean() / math.pi)
    # The other spots and the background lift this one: near it M + r^2/4 sum 1/R^3, and the mean of
    # |r - r'|^2 over two points of a flat punch is 4 a^2 / 3.
    holm = (3.0 + 1.0) / (4 * width)
    neighbours = (3.0 + 1.0) / (2 * math.pi) * (LATTICE_MADELUNG + LATTICE_CUBE / 3 * width**2)
    return 1 / conductance / (holm + neighbours)


@case("flow-spot", source="R. Holm (1967); [barber2003]", tolerance="grid")
def _spots() -> Checks:
    """The contact resistance of a circular spot is Holm's, with the field of its neighbours."""
    coarse, fine = _spot(96, 0.1), _spot(192, 0.1)
    layer = BondedLayer(solid=_SOLID, thickness=0.3)
    flat = periodic(np.zeros((8, 6)))
    pressed = frozen_contact(bem.solve(flat, layer, mean_pressure=1e-3).checked(), layer)
    # A clamped layer under uniform pressure is compressed alone: (1 - nu) E / (1 + nu) / (1 - 2 nu) / d.
    oedometric = (1 - 0.2) / (1 + 0.2) / (1 - 2 * 0.2) / 0.3
    # The edge of the set is off by a part of a cell, the resistance by a part of it in first order.
    words = "resistance over Holm's in a lattice, two grids in first order"
    yield relative(words, 2 * fine - coarse, 1.0, 5e-3)
    yield below("its error on the finer grid", abs(fine - 1), 0.02)
    yield relative("stiffness of a bonded layer in full contact [1/m]", pressed.stiffness, oedometric, 1e-9)


def _grooved(n: int, phase: Array) -> Array:
    return 1 + 0.6 * np.cos(phase) + np.zeros((n, n))


@case(
    "flow-channel",
    source="O. Reynolds (1886); oblique grooves: the mean of both conductances",
    tolerance="grid",
)
def _channels() -> Checks:
    """The conductance of a gap is that of its channels and grooves."""
    gap = np.zeros((9, 7))
    gap[:, 2:5] = 0.2
    channel = flow_conductance(gap, (3.0, 1.4), axis="x").conductance
    closed = flow_conductance(gap, (3.0, 1.4), axis="y").conductance
    along, across = 1 + 1.5 * 0.36, (1 - 0.36) ** 2.5 / (1 + 0.36 / 2)
    phase = {n: 2 * np.pi * (np.arange(n) + 0.5) / n for n in (16, 32, 64)}
    grooves = _grooved(64, phase[64][:, None])
    parallel, crossing = (
        12 * flow_conductance(grooves, (1.0, 2.5), axis=axis).conductance for axis in ("y", "x")
    )
    exact = (along + across) / 2
    errors = [
        abs(12 * flow_conductance(_grooved(n, a[:, None] + a[None, :]), (1.0, 1.0)).conductance - exact)
        for n, a in phase.items()
    ]
    words = "K of a channel of width w on 3/7 of the period [m^3]"
    yield relative(words, channel, 3 / 7 * 0.2**3 / 12, 1e-12)
    yield below("K across it", closed, 0.0)
    yield relative("12 K along grooves 1 + .6 cos", parallel, along, 1e-12)
    # The mean of an analytic function over a period converges faster than any power.
    yield relative("12 K across them", crossing, across, 1e-8)
    yield order("order along oblique ones", list(phase), errors, expected=2, tolerance=0.2)
