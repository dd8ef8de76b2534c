"""Elastic responses of periodic solids: surface displacement from pressure, one compliance per wavevector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fem_contact.solid import Solid

__all__ = ["HalfSpace", "Response"]

Array = NDArray[np.float64]


@runtime_checkable
class Response(Protocol):
    """An elastic solid as its surface sees it: u-hat(q) = C(q) p-hat(q)."""

    @property
    def contact_modulus(self) -> float:
        """E* [Pa] that sets the scale of stresses."""
        ...

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Surface displacement over pressure [m/Pa] at wavevectors (qx, qy) [1/m], broadcast together.

        At q = 0 it is the mean displacement per mean pressure, 0 where that is left out (half-space).
        """
        ...


@dataclass(frozen=True, kw_only=True)
class HalfSpace:
    """The homogeneous elastic half-space, C(q) = 2 / (E* |q|), with the infinite q = 0 response left out.

    Examples
    --------
    >>> soft = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    >>> soft.compliance(np.array([0.0, 3.0]), np.array([0.0, 4.0]))
    array([0. , 0.4])
    """

    solid: Solid

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.solid.contact_modulus

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return 2 / (E* |q|) [m/Pa], 0 at q = 0."""
        q = np.hypot(qx, qy)
        with np.errstate(divide="ignore"):
            return np.where(q > 0, 2 / (self.contact_modulus * q), 0.0)
