"""Which method handles which effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

from validation.effects.tables import effect_key
from validation.errors import UsageError
from validation.scenes.scene import Scene

if TYPE_CHECKING:
    pass

__all__ = ["HANDLED_BY", "check_effects"]


#: For each effect a scene can name, the methods that handle it. A method that is not named refuses the scene.
HANDLED_BY: dict[str, frozenset[str]] = {
    "hardness": frozenset({"bem", "fem", "theory"}),
    "adhesion": frozenset({"bem", "theory"}),
    "thickness": frozenset({"bem", "fem"}),
    "coating": frozenset({"bem", "theory"}),
    "graded": frozenset({"bem", "fem", "theory"}),
    "size-dependent-hardness": frozenset(),
    "cracks": frozenset(),
}


def check_effects(scene: Scene) -> None:
    """Refuse a scene that lists an effect one of its methods lacks, or a solid it cannot discretise.

    Raises
    ------
    UsageError
        Naming the key, the method, and what is allowed.
    """
    fem = scene.methods.fem
    if fem is not None and fem.method == "full" and scene.solid.poisson > 0.49:
        raise UsageError(
            f"solid.poisson = {scene.solid.poisson!r}: method 'fem' locks above 0.49 with elements of "
            "displacement alone; leave [methods.fem] out or lower it"
        )
    wanted = [name for name in ("bem", "fem", "theory") if getattr(scene.methods, name) is not None]
    for k, effect in enumerate(scene.effects):
        handled = HANDLED_BY[effect.kind]
        for method in wanted:
            if method not in handled:
                able = ", ".join(sorted(handled)) or "the functions of the package persson alone"
                raise UsageError(
                    f"{effect_key(k, 'kind')} = {effect.kind!r}: method {method!r} does not handle it; "
                    f"handled by: {able}"
                )
    if scene.effects:
        from validation.methods.slots import check_slots

        check_slots(scene)
