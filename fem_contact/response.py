"""Elastic responses of periodic solids: displacement from pressure, one compliance per wavevector."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from fem_contact._checks import alike, array, function, instance, positive
from fem_contact._types import Array
from fem_contact.errors import UnsupportedEffect
from fem_contact.solid import Solid


@runtime_checkable
class Response(Protocol):
    """An elastic solid as its surface sees it: u-hat(q) = C(q) p-hat(q)."""

    @property
    def contact_modulus(self) -> float:
        """E* [Pa] that sets the scale of stresses."""

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Surface displacement over pressure [m/Pa] at wavevectors (qx, qy) [1/m], broadcast together.

        At q = 0 it is the mean displacement per mean pressure, 0 where that is left out (half-space).
        """


@dataclass(frozen=True, kw_only=True)
class _Homogeneous:
    solid: Solid

    def __post_init__(self) -> None:
        instance("solid", self.solid, Solid)

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.solid.contact_modulus


@dataclass(frozen=True, kw_only=True)
class _Layer(_Homogeneous):
    thickness: float

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("thickness", self.thickness)

    def _with_mean(self, q: Array, ratio: Array) -> Array:
        """2 ratio / (E* q), with the confined compression at q = 0."""
        nu = self.solid.poisson
        mean = self.thickness * (1 + nu) * (1 - 2 * nu) / (self.solid.young * (1 - nu))
        return np.where(q > 0, 2 * ratio / (self.contact_modulus * np.where(q > 0, q, 1.0)), mean)


@dataclass(frozen=True, kw_only=True)
class HalfSpace(_Homogeneous):
    """The homogeneous elastic half-space, C(q) = 2 / (E* |q|), with the infinite q = 0 response left out.

    Examples
    --------
    >>> soft = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    >>> soft.compliance(np.array([0.0, 3.0]), np.array([0.0, 4.0]))
    array([0. , 0.4])
    """

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return 2 / (E* |q|) [m/Pa], 0 at q = 0."""
        q = wave_size(qx, qy)
        with np.errstate(divide="ignore", over="ignore"):
            return np.where(q > 0, 2 / (self.contact_modulus * q), 0.0)


@dataclass(frozen=True, kw_only=True)
class FreeHalfSpace(_Homogeneous):
    """The homogeneous elastic half-space that one patch is pressed on, without images: nothing is periodic.

    Outside the patch the surface is free. `bem.solve` and `bem.solve_path` take it: lengths of the surface
    are then the sides of the patch, the mean pressure is the force over its area, displacements are relative
    to points far away, and -offset is the approach of the level from which heights are counted.

    Parameters
    ----------
    solid : Solid
    """

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Refuse: a patch has no waves of its own.

        Raises
        ------
        UnsupportedEffect
            Always, so that nothing periodic takes it for a periodic solid.
        """
        raise UnsupportedEffect(
            "response = FreeHalfSpace: is not periodic and has no compliance per wavevector; it is pressed "
            "by bem.solve and bem.solve_path"
        )


