"""Roughness with a lay, as grinding leaves it: a stretched C(qx, qy), and its average over directions."""

import itertools
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, alike, non_negative, positive, real, within
from persson._quadrature import gauss
from persson.errors import InvalidInput
from persson.spectrum import Spectrum, SpectrumMoments, check_spectrum

#: Points of the quadrature over directions, on each panel between the ends of the spectrum.
_POINTS, _WEIGHTS = gauss(64)

_LARGEST = 50.0


@dataclass(frozen=True, kw_only=True)
class Stretched(SpectrumMoments):
    r"""A spectrum whose waves along x are longer by a factor; by itself, its average over directions.

    .. math:: C(q_x, q_y) = \gamma\, C_0\!\left(\sqrt{\gamma^2 q_x^2 + q_y^2}\right), \qquad
              \bar C(q) = \frac{1}{2\pi} \int_0^{2\pi} C(q\cos\varphi, q\sin\varphi)\, d\varphi

    The height keeps its variance; <|grad h|^2> is (1 + 1/gamma^2)/2 of that of C_0, and <(lap h)^2> is
    (3 + 2/gamma^2 + 3/gamma^4)/8.

    Parameters
    ----------
    spectrum : Spectrum
        C_0, isotropic.
    factor : float
        gamma, from 1 to 50: the ratio of the axes (Peklenik's number), with the lay along x.

    Raises
    ------
    InvalidInput
        For a factor outside its range.

    Notes
    -----
    Persson's theory sees the average alone: in full contact of a half-space the variance of the stress is
    (E*/2)^2 <|grad h|^2>, whatever the directions. J. Peklenik, Proc. Inst. Mech. Eng. 182, 108 (1967).

    Examples
    --------
    >>> from persson import SelfAffine
    >>> straight = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1.0, q_short=9.0)
    >>> ground = Stretched(spectrum=straight, factor=3)
    >>> bool(abs(ground.m2() / 0.01 - (1 + 1 / 9) / 2) < 1e-10)
    True
    """

    spectrum: Spectrum
    factor: float

    def __post_init__(self) -> None:
        check_spectrum(self.spectrum)
        if not hasattr(self.spectrum, "scaled"):
            raise InvalidInput("spectrum: has no `scaled`; give a `SelfAffine` or a `Tabulated`")
        within("factor", self.factor, f"[1, {_LARGEST:g}]")

    @property
    def q_min(self) -> float:
        """Smallest wavevector [1/m], along x."""
        return self.spectrum.q_min / self.factor

    @property
    def q_long(self) -> float:
        """Wavevector along x where the roll-off ends [1/m]."""
        return self.spectrum.q_long / self.factor

    @property
    def q_short(self) -> float:
        """Largest wavevector [1/m], along y."""
        return self.spectrum.q_short

    def directional(self, qx: ArrayLike, qy: ArrayLike) -> Array:
        """C(qx, qy) [m^4] of wavevectors [1/m], which broadcast."""
        along, across = real("qx", qx), real("qy", qy)
        alike(qx=along, qy=across)
        return self.factor * self.spectrum(np.hypot(self.factor * along, across))

    def __call__(self, q: ArrayLike) -> Array:
        """Average of C over the directions at |q| [m^4]."""
        wave = non_negative("q", q)
        return self._averaged(wave, lambda g, q: self.spectrum(g * q))

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`."""
        spectrum: Any = self.spectrum
        return replace(self, spectrum=spectrum.scaled(positive("factor", factor)))

    def _moment(self, order: int, upper: Array) -> Array:
        """In each direction the moment of C_0 up to g q_upper, over g^(2 order + 2)."""
        moment = (self.spectrum.m0, self.spectrum.m2, self.spectrum.m4)[order]
        return self._averaged(
            np.minimum(upper, self.q_short),
            lambda g, q: moment(np.minimum(g * q, self.spectrum.q_short)) / g ** (2 * order + 2),
        )

    def _averaged(self, q: Array, value: Any) -> Array:
        """Average gamma value(g, q) over a quarter of the directions; C_0 is asked for at g q."""
        flat = np.atleast_1d(q).ravel()
        ends = np.array([self.spectrum.q_min, self.spectrum.q_long, self.spectrum.q_short])
        # Between the directions in which g q crosses an end of the spectrum everything is smooth.
        longest = self.spectrum.q_min or self.spectrum.q_long
        ratio = np.minimum(ends[:, None] / np.maximum(flat, longest / (2 * self.factor)), self.factor)
        breadth = self.factor**2 - 1
        cosine = np.sqrt(np.clip((ratio**2 - 1) / breadth, 0, 1)) if breadth > 0 else np.zeros(ratio.shape)
        angle = np.arccos(cosine)
        panels = np.sort(
            np.concatenate([angle, np.zeros((1, flat.size)), np.full((1, flat.size), np.pi / 2)]), axis=0
        )
        total = np.zeros(flat.shape)
        for lower, upper in itertools.pairwise(panels):
            phi = lower + (upper - lower) * _POINTS[:, None]
            g = np.hypot(self.factor * np.cos(phi), np.sin(phi))
            total += (upper - lower) * (_WEIGHTS[:, None] * value(g, flat)).sum(axis=0)
        return np.asarray(self.factor * total / (np.pi / 2)).reshape(np.shape(q))[()]
