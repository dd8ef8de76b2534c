"""Frozen capillary waves: the roughness of a surface that was liquid (Persson 2006, Sec. 2.2 and App. A)."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import lambertw

from persson._checks import Array, positive, positive_fields, real, within
from persson.errors import InvalidInput
from persson.spectrum import EDGE, SpectrumMoments

#: Boltzmann constant [J/K], exact in the SI.
BOLTZMANN = 1.380649e-23


@dataclass(frozen=True, kw_only=True)
class CapillaryWaves(SpectrumMoments):
    r"""Power spectrum of capillary waves that froze at one temperature.

    .. math:: C(q) = \frac{1}{(2\pi)^2} \frac{k_B T}{\rho g + \gamma q^2 + \kappa q^4}
              = \frac{k_B T}{(2\pi)^2\gamma} \frac{1}{q_g^2 + q^2 + q^4/q_c^2}

    Parameters
    ----------
    temperature : float
        T [K] at which the waves froze: the glass transition.
    surface_tension : float
        gamma [J/m^2].
    q_bend : float
        q_c = sqrt(gamma / kappa) [1/m], beyond which bending stiffness suppresses the waves.
    q_min, q_short : float
        Smallest wavevector 2 pi / L and cut-off [1/m].
    q_gravity : float
        q_g = sqrt(rho g / gamma) [1/m], at most q_c / 2; 0 leaves gravity out.
    multiple : float
        Factor on C(q): 4 adds an equal surface coherently, 2 an independent one.

    Notes
    -----
    Persson 2006, Eqs. 2 and 3.

    Examples
    --------
    >>> polymer = {"temperature": 370.0, "surface_tension": 0.04, "q_bend": 1.7e9}
    >>> pmma = CapillaryWaves(**polymer, q_min=6.28e4, q_short=7e9)
    >>> round(pmma.moments().rms_height * 1e9, 3)
    0.455
    """

    temperature: float
    surface_tension: float
    q_bend: float
    q_min: float
    q_short: float
    q_gravity: float = 0.0
    multiple: float = 1.0

    def __post_init__(self) -> None:
        positive_fields(self, "temperature", "surface_tension", "q_bend", "q_min", "multiple")
        if not positive("q_short", self.q_short) >= self.q_min:
            raise InvalidInput(f"q_short = {self.q_short!r}: must be finite, at least q_min = {self.q_min!r}")
        within("q_gravity", self.q_gravity, "[0, q_bend / 2]", ends=(0, self.q_bend / 2))

    @property
    def q_long(self) -> float:
        """The smallest wavevector [1/m]: the waves have no roll-off."""
        return self.q_min

    @property
    def _strength(self) -> float:
        return self.multiple * BOLTZMANN * self.temperature / self.surface_tension

    def __call__(self, q: ArrayLike) -> Array:
        """C(q) [m^4] for wavevectors [1/m]; 0 outside [q_min, q_short]."""
        wave = real("q", q)
        inside = (wave >= self.q_min * (1 - EDGE)) & (wave <= self.q_short * (1 + EDGE))
        ratio = np.where(inside, wave, self.q_min) / self.q_bend
        gravity = self.q_gravity / self.q_bend
        square = ratio * ratio
        shape = 1 / (gravity * gravity + square + square * square)
        scale = self._strength / (4 * math.pi**2 * self.q_bend * self.q_bend)
        return np.where(inside, scale * shape, 0.0)

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`."""
        return replace(self, multiple=self.multiple * positive("factor", factor))

    def _moment(self, order: int, upper: Array) -> Array:
        """Partial fractions in s = q^2 / q_c^2; every term is a logarithm of a ratio near its own scale."""
        upper = np.clip(upper, self.q_min, self.q_short)
        low = self.q_min / self.q_bend
        width = (upper - self.q_min) / self.q_bend
        delta, start = width * (2 * low + width), low * low
        gravity = (self.q_gravity / self.q_bend) ** 2
        split = math.sqrt(1 - 4 * gravity)
        b = (1 + split) / 2
        a = gravity / b
        if order == 0:
            # log1p((b - a) delta / ...) instead of a difference of two logarithms.
            near = (start + a) * (start + delta + b)
            part = np.log1p((b - a) * delta / near) / (b - a) if b > a else delta / near
        elif order == 1:
            part = (b * np.log1p(delta / (start + b)) - a * np.log1p(delta / (start + a))) / (b - a)
        else:
            part = (b * _excess(b, delta, start) - a * _excess(a, delta, start)) / (b - a)
        return math.prod([self.q_bend * self.q_bend] * order, start=self._strength / (4 * math.pi)) * part


def _excess(root: float, delta: Array, start: float) -> Array:
    """Int s / (s + root) ds over [start, start + delta], without cancellation for s << root."""
    u = delta / (start + root)
    small = np.minimum(u, 0.3)
    series, power = np.zeros_like(u), small * small
    for n in range(2, 34):
        series = series + (-1) ** n * power / n
        power = power * small
    return start * u + root * np.where(u < 0.3, series, u - np.log1p(u))


def maximum_height(independent_points: float) -> float:
    r"""Highest point h_1 of a Gaussian surface over its rms height.

    .. math:: \frac{h_1}{h_\mathrm{rms}} =
              \left[2 \ln\left(\frac{h_\mathrm{rms}}{h_1}\frac{N}{\sqrt{2\pi}}\right)\right]^{1/2}

    Parameters
    ----------
    independent_points : float
        N = A_0 / xi^2, the number of patches that are not correlated; at least 10.

    Notes
    -----
    Persson 2006, App. A: the height exceeded with probability about 1/N. Peak to valley is twice that.

    Examples
    --------
    >>> round(maximum_height(1e8), 2), round(maximum_height(1e4), 2)
    (5.62, 3.73)
    """
    count = positive("independent_points", independent_points)
    if count < 10:
        raise InvalidInput(f"independent_points = {count!r}: must be at least 10; the formula is for many")
    # With x^2/2 + ln x = ln(N / sqrt(2 pi)), x^2 is Lambert's W of N^2 / (2 pi).
    return math.sqrt(float(lambertw(count * count / (2 * math.pi)).real))
