"""Persson's theory for scenes that yield or adhere; loaded only for a scene that lists one of the two."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from persson.errors import PerssonError
from validation.effects.tables import Adhesion, EffectSpec, HardnessEffect

if TYPE_CHECKING:
    from persson.spectrum import SelfAffine
    from persson.tabulated import Tabulated

__all__ = ["TheoryAreas", "predicted", "words"]

Modulus = float | Callable[[Any], NDArray[np.float64]]


@dataclass(frozen=True, kw_only=True)
class TheoryAreas:
    """What the theory says at one load.

    Attributes
    ----------
    area : float
        A/A0, yielded contact included; NaN where the theory has no answer.
    plastic : float or None
        A_pl/A0, with hardness.
    other : float or None
        A/A0 with the other reading of the elastic energy ("old", Eq. 43), with adhesion.
    note : str
        Which part of the theory it is, or why there is no answer.
    """

    area: float
    plastic: float | None
    other: float | None
    note: str


def words(effects: Sequence[EffectSpec]) -> str:
    """Name the part of the theory that a scene's effects call for.

    >>> words([])
    'Persson 2006, elastic, without adhesion'
    """
    kinds = {effect.kind for effect in effects}
    match ("adhesion" in kinds, "hardness" in kinds):
        case (True, True):
            return "Persson 2006, Sec. 9: adhesion (energy of Eqs. 44-49, no range) with a hardness"
        case (True, False):
            return "Persson 2006, Sec. 8: adhesion (energy of Eqs. 44-49, no range)"
        case (False, True):
            return "Persson 2006, Sec. 6: one hardness, in closed form"
    return "Persson 2006, elastic, without adhesion"


def predicted(
    effects: Sequence[EffectSpec],
    pressure: float,
    *,
    variance: float,
    spectrum: SelfAffine | Tabulated,
    modulus: Modulus,
) -> TheoryAreas:
    """Evaluate the theory with the hardness and the adhesion among some effects.

    Parameters
    ----------
    effects : sequence
        Of which one is a hardness or adhesion; layers and grading are in `variance` and `modulus`.
    pressure : float
        p0 [Pa].
    variance : float
        Stress variance at full contact [Pa^2].
    spectrum : SelfAffine or Tabulated
        C(q) with that variance.
    modulus : float or callable
        E* [Pa], or what each wave feels.
    """
    hard = next((effect.hardness for effect in effects if isinstance(effect, HardnessEffect)), None)
    sticky = next((effect for effect in effects if isinstance(effect, Adhesion)), None)
    note = words(effects)
    try:
        if sticky is None:
            from persson.hardness import constant_hardness

            assert hard is not None
            parts = constant_hardness(pressure, stress_variance=variance, yield_stress=hard)
            plastic = float(parts.plastic)
            return TheoryAreas(area=float(parts.elastic) + plastic, plastic=plastic, other=None, note=note)
        improved = _adhesive(sticky, hard, pressure, spectrum=spectrum, modulus=modulus, energy="improved")
    except PerssonError as error:
        return TheoryAreas(area=float("nan"), plastic=None, other=None, note=f"no answer: {error}")
    try:
        old = _adhesive(sticky, hard, pressure, spectrum=spectrum, modulus=modulus, energy="old")[0]
    except PerssonError:
        old = float("nan")
    plastic_area = None if hard is None else improved[1]
    return TheoryAreas(area=improved[0], plastic=plastic_area, other=old, note=note)


def _adhesive(
    effect: Adhesion,
    hardness: float | None,
    pressure: float,
    *,
    spectrum: SelfAffine | Tabulated,
    modulus: Modulus,
    energy: Literal["improved", "old"],
) -> tuple[float, float]:
    """Relative area, and the yielded part of it."""
    from persson.adhesion import Interface, solve_adhesion
    from persson.scale import Scale

    found = solve_adhesion(
        Scale(spectrum, contact_modulus=modulus),
        pressure=pressure,
        interface=Interface(work_of_adhesion=effect.work, energy=energy),
        yield_stress=hardness,
    ).checked()
    return found.real_area, float(found.area_plastic[-1])
