"""Power spectra C(q) of isotropic surface roughness and their moments.

Convention throughout (Persson 2006, Sec. 2): C(q) = (2 pi)^-2 int d^2x <h(x) h(0)> exp(-i q.x) [m^4], so
that the areal moments are m_2k = 2 pi int q^(2k+1) C(q) dq. Other communities use (2 pi)^2 C.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfcx

from persson._checks import Array, choice, instance, non_negative, positive, real, scalar, within
from persson.errors import InvalidInput

#: Relative slack with which a wavevector may exceed an edge it equals up to rounding.
EDGE = 1e-12

RollOff = Literal["sharp", "smooth", "plateau"]


@dataclass(frozen=True, kw_only=True)
class Moments:
    """Areal moments of a rough surface.

    Attributes
    ----------
    m0, m2, m4 : float
        <h^2> [m^2], <|grad h|^2> [-], <(lap h)^2> [1/m^2].
    """

    m0: float
    m2: float
    m4: float

    def __post_init__(self) -> None:
        for name, unit, power in (("m0", "m^2", 2), ("m2", "", 4), ("m4", "1/m^2", 6)):
            non_negative(name, getattr(self, name), unit=unit, power=power)

    @property
    def rms_height(self) -> float:
        """h_rms [m]."""
        return math.sqrt(self.m0)

    @property
    def rms_gradient(self) -> float:
        """h'_rms [-], both directions together."""
        return math.sqrt(self.m2)

    @property
    def nayak(self) -> float:
        """Nayak parameter alpha = (3/2) m0 m4 / m2^2 [-]."""
        return 1.5 * (self.m0 / self.m2) * (self.m4 / self.m2)


@runtime_checkable
class Spectrum(Protocol):
    """A power spectrum that vanishes outside [q_min, q_short]; any class with these members will do."""

    @property
    def q_min(self) -> float:
        """Smallest wavevector of the roughness [1/m]; 0 where it has none."""

    @property
    def q_long(self) -> float:
        """Wavevector where the roll-off ends [1/m]; equals `q_min` without one."""

    @property
    def q_short(self) -> float:
        """Cut-off wavevector [1/m]."""

    def __call__(self, q: ArrayLike) -> Array:
        """C(q) [m^4] for wavevectors [1/m]."""

    def m0(self, q_upper: ArrayLike | None = None) -> Array:
        """<h^2> [m^2] of the waves up to q_upper [1/m]."""

    def m2(self, q_upper: ArrayLike | None = None) -> Array:
        """<|grad h|^2> [-] of the waves up to q_upper [1/m]."""

    def m4(self, q_upper: ArrayLike | None = None) -> Array:
        """<(lap h)^2> [1/m^2] of the waves up to q_upper [1/m]."""


def check_spectrum(spectrum: object) -> None:
    """Refuse what is no spectrum."""
    instance("spectrum", spectrum, Spectrum, what="a power spectrum, such as `SelfAffine`")


def check_sample(spectrum: Spectrum, why: str) -> None:
    """Refuse a spectrum without smallest wavevector where the size of the sample matters."""
    if not spectrum.q_min > 0:
        raise InvalidInput(f"q_min = 0: {why}; give q_min = 2 pi / L")


def sampled_wavevectors(spectrum: Spectrum, count: int) -> Array:
    """Return wavevectors [1/m] from q_min to q_short, evenly spaced in ln q."""
    q = spectrum.q_min * np.geomspace(1.0, spectrum.q_short / spectrum.q_min, count)
    q[-1] = spectrum.q_short
    return q


class SpectrumMoments:
    """Moments by name for a spectrum that provides `_moment(order, upper)` of the waves up to `upper`."""

    def _moment(self, order: int, upper: Array) -> Array:
        raise NotImplementedError

    def _moment_up_to(self, order: int, q_upper: ArrayLike | None) -> Array:
        everything = np.asarray(np.inf)
        return self._moment(order, everything if q_upper is None else non_negative("q_upper", q_upper))

    def m0(self, q_upper: ArrayLike | None = None) -> Array:
        """<h^2> = 2 pi int q C dq [m^2] of the waves up to q_upper [1/m] (all by default)."""
        return self._moment_up_to(0, q_upper)

    def m2(self, q_upper: ArrayLike | None = None) -> Array:
        """<|grad h|^2> = 2 pi int q^3 C dq [-] of the waves up to q_upper [1/m] (all by default)."""
        return self._moment_up_to(1, q_upper)

    def m4(self, q_upper: ArrayLike | None = None) -> Array:
        """<(lap h)^2> = 2 pi int q^5 C dq [1/m^2] of the waves up to q_upper [1/m] (all by default)."""
        return self._moment_up_to(2, q_upper)

    def moments(self, q_upper: float | None = None) -> Moments:
        """Return m0, m2 and m4 of the waves up to q_upper [1/m], together."""
        if q_upper is not None:
            q_upper = scalar("q_upper", q_upper)
        return Moments(m0=float(self.m0(q_upper)), m2=float(self.m2(q_upper)), m4=float(self.m4(q_upper)))


