"""What an interface can hold: work of adhesion, detachment stress, and what viscoelasticity makes of it.

Persson 2006, Secs. 8.1, 8.4 and 8.6.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, alike, choice, instance, non_negative, positive, positive_fields, real


@dataclass(frozen=True, kw_only=True)
class Interface:
    """What the adhesion of two surfaces is made of, and which reading of the theory is used.

    Parameters
    ----------
    work_of_adhesion : float
        Delta gamma [J/m^2] of flat surfaces.
    energy : {"improved", "old", "as_printed"}
        Elastic energy at partial contact: Persson 2006, Eqs. 44-49 ("improved"), Eq. 43 ("old"), or Eq. 50
        as it is printed, which differs from Eq. 48 under load ("as_printed").
    area : {"star", "projected"}
        Whether the contact areas of Eq. 37 carry the slope factor of `persson.spectrum.area_factor` ("star").
    alpha : float
        Number of order 1 in Eq. 36; the paper uses 9/8.
    ideal_strength : float, optional
        sigma* = Delta gamma / a [Pa], which bounds the detachment stress at atomic scales (Sec. 8.4).
    """

    work_of_adhesion: float
    energy: Literal["improved", "old", "as_printed"] = "improved"
    area: Literal["star", "projected"] = "star"
    alpha: float = 1.125
    ideal_strength: float | None = None

    def __post_init__(self) -> None:
        positive_fields(self, "work_of_adhesion", "alpha")
        if self.ideal_strength is not None:
            positive("ideal_strength", self.ideal_strength)
        choice("energy", self.energy, ("improved", "old", "as_printed"))
        choice("area", self.area, ("star", "projected"))


def detachment_stress(
    work: ArrayLike, *, contact_modulus: ArrayLike, wavevector: ArrayLike, interface: Interface
) -> Array:
    r"""Largest tensile stress sigma_a an interface can carry at one magnification.

    .. math:: \sigma_a^0 = \sqrt{\alpha\gamma_\mathrm{eff} E^* q}, \qquad
              \sigma_a = \frac{\sigma^*\sigma_a^0}{\sigma^* + \sigma_a^0}

    Parameters
    ----------
    work : float or array
        gamma_eff [J/m^2]; where it is negative the surfaces do not adhere and sigma_a is 0.
    contact_modulus, wavevector : float or array
        E* [Pa] and q [1/m].
    interface : Interface
        Gives alpha and sigma*; without `ideal_strength`, sigma_a is the first expression.

    Notes
    -----
    Persson 2006, Eq. 36 and Sec. 8.4.
    """
    energy = np.maximum(real("work", work), 0.0)
    instance("interface", interface, Interface)
    modulus = non_negative("contact_modulus", contact_modulus)
    q = non_negative("wavevector", wavevector)
    alike(work=energy, contact_modulus=modulus, wavevector=q)
    bare = np.sqrt(interface.alpha * energy * modulus * q)
    strength = interface.ideal_strength
    return bare if strength is None else bare / (1 + bare / strength)


def crossover_length(work_of_adhesion: float, *, contact_modulus: float, atomic_distance: float) -> float:
    """Length l_c = a^2 E* / Delta gamma [m] below which the ideal strength bounds the stress.

    Persson 2006, Sec. 8.4, which writes E where Eq. 36 has E/(1 - nu^2): here it is E* as in Eq. 36, a factor
    1.1 for nu = .3. The number of order 1 in Eq. 36 is left out, as in the paper.

    Examples
    --------
    >>> round(crossover_length(0.05, contact_modulus=1e11, atomic_distance=7e-10) * 1e6, 2)
    0.98
    """
    a = positive("atomic_distance", atomic_distance)
    energy = positive("work_of_adhesion", work_of_adhesion)
    return a * a * positive("contact_modulus", contact_modulus) / energy


def opening_work(work_of_adhesion: float, *, dissipation: ArrayLike) -> Array:
    """Work ``Delta gamma [1 + f(v)]`` [J/m^2] an opening crack takes, viscoelastic solid (Sec. 8.6)."""
    f = non_negative("dissipation", dissipation)
    return positive("work_of_adhesion", work_of_adhesion) * (1 + f)


def closing_work(work_of_adhesion: float, *, dissipation: ArrayLike) -> Array:
    """Work ``Delta gamma / [1 + f(v)]`` [J/m^2] a closing crack gains, viscoelastic solid (Sec. 8.6)."""
    f = non_negative("dissipation", dissipation)
    return positive("work_of_adhesion", work_of_adhesion) / (1 + f)
