"""What a study on a scene says of it: what it took, and what it has no use for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from validation.scenes.scene import Scene
from validation.scenes.tables import FileSurface


def scene_words(options: Any, scene: Scene) -> Iterator[str]:
    """Say what a scene was asked for, and what of it is not used; `options` are a study's that takes a scene."""
    first, taken, surface = options.first, options.taken(scene, options.first), scene.surface
    what = str(surface.path) if isinstance(surface, FileSurface) else surface.kind
    effects = "".join(f", {effect.kind}" for effect in options.effects)
    values = "; ".join(
        f"{name.replace('_', ' ')} {_shown(value)}"
        for name, value in taken.items()
        if name not in options.off and _shown(value) == _shown(getattr(options, name))
    )
    yield (
        f"Surface ({what}), solid and load (p* = {first.reduced_pressure:.4g}{effects}) are those of the scene "
        f"{scene.name!r}, and so are: {values}."
    )
    unused = [f"[methods.{name}]" for name in scene.methods.solvers if name not in options.used]
    if unused:
        yield f"Not used of the scene, for this study presses by boundary elements: {', '.join(unused)}."
    shifts = "shifts" in scene.methods.options("bem").model_fields_set
    keys = {
        "methods.bem.shifts": shifts and "shifts" not in type(options).model_fields,
        "ensemble.grids": scene.ensemble is not None,
    }
    if any(keys.values()):
        names = ", ".join(name for name, idle in keys.items() if idle)
        yield f"Keys of the scene that this study has no use for: {names}."
    if options.off:
        names = ", ".join(name.replace("_", " ") for name in options.off)
        yield f"Parts of the study that a scene turns off: {names}."


def _shown(value: Any) -> str:
    values = value if isinstance(value, tuple) else (value,)
    return ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in values)