@dataclass(frozen=True, kw_only=True)
class SelfAffine(SpectrumMoments):
    r"""Self-affine fractal roughness, C ~ q^(-2(1+H)) between q_long and q_short.

    .. math:: C(q) = C_0\,(q/q_\mathrm{long})^{-2(1+H)}, \qquad q_\mathrm{long} \le q \le q_\mathrm{short}

    Parameters
    ----------
    hurst : float
        Hurst exponent H in [0, 1]; the fractal dimension is 3 - H.
    q_long, q_short : float
        Ends of the self-affine range [1/m].
    amplitude : float
        C(q_long) [m^4]; `from_rms_height` and `from_rms_gradient` set it by a moment.
    rolloff : {"sharp", "smooth", "plateau"}
        What lies below q_long: nothing ("sharp"); C = C(q_long) ("plateau"); or, with the power law bent
        over smoothly everywhere, C = C(q_long) [(1 + (q/q_long)^2) / 2]^(-1-H) ("smooth").
    q_min : float, optional
        Lower end of a plateau or smooth roll-off [1/m], 2 pi / L for a sample of size L; 0 by default.

    Raises
    ------
    InvalidInput
        For a parameter outside its range, naming it.

    Notes
    -----
    Persson 2006, Sec. 2. Wavevectors enter as q/q_long only, so no result depends on the unit of length.

    Examples
    --------
    >>> rough = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e8)
    >>> round(rough.moments().rms_gradient, 12)
    0.1
    >>> bool(abs(rough(2e5) / rough(1e5) - 2**-3.6) < 1e-14)
    True
    """

    hurst: float
    q_long: float
    q_short: float
    amplitude: float
    rolloff: RollOff = "sharp"
    q_min: float = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        within("hurst", self.hurst, "[0, 1]")
        positive("q_long", self.q_long)
        positive("amplitude", self.amplitude, unit="m^4", power=4)
        choice("rolloff", self.rolloff, ("sharp", "smooth", "plateau"))
        if not positive("q_short", self.q_short) >= self.q_long:
            raise InvalidInput(
                f"q_short = {self.q_short!r}: must be finite and at least q_long = {self.q_long!r}"
            )
        lowest = self.q_min
        if lowest is None:
            object.__setattr__(self, "q_min", self.q_long if self.rolloff == "sharp" else 0.0)
        elif self.rolloff == "sharp" and non_negative("q_min", lowest).ravel()[0] != self.q_long:
            raise InvalidInput(
                f"q_min = {lowest!r}: a sharp roll-off ends at q_long; name a plateau or smooth one"
            )
        else:
            within("q_min", lowest, f"[0, q_long = {self.q_long!r}]", ends=(0, self.q_long))

    @classmethod
    def from_rms_height(
        cls,
        rms_height: float,
        *,
        hurst: float,
        q_long: float,
        q_short: float,
        rolloff: RollOff = "sharp",
        q_min: float | None = None,
    ) -> Self:
        """Return the spectrum with sqrt(m0) = rms_height [m]; the other parameters as for the class."""
        shape: dict[str, Any] = {"hurst": hurst, "q_long": q_long, "q_short": q_short, "q_min": q_min}
        return cls(**shape, rolloff=rolloff, amplitude=1.0)._normalised("rms_height", rms_height, 0)

    @classmethod
    def from_rms_gradient(
        cls,
        rms_gradient: float,
        *,
        hurst: float,
        q_long: float,
        q_short: float,
        rolloff: RollOff = "sharp",
        q_min: float | None = None,
    ) -> Self:
        """Return the spectrum with sqrt(m2) = rms_gradient [-]; the other parameters as for the class."""
        shape: dict[str, Any] = {"hurst": hurst, "q_long": q_long, "q_short": q_short, "q_min": q_min}
        return cls(**shape, rolloff=rolloff, amplitude=1.0)._normalised("rms_gradient", rms_gradient, 1)

    def _normalised(self, name: str, rms: float, order: int) -> Self:
        """Return this spectrum of C(q_long) = 1 with another amplitude: its moment of an order is rms^2."""
        rms, moment = positive(name, rms), float(self._moment_up_to(order, None))
        if moment == 0:
            raise InvalidInput(
                f"q_short = {self.q_short!r}: an empty range of wavevectors cannot carry {name} = {rms!r}"
            )
        return replace(self, amplitude=rms * rms / moment)

    def __call__(self, q: ArrayLike) -> Array:
        """C(q) [m^4] for an array of q [1/m]; 0 outside [q_min, q_short]."""
        ratio = real("q", q) / self.q_long
        inside = (ratio >= self.q_min / self.q_long * (1 - EDGE)) & (
            ratio <= self.q_short / self.q_long * (1 + EDGE)
        )
        safe = np.where(inside, ratio, 1.0)
        if self.rolloff == "smooth":
            shape = ((1 + safe * safe) / 2) ** (-1 - self.hurst)
        elif self.rolloff == "plateau":
            shape = np.maximum(safe, 1.0) ** (-2 * (1 + self.hurst))
        else:
            shape = safe ** (-2 * (1 + self.hurst))
        return np.where(inside, self.amplitude * shape, 0.0)

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`: 4 adds an equal surface coherently."""
        return replace(self, amplitude=self.amplitude * positive("factor", factor))

    def _moment(self, order: int, upper: Array) -> Array:
        """Moment m_(2 order) = 2 pi int q^(2 order + 1) C dq from q_min to upper, exact on each panel."""
        upper = np.minimum(upper, self.q_short)
        lower = self.q_min / self.q_long  # panels are integrated in q/q_long
        # Widths are subtracted before anything is divided: a narrow band then keeps its digits.
        if self.rolloff == "smooth":
            part = _bent_panel(order, self.hurst, lower, np.maximum(upper - self.q_min, 0.0) / self.q_long)
        else:
            width = np.maximum(upper - self.q_long, 0.0) / self.q_long
            part = _power_panel(2 * order - 2 * self.hurst, 1.0, width)
            if self.rolloff == "plateau":
                width = np.maximum(np.minimum(upper, self.q_long) - self.q_min, 0.0) / self.q_long
                part = part + _power_panel(2.0 * order + 2, lower, width)
        # One factor after the other: with the same rounding in all units, which a power has not.
        scale = math.prod([self.q_long * self.q_long] * (order + 1), start=2 * math.pi * self.amplitude)
        return scale * part


def growth(exponent: ArrayLike, x: Array) -> Array:
    """(exp(a x) - 1) / a, which is x at a = 0."""
    safe = np.where(np.asarray(exponent) != 0, exponent, 1.0)
    return np.where(np.asarray(exponent) != 0, np.expm1(safe * x) / safe, x)


def _power_panel(exponent: float, lower: float, width: Array) -> Array:
    """Int x^(exponent - 1) dx from lower to lower + width, for any exponent (positive if lower = 0)."""
    if lower == 0:
        return width**exponent / exponent
    return np.asarray(lower**exponent * growth(exponent, np.log1p(width / lower)))


def _bent_panel(order: int, hurst: float, lower: float, width: Array) -> Array:
    """Int x^(2k+1) [(1 + x^2)/2]^(-1-H) dx from lower to lower + width.

    With s = x^2 and 1 + s = (1 + s_lower)(1 + r) the expansion of s^k in r has positive terms only: no
    cancellation.
    """
    start = 1 + lower * lower
    stretch = np.log1p(width * (2 * lower + width) / start)
    total = np.zeros_like(stretch)
    for j in range(order + 1):
        weight = math.comb(order, j) * (lower * lower) ** (order - j) * start**j
        total = total + weight * _bent_integral(j, hurst, stretch)
    return np.asarray(total * 2**hurst * start**-hurst)


def _bent_integral(order: int, hurst: float, x: Array) -> Array:
    """Int r^j (1 + r)^(-1-H) dr from 0 to r, with x = log(1 + r): int (e^x - 1)^j e^(-H x) dx."""
    terms = [(math.comb(order, i) * (-1) ** (order - i), i - hurst) for i in range(order + 1)]
    large = np.zeros_like(x)
    for weight, a in terms:
        large = large + weight * growth(a, x)
    # The closed form loses digits like x^-j for small x; there its Taylor series converges at once.
    small, y, power = np.zeros_like(x), np.minimum(x, 1.0), np.minimum(x, 1.0)
    for n in range(30):
        if n >= order:
            small = small + sum(weight * a**n for weight, a in terms) * power
        power = power * y / (n + 2)
    return np.where(x < 1, small, large)


def area_factor(m2: ArrayLike) -> Array:
    r"""Surface area of a randomly rough surface over its projected area, A*/A0.

    .. math:: g = \langle\sqrt{1+|\nabla h|^2}\rangle
              = 1 + \tfrac12\sqrt{\pi m_2}\,e^{1/m_2}\operatorname{erfc}(1/\sqrt{m_2})

    Parameters
    ----------
    m2 : float or array
        <|grad h|^2> [-] of a Gaussian surface; not restricted to small slopes.

    Notes
    -----
    Average of sqrt(1 + s) over the exponential distribution of s = |grad h|^2; Persson 2006, Sec. 8.1.

    Examples
    --------
    >>> round(float(area_factor(0.99)), 5)
    1.37583
    >>> float(area_factor(0.0))
    1.0
    """
    slope = np.sqrt(non_negative("m2", m2, power=2))
    safe = np.where(slope > 0, slope, 1.0)
    return 1 + np.where(slope > 0, 0.5 * math.sqrt(math.pi) * safe * erfcx(1 / safe), 0.0)
