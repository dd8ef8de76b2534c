"""A layer on a rigid base."""

import math
from typing import Literal, Self

from fem_contact.response import BondedLayer, FrictionlessLayer
from validation.effects.base import Body, ContactModel, Effect, Judgement, Roughness
from validation.report.quantities import as_length
from validation.units import Length, key

#: q_long d beyond which a rigid base changes the compliance by less than a tenth of a percent.
_DEEP = 8.0


class Thickness(Effect):
    """The solid is a layer on a rigid base."""

    kind: Literal["thickness"] = "thickness"
    thickness: Length = key('thickness of the layer, e.g. "20 um"')
    base: Literal["bonded", "frictionless"] = key(
        "whether the layer sticks to its rigid base or slides on it", "bonded"
    )

    slot = "response"
    papers = ("Layer on a rigid base: K. L. Johnson, Contact Mechanics (Cambridge, 1985), Sec. 5.8.",)

    def fill(self, model: ContactModel) -> None:
        """Give the compliance of the layer; a mesh is clamped, so that only a bonded layer is a body."""
        kind = BondedLayer if self.base == "bonded" else FrictionlessLayer
        model.response = kind(solid=model.solid, thickness=self.thickness)
        model.body = Body(depth=self.thickness) if self.base == "bonded" else None

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the thickness with the longest wave."""
        deep = 2 * math.pi * self.thickness / rough.longest
        return self.judgement(f"q_long d = {deep:.3g} (bonded layer, Johnson 1985)", matters=deep < _DEEP)

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement:
        """Name the thickness above which the base is not felt."""
        deep = _DEEP * rough.longest / (2 * math.pi)
        return cls.unknown(
            f"longest wave {as_length(rough.longest, 4)}",
            f"a thickness; negligible above {as_length(deep, 3)}",
        )

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a thin layer."""
        return cls(thickness=0.1)