@dataclass(frozen=True, kw_only=True)
class BondedLayer(_Layer):
    r"""An elastic layer of finite thickness whose bottom is held fast.

    .. math:: C(q) = \frac{2}{E^* q}\,
              \frac{k\sinh 2a - 2a}{k\cosh 2a + 2a^2 + (k^2+1)/2},\qquad a = q d,\ k = 3 - 4\nu

    At q = 0 the layer is compressed without sideways strain: C(0) = d (1+nu)(1-2nu) / (E (1-nu)), 0 at nu =
    1/2.

    Parameters
    ----------
    solid : Solid
    thickness : float
        d [m], positive.

    Notes
    -----
    K. L. Johnson, Contact Mechanics (1985), Sec. 5.8; no tangential traction at the surface.

    Examples
    --------
    >>> layer = BondedLayer(solid=Solid(young=1.0, poisson=0.0), thickness=0.5)
    >>> layer.compliance(np.array([0.0, 400.0]), np.array([0.0, 0.0]))
    array([0.5  , 0.005])
    """

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return C(q) [m/Pa]."""
        q = wave_size(qx, qy)
        k = 3 - 4 * self.solid.poisson
        twice = 2 * q * self.thickness
        decay = np.exp(-twice)
        # Numerator and denominator times 2 exp(-2a), which cannot overflow.
        above = (k - 1) * -np.expm1(-2 * twice) + _sinh_excess(twice)
        below = k * (1 + decay**2) + (twice**2 + k**2 + 1) * decay
        return self._with_mean(q, above / below)


@dataclass(frozen=True, kw_only=True)
class FrictionlessLayer(_Layer):
    r"""An elastic layer of finite thickness that slides on a rigid base, without friction or lift-off.

    .. math:: C(q) = \frac{2}{E^* q}\, \frac{\cosh 2a - 1}{\sinh 2a + 2a},\qquad a = q d

    The mean strain sideways is that of the period, zero, so that C(0) = d (1+nu)(1-2nu) / (E (1-nu)) as for
    the bonded layer.

    Parameters
    ----------
    solid : Solid
    thickness : float
        d [m], positive.

    Notes
    -----
    K. L. Johnson, Contact Mechanics (1985), Sec. 5.8.
    """

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return C(q) [m/Pa]."""
        q = wave_size(qx, qy)
        twice = 2 * q * self.thickness
        above = np.expm1(-twice) ** 2
        below = -np.expm1(-2 * twice) + 2 * twice * np.exp(-twice)
        ratio = above / np.where(below > 0, below, 1.0)
        return self._with_mean(q, ratio)


@dataclass(frozen=True, kw_only=True)
class GivenResponse:
    """Any solid whose surface compliance is known per wavevector.

    Parameters
    ----------
    contact_modulus : float
        E* [Pa] that sets the scale of stresses in residuals and reduced quantities.
    function : callable
        C(qx, qy) [m/Pa] for arrays of wavevectors [1/m]; positive but at q = 0, where 0 leaves the mean
        displacement out.
    """

    contact_modulus: float
    function: Callable[[Array, Array], Array]

    def __post_init__(self) -> None:
        positive("contact_modulus", self.contact_modulus)
        function("function", self.function, of=("qx", "qy"))

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return the given C(qx, qy) [m/Pa]."""
        qx, qy = np.broadcast_arrays(*checked_waves(qx, qy))
        return array("function(qx, qy)", self.function(qx, qy), unit="m/Pa", power=2)


def check_response(response: object) -> None:
    """Refuse what is no elastic response."""
    what = "an elastic response, such as `HalfSpace`, with `contact_modulus` and `compliance`"
    instance("response", response, Response, what=what)
    positive("response.contact_modulus", getattr(response, "contact_modulus", None), unit="Pa")


def wave_size(qx: ArrayLike, qy: ArrayLike) -> Array:
    """|q| [1/m] of wavevectors that are finite real numbers."""
    x, y = checked_waves(qx, qy)
    return np.asarray(np.hypot(x, y))


def checked_waves(qx: ArrayLike, qy: ArrayLike) -> tuple[Array, Array]:
    """Return components [1/m] of wavevectors, finite real numbers that broadcast."""
    x, y = array("qx", qx), array("qy", qy)
    alike(qx=x, qy=y)
    return x, y


def _sinh_excess(t: Array) -> Array:
    """2 exp(-t) (sinh t - t), by its series where the difference would cancel."""
    square = np.minimum(t, 1.0) ** 2
    series = 1 + square / 20 * (1 + square / 42 * (1 + square / 72 * (1 + square / 110 * (1 + square / 156))))
    direct = -np.expm1(-2 * t) - 2 * t * np.exp(-t)
    return np.where(t < 1, np.exp(-t) * t**3 / 3 * series, direct)
