"""Spheres and asperities: Hertz, JKR, Greenwood and Williamson, Nayak, Fuller and Tabor."""

from __future__ import annotations

import math

import numpy as np

from persson import spheres
from persson.asperities import bush_gibson_thomas, nayak_asperities, ring_asperities
from persson.spectrum import Moments
from validation.arrays import Array
from validation.cases import Checks, below, case, near, relative

_RADIUS, _MODULUS, _WORK = 2e-3, 3e6, 0.05


@case("spheres-adhesive", source="[johnson1971]; [maugis1992]")
def _jkr() -> Checks:
    """An adhesive sphere comes off at 3/2 pi w R if soft, at 2 pi w R if stiff."""

    def load(a: float | Array) -> Array:
        return spheres.jkr_load(a, radius=_RADIUS, contact_modulus=_MODULUS, work_of_adhesion=_WORK)

    # Without load a^3 = 9 pi w R^2 / (2 E*); at pull-off it is a quarter of that.
    free = math.cbrt(4.5 * math.pi * _WORK * _RADIUS**2 / _MODULUS)
    around = free * np.linspace(0.2, 1.0, 4001)
    unit, reach = math.pi * _WORK * _RADIUS, 4e-9
    tabor = spheres.tabor_parameter(_RADIUS, contact_modulus=_MODULUS, work_of_adhesion=_WORK, range_=reach)
    exact = (_RADIUS * _WORK**2 / _MODULUS**2 / reach**3) ** (1 / 3)
    soft = spheres.jkr_pull_off(_RADIUS, work_of_adhesion=_WORK)
    stiff = spheres.derjaguin_pull_off(_RADIUS, work_of_adhesion=_WORK)
    yield below("F at the radius of no load, over pull-off", load(free) / (1.5 * unit), 1e-12)
    yield relative("smallest F [N]", np.min(load(around)), -1.5 * unit, 1e-6)
    yield relative("pull-off force [N]", soft, 1.5 * unit, 1e-12)
    yield relative("pull-off of stiff spheres over pi w R", stiff / unit, 2.0, 1e-12)
    yield relative("Tabor parameter", tabor, exact, 1e-12)
    # Maugis's transition, to the fourth digit of its limits.
    yield relative("pull-off of Maugis at mu = 1e-3", spheres.maugis_pull_off(1e-3), 2.0, 2e-3)
    yield relative("pull-off of Maugis at mu = 50", spheres.maugis_pull_off(50.0), 1.5, 2e-3)


#: Moments of a surface with a Nayak parameter of 12.
_MOMENTS = Moments(m0=4e-12, m2=1e-2, m4=1e-2**2 * 8 / 4e-12)


@case("asperities-summits", source="[nayak1971]; [mccool1987]")
def _summits() -> Checks:
    """Summits of a random surface have Nayak's density, curvature and heights.

    Statistics of summits in the moments of a profile: mu0 = m0, mu2 = m2 / 2, mu4 = 3 m4 / 8.
    """
    mu2, mu4 = _MOMENTS.m2 / 2, 3 * _MOMENTS.m4 / 8
    alpha = _MOMENTS.m0 * mu4 / mu2**2
    asperities = nayak_asperities(_MOMENTS)
    density = mu4 / mu2 / (6 * math.pi * math.sqrt(3))
    mean = 4 * math.sqrt(_MOMENTS.m0 / (math.pi * alpha))
    deviation = math.sqrt(_MOMENTS.m0 * (1 - 0.8968 / alpha))
    # How many summits stand above a plane tells where they are: mean and scatter of their heights.
    d = np.linspace(-8, 8, 401) * math.sqrt(_MOMENTS.m0)
    contact = bush_gibson_thomas(d, moments=_MOMENTS, contact_modulus=1.0)
    share = contact.density / density
    under = (d < 0).astype(float)
    under[d == 0] = 0.5
    first = float(np.trapezoid(share - under, d))
    second = 2 * float(np.trapezoid(d * (share - under), d))
    ring = ring_asperities(1e5, rms_height=1e-6)
    yield relative("Nayak parameter", _MOMENTS.nayak, alpha, 1e-12)
    yield relative("density [1/m^2]", asperities.density, density, 1e-12)
    yield relative("mean curvature [1/m]", 1 / asperities.radius, 8 / 3 * math.sqrt(mu4 / math.pi), 1e-12)
    yield relative("scatter of heights [m]", asperities.rms_height, deviation, 1e-4)
    yield relative("mean height, counted above planes [m]", first, mean, 1e-4)
    scatter = math.sqrt(second - first**2)
    yield relative("scatter of heights, counted above planes [m]", scatter, deviation, 1e-3)
    yield near("n_0 / q^2 of one wavelength", ring.density / 1e10, 0.029, 5e-4)
    yield relative("1/R of one wavelength [1/m]", 1 / ring.radius, math.sqrt(2) * 1e10 * 1e-6, 1e-12)
    yield relative("h* of one wavelength [m]", ring.rms_height, 0.6e-6, 1e-12)
