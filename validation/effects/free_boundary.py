"""One patch is pressed on a half-space, without images; the body may be curved as a whole."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, Self

import numpy as np

from fem_contact.response import FreeHalfSpace
from fem_contact.surface import HeightField, Patch
from validation.arrays import Grid
from validation.effects.base import ContactModel, Effect, Judgement, Roughness
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.units import Length, key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem


class FreeBoundary(Effect):
    """The rough body is one patch with free surroundings, flat or curved as a whole: nothing is periodic."""

    kind: Literal["free-boundary"] = "free-boundary"
    radius: Length | None = key(
        'nominal radius of a ball under the roughness, e.g. "1 mm"; default: flat', None
    )

    slot = "boundary"
    meshed = False
    cost = 6.0
    papers = ("Cells under constant pressure: [love1929].",)

    def fill(self, model: ContactModel) -> None:
        """Give the half-space without images."""
        model.response = FreeHalfSpace(solid=model.solid)

    def shaped(self, field: HeightField) -> HeightField:
        """Lay the roughness on a paraboloid whose apex is the middle of the patch."""
        if self.radius is None:
            return field
        # Points of a patch are the middles of its cells.
        half = 0.5 if isinstance(field, Patch) else 0.0
        x, y = (
            (np.arange(n) + half - n / 2) * step for n, step in zip(field.shape, field.spacing, strict=True)
        )
        sag = (x[:, None] ** 2 + y[None, :] ** 2) / (2 * self.radius)
        return type(field)(heights=field.heights - sag, lengths=field.lengths)

    def check(self, problem: ContactProblem, grids: Sequence[Grid], *, model: ContactModel, key: str) -> None:
        """Refuse attraction, layers, a distance that is held, and a ball that would not fit on the patch."""
        if model.gap_law is not None or not isinstance(model.response, FreeHalfSpace):
            other = "adhesion" if model.gap_law is not None else "a layer or graded solid"
            raise UsageError(f"{key} kind = {self.kind!r}: is not solved together with {other}")
        if problem.load.held:
            raise UsageError(
                f"load.{problem.load.key}: a patch with free surroundings is pressed by a load; give "
                "pressure, reduced_pressure or force"
            )
        if self.radius is None:
            return
        force = problem.pressure * problem.lengths[0] * problem.lengths[1]
        contact = (3 * force * self.radius / (4 * problem.contact_modulus)) ** (1 / 3)
        touches = f"the ball would touch over {as_length(contact, 3)} (Hertz)"
        if contact > self.radius:
            raise UsageError(
                f"{key} radius = {as_length(self.radius)}: {touches}, where no paraboloid is a ball; take a "
                "larger radius or a smaller load"
            )
        edge = 0.5 * min(problem.lengths)
        if contact > edge:
            raise UsageError(
                f"{key} radius = {as_length(self.radius)}: {touches}, beyond the edge of the patch, "
                f"{as_length(edge, 3)} from its middle; take a larger patch or a smaller load"
            )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the nominal curvature with that of the roughness; an edge always matters."""
        if self.radius is None:
            return self.judgement("no images: the edges of the patch bear, too", matters=True)
        ratio = 1 / (self.radius * rough.curvature) if rough.curvature > 0 else math.inf
        return self.judgement(
            f"1/R over the rms curvature of a profile = {ratio:.3g}; no images", matters=True
        )

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a ball."""
        return cls(radius=2.0)
