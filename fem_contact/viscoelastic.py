"""Viscoelastic solids: a complex modulus over frequency, from a Prony series or a table."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from contact_checks import UNITS
from fem_contact._checks import array, instance, poisson_ratio, positive, positives, samples
from fem_contact._types import Array, Complex
from fem_contact.errors import InvalidInput


@runtime_checkable
class ViscoelasticSolid(Protocol):
    """A linear solid under oscillation; Poisson's ratio does not depend on the frequency."""

    @property
    def poisson(self) -> float:
        """Poisson's ratio nu."""

    def modulus(self, frequency: ArrayLike) -> Complex:
        """E(omega) [Pa] for omega >= 0 [1/s]: storage modulus + i times the loss modulus.

        Strains go like exp(+i omega t), so that the imaginary part is not negative.
        """


@dataclass(frozen=True, kw_only=True)
class PronySolid:
    r"""A solid whose stress after a step of strain relaxes as a sum of exponentials.

    .. math:: E(t) = E_0 + \sum_k E_k e^{-t/\tau_k},\qquad
              E(\omega) = E_0 + \sum_k E_k \frac{i\omega\tau_k}{1 + i\omega\tau_k}

    Parameters
    ----------
    relaxed : float
        E_0 [Pa], the modulus of a very slow strain, positive.
    moduli : sequence of float
        E_k [Pa], none negative.
    times : sequence of float
        Relaxation times tau_k [s], positive, as many.
    poisson : float
        nu in (-1, 1/2].

    Examples
    --------
    >>> rubber = PronySolid(relaxed=1e6, moduli=(9e6,), times=(1e-3,), poisson=0.5)
    >>> rubber.modulus([0.0, 1e3])
    array([1000000.      +0.j, 5500000.+4500000.j])
    """

    relaxed: float
    moduli: Sequence[float]
    times: Sequence[float]
    poisson: float

    def __post_init__(self) -> None:
        positive("relaxed", self.relaxed)
        poisson_ratio(self.poisson)
        moduli, times = samples("moduli", self.moduli), samples("times", self.times)
        if moduli.size != times.size or moduli.min() < 0:
            raise InvalidInput(
                f"moduli, times: {moduli.size} and {times.size} values: must be as many, no modulus negative"
            )
        positives("times", times)
        object.__setattr__(self, "moduli", tuple(map(float, moduli)))
        object.__setattr__(self, "times", tuple(map(float, times)))

    @classmethod
    def standard(cls, *, relaxed: float, unrelaxed: float, time: float, poisson: float) -> Self:
        r"""Return the standard solid, by its retardation time.

        .. math:: \frac{1}{E(\omega)} = \frac{1}{E_\infty} +
                  \Bigl(\frac{1}{E_0} - \frac{1}{E_\infty}\Bigr)\frac{1}{1 + i\omega\tau}

        Parameters
        ----------
        relaxed, unrelaxed : float
            E_0 < E_inf [Pa], at low and at high frequency.
        time : float
            Retardation time tau [s]; the relaxation time is tau E_0 / E_inf.
        """
        low, high = positive("relaxed", relaxed), positive("unrelaxed", unrelaxed)
        if high < low:
            raise InvalidInput(f"unrelaxed = {high!r} Pa: must not be below relaxed = {low!r} Pa")
        times = (positive("time", time) * (low / high),)
        return cls(relaxed=low, moduli=(high - low,), times=times, poisson=poisson)

    @property
    def unrelaxed(self) -> float:
        """E_inf [Pa], the modulus of a very fast strain."""
        return self.relaxed + math.fsum(self.moduli)

    def creep_compliance(self, time: ArrayLike) -> Array:
        r"""J(t) [1/Pa] at times t >= 0 [s]: the strain that a unit of stress leaves, from 1/E_inf to 1/E_0.

        Notes
        -----
        The stresses s_k of the terms obey
        :math:`\sum_j (\delta_{kj}/E_k + 1/E_0)\, s_j' = -s_k/(E_k \tau_k)`.
        """
        since = _not_negative("time", time)
        at_work = np.array(self.moduli) > 0
        share, decay = np.array(self.moduli)[at_work] / self.relaxed, np.array(self.times)[at_work]
        if not share.size:
            return np.full(since.shape, 1 / self.relaxed)
        rates, modes = scipy.linalg.eigh(np.diag(1 / (share * decay)), np.diag(1 / share) + 1.0)
        fading = np.exp(-np.multiply.outer(since, rates)) @ modes.sum(axis=0) ** 2
        return np.asarray((1 - fading) / self.relaxed)

    def modulus(self, frequency: ArrayLike) -> Complex:
        """E(omega) [Pa] for omega >= 0 [1/s]."""
        omega = _not_negative("frequency", frequency)
        total = np.full(omega.shape, complex(self.relaxed))
        for modulus, time in zip(self.moduli, self.times, strict=True):
            # Of the lesser of omega tau and its inverse, so that nothing overflows.
            turn = omega * time
            fast = turn > 1
            less = np.minimum(turn, 1 / np.maximum(turn, 1.0))
            stored = np.where(fast, 1.0, less * less) / (1 + less * less)
            total += modulus * (stored + 1j * less / (1 + less * less))
        return total


