"""Contact that can carry one tensile stress at every magnification: the load that adhesion adds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, alike, non_negative, positive, real
from persson.elastic import contact_area, non_contact_area
from persson.errors import OutsideTheory


@dataclass(frozen=True, kw_only=True)
class AdhesionLoad:
    """Area and force of a contact with one tensile limit.

    Attributes
    ----------
    area : array
        A(zeta)/A0.
    contact_force : array
        F(zeta)/A0 [Pa], the force in the area of contact.
    """

    area: Array
    contact_force: Array


def adhesion_load(pressure: ArrayLike, *, stress_variance: ArrayLike, tensile_limit: float) -> AdhesionLoad:
    r"""Area of contact, and the force in it, where sigma_a does not depend on magnification.

    .. math:: \frac{A}{A_0} = \operatorname{erf}\frac{\sigma_0 + \sigma_a}{\sqrt{2V}}, \qquad
              \frac{F}{A_0} = \sigma_0 + \sigma_a\Bigl(1 - \frac{A}{A_0}\Bigr)

    Parameters
    ----------
    pressure : float or array
        sigma_0 [Pa], negative for tension.
    stress_variance : float or array
        V [Pa^2].
    tensile_limit : float
        sigma_a [Pa], positive.

    Raises
    ------
    OutsideTheory
        For a tension that is not below sigma_a.

    Notes
    -----
    Persson 2006, Eqs. 40-42: for A much smaller than A0 the force is the load plus the adhesion load,
    sigma_0 + sigma_a. The area is that of a load sigma_0 + sigma_a without adhesion (Eq. 20), because
    only the distance of the wall counts. F exceeds the load by what attracts outside the contact. With a
    detachment stress that grows with magnification, `persson.adhesion.solve_adhesion` gives F(zeta).

    Examples
    --------
    >>> light = adhesion_load(1e5, stress_variance=1e18, tensile_limit=2e6)
    >>> round(float(light.contact_force) / 1e5, 1)
    21.0
    """
    limit = positive("tensile_limit", tensile_limit)
    load = real("pressure", pressure)
    variance = non_negative("stress_variance", stress_variance, power=2)
    alike(pressure=load, stress_variance=variance)
    if np.any(load + limit <= 0):
        raise OutsideTheory(
            f"pressure = {float(np.min(load))!r} Pa: the tension must stay below tensile_limit = {limit!r} Pa"
        )
    held = load + limit
    return AdhesionLoad(
        area=contact_area(held, stress_variance=variance),
        contact_force=load + limit * non_contact_area(held, stress_variance=variance),
    )
