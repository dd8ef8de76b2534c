"""Ground surfaces: a stretched spectrum, surfaces on nested grids, and what the theory is told of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fem_contact import bem
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import measured_lay, random_surface
from persson.elastic import stress_variance
from persson.spectrum import SelfAffine
from persson.stretched import Stretched
from validation.cases import Check, below, case, relative

_STRAIGHT = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2 * np.pi * 8, q_short=2 * np.pi * 64)
_HALF_SPACE = HalfSpace(solid=Solid(young=1.0, poisson=0.3))


@case(
    "stretched-moments",
    "The average over directions of a stretched spectrum has its closed moments.",
    source="Integrals of (cos^2/gamma^2 + sin^2)^k over the directions",
)
def _moments() -> Iterator[Check]:
    for factor in (2.0, 5.0, 20.0):
        lay, inverse = Stretched(spectrum=_STRAIGHT, factor=factor), factor**-2
        for name, ratio, exact in (
            ("m0", float(lay.m0() / _STRAIGHT.m0()), 1.0),
            ("m2", float(lay.m2() / _STRAIGHT.m2()), (1 + inverse) / 2),
            ("m4", float(lay.m4() / _STRAIGHT.m4()), (3 + 2 * inverse + 3 * inverse**2) / 8),
        ):
            yield relative(f"{name} over the isotropic, gamma = {factor:g}", ratio, exact, 1e-9)


@case(
    "stretched-surfaces",
    "Surfaces with a lay are the same on nested grids and have the slopes of their spectrum; full "
    "contact knows their mean square slope alone.",
    source="B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001): V = (E*/2)^2 <|grad h|^2>",
    tolerance="estimate",
)
def _surfaces() -> Iterator[Check]:
    factor, n = 4.0, 192
    lay = Stretched(spectrum=_STRAIGHT, factor=factor)
    made = {
        points: random_surface(
            lay.directional,
            q_short=lay.q_short,
            lengths=(1.0, 1.0),
            shape=(points, points),
            seed=11,
            isotropic=False,
        )
        for points in (n, 2 * n)
    }
    coarse, fine = made[n], made[2 * n]
    found = measured_lay(coarse)
    # Full contact: the waves of pressure are E* q/2 times those of the heights, in whatever direction.
    pressed = bem.solve(coarse, _HALF_SPACE, mean_pressure=1.0).checked()
    variance = float(stress_variance(coarse.rms_gradient**2, contact_modulus=_HALF_SPACE.contact_modulus))
    yield below(
        "difference of nested grids over h_rms",
        float(np.max(np.abs(fine.heights[::2, ::2] - coarse.heights))) / coarse.rms_height,
        1e-12,
    )
    # Two waves fit along the lay for each of eight across: sums stand for integrals within some percent.
    yield relative("slope across over slope along", found.ratio, factor, 0.05)
    yield relative("h'_rms over that of C(qx, qy)", coarse.rms_gradient, np.sqrt(lay.m2()), 0.05)
    yield below("angle of the lay", abs(found.direction), 1e-12)
    yield relative("variance of p in full contact [Pa^2]", np.var(pressed.pressure), variance, 1e-9)
