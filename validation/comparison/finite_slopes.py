"""What finite slopes change, as the study large-slope measured it, read off for a scene."""

from __future__ import annotations

import numpy as np

from validation.effects.base import Judgement, Roughness

#: Differences of contact area and of rms pressure from the linear ones per h'_rms, by Poisson ratio: mean of
#: p* = .05 and .2 up to h'_rms = .4 over four surfaces, by `fem-contact study large-slope` for nu = .3 and
#: with 8 points per shortest wave for the others (docs/block.md). Either load is a third off the mean.
_POISSONS = (0.0, 0.3, 0.45, 0.49)
_AREA = (-0.30, -0.12, -0.01, 0.03)
_RMS_PRESSURE = (0.27, 0.115, 0.01, -0.03)

#: What is left over h'_rms^2 where the first order vanishes: 3 % at nu = .45 and slopes of .7.
_SECOND_ORDER = 0.06

#: Largest relative difference that is called negligible.
_NEGLIGIBLE = 0.02


def finite_slopes(rough: Roughness, *, poisson: float) -> Judgement:
    """Say whether the slopes are too large for linear elasticity.

    Both differences go with the slope to first order and vanish near nu = .45: the surface of a compressible
    solid is drawn into the contact, and meets the profile elsewhere than the linear one does.
    """
    slope = rough.gradient
    area, pressure = (slope * float(np.interp(poisson, _POISSONS, rates)) for rates in (_AREA, _RMS_PRESSURE))
    matters = max(abs(area), abs(pressure)) + _SECOND_ORDER * slope**2 > _NEGLIGIBLE
    return Judgement(
        effect="finite slopes",
        number=f"h'_rms = {slope:.2g} changes the contact area by about {100 * area:+.1g} % and the rms "
        f"pressure by {100 * pressure:+.1g} % (measured on a neo-Hookean block, nu = {poisson:.3g})",
        verdict="matters: every method here is linear in the slope" if matters else "negligible",
    )
