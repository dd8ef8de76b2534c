"""One patch with free surroundings: a ball without images, and a flat square punch."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem
from fem_contact.area import subcell_area
from fem_contact.conductance import frozen_contact
from fem_contact.response import FreeHalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import Patch
from validation.cases import Checks, below, case, order
from validation.cases._closed_forms import HertzInPeriod

_FREE = FreeHalfSpace(solid=Solid(young=1.0, poisson=0.3))
#: Side of the patch over the contact radius: little more than the contact itself.
_SIDE = 2.5

#: Capacitance of a square plate over 4 pi eps times its side.
_SQUARE = 0.3667892


@case("free-hertz", source="[hertz1882]; [johnson_book], Sec. 4.2", tolerance="grid")
def _hertz() -> Checks:
    """A ball on a patch hardly larger than its contact is Hertz's within .1 %: it has no images.

    Press a ball of radius 1 to a contact of radius .1; no grid point is its apex.
    """
    a, side = 0.1, _SIDE * 0.1
    hertz = HertzInPeriod(radius=a, contact_modulus=_FREE.contact_modulus)
    sizes, approaches, pressures, radii = (32, 64, 128, 256), [], [], []
    for n in sizes:
        x = (np.arange(n) + 0.25) * side / n - side / 2
        r = np.hypot(x[:, None], x[None, :])
        surface = Patch(heights=-(r**2) / 2, lengths=(side, side))
        result = bem.solve(surface, _FREE, mean_pressure=hertz.load / side**2, tolerance=1e-9).checked()
        approaches.append(abs(-result.offset / a**2 - 1))
        off = np.abs(result.pressure - hertz.pressure(r)) / hertz.peak
        pressures.append(float(np.max(off[r < 0.8 * a])))
        area = subcell_area(result) * side**2
        radii.append(abs(math.sqrt(area / math.pi) / a - 1))
    yield below(f"error of the approach a^2/R at n = {sizes[-1]}", approaches[-1], 1e-3)
    yield below(f"largest error of p(r) over the peak inside .8 a, n = {sizes[-1]}", pressures[-1], 1e-3)
    yield below(f"error of the contact radius, located, at n = {sizes[-1]}", radii[-1], 1e-5)
    yield order("observed order of the approach", sizes, approaches, expected=2, tolerance=0.7)
    yield order("observed order of p(r)", sizes, pressures, expected=2, tolerance=0.7)


@case("free-punch", source="[read1997]: C = .3667892 x 4 pi eps L", tolerance="grid")
def _punch() -> Checks:
    """A flat square patch has the stiffness of a punch, that is the capacitance of a square plate.

    Pressures at the edges of a punch are infinite: first order.
    """
    sizes, errors, exact = (16, 32, 64), [], math.pi * _SQUARE * _FREE.contact_modulus
    for n in sizes:
        flat = Patch(heights=np.zeros((n, n)), lengths=(1.0, 1.0))
        result = bem.solve(flat, _FREE, mean_pressure=0.01).checked()
        errors.append(1 - frozen_contact(result, _FREE).stiffness / exact)
    limit = 2 * errors[-1] - errors[-2]
    yield order("observed order of the stiffness", sizes, errors, expected=1, tolerance=0.2)
    yield below("error of its limit over the grids", abs(limit), 2e-3)
