"""Contact area with a corrected elastic energy: variants of the theory, beside the original.

Under partial contact less energy is stored than full contact of the same area would store. The variants let
the stress variance grow by dV = S(P) dV_full, with P the relative contact area: S = 1 is the theory of 2001.
"""

import functools
import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from scipy.special import erf, erfc, erfinv

from persson._checks import Array, alike, choice, non_negative, real, shown, within
from persson._quadrature import gauss
from persson.elastic import KAPPA_PERSSON, contact_area
from persson.errors import InvalidInput

Variant = Literal["persson", "yang_persson", "wang_mueser", "xu"]

#: What is said of the elastic energy of a partial contact without adhesion.
EnergyReading = Literal["old", "improved", "as_printed", "yang_persson", "wang_mueser", "xu", "xu_hybrid"]

#: Share of the full energy that is stored at vanishing contact, gamma of Yang and Persson (2008).
ENERGY_RATIO = 0.45
#: The same of Xu et al. (2024), as in the code they published.
XU_RATIO = 0.42

_NODES = np.geomspace(1e-3, 1e26, 1400)
_POINTS, _WEIGHTS = gauss(8)


def energy_factor(area: ArrayLike, *, variant: Variant, energy_ratio: float = ENERGY_RATIO) -> Array:
    """S(P) = dV / dV_full at relative contact area P.

    Parameters
    ----------
    area : float or array
        P = A/A0 in [0, 1].
    variant : {"persson", "yang_persson", "wang_mueser"}
        1; g + (1 - g) P^2 (Yang and Persson, J. Phys. Condens. Matter 20, 215214, 2008); 5/9 - 2/9 P^2 + 6/9
        P^4 (Wang and Mueser, Tribol. Lett. 65, 2017, "Gauging Persson theory on adhesion").
    energy_ratio : float
        g of Yang and Persson.

    Notes
    -----
    The polynomial of Wang and Mueser was taken from the code that Xu et al. (2024) published
    (github.com/xylcsi/PerssonModelFudgeFactor), which names that paper; the paper itself was not at hand.
    """
    choice("variant", variant, get_args(Variant)[:-1])
    within("energy_ratio", energy_ratio, "(0, 1]")
    p2 = np.square(real("area", area))
    if np.any(p2 > 1) or np.any(np.asarray(area) < 0):
        raise InvalidInput(f"area = {shown(area)}: must lie in [0, 1]")
    if variant == "persson":
        return np.ones_like(p2)
    if variant == "yang_persson":
        return np.asarray(energy_ratio + (1 - energy_ratio) * p2)
    return np.asarray((5 - 2 * p2 + 6 * p2 * p2) / 9)


def energy_share(pressure: ArrayLike, *, stress_variance: ArrayLike, energy: EnergyReading = "old") -> Array:
    r"""P~, the elastic energy that a wave stores over that in full contact, without adhesion.

    .. math:: U_\mathrm{el} = A_0 \int \tilde P\, \frac{dV}{E^* q}, \qquad
              P = \operatorname{erf} s, \quad s = \frac{\sigma_0}{\sqrt{2V}}

    Parameters
    ----------
    pressure : float or array
        Nominal pressure sigma_0 [Pa].
    stress_variance : float or array
        V [Pa^2] of full contact with the waves up to this one.
    energy : str
        "old": P, Eq. 43 of Persson 2006. "improved": Eq. 48 over 49, P + 2 s exp(-s^2)/sqrt(pi) - 4 s^2
        erfc(s). "as_printed": Eq. 50, the mean of P over the waves so far. "yang_persson": P [g + (1 - g)
        P^2], g = .45. "wang_mueser": P (5 - 2 P^2 + 6 P^4)/9 with the area of that variant. "xu": P dV_p/dV
        with V_p = [g + (1 - g) P] V, g = .42. "xu_hybrid": the area of "xu" with P (g - 2/9 P^2 +
        (11/9 - g) P^4).

    Notes
    -----
    The last two are those of the code that Xu et al. (2024) published with their variant (see
    `corrected_contact_area`). At full contact all are 1; at vanishing load they are 1, 2, 2, .45, 5/9, .42
    and .42 times the area of their variant.

    Examples
    --------
    >>> light = {"pressure": 0.01, "stress_variance": 1.0}
    >>> [round(float(energy_share(**light, energy=name)), 4) for name in ("old", "improved")]
    [0.008, 0.0158]
    """
    choice("energy", energy, get_args(EnergyReading))
    load = non_negative("pressure", pressure)
    full = non_negative("stress_variance", stress_variance, power=2)
    variant: Variant = "wang_mueser" if energy == "wang_mueser" else "persson"
    variant = "xu" if energy in ("xu", "xu_hybrid") else variant
    area = np.asarray(corrected_contact_area(load, stress_variance=full, variant=variant))
    square = area * area
    if energy == "old":
        return area
    if energy in ("yang_persson", "wang_mueser"):
        return area * energy_factor(area, variant=energy)
    if energy == "xu_hybrid":
        return area * (XU_RATIO - 2 / 9 * square + (11 / 9 - XU_RATIO) * square * square)
    if energy == "xu":
        bell = _bell(erfinv(np.minimum(area, 1 - 1e-16)))
        factor = XU_RATIO + (1 - XU_RATIO) * area
        # From V_p = factor V: contact is lost as V grows, and V_p grows by less than factor dV.
        return area * factor / (1 + (1 - XU_RATIO) * bell / (2 * factor))
    root = np.sqrt(2 * full)
    # Beyond 27 nothing of the terms is left, and the area is 1.
    closed = np.where(np.broadcast_to(load, np.shape(area)) > 0, 27.0, 0.0)
    s = np.minimum(np.divide(load, root, out=closed, where=root > 0), 27.0)
    outside = 2 * s * s * erfc(s)
    return np.asarray(area + _bell(s) - (2 if energy == "improved" else 1) * outside)[()]


