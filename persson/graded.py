"""Graded solids, layers and plates: the modulus a wave of roughness feels (Persson 2006, Sec. 5)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import (
    Array,
    function,
    non_negative,
    numbers_of,
    poisson_ratio,
    positive,
    positive_fields,
    positives,
    real,
    returned,
)
from persson._quadrature import panels
from persson.errors import InvalidInput


def checked_wavevectors(wavevector: ArrayLike) -> Array:
    """Return positive wavevectors [1/m]."""
    return non_negative("wavevector", wavevector, zero="must be positive, in 1/m")


def _plane_strain(modulus: Array, poisson: float) -> Array:
    return modulus / (1 - poisson * poisson)


@dataclass(frozen=True, kw_only=True)
class GradedModulus:
    r"""Modulus felt at wavevector q for any profile E(z), as a contact modulus.

    .. math:: \tilde E(q) = q \int_0^\infty E(z)\, e^{-qz}\, dz, \qquad \tilde E^* = \tilde E / (1 - \nu^2)

    Parameters
    ----------
    young : callable
        E(z) [Pa] for an array of depths z >= 0 [m]; may grow with depth, more slowly than exponentially.
    poisson : float
        nu, the same at all depths.
    breaks : sequence of float
        Depths [m] where E(z) jumps or has a kink.

    Notes
    -----
    Persson 2006, Sec. 5: a weighting by the decay of the deformation field, best where E changes little over
    1/q. An instance goes to `persson.scale.Scale` as its modulus, and from there into sigma_a and the
    elastic energy too.

    Examples
    --------
    >>> linear = GradedModulus(young=lambda z: 1e6 * (1 + z / 1e-3), poisson=0.0)
    >>> bool(abs(linear(1e3) / 2e6 - 1) < 1e-12)
    True
    """

    young: Callable[[Array], Array]
    poisson: float
    breaks: Sequence[float] = ()

    def __post_init__(self) -> None:
        poisson_ratio(self.poisson)
        function("young", self.young)
        object.__setattr__(self, "breaks", tuple(positives("breaks", self.breaks, unit="m")))

    def __call__(self, wavevector: ArrayLike) -> Array:
        """E~*(q) [Pa] for wavevectors [1/m]."""
        q = checked_wavevectors(wavevector)
        # Panels grow with depth: fine near the surface, where a thin layer may lie, and up to exp(-60).
        nodes = np.append(0.0, np.geomspace(1e-9, 60.0, 80))
        breaks = np.array(sorted(self.breaks))
        result = np.empty(q.size)
        for index, wave in enumerate(q.flat):
            x, weights = panels(np.unique(np.append(nodes, np.minimum(breaks * wave, 60.0))), 12)
            young = returned("young(z)", self.young(x / wave), x.shape, unit="Pa")
            result[index] = np.sum(weights * young * np.exp(-x))
        return _plane_strain(result.reshape(q.shape), self.poisson)


@dataclass(frozen=True, kw_only=True)
class ExponentialLayers:
    r"""A modulus that relaxes exponentially to its bulk value, in closed form.

    .. math:: E(z) = E_\infty + \sum_i \Delta_i e^{-z/d_i}, \qquad
              \tilde E(q) = E_\infty + \sum_i \Delta_i \frac{q d_i}{1 + q d_i}

    Parameters
    ----------
    bulk : float
        E_inf [Pa].
    excess : sequence of float
        Delta_i [Pa], which may be negative as long as E(z) stays positive.
    depths : sequence of float
        d_i [m].
    poisson : float
        nu.
    """

    bulk: float
    excess: Sequence[float]
    depths: Sequence[float]
    poisson: float

    def __post_init__(self) -> None:
        positive("bulk", self.bulk)
        poisson_ratio(self.poisson)
        excess, depths = numbers_of("excess", self.excess), positives("depths", self.depths)
        if len(excess) != len(depths):
            raise InvalidInput(f"{len(excess)} excess moduli and {len(depths)} depths: must be as many")
        total = real("excess", self.excess).sum()
        if not self.bulk + total > 0:
            raise InvalidInput("excess: the modulus at the surface, bulk + sum(excess), must be positive")

    def young(self, depth: ArrayLike) -> Array:
        """E(z) [Pa]."""
        z = non_negative("depth", depth)
        return np.asarray(
            self.bulk + sum(e * np.exp(-z / d) for e, d in zip(self.excess, self.depths, strict=True))
        )

    def __call__(self, wavevector: ArrayLike) -> Array:
        """E~*(q) [Pa] for wavevectors [1/m]."""
        q = checked_wavevectors(wavevector)
        value = self.bulk + sum(
            e * (q * d / (1 + q * d)) for e, d in zip(self.excess, self.depths, strict=True)
        )
        return _plane_strain(np.asarray(value), self.poisson)[()]


@dataclass(frozen=True, kw_only=True)
class SurfaceLayer:
    """A layer of one modulus on a solid of another, E~(q) = E_bulk + (E_layer - E_bulk)(1 - exp(-q d)).

    Parameters
    ----------
    layer, bulk : float
        Young's moduli [Pa].
    thickness : float
        d [m].
    poisson : float
        nu of both.
    """

    layer: float
    bulk: float
    thickness: float
    poisson: float

    def __post_init__(self) -> None:
        positive_fields(self, "layer", "bulk", "thickness")
        poisson_ratio(self.poisson)

    def __call__(self, wavevector: ArrayLike) -> Array:
        """E~*(q) [Pa] for wavevectors [1/m]."""
        share = -np.expm1(-checked_wavevectors(wavevector) * self.thickness)
        return _plane_strain(self.bulk + (self.layer - self.bulk) * share, self.poisson)


@dataclass(frozen=True, kw_only=True)
class ElasticPlate:
    r"""Modulus felt at wavevector q by a plate whose other face is free, as a contact modulus.

    .. math:: E^*(q) = \frac{E}{1-\nu^2}\,\frac{\sinh^2 x - x^2}{\sinh x\cosh x + x}, \qquad x = q d

    Parameters
    ----------
    young, poisson : float
        E [Pa] and nu.
    thickness : float
        d [m].

    Notes
    -----
    Exact in plane strain without friction, from the stress function of a strip. Long waves bend the
    plate: E*(q) tends to (E*/6) (q d)^3, which is the bending stiffness E d^3 / 12 (1 - nu^2) times 2
    q^3, the limit that Persson (2006), Sec. 5, names (B. N. J. Persson and S. Gorb, J. Chem. Phys. 119,
    11437, 2003). Short waves feel the bulk. An instance goes to `persson.scale.Scale` as its modulus, and
    from there into sigma_a and the elastic energy. Where V grows by waves with q d < 1 only, the plate
    lies on the roughness almost without resistance.

    Examples
    --------
    >>> plate = ElasticPlate(young=1e9, poisson=0.0, thickness=1e-6)
    >>> round(float(plate(1e4)) / 1e3, 4), round(float(plate(1e8)) / 1e9, 6)
    (0.1667, 1.0)
    """

    young: float
    poisson: float
    thickness: float

    def __post_init__(self) -> None:
        positive_fields(self, "young", "thickness")
        poisson_ratio(self.poisson)

    def __call__(self, wavevector: ArrayLike) -> Array:
        """E*(q) [Pa] for wavevectors [1/m]."""
        x = checked_wavevectors(wavevector) * self.thickness
        bulk = self.young / (1 - self.poisson * self.poisson)
        thin = np.minimum(x, 0.3)
        y = 4 * thin * thin
        # sinh^2 x - x^2 and sinh x cosh x + x as series of cosh 2x and sinh 2x, where they would cancel.
        above = y * y / 48 * (1 + y / 30 * (1 + y / 56 * (1 + y / 90 * (1 + y / 132))))
        under = thin * (2 + y / 6 * (1 + y / 20 * (1 + y / 42 * (1 + y / 72))))
        wide = np.clip(x, 0.3, 30.0)
        thick = (np.sinh(wide) ** 2 - wide * wide) / (np.sinh(wide) * np.cosh(wide) + wide)
        return bulk * np.where(x < 0.3, above / under, np.where(x < 30, thick, 1.0))
