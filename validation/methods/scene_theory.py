"""Persson's theory for one surface of a scene, with the realised gradient and from C(q) alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from persson import elastic
from validation.report.words import json_ready
from validation.scenes.scene import FileSurface, Scene, SelfAffineSurface
from validation.scenes.surfaces import measured_spectrum, spectrum_of

if TYPE_CHECKING:
    from persson.spectrum import SelfAffine
    from persson.tabulated import Tabulated

__all__ = ["Theory", "theory_of"]


@dataclass(frozen=True, kw_only=True)
class Theory:
    """Persson's theory for the scene.

    Attributes
    ----------
    area : float
        A/A0 conditional on the realised gradient of this surface.
    ensemble_area : float or None
        A/A0 from C(q) alone; None for a surface read from a file.
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


def theory_of(scene: Scene, field: HeightField, pressure: float, modulus: float) -> Theory | None:
    """Return the theory for one surface of a scene; None unless the scene asks for it."""
    if scene.methods.theory is None:
        return None
    variance = float(elastic.stress_variance(field.moments[1], contact_modulus=modulus))
    felt = None
    if scene.effects:
        from validation.methods.slots import theory_modulus, theory_variance

        felt = theory_modulus(Solid(**scene.solid.model_dump()), scene.effects)
        variance = variance if felt is None else theory_variance(field, felt)
    ensemble = None
    spectrum: SelfAffine | Tabulated | None = None
    if isinstance(scene.surface, SelfAffineSurface):
        spectrum = spectrum_of(scene.surface)
    elif scene.surface.edges in ("tukey", "hann"):
        spectrum = measured_spectrum(scene.surface)
    if any(effect.kind in ("hardness", "adhesion") for effect in scene.effects):
        return _theory_of_effects(
            scene, field, pressure, modulus=felt or modulus, variance=variance, spectrum=spectrum
        )
    if spectrum is not None:
        from_spectrum = _spectral_variance(spectrum, felt or modulus)
        ensemble = float(elastic.contact_area(pressure, stress_variance=from_spectrum))
    return Theory(
        area=float(elastic.contact_area(pressure, stress_variance=variance)),
        ensemble_area=ensemble,
        stress_variance=variance,
    )


def _theory_of_effects(
    scene: Scene,
    field: HeightField,
    pressure: float,
    *,
    modulus: float | Callable[[Any], NDArray[np.float64]],
    variance: float,
    spectrum: SelfAffine | Tabulated | None,
) -> Theory:
    """Theory of a scene that yields or adheres, with the realised gradient and from C(q) alone."""
    from validation.methods.effect_theory import predicted

    ensemble = None
    if spectrum is not None:
        alone = _spectral_variance(spectrum, modulus)
        found = predicted(scene.effects, pressure, variance=alone, spectrum=spectrum, modulus=modulus)
        ensemble = found.area if np.isfinite(found.area) else None
    elif isinstance(scene.surface, FileSurface):
        spectrum = measured_spectrum(scene.surface)
    assert spectrum is not None
    own = spectrum.scaled(float(field.rms_gradient**2 / spectrum.m2()))
    found = predicted(scene.effects, pressure, variance=variance, spectrum=own, modulus=modulus)
    return Theory(
        area=found.area,
        ensemble_area=ensemble,
        stress_variance=variance,
        plastic=found.plastic,
        other=found.other,
        note=found.note,
    )


def _spectral_variance(
    spectrum: SelfAffine | Tabulated, modulus: float | Callable[[Any], NDArray[np.float64]]
) -> float:
    """Full-contact stress variance of C(q) [Pa^2], on a solid whose modulus may depend on the wave."""
    if not callable(modulus):
        return float(elastic.stress_variance(spectrum.m2(), contact_modulus=modulus))
    from persson.scale import Scale

    scale = Scale(spectrum, contact_modulus=modulus)
    return float(scale.variance(scale.q_short))