@dataclass(frozen=True, kw_only=True)
class TabulatedSolid:
    """A solid whose modulus was measured at a number of frequencies.

    Between them the logarithm of the storage modulus and the loss factor E''/E' are linear in the logarithm
    of the frequency. At frequency 0 the solid is elastic with the first storage modulus; elsewhere outside
    the table nothing is known, and asking is refused.

    Parameters
    ----------
    frequencies : sequence of float
        omega [1/s], positive and rising: 2 pi times the cycles per second.
    storage, loss : sequence of float
        E' and E'' [Pa] at them; E' positive, E'' not negative.
    poisson : float
        nu in (-1, 1/2].

    Examples
    --------
    >>> measured = TabulatedSolid(frequencies=[1, 100], storage=[1e6, 1e8], loss=[1e5, 3e7], poisson=0.5)
    >>> measured.modulus([10.0]).round()
    array([10000000.+2000000.j])
    """

    frequencies: Sequence[float]
    storage: Sequence[float]
    loss: Sequence[float]
    poisson: float

    def __post_init__(self) -> None:
        poisson_ratio(self.poisson)
        omega = samples("frequencies", self.frequencies, least=2)
        storage, loss = np.array(positives("storage", self.storage)), samples("loss", self.loss)
        if not omega.size == storage.size == loss.size:
            raise InvalidInput(
                f"frequencies, storage, loss: {omega.size}, {storage.size} and {loss.size} values: "
                "must be as many"
            )
        if not (omega[0] > 0 and np.all(np.diff(omega) > 0)):
            raise InvalidInput("frequencies: must be positive and rising, in 1/s")
        if loss.min() < 0:
            raise InvalidInput("loss: moduli must not be negative, in Pa")
        for name, values in (("frequencies", omega), ("storage", storage), ("loss", loss)):
            object.__setattr__(self, name, tuple(map(float, values)))

    def modulus(self, frequency: ArrayLike) -> Complex:
        """E(omega) [Pa] for omega >= 0 [1/s]; refused outside the table, 0 excepted."""
        omega = _not_negative("frequency", frequency)
        low, high = self.frequencies[0], self.frequencies[-1]
        given = omega[omega > 0]
        # Frequencies at the ends may have been rounded on their way here.
        if given.size and (given.min() < low * (1 - 1e-9) or given.max() > high * (1 + 1e-9)):
            raise InvalidInput(
                f"frequencies from {given.min():.4g} to {given.max():.4g} 1/s are asked for, the table spans "
                f"{low:.4g} to {high:.4g} 1/s: choose another velocity or grid, or extend the table"
            )
        nodes, storage = np.log(self.frequencies), np.log(self.storage)
        factor = np.divide(self.loss, self.storage)
        at = np.log(np.where(omega > 0, omega, low))
        storage_at = np.exp(np.interp(at, nodes, storage))
        lag = np.where(omega > 0, np.interp(at, nodes, factor), 0.0)
        return np.asarray(storage_at * (1 + 1j * lag))


def _not_negative(name: str, value: ArrayLike) -> Array:
    values = array(name, value, power=2)
    if values.size and values.min() < 0:
        raise InvalidInput(f"{name} = {float(values.min())!r} {UNITS[name]}: must not be negative")
    return values


def check_viscoelastic(solid: object) -> None:
    """Raise InvalidInput for what is no viscoelastic solid, or has a Poisson ratio of none."""
    what = "a viscoelastic solid, such as `PronySolid`, with `modulus` and `poisson`"
    instance("solid", solid, ViscoelasticSolid, what=what)
    poisson_ratio(getattr(solid, "poisson", None))
