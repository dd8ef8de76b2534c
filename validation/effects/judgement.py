"""Why an effect is in or out: for each the dimensionless number that decides, its source, and a word.

The words are *negligible*, *matters* and *unknown without ...*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fem_contact.surface import HeightField
from validation.effects.tables import Adhesion, Coating, EffectSpec, Graded, HardnessEffect, Thickness

if TYPE_CHECKING:
    from validation.scenes.scene import Scene

__all__ = ["Judgement", "Roughness", "full_contact_energy", "judge", "unlisted"]


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A number and what follows from it.

    Attributes
    ----------
    effect : str
    number : str
        The dimensionless number, in words and digits, with its source.
    verdict : str
        Begins with "negligible", "matters" or "unknown without".
    """

    effect: str
    number: str
    verdict: str

    @property
    def matters(self) -> bool:
        """Whether the effect should not be left out."""
        return self.verdict.startswith("matters")


@dataclass(frozen=True, kw_only=True)
class Roughness:
    """What the judgements need to know of a scene.

    Attributes
    ----------
    modulus : float
        E* [Pa].
    gradient, curvature : float
        h'_rms, and the rms curvature of a profile sqrt(3 m4 / 8) [1/m].
    longest, shortest : float
        Longest and shortest wavelength [m].
    full_energy : float
        Elastic energy per area at full contact [J/m^2].
    """

    modulus: float
    gradient: float
    curvature: float
    longest: float
    shortest: float
    full_energy: float

    @classmethod
    def of(cls, field: HeightField, *, modulus: float, longest: float, shortest: float) -> Roughness:
        """Measure a surface."""
        return cls(
            modulus=modulus,
            gradient=field.rms_gradient,
            curvature=math.sqrt(3 * field.moments[2] / 8),
            longest=longest,
            shortest=shortest,
            full_energy=full_contact_energy(field, modulus=modulus),
        )


def full_contact_energy(field: HeightField, *, modulus: float) -> float:
    """Elastic energy per area of a half-space that follows the whole surface, (E*/4) sum q |h(q)|^2 [J/m^2].

    Examples
    --------
    >>> x = np.arange(16) / 16
    >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.25))
    >>> round(full_contact_energy(wave, modulus=8.0) / (2 * np.pi), 12)
    1.0
    """
    nx, ny = field.shape
    power = np.abs(np.fft.fft2(field.heights, norm="forward")) ** 2
    qx = 2 * np.pi * np.fft.fftfreq(nx, field.lengths[0] / nx)
    qy = 2 * np.pi * np.fft.fftfreq(ny, field.lengths[1] / ny)
    return 0.25 * modulus * float(np.sum(np.hypot(qx[:, None], qy[None, :]) * power))


def judge(effect: EffectSpec, rough: Roughness) -> Judgement:
    """Say whether a listed effect matters, or what it costs for nothing."""
    if rough.gradient == 0:
        return Judgement(effect=effect.kind, number="flat surface", verdict="unknown without roughness")
    match effect:
        case HardnessEffect():
            return _hardness(effect, rough)
        case Adhesion():
            return _adhesion(effect, rough)
        case Thickness():
            deep = 2 * math.pi * effect.thickness / rough.longest
            return _said(effect.kind, f"q_long d = {deep:.3g} (bonded layer, Johnson 1985)", deep < _DEEP)
        case Coating():
            thin = 2 * math.pi * effect.thickness / rough.shortest
            number = f"q_short d = {thin:.3g}: the shortest waves feel the coating where it is above 0.1"
            return _said(effect.kind, number, thin > _THIN)
        case Graded():
            return _graded(effect, rough)
    return Judgement(effect=effect.kind, number="a part of the theory alone", verdict="unknown without it")


#: q_long d beyond which a rigid base changes the compliance by less than a tenth of a percent.
_DEEP = 8.0
#: q_short d below which a coating is not felt.
_THIN = 0.1
#: Standard deviations of the full-contact stress beyond which points that yield are rare.
_RARE = 4.0


