"""Shear stress of sliding contacts, local and nominal (Persson 2006, Sec. 10.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, non_negative, positive
from persson.errors import InvalidInput

__all__ = ["adhesional_pressure", "local_shear_stress", "nominal_shear_stress", "slip_energy"]


def nominal_shear_stress(area: ArrayLike, *, local_shear_stress: float) -> Array:
    """Nominal shear stress tau = tau_f A/A0 [Pa]: tau_f holds in the real contact, whatever its pressure.

    Persson 2006, Sec. 10.1; `area` is A/A0 in [0, 1], `local_shear_stress` tau_f [Pa].

    Examples
    --------
    >>> float(nominal_shear_stress(0.25, local_shear_stress=50e6))
    12500000.0
    """
    share = non_negative("area", area)
    if np.any(share > 1):
        raise InvalidInput(f"area = {float(np.max(share))!r}: must lie in [0, 1]")
    return share * positive("local_shear_stress", local_shear_stress, unit="Pa")


def local_shear_stress(nominal: ArrayLike, *, pressure: float, hardness: float) -> Array:
    """Local shear stress tau_f = tau H / sigma_0 [Pa] of a contact that has yielded, A/A0 = sigma_0/H.

    Persson 2006, Sec. 10.1; `nominal` is tau [Pa], `pressure` sigma_0 [Pa], `hardness` H [Pa].

    Examples
    --------
    >>> float(local_shear_stress(5e6, pressure=30e6, hardness=300e6))
    50000000.0
    """
    load, limit = positive("pressure", pressure, unit="Pa"), positive("hardness", hardness, unit="Pa")
    if load > limit:
        raise InvalidInput(f"pressure = {load!r} Pa: must not exceed hardness = {limit!r} Pa")
    return non_negative("nominal", nominal, unit="Pa") * (limit / load)


def slip_energy(shear_stress: ArrayLike, *, slip: float) -> Array:
    """Barrier of a local slip per area, delta epsilon / a^2 = tau_f b [J/m^2], if all of it is lost.

    Persson 2006, Sec. 10.1, footnote; `shear_stress` is tau_f [Pa], `slip` b [m], about a lattice constant.

    Examples
    --------
    >>> round(float(slip_energy(50e6, slip=3e-10)), 6)
    0.015
    """
    return non_negative("shear_stress", shear_stress, unit="Pa") * positive("slip", slip, unit="m")


def adhesional_pressure(barrier: ArrayLike, *, lift: float) -> Array:
    """Pressure p_ad = delta epsilon / (a^2 delta h) [Pa], below which pressure hardly matters to shear.

    Persson 2006, Sec. 10.1; `barrier` is delta epsilon / a^2 [J/m^2], `lift` delta h [m], by which the
    surfaces part locally when they slip.

    Examples
    --------
    >>> round(float(adhesional_pressure(0.016, lift=1e-12)) / 1e9)
    16
    """
    return non_negative("barrier", barrier, unit="J/m^2") / positive("lift", lift, unit="m")
