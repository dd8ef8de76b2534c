"""From the effects a scene lists to the slots of the solvers; loaded only for a scene that lists one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem_contact.contact import ContactResult
from fem_contact.errors import UnsupportedEffect
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace, Response
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.effects.tables import (
    SLOTS,
    Adhesion,
    Coating,
    EffectSpec,
    Graded,
    HardnessEffect,
    Thickness,
    effect_key,
)
from validation.errors import UsageError
from validation.scenes.surfaces import surveyed
from validation.solves.solve import nominal_pressure

if TYPE_CHECKING:
    from fem_contact.gap_laws import GapLaw
    from validation.scenes.scene import Scene

__all__ = [
    "block_arguments",
    "check_slots",
    "gap_law",
    "response_of",
    "solve_bem",
    "theory_modulus",
    "theory_variance",
]

Array = NDArray[np.float64]


def response_of(solid: Solid, effects: tuple[EffectSpec, ...]) -> Response:
    """Return the elastic response that the effects call for; the half-space if none changes it."""
    for effect in effects:
        if isinstance(effect, Thickness):
            kind = BondedLayer if effect.base == "bonded" else FrictionlessLayer
            return kind(solid=solid, thickness=effect.thickness)
        if isinstance(effect, Coating):
            from fem_contact.graded import LayeredSolid

            poisson = solid.poisson if effect.poisson is None else effect.poisson
            coating = Solid(young=effect.young, poisson=poisson)
            return LayeredSolid(layers=[coating], thicknesses=[effect.thickness], base=solid)
        if isinstance(effect, Graded):
            from fem_contact.graded import ExponentialSolid

            return ExponentialSolid(surface=solid, bulk_young=effect.bulk_young, depth=effect.depth)
    return HalfSpace(solid=solid)


def gap_law(effect: Adhesion) -> GapLaw:
    """Return the law of the gap that an adhesion table describes."""
    from fem_contact.gap_laws import Dugdale, Exponential

    kind = Exponential if effect.law == "exponential" else Dugdale
    return kind(work=effect.work, reach=effect.reach)


def solve_bem(
    field: HeightField,
    solid: Solid,
    *,
    effects: tuple[EffectSpec, ...],
    mean_pressure: float,
    tolerance: float,
    threads: int | None = None,
) -> ContactResult:
    """Solve by boundary elements with the effects of a scene.

    Raises
    ------
    UnsupportedEffect
        For an effect, or two together, that boundary elements do not handle.
    """
    response = response_of(solid, effects)
    others = [effect for effect in effects if SLOTS[effect.kind] != "response"]
    said: dict[str, Any] = {"mean_pressure": mean_pressure, "tolerance": tolerance, "threads": threads}
    match others:
        case []:
            from fem_contact import bem

            return bem.solve(field, response, **said)
        case [HardnessEffect() as hard]:
            from fem_contact.hardness import Hardness, press

            return press(field, response, hardness=Hardness(pressure=hard.hardness), **said)
        case [Adhesion() as sticky]:
            from fem_contact import adhesion

            return adhesion.solve(field, response, law=gap_law(sticky), **said).contact
        case [HardnessEffect() as hard, Adhesion() as sticky] | [
            Adhesion() as sticky,
            HardnessEffect() as hard,
        ]:
            from fem_contact import adhesion

            law = gap_law(sticky)
            return adhesion.solve(field, response, law=law, hardness=hard.hardness, **said).contact
    names = " and ".join(repr(effect.kind) for effect in others)
    raise UnsupportedEffect(f"boundary elements do not handle {names}; leave it out, or split the scene")


@dataclass(frozen=True)
class _Profile:
    """E(z) over that of the surface, at cell centres; a class, so that it can go to another process."""

    effect: Graded
    young: float

    def __call__(self, x: Array, y: Array, z: Array) -> Array:
        del x, y
        ratio = self.effect.bulk_young / self.young
        return np.asarray(ratio + (1 - ratio) * np.exp(z / self.effect.depth))


def block_arguments(solid: Solid, effects: tuple[EffectSpec, ...]) -> dict[str, Any]:
    """Return the arguments of the finite-element block that stand for the effects of a scene.

    Raises
    ------
    UnsupportedEffect
        For an effect that the block does not handle.
    """
    arguments: dict[str, Any] = {}
    for effect in effects:
        if isinstance(effect, Thickness) and effect.base == "bonded":
            arguments["depth"] = effect.thickness
        elif isinstance(effect, Graded):
            arguments["modulus"] = _Profile(effect, solid.young)
        elif isinstance(effect, HardnessEffect):
            arguments["pressure_bound"] = effect.hardness
        else:
            raise UnsupportedEffect(
                f"finite elements do not handle {effect.kind!r} as this scene has it; use boundary elements"
            )
    return arguments


def check_slots(scene: Scene) -> None:
    """Refuse, before anything is computed, effects that do not fit the scene's load, grids or each other.

    Raises
    ------
    UsageError
        Naming the key and what is allowed.
    """
    fem, theory = scene.methods.fem, scene.methods.theory
    for k, effect in enumerate(scene.effects):
        key = effect_key(k, "").rstrip()
        if isinstance(effect, HardnessEffect):
            _check_hardness(scene, effect, key)
        elif isinstance(effect, Adhesion):
            _check_adhesion(scene, effect, key)
        elif isinstance(effect, Coating) and theory is not None and effect.poisson is not None:
            if effect.poisson != scene.solid.poisson:
                raise UsageError(
                    f"{key} poisson = {effect.poisson!r}: method 'theory' knows one Poisson ratio, that of "
                    f"the solid, {scene.solid.poisson!r}"
                )
        elif isinstance(effect, Thickness) and fem is not None:
            if fem.depth is not None:
                raise UsageError(f"methods.fem.depth: {key} thickness says the depth; leave one of them out")
            if effect.base != "bonded":
                raise UsageError(
                    f"{key} base = {effect.base!r}: must be 'bonded', as method 'fem' is clamped"
                )


def _check_hardness(scene: Scene, effect: HardnessEffect, key: str) -> None:
    pressure = nominal_pressure(scene.load, scene.solid, surveyed(scene.surface))
    if effect.hardness < pressure:
        raise UsageError(
            f"{key} hardness = {effect.hardness:.6g} Pa: must not be below the nominal pressure "
            f"{pressure:.6g} Pa, or nothing carries the load"
        )


def _check_adhesion(scene: Scene, effect: Adhesion, key: str) -> None:
    from fem_contact.adhesion import CELLS_NEEDED, cells_in_process_zone

    bem = scene.methods.bem
    if bem is None:
        return
    modulus = response_of(Solid(**scene.solid.model_dump()), scene.effects).contact_modulus
    grids = list(bem.grids) + list(() if scene.ensemble is None else scene.ensemble.grids)
    for grid in grids:
        spacing = max(length / n for length, n in zip(scene.surface.length, grid, strict=True))
        cells = cells_in_process_zone(gap_law(effect), spacing=spacing, contact_modulus=modulus)
        if cells < CELLS_NEEDED:
            needed = [int(np.ceil(n * CELLS_NEEDED / cells)) for n in grid]
            raise UsageError(
                f"{key} reach = {effect.reach:.6g} m: grid {list(grid)} has {cells:.3g} cells in the zone "
                f"where adhesion acts and needs {CELLS_NEEDED:.0f}: at least {needed}, or a longer reach"
            )


def theory_modulus(solid: Solid, effects: tuple[EffectSpec, ...]) -> Callable[[ArrayLike], Array] | None:
    """Return the contact modulus that a wave feels by Persson's theory; None where it is the solid's."""
    for effect in effects:
        if isinstance(effect, Graded):
            from persson.graded import ExponentialLayers

            return ExponentialLayers(
                bulk=effect.bulk_young,
                excess=[solid.young - effect.bulk_young],
                depths=[effect.depth],
                poisson=solid.poisson,
            )
        if isinstance(effect, Coating):
            from persson.graded import SurfaceLayer

            return SurfaceLayer(
                bulk=solid.young, layer=effect.young, thickness=effect.thickness, poisson=solid.poisson
            )
    return None


def theory_variance(field: HeightField, modulus: Callable[[ArrayLike], Array]) -> float:
    """Full-contact stress variance of one surface on a solid whose modulus depends on the wave [Pa^2]."""
    nx, ny = field.shape
    power = np.abs(np.fft.fft2(field.heights, norm="forward")) ** 2
    qx = 2 * np.pi * np.fft.fftfreq(nx, field.lengths[0] / nx)
    qy = 2 * np.pi * np.fft.fftfreq(ny, field.lengths[1] / ny)
    q = np.hypot(qx[:, None], qy[None, :])
    felt = np.zeros(q.shape)
    felt[q > 0] = modulus(q[q > 0])
    return float(np.sum((felt * q / 2) ** 2 * power))
