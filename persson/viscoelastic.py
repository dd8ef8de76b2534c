"""What a viscoelastic solid dissipates at the edge of a contact that opens (Persson 2006, Sec. 8.6)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from persson._checks import Array, function, in_proportion, non_negative, positive, returned
from persson._quadrature import panels
from persson.errors import InvalidInput

#: E-folds of frequency below the highest over which is summed, and in how many panels.
_SPAN, _PANELS = 60.0, 100


@dataclass(frozen=True, kw_only=True)
class StandardSolid:
    r"""A solid with one retardation time.

    .. math:: \frac{1}{E(\omega)} = \frac{1}{E_\infty} +
              \Bigl(\frac{1}{E_0} - \frac{1}{E_\infty}\Bigr)\frac{1}{1 + i\omega\tau}

    Parameters
    ----------
    relaxed, unrelaxed : float
        E_0 < E_inf [Pa], at low and at high frequency.
    time : float
        tau [s].
    """

    relaxed: float
    unrelaxed: float
    time: float

    def __post_init__(self) -> None:
        low = positive("relaxed", self.relaxed)
        if positive("unrelaxed", self.unrelaxed) <= low:
            raise InvalidInput(f"unrelaxed = {self.unrelaxed!r} Pa: must exceed relaxed = {low!r} Pa")
        positive("time", self.time)

    def creep_compliance(self, time: ArrayLike) -> Array:
        """J(t) [1/Pa] at t >= 0 [s]; a contact whose load does not fall has the area of E = 1/J(t)."""
        since = non_negative("time", time) / self.time
        return 1 / self.unrelaxed - (1 / self.relaxed - 1 / self.unrelaxed) * np.expm1(-since)

    def modulus(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """E(omega) [Pa] for omega [1/s], storage modulus + i times the loss modulus."""
        x = non_negative("frequency", frequency) * self.time
        compliance = 1 / self.unrelaxed + (1 / self.relaxed - 1 / self.unrelaxed) / (1 + 1j * x)
        return np.asarray(1 / compliance)

    def loss_compliance(self, frequency: ArrayLike) -> Array:
        """-Im 1/E(omega) [1/Pa] for omega [1/s]."""
        x = non_negative("frequency", frequency) * self.time
        # x / (1 + x^2) that does not overflow.
        lag = np.minimum(x, 1 / np.maximum(x, 1.0))
        return np.asarray((1 / self.relaxed - 1 / self.unrelaxed) * lag / (1 + lag * lag))[()]


def crack_dissipation(
    velocity: float,
    *,
    loss_compliance: Callable[[Array], Array],
    relaxed: float,
    tip_radius: float,
    contact_size: float = math.inf,
) -> float:
    r"""Factor f(v) by which dissipation raises the work to open an interfacial crack.

    .. math:: 1 + f = \Bigl[1 - \frac{2E_0}{\pi}\int_{2\pi v/D}^{2\pi v/a}\frac{d\omega}{\omega}
              \sqrt{1 - \Bigl(\frac{\omega a}{2\pi v}\Bigr)^2}\;
              \Bigl|\operatorname{Im}\frac{1}{E(\omega)}\Bigr| \Bigr]^{-1}, \qquad a = a_0 (1 + f)

    Parameters
    ----------
    velocity : float
        v [m/s] of the crack tip.
    loss_compliance : callable
        |Im 1/E(omega)| [1/Pa] for an array of frequencies [1/s], as `StandardSolid.loss_compliance`.
    relaxed : float
        E_0 [Pa], the modulus at low frequency.
    tip_radius : float
        a_0 [m], radius of the tip of a slow crack, where bonds break.
    contact_size : float
        D [m], size of the contact region that opens: nothing farther from the tip than D dissipates.
        Infinite for the crack of an infinite solid.

    Returns
    -------
    float
        f(v) >= 0. With D infinite it grows to E_inf/E_0 - 1, "about 10^3" for rubber; `opening_work` and
        `closing_work` of `persson.interface` take it from there.

    Notes
    -----
    Persson 2006, Sec. 8.6, states the factor and its limit; the formula is that of B. N. J. Persson and
    E. Brener, Phys. Rev. E 71, 036123 (2005), which the paper cites, with the tip blunted in proportion
    to the work. The lower end of the integral is an estimate for "as long as the linear size d of the
    dissipative region is smaller than the linear size D of the contact": at a distance r the solid is
    strained at omega = 2 pi v / r. So f is that of the infinite solid while d, about 2 pi v tau, is below
    D, and falls again at higher velocity; it vanishes at D = a_0.

    Examples
    --------
    >>> rubber = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)
    >>> told = {"loss_compliance": rubber.loss_compliance, "relaxed": 1e6, "tip_radius": 1e-9}
    >>> round(crack_dissipation(1e3, **told))
    999
    """
    speed = 2 * math.pi * positive("velocity", velocity)
    function("loss_compliance", loss_compliance)
    low = positive("relaxed", relaxed)
    radius = positive("tip_radius", tip_radius)
    endless = isinstance(contact_size, float) and contact_size == math.inf
    size = math.inf if endless else positive("contact_size", contact_size)
    if size <= radius:
        return 0.0

    def missing(blunt: float) -> float:
        """1 + f that the integral gives for a tip of radius a_0 (1 + f), less that factor, in logarithms."""
        tip = radius * math.exp(blunt)
        extent = _SPAN if endless else min(_SPAN, max(math.log(size / tip), 0.0))
        taken = low * _compliance_taken(loss_compliance, highest=speed / tip, extent=extent)
        if not taken < 1:
            raise InvalidInput(
                "loss_compliance: takes more than 1 / relaxed; the two do not belong to one solid"
            )
        return -math.log1p(-taken) - blunt

    with in_proportion():
        if missing(0.0) <= 0:
            return 0.0
        top = 1.0
        while missing(top) > 0:
            top *= 2
        return math.expm1(brentq(missing, 0.0, top, xtol=1e-12))


def _compliance_taken(loss_compliance: Callable[[Array], Array], *, highest: float, extent: float) -> float:
    r"""Return what the losses of a crack take of its compliance 1/E_0 [1/Pa].

    .. math:: \frac{2}{\pi}\int \frac{d\omega}{\omega} \sqrt{1 - (\omega/\omega_1)^2}\;
              \Bigl|\operatorname{Im}\frac{1}{E(\omega)}\Bigr|

    over `extent` e-folds of frequency below the `highest`, omega_1 [1/s].
    """
    # With z = ln(omega_1 / omega) the weight sqrt(1 - exp(-2 z)) starts like a root: z = y^2.
    y, weights = panels(np.linspace(0.0, math.sqrt(extent), _PANELS + 1), 6)
    z = y**2
    loss = returned("loss_compliance", loss_compliance(highest * np.exp(-z)), z.shape, unit="1/Pa")
    return 2 / math.pi * float(np.sum(weights * 2 * y * np.sqrt(-np.expm1(-2 * z)) * np.abs(loss)))