def _said(effect: str, number: str, matters: bool) -> Judgement:
    if matters:
        return Judgement(effect=effect, number=number, verdict="matters")
    from validation.solves.calibration import effect_costs

    costs = effect_costs()
    words = f"negligible; it costs {costs.factors[effect]:.2g} times the plain solve ({costs.source})"
    return Judgement(effect=effect, number=number, verdict=words)


def _hardness(effect: HardnessEffect, rough: Roughness) -> Judgement:
    ratio = rough.modulus * rough.gradient / effect.hardness
    number = (
        f"E* h'_rms / H = {ratio:.3g} (stress spread at full contact is half of it; Persson 2006, Sec. 6)"
    )
    return _said(effect.kind, number, ratio / 2 > 1 / _RARE)


def _adhesion(effect: Adhesion, rough: Roughness) -> Judgement:
    radius = 2 / rough.curvature
    tabor = (radius * effect.work**2 / rough.modulus**2 / effect.reach**3) ** (1 / 3)
    parting = _parting(effect, rough)
    stored = rough.full_energy / effect.work
    number = (
        f"Pastewka-Robbins number {parting:.3g} (sticky below 1; Pastewka and Robbins 2014, Eq. 10), "
        f"U_full/w = {stored:.3g} (Persson 2006, Sec. 8), Tabor parameter of a summit {tabor:.3g}"
    )
    return _said(effect.kind, number, parting < _FELT or stored < 10)


#: Pastewka-Robbins number below which attraction takes more than 2 % off what repulsion carries.
_FELT = 50.0


def _parting(effect: Adhesion, rough: Roughness) -> float:
    r"""Repulsion in the contacts over the attraction around them.

    .. math:: \frac{h' \rho}{\kappa_\mathrm{rep}\, \ell_a}\left(\frac{h' d_\mathrm{rep}}{4\rho}\right)^{2/3},
              \qquad \ell_a = w/E^*,\quad d_\mathrm{rep} = 4 h'/h'',\quad \kappa_\mathrm{rep} = 2

    L. Pastewka, M. O. Robbins, PNAS 111 (2014) 3298, Eq. 10, with h'' half of the rms Laplacian.
    """
    laplacian = rough.curvature * math.sqrt(8 / 3)
    width = 4 * rough.gradient / (laplacian / 2)
    length = effect.work / rough.modulus
    bare = rough.gradient * effect.reach / (_KAPPA_REPULSIVE * length)
    return float(bare * (rough.gradient * width / (4 * effect.reach)) ** (2 / 3))


#: Contact area over load / (E* h'_rms) without adhesion.
_KAPPA_REPULSIVE = 2.0


def _graded(effect: Graded, rough: Roughness) -> Judgement:
    wave = 2 * math.pi * effect.depth / rough.longest
    number = (
        f"q_long d = {wave:.3g}: the longest wave feels the profile where it is below 100; "
        "theory wants max E'/(E q) < 1 (Persson 2006, Sec. 5)"
    )
    return _said(effect.kind, number, wave < 100)


def unlisted(scene: Scene, rough: Roughness) -> tuple[Judgement, ...]:
    """Judge the effects a scene does not list; without their parameters, say what would decide."""
    scale = rough.modulus * rough.gradient
    deep = _DEEP * rough.longest / (2 * math.pi)
    found = {
        "hardness": (
            f"E* h'_rms = {scale:.4g} Pa (Persson 2006, Sec. 6)",
            f"unknown without a hardness; negligible above {_RARE / 2 * scale:.3g} Pa",
        ),
        "adhesion": (
            f"U_full = {rough.full_energy:.3g} J/m^2 (Persson 2006, Sec. 8)",
            f"unknown without a work of adhesion and its range; it matters from about "
            f"{rough.full_energy / 10:.2g} J/m^2",
        ),
        "thickness": (
            f"longest wave {rough.longest:.4g} m",
            f"unknown without a thickness; negligible above {deep:.3g} m",
        ),
        "graded": ("E(z) constant", "unknown without a profile of the modulus"),
    }
    listed = {effect.kind for effect in scene.effects}
    if listed & {"thickness", "coating", "graded"}:
        listed |= {"thickness", "coating", "graded"}
    return tuple(
        Judgement(effect=name, number=number, verdict=verdict)
        for name, (number, verdict) in found.items()
        if name not in listed
    )