def _bell(s: Array) -> Array:
    return 2 / math.sqrt(math.pi) * s * np.exp(-s * s)


def light_load_kappa(variant: Variant) -> float:
    """Limit of (A/A0)/p* at vanishing load: sqrt(8/pi) / sqrt(S(0)).

    Examples
    --------
    >>> round(light_load_kappa("wang_mueser"), 3), round(light_load_kappa("yang_persson"), 3)
    (2.141, 2.379)
    """
    choice("variant", variant, get_args(Variant))
    zero = XU_RATIO if variant == "xu" else float(energy_factor(0.0, variant=variant))
    return KAPPA_PERSSON / math.sqrt(zero)


def corrected_contact_area(pressure: ArrayLike, *, stress_variance: ArrayLike, variant: Variant) -> Array:
    r"""Relative contact area of an elastic solid in a variant of the theory.

    .. math:: \frac{dV}{dV_\mathrm{full}} = S(P), \qquad P = \operatorname{erf}\frac{\sigma_0}{\sqrt{2V}}

    Parameters
    ----------
    pressure : float or array
        sigma_0 [Pa].
    stress_variance : float or array
        V_full [Pa^2], the variance at full contact.
    variant : {"persson", "yang_persson", "wang_mueser", "xu"}
        As for `energy_factor`; "xu" is V = [g + (1 - g) P] V_full, which needs no integration (Xu, Zhu,
        Xiao and Zhou, Tribol. Lett. 2024, doi 10.1007/s11249-024-01838-4), with g = .42 as in the code they
        published. That code takes .42 for the variant of Yang and Persson, too; here it is .45.

    Notes
    -----
    In y = V/sigma_0^2 the equation is autonomous: V_full/sigma_0^2 = int dy / S, which is inverted.

    Examples
    --------
    >>> p = corrected_contact_area(0.02, stress_variance=0.25, variant="wang_mueser")
    >>> round(float(p) / 0.02, 2)
    2.14
    """
    load = non_negative("pressure", pressure)
    full = non_negative("stress_variance", stress_variance, power=2)
    choice("variant", variant, get_args(Variant))
    if variant == "persson":
        return contact_area(load, stress_variance=full)
    alike(pressure=load, stress_variance=full)
    load, full = np.broadcast_arrays(load, full)
    loaded = (load > 0) & (full > 0)
    root = np.sqrt(full)
    x = np.where(loaded, np.where(loaded, root, 1.0) / np.where(loaded, load, 1.0), 1.0)
    # Beyond it the square could not be represented, and the area is proportional to the load.
    limited = np.minimum(x, 1e100)
    y = _xu(limited**2) if variant == "xu" else _grown(limited**2, variant)
    area = erf(1 / np.sqrt(2 * y)) * (limited / x)
    return np.where(loaded, area, np.where(load > 0, 1.0, 0.0))[()]


def _rate(y: Array, variant: Variant) -> Array:
    return 1 / energy_factor(erf(1 / np.sqrt(2 * y)), variant=variant)


@functools.cache
def _table(variant: Variant) -> tuple[Array, PchipInterpolator]:
    """Return x = int_0^y dy' / S(erf(1/sqrt(2 y'))) at the nodes, and ln y over ln x; below 1e-3 S is 1."""
    low, high = _NODES[:-1, None], _NODES[1:, None]
    parts = (_rate(low + (high - low) * _POINTS, variant) @ _WEIGHTS) * np.diff(_NODES)
    table = np.concatenate([_NODES[:1], _NODES[0] + np.cumsum(parts)])
    return table, PchipInterpolator(np.log(table), np.log(_NODES))


def _grown(x: Array, variant: Variant) -> Array:
    """Invert x = int_0^y dy' / S(erf(1/sqrt(2 y')))."""
    table, start_of = _table(variant)
    inside = np.clip(x, table[0], table[-1])
    y = np.exp(start_of(np.log(inside)))
    index = np.clip(np.searchsorted(_NODES, y, side="right") - 1, 0, _NODES.size - 2)
    for _ in range(2):
        start = _NODES[index]
        part = start[..., None] + (y - start)[..., None] * _POINTS
        value = table[index] + (_rate(part, variant) @ _WEIGHTS) * (y - start)
        y = y + (inside - value) / _rate(y, variant)
    return np.where(x < table[0], x, np.where(x > table[-1], x * (y / inside), y))


def _xu(x: Array) -> Array:
    """Solve y = [g + (1 - g) erf(1/sqrt(2y))] x by Newton's method in ln y, where the slope is 1 to 1.2."""
    log = np.log(x) + np.log(XU_RATIO + (1 - XU_RATIO) * erf(1 / np.sqrt(2 * x)))
    for _ in range(6):
        s = np.exp(-log / 2) / math.sqrt(2)
        factor = XU_RATIO + (1 - XU_RATIO) * erf(s)
        log = log - (log - np.log(factor * x)) / (1 + (1 - XU_RATIO) * _bell(s) / (2 * factor))
    return np.asarray(np.exp(log))
