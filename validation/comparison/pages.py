"""The page of a run, a theory or a sweep: its views, pictures, and what a reader should know of the scene."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import xarray as xr

from validation.comparison.explain import judgements
from validation.comparison.run_views import run_views
from validation.comparison.sweep_views import sweep_views
from validation.comparison.theory_alone import theory_views
from validation.errors import UsageError
from validation.execution.results import Result
from validation.report.page import Page, Picture, page_of
from validation.report.papers import CITED_FOR
from validation.report.quantities import as_length, in_prefixed_unit, in_shown_unit, quantity_of
from validation.sandbox import Child
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene

_VIEWS = {"run": run_views, "theory": theory_views, "sweep": sweep_views}
#: Seconds that a picture may take.
_PATIENCE = 120


def effects_words(scene: Scene, problem: ContactProblem) -> str:
    """Say in lines which effects ran and which were left out, with the number that decides."""
    run, left_out = judgements(scene, problem)
    lines = [] if run else ["None beyond linear elasticity runs."]
    for title, items in (("Runs", run), ("Left out", left_out)):
        lines += [f"{title}: {item.effect}: {item.number} - {item.verdict}" for item in items]
    return "\n".join(lines)


def result_page(result: Result, *, figures: bool, pictures: bool = False) -> Page:
    """Return the page of what a scene left, drawn or not, all of it from its dataset and from what was asked.

    A UsageError for a record of another kind.
    """
    if result.kind not in _VIEWS:
        raise UsageError(f"holds a {result.kind}, of which this makes no page")
    data, scene = result.data, Scene.model_validate(result.settings.get("written", result.settings["scene"]))
    missing = {"run": "not asked for", "theory": "no surface was pressed", "sweep": ""}[result.kind]
    picture = None
    if pictures and figures and result.kind == "run":
        picture, missing = _picture(result)
    settings = {key: value for key, value in result.settings.items() if key not in ("written", "cases")}
    cited = [paper for method in scene.methods.chosen.values() for paper in method.cited(scene.effects)]
    cited += [paper for effect in scene.effects for paper in effect.papers]
    beside = {"perimeter": bool(scene.methods.solvers), "measured": scene.surface.kind == "file"}
    titles = {"effects_words": "Effects", "treatment": "The measured surface"}
    notes = {title: lines for n, title in titles.items() if (lines := data.attrs.get(n, "").splitlines())}
    return page_of(
        data,
        _VIEWS[result.kind](data),
        figures=figures,
        title=str(data.attrs["title"]),
        lead=_lead(result.kind, data, scene),
        notes=notes,
        pictures=() if picture is None else (picture,),
        no_picture=missing,
        settings={**settings, "scene": scene.as_written},
        seeds=_seeds(scene, data),
        papers=(*cited, *(CITED_FOR[name] for name, used in beside.items() if used)),
        summary={"kind": result.kind, "name": result.name, **settings},
        data=None,
    )


def _lead(kind: str, data: xr.Dataset, scene: Scene) -> str:
    if kind == "sweep":
        keys = {name: data[name].size for name in str(data.attrs["keys"]).split()}
        swept = (f"{quantity_of(data, name).symbol} ({size} values)" for name, size in keys.items())
        joined = " beside " if data.attrs["mode"] == "zip" else " times "
        return f"Swept: {joined.join(swept)}, {data.attrs['cases']} cases"
    modulus = in_shown_unit(data.contact_modulus)
    if kind == "theory":
        return (
            f"Rigid rough surface on an elastic solid, by the theory alone: {data.attrs['theory']}; E* = "
            f"{modulus}, h'_rms = {float(data.rms_gradient):.4g}"
        )
    kinds = [effect.kind.replace("-", " ") for effect in scene.effects]
    effects = "effects: " + ", ".join(kinds) if kinds else "elastic, no adhesion"
    bodies = "Rigid rough" if scene.solid.second_young is None else "Elastic rough"
    held = "".join(f"{key.replace('_', ' ')} {as_length(v, 4)} held, " for key, v in scene.load.held.items())
    if scene.load.force is not None:
        held = f"force = {in_prefixed_unit(scene.load.force, 'N')}, "
    coated = not np.isclose(data.contact_modulus, data.surface_modulus, rtol=1e-9)
    return (
        f"{bodies} surface on an elastic solid, frictionless, {effects}; {held}p* = "
        f"{float(data.reduced_pressure):.4g} (p0 = {in_shown_unit(data.pressure)}, E* = {modulus}"
        f"{' of the solid below the coating' * coated}, realised h'_rms = {float(data.rms_gradient):.4g})"
    )


def _seeds(scene: Scene, data: xr.Dataset) -> str:
    swept = [c for c in data.coords.values() if c.attrs.get("key") == "surface.seed"]
    if swept:
        return ", ".join(f"{value:g}" for value in swept[0].values)
    surface = scene.surface
    if surface.kind == "file":
        return "none: the surface was measured"
    if not scene.methods.solvers:
        return "none: no surface was drawn"
    if scene.ensemble is None:
        return str(surface.seed)
    last = surface.seed_of(scene.ensemble.realisations - 1)
    return f"{surface.seed} (the surface shown), {surface.seed} to {last} (scatter between surfaces)"


def _picture(result: Result) -> tuple[Picture | None, str]:
    """Render the finest finite-element solve, or the finest of all, of the surface as it stands."""
    keys = result.data.solve.isel(shift=0)
    groups = [
        ((result.store / f"{key}.vtu").exists(), g, str(key), str(keys.solver[m].item()))
        for (m, g), key in np.ndenumerate(keys.values)
        if key
    ]
    _, g, key, solver = max(groups)
    return render_stored(result.store / f"{key}.nc", label=f"{solver} on {keys.grid[g].item()}")


def render_stored(solve: Path, *, label: str) -> tuple[Picture | None, str]:
    """Return a picture of the deformed surface of a stored solve, or None and the reason why there is none.

    It is done in a process of its own: without a display or a graphics driver the renderer may not only fail
    but take its process with it.
    """
    with tempfile.TemporaryDirectory() as folder, Child() as worker:
        image = Path(folder) / "surface-3d.png"
        try:
            worker.call(_render, solve, image, seconds=_PATIENCE)
        except Exception as error:  # its own, or that of the process it takes with it
            return None, f"off-screen rendering does not work here: {error}{worker.last_words()}"
        png = image.read_bytes()
    caption = (
        f"The deformed surface of the elastic body ({label}), coloured by contact pressure: dark is high, "
        "light is low. Displacements are magnified so that the deepest dent is a tenth of the period."
    )
    return Picture(name="surface-3d", png=png, caption=caption), ""


def _render(solve: Path, image: Path) -> None:
    from fem_contact.export import render_surface
    from validation.execution.press import decode_result
    from validation.execution.store import read_numbers

    # The renderer chooses the format by the suffix.
    render_surface(image, read_numbers(solve, decode_result))
