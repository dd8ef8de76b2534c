"""Plastic yielding at a constant hardness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal, Self

from pydantic import Field

from validation.effects.base import Effect, Grid, Judgement, Roughness, SlotName, Slots, Told
from validation.errors import UsageError
from validation.units import Pressure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from validation.scenes.realised import Realised

__all__ = ["Hardness"]

#: Standard deviations of the full-contact stress beyond which points that yield are rare.
_RARE = 4.0


class Hardness(Effect):
    """The solid yields where the pressure reaches its hardness: 0 <= p <= H."""

    kind: Literal["hardness"] = "hardness"
    hardness: Pressure = Field(description='indentation hardness H, e.g. "2 GPa"')

    slot: ClassVar[SlotName] = "pressure bound"
    cost: ClassVar[float] = 1.4
    papers: ClassVar[tuple[str, ...]] = (
        "Hardness as a bound of the pressure: A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, "
        "Tribol. Int. 40, 574 (2007).",
    )

    def fill(self, slots: Slots) -> None:
        """Bound the pressure."""
        slots.pressure_bound = self.hardness

    def theory(self, told: Told) -> None:
        """Persson 2006, Sec. 6."""
        told.hardness = self.hardness

    def check(self, realised: Realised, grids: Sequence[Grid], *, slots: Slots, key: str) -> None:
        """Refuse a hardness below the nominal pressure."""
        if self.hardness < realised.pressure:
            raise UsageError(
                f"{key} hardness = {self.hardness:.6g} Pa: must not be below the nominal pressure "
                f"{realised.pressure:.6g} Pa, or nothing carries the load"
            )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the spread of the stress with the hardness."""
        ratio = rough.modulus * rough.gradient / self.hardness
        number = (
            f"E* h'_rms / H = {ratio:.3g} (stress spread at full contact is half of it; Persson 2006, Sec. 6)"
        )
        return self.said(number, matters=ratio / 2 > 1 / _RARE)

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement:
        """Name the hardness above which yielding is rare."""
        scale = rough.modulus * rough.gradient
        return cls.unknown(
            f"E* h'_rms = {scale:.4g} Pa (Persson 2006, Sec. 6)",
            f"a hardness; negligible above {_RARE / 2 * scale:.3g} Pa",
        )

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a hardness that yields a part of the contact."""
        return cls(hardness=0.06)
