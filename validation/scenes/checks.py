"""What is refused of a scene before anything is computed, beyond what its tables say by themselves."""

from __future__ import annotations

from validation.effects.base import Slots, effect_key
from validation.errors import UsageError
from validation.methods import methods
from validation.methods.base import check_effects_handled
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene

__all__ = ["check_scene"]


def check_scene(scene: Scene, realised: Realised) -> None:
    """Refuse effects that a listed method lacks, and what does not fit load, grids or each other.

    Raises
    ------
    UsageError
        Naming the key, the method, and what is allowed.
    """
    _ = realised.field  # a surface that cannot be made is refused here, by name
    asked = scene.methods.asked
    check_effects_handled(asked, scene.effects, methods())
    for name, method in asked.items():
        missing = method.available()
        if missing is not None:
            raise UsageError(f"methods.{name}: {missing}")
    if scene.effects:
        slots = Slots.filled(realised.elastic, scene.effects)
        grids = [grid for name in scene.methods.solvers for grid in scene.methods.options(name).grids]
        grids += [] if scene.ensemble is None else scene.ensemble.grids
        for k, effect in enumerate(scene.effects):
            effect.check(realised, grids, slots=slots, key=effect_key(k, ""))
    for name, method in asked.items():
        method.check(scene.methods.options(name), realised, scene.effects)
