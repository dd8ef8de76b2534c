"""What is refused of a scene before anything is computed, beyond what its tables say by themselves."""

from __future__ import annotations

import itertools

from validation.effects.base import ContactModel, effect_key
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.tables import Load
from validation.solvers import methods


def check_scene(scene: Scene, problem: ContactProblem) -> None:
    """Refuse effects that a listed method lacks, and what does not fit load, grids or each other.

    A UsageError names the key, the method, and what is allowed.
    """
    for k in range(1 + len(getattr(scene.surface, "more_paths", ()))):
        _ = problem.further(k).field  # a surface that cannot be made is refused here, by name
    asked = scene.methods.chosen
    for k, effect in enumerate(scene.effects):
        able = sorted(name for name, method in methods().items() if method.handles(type(effect)))
        if unable := [name for name in asked if name not in able]:
            raise UsageError(
                f"{effect_key(k, 'kind')} = {effect.kind!r}: method {unable[0]!r} does not handle it; "
                f"handled by: {', '.join(able) or 'none'}"
            )
    for name, method in asked.items():
        if missing := method.available():
            raise UsageError(f"methods.{name}: {missing}")
    _check_control(scene)
    if scene.subsurface is not None:
        if all(solver.sinks for solver in scene.methods.solvers.values()):
            raise UsageError("quantities.subsurface: is read off surface pressures; add [methods.bem]")
        response = ContactModel.filled(problem.elastic, scene.effects).felt_response
        base, depths = getattr(response, "thickness", None), scene.subsurface.depths
        if base is not None and depths is not None and depths[-1] > base:
            raise UsageError(
                f"quantities.subsurface.depths: the deepest, {as_length(depths[-1])}, lies below the base of "
                f"the layer, at {as_length(base)}"
            )
    for k, effect in enumerate(scene.effects):
        for name in scene.methods.solvers:
            effect.check_solver(name, key=effect_key(k, ""))
    if scene.effects:
        model = ContactModel.filled(problem.elastic, scene.effects if scene.methods.solvers else ())
        grids = [grid for name in scene.methods.solvers for grid in scene.methods.options(name).grids]
        grids += [] if scene.ensemble is None else scene.ensemble.grids
        cases = [problem]
        if not problem.load.held and len(problem.pressures) > 1:
            cases = [problem.under(Load(pressure=pressure)) for pressure in problem.pressures]
        for (k, effect), case in itertools.product(enumerate(scene.effects), cases):
            effect.check(case, grids, model=model, key=effect_key(k, ""))
    for name, method in asked.items():
        method.check(scene.methods.options(name), problem, scene.effects)


def _check_control(scene: Scene) -> None:
    """Refuse methods that cannot hold a distance, bodies that sink differently, a second body on a layer."""
    solvers, key = scene.methods.solvers, scene.load.key
    filled = {effect.slot: effect.kind for effect in scene.effects}
    layered, patch = filled.get("response"), filled.get("boundary")
    if scene.solid.second_young is not None and layered is not None:
        raise UsageError(
            f"solid.second_young: effect {layered!r} changes one body alone, and two bodies are solved as "
            "one half-space; leave one of them out"
        )
    if getattr(scene.surface, "edges", None) == "free" and patch is None:
        raise UsageError(
            "surface.edges = 'free': has no period, which everything but the effect 'free-boundary' needs; "
            "list it, or taper the edges"
        )
    if patch is not None and scene.ensemble is not None:
        raise UsageError(f"ensemble: averages over periods; effect {patch!r} presses one patch; remove one")
    if patch is not None and scene.quantities is not None:
        raise UsageError(f"quantities: are read off a period; leave them out, or the effect {patch!r}")
    if not scene.load.held:
        return
    able = [name for name, method in methods().items() if key in getattr(method, "holds", ())]
    for name in solvers:
        if name not in able:
            raise UsageError(
                f"load.{key}: method {name!r} presses with a load; held by: {', '.join(able) or 'none'}"
            )
    sinking = [name for name, solver in solvers.items() if solver.sinks]
    if key == "offset" and layered is None and 0 < len(sinking) < len(solvers):
        raise UsageError(
            f"load.offset: the body of method {sinking[0]!r} sinks as a whole under its load, a half-space "
            "does not; ask them one by one"
        )
