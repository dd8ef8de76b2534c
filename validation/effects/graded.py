"""A modulus that relaxes with depth."""

import math
from functools import partial
from typing import Literal, Self

import numpy as np

from validation.arrays import Array
from validation.effects.base import Body, ContactModel, Effect, Judgement, Roughness, TheoryInputs
from validation.units import Length, Pressure, key


def _relaxing(ratio: float, depth: float, x: Array, y: Array, z: Array) -> Array:
    """E(z) over that of the surface, at cell centres."""
    return ratio + (1 - ratio) * np.exp(z / depth)


class Graded(Effect):
    """The modulus relaxes exponentially from that of the solid at the surface to another one below."""

    kind: Literal["graded"] = "graded"
    bulk_young: Pressure = key('Young\'s modulus far below the surface, e.g. "3 GPa"')
    depth: Length = key('depth over which it relaxes, e.g. "5 um"')

    slot = "response"
    cost = 6.1
    since = "2026-11-29"
    papers = (
        "Graded half-space, solved: [giannakopoulos1997].",
        "Modulus that varies with depth, theory: [persson2006], Sec. 5.",
    )

    def fill(self, model: ContactModel) -> None:
        """Give the compliance of the graded half-space, and its profile for a mesh."""
        from fem_contact.graded import ExponentialSolid

        model.response = ExponentialSolid(surface=model.solid, bulk_young=self.bulk_young, depth=self.depth)
        model.body = Body(modulus=partial(_relaxing, self.bulk_young / model.solid.young, self.depth))

    def theory(self, inputs: TheoryInputs) -> None:
        """Persson 2006, Sec. 5."""
        from persson.graded import ExponentialLayers

        inputs.modulus = ExponentialLayers(
            bulk=self.bulk_young,
            excess=[inputs.solid.young - self.bulk_young],
            depths=[self.depth],
            poisson=inputs.solid.poisson,
        )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the depth with the longest wave."""
        wave = 2 * math.pi * self.depth / rough.longest
        number = (
            f"q_long d = {wave:.3g}: the longest wave feels the profile where it is below 100; "
            "theory wants max E'/(E q) < 1 (Persson 2006, Sec. 5)"
        )
        return self.judgement(number, matters=wave < 100)

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement:
        """Without a profile there is nothing to judge."""
        return cls.unknown("E(z) constant", "a profile of the modulus")

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a stiffer bulk."""
        return cls(bulk_young=3.0, depth=0.05)
