"""Which wavevector belongs to which variance of the full-contact stress."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from persson._checks import Array, non_negative, positive, returned
from persson.errors import InvalidInput
from persson.spectrum import Spectrum, check_spectrum

#: Points per e-fold of q - q_min in the table that inverts V(q), and where it starts.
_DENSITY = 24
_START = 1e-14


class Scale:
    """The variance V(q) of the full-contact stress with all roughness up to q, and its inverse.

    Parameters
    ----------
    spectrum : Spectrum
        C(q).
    contact_modulus : float or callable
        E* [Pa], or E~*(q) [Pa] for an array of wavevectors where the modulus is graded in depth (Persson
        2006, Sec. 5).

    Raises
    ------
    InvalidInput
        For a modulus that is not positive, or a spectrum without roughness.

    Notes
    -----
    V = (1/4) int E*^2 2 pi q^3 C dq (Persson 2006, Eqs. 17 and 18). With a constant modulus it is exact;
    with a graded one it is summed over the table's intervals, each with the exact moment of the spectrum and
    the mean of E*^2.
    """

    def __init__(self, spectrum: Spectrum, *, contact_modulus: float | Callable[[Array], Array]) -> None:
        check_spectrum(spectrum)
        self.spectrum = spectrum
        # A roll-off that reaches q = 0 starts where nothing of it is felt.
        self.q_min = float(spectrum.q_min if spectrum.q_min > 0 else spectrum.q_long * 1e-9)
        self.q_short = float(spectrum.q_short)
        if not self.q_short > self.q_min:
            raise InvalidInput("the spectrum holds no roughness: q_short must exceed q_min")
        self._origin = float(spectrum.q_min)
        span = (self.q_short - self._origin) / self.q_min
        start = _START if self._origin > 0 else 1.0
        count = max(int(_DENSITY * np.log(span / start)), 64)
        offsets = np.append(np.geomspace(start, span, count)[:-1], span)
        self._q = self._origin + self.q_min * offsets
        self._q[-1] = self.q_short
        self.graded = callable(contact_modulus)
        if callable(contact_modulus):
            self._modulus = contact_modulus
            zero = "must be positive at every wavevector"
            non_negative("contact_modulus(q)", self.modulus(self._q), unit="Pa", zero=zero)
            first = self._between(np.array([spectrum.q_min]), self._q[:1])
            self._variance = np.cumsum(np.concatenate([first, self._between(self._q[:-1], self._q[1:])]))
        else:
            constant = positive("contact_modulus", contact_modulus)
            self._modulus = lambda q: np.full(np.shape(q), constant)
            self._variance = self.variance(self._q)
        keep = np.append(True, np.diff(self._variance) > 0) & (self._variance > 0)
        if keep.sum() < 2:
            raise InvalidInput("the spectrum holds no roughness: C(q) vanishes")
        top = self._variance[-1]
        x = np.log((self._q[keep] - self._origin) / self.q_min)
        self._inverse = PchipInterpolator(np.log(self._variance[keep] / top), x, extrapolate=False)
        self._first, self._top = float(self._variance[keep][0]), float(top)

    def modulus(self, q: ArrayLike) -> Array:
        """E*(q) [Pa]."""
        wave = non_negative("q", q)
        return returned("contact_modulus(q)", self._modulus(wave), wave.shape, unit="Pa")

    def _between(self, low: Array, high: Array) -> Array:
        """Int E*^2/4 dm2 by Simpson's rule in m2, whose middle has half of the interval's m2 below it."""
        m2_low, m2_high = self.spectrum.m2(low), self.spectrum.m2(high)
        middle = (low + high) / 2
        density = 2 * np.pi * middle * middle * middle * self.spectrum(middle)
        shift = (m2_low + m2_high) / 2 - self.spectrum.m2(middle)
        middle = np.clip(middle + shift / np.where(density > 0, density, np.inf), low, high)
        squares = [np.square(self.modulus(np.maximum(q, self.q_min)) / 2) for q in (low, middle, high)]
        return np.asarray((m2_high - m2_low) * (squares[0] + 4 * squares[1] + squares[2]) / 6)

    def variance(self, q: ArrayLike) -> Array:
        """V [Pa^2] for wavevectors q [1/m]."""
        wave = non_negative("q", q)
        if not self.graded:
            half = self.modulus(wave) / 2
            return np.asarray(self.spectrum.m2(wave) * half * half)[()]
        inside = np.clip(wave, self._q[0], self._q[-1])
        index = np.clip(np.searchsorted(self._q, inside, side="right") - 1, 0, self._q.size - 2)
        value = self._variance[index] + self._between(self._q[index], inside)
        return np.where(wave >= self._q[0], value, 0.0)[()]

    def wavevector(self, variance: ArrayLike) -> Array:
        """Q [1/m] at which V(q) equals `variance` [Pa^2]; q_min below the first, q_short above the last."""
        wanted = non_negative("variance", variance, power=2)
        value = np.clip(wanted, self._first, self._top)
        q = self._origin + self.q_min * np.exp(self._inverse(np.log(value / self._top)))
        for _ in range(2):
            # The table is good to 1e-5; Newton makes the inverse as smooth as the spectrum, which moving
            # walls need.
            half = self.modulus(q) / 2
            rate = 2 * np.pi * q * q * q * self.spectrum(q) * half * half
            step = (self.variance(q) - value) / np.where(rate > 0, rate, np.inf)
            offset = q - self._origin
            q = self._origin + np.clip(offset - step, offset / 2, offset * 2)
        return np.where(wanted < self._first, self.q_min, np.minimum(q, self.q_short))[()]


def of_variance(function: Callable[[Array], Array], scale: Scale) -> Callable[[Array], Array]:
    """Return a function of q [1/m] as one of V(q) [Pa^2]."""
    return lambda variance: np.asarray(function(scale.wavevector(variance)))
