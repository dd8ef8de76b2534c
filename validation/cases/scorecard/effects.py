"""Solids that are no elastic half-space, for solvers that can be given them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fem_contact.surface import HeightField
from validation.cases import Check
from validation.cases._closed_forms import westergaard_mean_pressure, westergaard_pressure
from validation.cases.scorecard.elementary import WAVES, full_contact_transfer
from validation.cases.scorecard.subject import SOFT, Subject
from validation.effects.base import Effect, Slots
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness

__all__ = ["NEEDED", "layer", "yielding"]

#: Rows and the effects that a solver must be able to be given.
NEEDED: dict[str, type[Effect]] = {"layer": Thickness, "yielding-wave": Hardness}

_THICKNESS = 0.25
#: Half of the width that stays elastic, over the period, and the amplitude.
_HALF_WIDTH, _AMPLITUDE = 0.3, 0.01


def layer(subject: Subject) -> Sequence[Check]:
    """Press waves flat on a layer a quarter of the period thick, bonded to its base."""
    slots = Slots.filled(SOFT, [Thickness(thickness=_THICKNESS)])
    found = full_contact_transfer(subject, slots=slots)
    return [
        Check.below(f"error of the pressure of the wave ({kx}, {ky})", abs(ratio - 1), float(allowed))
        for (kx, ky, *_), ratio, allowed in zip(WAVES, found.ratio, found.allowed, strict=True)
    ]


def yielding(subject: Subject) -> Sequence[Check]:
    """Press a wave whose crests yield: H - p is Westergaard's pressure under the troughs."""
    n = 2 * subject.ladder[-1]
    x = (np.arange(n) + 0.5) / n - 0.5
    heights = -_AMPLITUDE * np.cos(2 * np.pi * x)[:, None] * np.ones(4)
    surface = HeightField(heights=heights, lengths=(1.0, 4 / n))
    short = westergaard_mean_pressure(_AMPLITUDE, half_width=_HALF_WIDTH)
    missing = westergaard_pressure(x, half_width=_HALF_WIDTH, mean_pressure=short)
    # Twice what the troughs lack: they stay pressed.
    hardness = 2 * float(missing.max())
    slots = Slots.filled(SOFT, [Hardness(hardness=hardness)])
    found = subject.press(surface, hardness - short, slots=slots)
    inside = np.abs(x) < 0.9 * _HALF_WIDTH
    lacks = hardness - found.claim.pressure[:, 1]
    width = float(np.mean(found.result.at_bound[:, 1]))
    return [
        Check.below(
            "mean error of H - p(x) over its peak, inside",
            float(np.abs(lacks - missing)[inside].mean() / missing.max()),
            0.01,
        ),
        Check.near("yielded width", width, 1 - 2 * _HALF_WIDTH, 2 / n),
        Check.below(
            "largest pressure above H, over H",
            max(float(found.claim.pressure.max()) / hardness - 1, 0.0),
            10 * subject.tolerance,
        ),
    ]
