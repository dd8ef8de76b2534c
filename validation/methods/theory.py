"""Persson's theory: with the realised gradient of a surface, and from C(q) alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from fem_contact.surface import HeightField
from persson import elastic
from persson.errors import PerssonError
from validation.effects.base import Effect, Told, effect_key
from validation.errors import UsageError
from validation.methods.base import Method
from validation.report.words import json_ready
from validation.units import Table

if TYPE_CHECKING:
    from persson.spectrum import SelfAffine
    from persson.tabulated import Tabulated
    from validation.scenes.realised import Realised

__all__ = ["Areas", "Prediction", "Theory", "TheoryOptions", "predict", "theory_words", "with_effects"]

Array = NDArray[np.float64]
Modulus = float | Callable[[Any], Array]


class TheoryOptions(Table):
    """Persson's theory; it has no settings."""


class Theory(Method):
    """Persson's theory."""

    name = "theory"
    label = "Persson"
    options: ClassVar[type[Table]] = TheoryOptions
    papers = ("Theory: B. N. J. Persson, Surf. Sci. Rep. 61, 201 (2006); J. Chem. Phys. 115, 3840 (2001).",)

    def handles(self, effect: type[Effect]) -> bool:
        """Whether the effect tells the theory anything."""
        return effect.has_theory()

    def check(self, options: Any, realised: Realised, effects: Sequence[Effect]) -> None:
        """Refuse an effect with parameters that the theory does not know."""
        for k, effect in enumerate(effects):
            try:
                effect.theory(Told(solid=realised.elastic))
            except UsageError as error:
                raise UsageError(f"{effect_key(k, '')} {error}") from None


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """What the theory says of one surface of a scene.

    Attributes
    ----------
    area : float
        A/A0 conditional on the realised gradient of this surface, yielded contact included; NaN where the
        theory has no answer.
    ensemble_area : float or None
        A/A0 from C(q) alone; None where there is no C(q).
    stress_variance : float
        V [Pa^2] of the realised surface at full contact.
    plastic : float or None
        A_pl/A0 with a hardness.
    other : float or None
        A/A0 with the other reading of the elastic energy (Eq. 43), with adhesion.
    note : str
        Which part of the theory, where it is not that of elastic contact without adhesion; or why `area` is
        NaN.
    """

    area: float
    ensemble_area: float | None
    stress_variance: float
    plastic: float | None = None
    other: float | None = None
    note: str = ""

    @property
    def answers(self) -> bool:
        """Whether the theory has an answer."""
        return bool(np.isfinite(self.area))

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON-ready data, null where there is no answer."""
        return json_ready(asdict(self))


def predict(realised: Realised, effects: Sequence[Effect]) -> Prediction:
    """Return what the theory says of one surface with the effects of its scene."""
    told = Told.by(realised.elastic, effects)
    variance = _realised_variance(realised, told)
    spectrum = realised.spectrum
    alone = None if spectrum is None else _spectral_variance(spectrum, told.felt_modulus)
    if told.hardness is None and told.work is None:
        ensemble = (
            None if alone is None else float(elastic.contact_area(realised.pressure, stress_variance=alone))
        )
        area = float(elastic.contact_area(realised.pressure, stress_variance=variance))
        return Prediction(area=area, ensemble_area=ensemble, stress_variance=variance)
    ensemble = None
    if spectrum is not None and alone is not None:
        found = with_effects(told, realised.pressure, variance=alone, spectrum=spectrum)
        ensemble = found.area if np.isfinite(found.area) else None
    shape = realised.spectrum_shape
    own = shape.scaled(float(realised.field.rms_gradient**2 / shape.m2()))
    found = with_effects(told, realised.pressure, variance=variance, spectrum=own)
    return Prediction(
        area=found.area,
        ensemble_area=ensemble,
        stress_variance=variance,
        plastic=found.plastic,
        other=found.other,
        note=found.note,
    )


def _realised_variance(realised: Realised, told: Told) -> float:
    """Full-contact stress variance of the surface [Pa^2], on a solid whose modulus may depend on the wave."""
    if told.modulus is None:
        return float(
            elastic.stress_variance(realised.field.moments[1], contact_modulus=realised.contact_modulus)
        )
    return _summed_variance(realised.field, told.modulus)


def _summed_variance(field: HeightField, modulus: Callable[[Any], Array]) -> float:
    nx, ny = field.shape
    power = np.abs(np.fft.fft2(field.heights, norm="forward")) ** 2
    qx = 2 * np.pi * np.fft.fftfreq(nx, field.lengths[0] / nx)
    qy = 2 * np.pi * np.fft.fftfreq(ny, field.lengths[1] / ny)
    q = np.hypot(qx[:, None], qy[None, :])
    felt = np.zeros(q.shape)
    felt[q > 0] = modulus(q[q > 0])
    return float(np.sum((felt * q / 2) ** 2 * power))


def _spectral_variance(spectrum: SelfAffine | Tabulated, modulus: Modulus) -> float:
    """Full-contact stress variance of C(q) [Pa^2], on a solid whose modulus may depend on the wave."""
    if not callable(modulus):
        return float(elastic.stress_variance(spectrum.m2(), contact_modulus=modulus))
    from persson.scale import Scale

    scale = Scale(spectrum, contact_modulus=modulus)
    return float(scale.variance(scale.q_short))


@dataclass(frozen=True, kw_only=True)
class Areas:
    """A/A0 (NaN without an answer), A_pl/A0, A/A0 by the other energy, which part of the theory it is."""

    area: float
    plastic: float | None
    other: float | None
    note: str


def theory_words(told: Told) -> str:
    """Name the part of the theory that effects call for.

    >>> from fem_contact.solid import Solid
    >>> theory_words(Told(solid=Solid(young=1e9, poisson=0.3)))
    'Persson 2006, elastic, without adhesion'
    """
    match (told.work is not None, told.hardness is not None):
        case (True, True):
            return "Persson 2006, Sec. 9: adhesion (energy of Eqs. 44-49, no range) with a hardness"
        case (True, False):
            return "Persson 2006, Sec. 8: adhesion (energy of Eqs. 44-49, no range)"
        case (False, True):
            return "Persson 2006, Sec. 6: one hardness, in closed form"
    return "Persson 2006, elastic, without adhesion"


def with_effects(told: Told, pressure: float, *, variance: float, spectrum: SelfAffine | Tabulated) -> Areas:
    """Evaluate the theory with a hardness, adhesion, or both."""
    note = theory_words(told)
    try:
        if told.work is None:
            from persson.hardness import constant_hardness

            assert isinstance(told.hardness, float)
            parts = constant_hardness(pressure, stress_variance=variance, yield_stress=told.hardness)
            plastic = float(parts.plastic)
            return Areas(area=float(parts.elastic) + plastic, plastic=plastic, other=None, note=note)
        improved = _adhesive(told, pressure, spectrum=spectrum, energy="improved")
    except PerssonError as error:
        return Areas(area=float("nan"), plastic=None, other=None, note=f"no answer: {error}")
    try:
        old = _adhesive(told, pressure, spectrum=spectrum, energy="old")[0]
    except PerssonError:
        old = float("nan")
    plastic_area = None if told.hardness is None else improved[1]
    return Areas(area=improved[0], plastic=plastic_area, other=old, note=note)


def _adhesive(
    told: Told,
    pressure: float,
    *,
    spectrum: SelfAffine | Tabulated,
    energy: Literal["improved", "old"],
) -> tuple[float, float]:
    """Relative area, and the yielded part of it."""
    from persson.adhesion import Interface, solve_adhesion
    from persson.scale import Scale

    assert told.work is not None
    found = solve_adhesion(
        Scale(spectrum, contact_modulus=told.felt_modulus),
        pressure=pressure,
        interface=Interface(work_of_adhesion=told.work, energy=energy),
        yield_stress=told.hardness,
    ).checked()
    return found.real_area, float(found.area_plastic[-1])
