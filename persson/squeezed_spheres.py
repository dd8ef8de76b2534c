"""A rough sphere squeezed until its asperities yield, and how it sticks then (Persson 2006, Sec. 10.2)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, instance, non_negative, positive
from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.errors import OutsideTheory
from persson.hardness import constant_hardness
from persson.scale import Scale
from persson.spectrum import Spectrum, check_sample, check_spectrum, sampled_wavevectors
from persson.tabulated import Tabulated, smoothed

#: Wavevectors at which the smoothed spectrum is tabulated.
_NODES = 400


def hertz_pressure(force: ArrayLike, *, radius: float, contact_modulus: float) -> Array:
    r"""Nominal pressure F/A0 [Pa] of a sphere on a flat.

    .. math:: A_0 = \pi \Bigl(\frac{3FR}{4E^*}\Bigr)^{2/3}

    Parameters
    ----------
    force : float or array
        F [N].
    radius, contact_modulus : float
        R [m] and E* [Pa] of both bodies together (Eq. 5).

    Notes
    -----
    Persson 2006, Eq. 54, which writes E* for 4/3 of this E* (docs/errata.md).
    """
    load = non_negative("force", force)
    big = positive("radius", radius)
    stiff = 4 / 3 * positive("contact_modulus", contact_modulus)
    return np.cbrt(load / big / big / stiff) * stiff / math.pi


def yielded_share(force: ArrayLike, *, radius: float, contact_modulus: float, hardness: float) -> Array:
    r"""Share A/A0 of the Hertzian contact that touches if every asperity has yielded: the pressure over H.

    .. math:: \frac{A}{A_0} = \frac{1}{\pi H}\Bigl(\frac{4E^*}{3R}\Bigr)^{2/3} F^{1/3}

    Arguments as for `hertz_pressure`, and H [Pa]. Persson 2006, Eq. 55.

    Raises
    ------
    OutsideTheory
        For a force under which the nominal pressure reaches H.
    """
    limit = positive("hardness", hardness)
    pressure = hertz_pressure(force, radius=radius, contact_modulus=contact_modulus)
    if np.any(pressure > limit):
        raise OutsideTheory(
            f"force = {float(np.max(force))!r} N: the nominal pressure exceeds hardness = {limit!r} Pa"
        )
    return pressure / limit


def yielded_pull_off(
    force: ArrayLike, *, radius: float, contact_modulus: float, hardness: float, work_of_adhesion: float
) -> Array:
    r"""Pull-off force [N] after squeezing with F, if what has yielded sticks and nothing else does.

    .. math:: F_\mathrm{ad} = 2\pi R\,\Delta\gamma\,\frac{A}{A_0}
              = \frac{2\Delta\gamma}{H}\Bigl(R\bigl(\tfrac43 E^*\bigr)^2\Bigr)^{1/3} F^{1/3}

    Arguments as for `yielded_share`, and Delta gamma [J/m^2], which is twice the gamma_sl of two equal
    bodies.

    Notes
    -----
    Persson 2006, Eqs. 53, 55 and 56, after F. Restagno et al., Phys. Rev. E 65, 042301 (2002). The
    elastic energy that the contact gives back is left out; `roughness_barrier` has it.
    """
    share = yielded_share(force, radius=radius, contact_modulus=contact_modulus, hardness=hardness)
    work = positive("work_of_adhesion", work_of_adhesion)
    return 2 * math.pi * radius * work * share


@dataclass(frozen=True, kw_only=True)
class RoughnessBarrier:
    """Adhesion without load before and after a squeeze that flattened the short waves.

    Attributes
    ----------
    before, after : AdhesiveContact
        Of the surface as it was, and of the smoothed one as if it were smoothed everywhere.
    spectrum : Tabulated
        Cbar(q) of the smoothed surface.
    flattened : float
        Share of the nominal area that has yielded: contact is confined to it, since outside the short
        waves stand.
    """

    before: AdhesiveContact
    after: AdhesiveContact
    spectrum: Tabulated
    flattened: float

    @property
    def holds(self) -> bool:
        """Whether the roughness is a barrier: no adhesion before, some after."""
        return self.before.macroscopic_work <= 0 < self.after.macroscopic_work

    @property
    def work(self) -> float:
        """Macroscopic gamma_eff [J/m^2]: that of the smoothed surface, on the flattened share alone."""
        return self.flattened * max(self.after.macroscopic_work, 0.0)


def roughness_barrier(
    spectrum: Spectrum,
    *,
    contact_modulus: float | Callable[[Array], Array],
    pressure: float,
    yield_stress: float,
    interface: Interface,
) -> RoughnessBarrier:
    """Squeeze a rough contact with a nominal pressure until its short waves yield, and let go.

    Parameters
    ----------
    spectrum : Spectrum
        C(q), with q_min > 0.
    contact_modulus : float or callable
        As for `persson.scale.Scale`.
    pressure, yield_stress : float
        sigma_0 and hardness sigma_Y [Pa].
    interface : Interface
        Work of adhesion and the reading of the theory.

    Notes
    -----
    Persson 2006, Sec. 10.2: Cbar(q) = (1 - A_pl(q)/A_pl0) C(q) with A_pl0/A0 = sigma_0/sigma_Y. The paper
    calls what keeps the contact inside the flattened spots the roughness barrier; there
    `RoughnessBarrier.work` is a lower bound, because less is deformed near the tops than where everything
    is smoothed.
    """
    check_spectrum(spectrum)
    instance("interface", interface, Interface)
    load = positive("pressure", pressure)
    limit = positive("yield_stress", yield_stress)
    check_sample(spectrum, "the size L of the sample matters without load")
    scale = Scale(spectrum, contact_modulus=contact_modulus)
    q = sampled_wavevectors(spectrum, _NODES)
    areas = constant_hardness(load, stress_variance=scale.variance(q), yield_stress=limit)
    yielded = np.minimum(areas.plastic * (limit / load), 1.0)
    smooth = smoothed(spectrum, wavevectors=q, yielded=yielded)
    return RoughnessBarrier(
        before=solve_adhesion(scale, pressure=0.0, interface=interface).checked(),
        after=solve_adhesion(
            Scale(smooth, contact_modulus=contact_modulus), pressure=0.0, interface=interface
        ).checked(),
        spectrum=smooth,
        flattened=float(areas.plastic[-1]),
    )
