"""Plastic yielding at a hardness, which may rise towards short waves and small patches."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from validation.arrays import Array, Grid
from validation.effects.base import ContactModel, Effect, Judgement, Roughness, TheoryInputs
from validation.errors import UsageError
from validation.report.quantities import as_length, in_prefixed_unit
from validation.units import Length, Number, Pressure, key, wrong

if TYPE_CHECKING:
    from collections.abc import Sequence

    from validation.scenes.problem import ContactProblem

#: Solvers that know a hardness by the size of a patch.
_BY_SIZE = ("bem", "fem")

#: Standard deviations of the full-contact stress beyond which points that yield are rare.
RARE = 4.0


class Hardness(Effect):
    """The solid yields where the pressure reaches its hardness: 0 <= p <= H."""

    kind: Literal["hardness"] = "hardness"
    hardness: Pressure = key('indentation hardness H, e.g. "2 GPa"')
    size_wavelength: Length | None = key(
        "length l below which it rises, as H (1 + l/lambda)^size_exponent: lambda is that of a "
        "wave in the theory, the diameter of a patch of contact in solvers",
        None,
    )
    size_exponent: Number | None = key(
        "how fast it rises towards short waves, in [0, 2], e.g. 0.5", None, ge=0, le=2
    )

    slot = "pressure bound"
    cost = 1.4
    papers = ("Hardness as a bound of the pressure: [almqvist2007].",)

    @property
    def solves(self) -> float:  # type: ignore[override]
        """One, or the three to eight until every patch bears what its size allows."""
        return 1.0 if self.size_wavelength is None else 5.0

    @model_validator(mode="after")
    def _both_or_neither(self) -> Self:
        if (self.size_wavelength is None) != (self.size_exponent is None):
            raise wrong("give both 'size_wavelength' and 'size_exponent', or neither")
        return self

    def fill(self, model: ContactModel) -> None:
        """Bound the pressure."""
        model.pressure_bound = self.hardness
        if self.size_wavelength is not None:
            from fem_contact import hardness

            model.patch_hardness = hardness.Hardness(
                pressure=self.hardness, length=self.size_wavelength, exponent=self.size_exponent or 0.0
            )

    def theory(self, inputs: TheoryInputs) -> None:
        """Persson 2006, Sec. 6; Eqs. 33 and 34 where it rises towards short waves."""
        inputs.hardness = self.hardness if self.size_wavelength is None else self._at

    def _at(self, q: Array) -> Array:
        """Hardness [Pa] that waves of wavevector q [1/m] meet."""
        assert self.size_wavelength is not None
        assert self.size_exponent is not None
        start = 2 * math.pi / self.size_wavelength
        return self.hardness * (1 + q / start) ** self.size_exponent

    def check_solver(self, name: str, *, key: str) -> None:
        """Refuse a hardness that depends on the size of what is pressed in."""
        if self.size_wavelength is not None and name not in _BY_SIZE:
            raise UsageError(
                f"{key} size_wavelength = {as_length(self.size_wavelength)}: method {name!r} knows one "
                f"hardness for all sizes; handled by: {', '.join(_BY_SIZE)}, theory"
            )

    def check(self, problem: ContactProblem, grids: Sequence[Grid], *, model: ContactModel, key: str) -> None:
        """Refuse a hardness below the nominal pressure, and one by size with adhesion or at a distance."""
        if self.size_wavelength is not None and (problem.load.held or model.gap_law is not None):
            why = "adhesion" if model.gap_law is not None else problem.load.key
            raise UsageError(
                f"{key} size_wavelength = {as_length(self.size_wavelength)}: does not go with {why}"
            )
        if not problem.load.held and self.hardness < problem.pressure:
            raise UsageError(
                f"{key} hardness = {in_prefixed_unit(self.hardness, 'Pa', 6)}: must not be below the nominal "
                f"pressure {in_prefixed_unit(problem.pressure, 'Pa', 6)}, or nothing carries the load"
            )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the spread of the stress with the hardness."""
        ratio = rough.modulus * rough.gradient / self.hardness
        number = (
            f"E* h'_rms / H = {ratio:.3g} (stress spread at full contact is half of it; Persson 2006, Sec. 6)"
        )
        return self.judgement(number, matters=ratio / 2 > 1 / RARE)

    @classmethod
    def unlisted(cls, rough: Roughness) -> Judgement:
        """Name the hardness above which yielding is rare."""
        scale = rough.modulus * rough.gradient
        return cls.unknown(
            f"E* h'_rms = {in_prefixed_unit(scale, 'Pa')} (Persson 2006, Sec. 6)",
            f"a hardness; negligible above {in_prefixed_unit(RARE / 2 * scale, 'Pa', 3)}",
        )

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a hardness that yields a part of the contact."""
        return cls(hardness=0.06)
