"""Where adhesive contact ends: pull-off, and the roughness that kills adhesion (Persson 2006, Sec. 8)."""

import math
from collections.abc import Callable
from typing import Protocol, Self

from persson._checks import Array, function, instance, within
from persson.adhesion import AdhesionStatus, Interface, solve_adhesion
from persson.errors import OutsideTheory
from persson.scale import Scale
from persson.spectrum import Spectrum, check_sample, check_spectrum


class ScalableSpectrum(Spectrum, Protocol):
    """A spectrum that can be made rougher or smoother."""

    def scaled(self, factor: float) -> Self:
        """Return the spectrum times `factor`."""


def pull_off_stress(scale: Scale, *, interface: Interface, tolerance: float = 1e-3) -> float:
    """Largest nominal tension [Pa], as a positive number, at which contact still exists; 0 without adhesion.

    Bisection between no load and the detachment stress of the macroscopic interface, each tension reached
    from the largest one that held; to `tolerance` relative to that detachment stress.

    Examples
    --------
    >>> from persson.spectrum import SelfAffine
    >>> rough = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=1e5, q_short=1e8)
    >>> stiff = Scale(rough, contact_modulus=1e11)
    >>> pull_off_stress(stiff, interface=Interface(work_of_adhesion=0.05))
    0.0
    """
    instance("scale", scale, Scale)
    instance("interface", interface, Interface)
    within("tolerance", tolerance, "[1e-12, 0.5]")
    check_sample(scale.spectrum, "the size L of the sample sets the pull-off stress")
    held = solve_adhesion(scale, pressure=0.0, interface=interface)
    if held.status is AdhesionStatus.NO_CONTACT:
        return 0.0
    low, high = 0.0, float(held.tensile_limit[0])
    span = high
    while high - low > tolerance * span:
        middle = 0.5 * (low + high)
        state = solve_adhesion(scale, pressure=-middle, interface=interface, start=held)
        if state.status is AdhesionStatus.CONVERGED:
            low, held = middle, state
        else:
            high = middle
    return low


def critical_roughness(
    spectrum: ScalableSpectrum,
    *,
    contact_modulus: float | Callable[[Array], Array],
    interface: Interface,
    tolerance: float = 2e-3,
) -> float:
    """Factor on the heights of a surface at which contact without load, and with it adhesion, is lost.

    Parameters
    ----------
    spectrum : Spectrum
        C(q) at factor 1; the factor r stands for ``spectrum.scaled(r**2)``.
    contact_modulus : float or callable
        As for `persson.scale.Scale`.
    interface : Interface
        Work of adhesion and the reading of the theory.
    tolerance : float
        Relative width at which bisection stops, at least 1e-6: seconds to 1e-4, a minute to 1e-6, since two
        branches meet there and the rounds that tell them apart grow like one over the root of the distance.

    Raises
    ------
    OutsideTheory
        Where adhesion survives, or fails, at every factor between 1e-6 and 1e6.

    Notes
    -----
    Persson 2006, Secs. 8.3 and 10.2: the macroscopic gamma_eff(1) left by a load that is taken away vanishes
    there.
    """
    check_spectrum(spectrum)
    function("spectrum.scaled", getattr(spectrum, "scaled", None))
    instance("interface", interface, Interface)
    accuracy = within("tolerance", tolerance, "[1e-6, 1]")

    def sticks(factor: float) -> bool:
        scale = Scale(spectrum.scaled(factor * factor), contact_modulus=contact_modulus)
        state = solve_adhesion(scale, pressure=0.0, interface=interface, rounds=20_000)
        return state.checked().real_area > 0

    low = high = 1.0
    step = 4.0 if sticks(1.0) else 0.25
    while sticks(high if step > 1 else low) == (step > 1):
        low, high = (high, high * step) if step > 1 else (low * step, low)
        if not 1e-6 < low <= high < 1e6:
            raise OutsideTheory("adhesion does not change between 1e-6 and 1e6 of the roughness")
    while high / low > 1 + accuracy:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if sticks(middle) else (low, middle)
    return math.sqrt(low * high)
