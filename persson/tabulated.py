"""Power spectra given by numbers: measured ones, and those smoothed by plastic flow."""

import math
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, choice, non_negative, positive, real
from persson.errors import InvalidInput, OutsideTheory
from persson.spectrum import EDGE, Spectrum, SpectrumMoments, check_spectrum, growth


@dataclass(frozen=True, kw_only=True)
class Tabulated(SpectrumMoments):
    """A spectrum through given points, a power law between neighbours; its moments are exact for that.

    Parameters
    ----------
    wavevectors : (n,) array
        q [1/m], positive and increasing, n >= 2.
    power : (n,) array
        C(q) [m^4], positive, in the convention <h^2> = 2 pi int q C dq.

    Raises
    ------
    InvalidInput
        For points that are missing, negative or out of order.

    Examples
    --------
    >>> flat = Tabulated(wavevectors=[1.0, 2.0], power=[1.0, 1.0])
    >>> bool(abs(flat.m0() - 3 * np.pi) < 1e-12)
    True
    """

    wavevectors: Array
    power: Array

    def __post_init__(self) -> None:
        q = np.array(real("wavevectors", self.wavevectors))
        c = np.array(real("power", self.power, unit="m^4", power=4))
        if q.ndim != 1 or q.size < 2 or q.shape != c.shape:
            raise InvalidInput(
                f"wavevectors {q.shape} and power {c.shape}: must be equal, one-dimensional, n >= 2"
            )
        if not (q[0] > 0 and np.all(np.diff(q) > 0)):
            raise InvalidInput("wavevectors: must be finite, positive and increasing")
        if not np.all(c > 0):
            raise InvalidInput("power: must be finite and positive; leave out points without roughness")
        for name, value in (("wavevectors", q), ("power", c)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def from_areal_psd(cls, wavevectors: ArrayLike, power: ArrayLike) -> Self:
        """Read the areal PSD of other communities, (2 pi)^2 C(q) [m^4]."""
        c = real("power", power, unit="m^4", power=4) / (4 * math.pi**2)
        return cls(wavevectors=real("wavevectors", wavevectors), power=c)

    @property
    def q_min(self) -> float:
        """First wavevector [1/m]."""
        return float(self.wavevectors[0])

    @property
    def q_long(self) -> float:
        """First wavevector [1/m]: a table names no roll-off."""
        return self.q_min

    @property
    def q_short(self) -> float:
        """Last wavevector [1/m]."""
        return float(self.wavevectors[-1])

    @property
    def _exponents(self) -> Array:
        q, c = self.wavevectors, self.power
        # Ratios before logarithms: no digit of the exponents may depend on the unit of length.
        return np.log(c[1:] / c[:-1]) / np.log(q[1:] / q[:-1])

    def __call__(self, q: ArrayLike) -> Array:
        """C(q) [m^4]; 0 outside the table."""
        wave = real("q", q)
        inside = (wave >= self.q_min * (1 - EDGE)) & (wave <= self.q_short * (1 + EDGE))
        safe = np.clip(wave, self.q_min, self.q_short)
        index = np.clip(np.searchsorted(self.wavevectors, safe, side="right") - 1, 0, self.power.size - 2)
        value = self.power[index] * (safe / self.wavevectors[index]) ** self._exponents[index]
        return np.where(inside, value, 0.0)

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`."""
        return replace(self, power=self.power * positive("factor", factor))

    def _moment(self, order: int, upper: Array) -> Array:
        q, c, n = self.wavevectors, self.power, self._exponents + 2 * order + 2
        weight = c[:-1].copy()
        for _ in range(order + 1):
            weight = weight * q[:-1] * q[:-1]
        whole = np.append(0.0, np.cumsum(weight * growth(n, np.log1p(np.diff(q) / q[:-1]))))
        safe = np.clip(upper, q[0], q[-1])
        index = np.clip(np.searchsorted(q, safe, side="right") - 1, 0, q.size - 2)
        rest = weight[index] * growth(n[index], np.log1p((safe - q[index]) / q[index]))
        return 2 * math.pi * (whole[index] + rest)


def smoothed(
    spectrum: Spectrum,
    *,
    wavevectors: ArrayLike,
    yielded: ArrayLike,
    form: Literal["gradual", "sharp"] = "gradual",
) -> Tabulated:
    """Spectrum of a surface after plastic flow has flattened its short waves.

    Parameters
    ----------
    spectrum : Spectrum
        C(q) before squeezing.
    wavevectors : (n,) array
        q [1/m], increasing, dense enough to be joined by power laws.
    yielded : (n,) array
        A_pl(q) over its final value sigma_0 A_0 / sigma_Y, in [0, 1].
    form : {"gradual", "sharp"}
        C(q) (1 - yielded), or C(q) up to where half has yielded.

    Notes
    -----
    Persson 2006, Sec. 10.2.
    """
    check_spectrum(spectrum)
    choice("form", form, ("gradual", "sharp"))
    q = np.atleast_1d(non_negative("wavevectors", wavevectors))
    share = np.atleast_1d(non_negative("yielded", yielded, vanishing=True))
    if q.shape != share.shape or np.any(share > 1 + 1e-6):
        raise InvalidInput("yielded: must hold one share between 0 and 1 for each wavevector")
    keep = np.minimum(1 - share, 1.0)
    power = spectrum(q)
    if form == "gradual":
        power = power * np.where(keep > 1e-12, keep, 0.0)
    else:
        power = np.where(share <= 0.5, power, 0.0)
    if np.count_nonzero(power) < 2:
        raise OutsideTheory("yielded: all roughness has yielded, no spectrum is left")
    return Tabulated(wavevectors=q[power > 0], power=power[power > 0])
