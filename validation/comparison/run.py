"""Running a scene or a sweep: check everything, solve what is not stored, compare, write results and page."""

from __future__ import annotations

import dataclasses
import itertools
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.comparison.explain import judgements, oblong_grids, problems_of, solves_of_sweep
from validation.comparison.fields import with_fields, write_below
from validation.comparison.numbers import scene_data
from validation.comparison.run_views import run_views
from validation.comparison.sweep_views import sweep_views
from validation.comparison.theory_alone import theory_data, theory_views
from validation.comparison.treatment import with_treatment
from validation.errors import RunFailed, UsageError
from validation.execution.bench import Bench, Solves
from validation.execution.press import Press, run_solves
from validation.execution.provenance import SOLVES_MADE, made_words
from validation.execution.results import Outputs, Result, clear_results, leave, record_of, show
from validation.files import atomic_path, locked, prepare_folder
from validation.report.page import Page, Picture, clear_page, page_of
from validation.report.papers import CITED_FOR
from validation.report.places import gather
from validation.report.quantities import as_length, in_prefixed_unit, in_shown_unit, labelled, quantity_of
from validation.sandbox import Child
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import Scene
from validation.scenes.sweep import Sweep


def run_scene(
    scene: Scene,
    folder: Path,
    *,
    bench: Bench | None = None,
    problem: ContactProblem | None = None,
    accurate: Mapping[str, Any] | None = None,
    report: bool = True,
    pictures: bool = False,
) -> Outputs:
    """Run a scene into a folder; finished solves found in the store are used, not repeated.

    `accurate` is what was reached where the grids were chosen for an accuracy. Solves run in this process
    and are kept in `folder`/solves unless a `bench` says where, to be shared with other runs and studies.
    `pictures` in 3-D are rendered off screen in some seconds; without `report` figures and page are left for
    `report_scene`.

    A UsageError for a scene or folder that cannot be used, before anything is computed. A RunFailed when no
    solve succeeds; of others the report tells.
    """
    problem = problem or realise(scene)
    check_scene(scene, problem)
    settings = asked_of(scene, **({} if accurate is None else {"accuracy": dict(accurate)}))
    bench = bench or Bench.at(folder / "solves")
    for grids, words in oblong_grids(scene, problem):
        bench.progress.note(f"{grids}: {words}")

    def measured(results: Solves) -> tuple[xr.Dataset, Sequence[Path]]:
        written: Sequence[Path] = ()
        if scene.methods.solvers:
            failures = {s: why for s, why in results.failures.items() if not s.problem.variation}
            data = scene_data(scene, problem, results, failures=failures, accurate=accurate)
            data = with_treatment(data, problem, results)
            data = with_fields(data, scene, problem, results)
            with locked(folder):
                fields = folder / "fields"
                written = (*_link_blocks(results, fields), *write_below(scene, results, fields))
        else:
            data = theory_data(scene, problem)
        return data.assign_attrs(effects_words=effects_words(scene, problem)), written

    kind = "run" if scene.methods.solvers else "theory"
    solves, shown = run_solves(scene, problem), {"report": report, "pictures": pictures}
    return solve_and_write(bench, folder, solves, measured, kind=kind, settings=settings, **shown)


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    bench: Bench | None = None,
    cases: Sequence[ContactProblem] | None = None,
    report: bool = True,
) -> Outputs:
    """Run every scene of a sweep into one folder, as `run_scene` does one."""
    problems = cases or problems_of(sweep)
    solves = solves_of_sweep(sweep, problems)
    keys = [dataclasses.asdict(key) for key in sweep.keys]
    plain = [_in_si(scene) for scene in sweep.scenes]
    # Of each case the tables in which it is another than the first.
    own = [{name: table for name, table in one.items() if table != plain[0].get(name)} for one in plain]
    settings = asked_of(sweep.scenes[0], sweep={"mode": sweep.mode, "keys": keys}, cases=own)

    def measured(results: Solves) -> tuple[xr.Dataset, Sequence[Path]]:
        counts = {"solves": len(solves), "asked": sum(map(len, map(run_solves, sweep.scenes, problems)))}
        return sweep_data(sweep, problems, results).assign_attrs(counts), ()

    bench = bench or Bench.at(folder / "solves")
    return solve_and_write(bench, folder, solves, measured, kind="sweep", settings=settings, report=report)


def asked_of(scene: Scene, **more: Any) -> dict[str, Any]:
    """Return what a record says was asked: a scene in SI, as it was written, and what else."""
    return {"scene": _in_si(scene), "written": scene.as_written, **more}


def _in_si(scene: Scene) -> dict[str, Any]:
    return scene.model_dump(mode="json", exclude_none=True)


def solve_and_write(
    bench: Bench,
    folder: Path,
    solves: Sequence[Press],
    measured: Callable[[Solves], tuple[xr.Dataset, Sequence[Path]]],
    *,
    kind: str,
    settings: Mapping[str, Any],
    report: bool,
    pictures: bool = False,
) -> Outputs:
    """Do the solves of a run or a sweep, and write dataset, record and page.

    `measured` makes the dataset of the results, and other files. What the folder holds of another question
    is taken away first: if this is interrupted, nothing in it belies it.
    """
    prepare_folder(folder)
    with locked(folder):
        if record_of(folder).get("asked") != settings:
            clear_results(folder)
            clear_page(folder)
            for block in (folder / "fields").glob("*.vtu"):
                block.unlink(missing_ok=True)
    store = bench.store
    results = bench.solve(solves, despite_failures=True)
    data, written = measured(results)
    if results:
        data.attrs[SOLVES_MADE] = "\n".join(made_words(results.made()))
    page, name = partial(result_page, pictures=pictures), settings["scene"]["name"]
    about: dict[str, Any] = {"kind": kind, "name": name, "settings": settings, "store": store.folder}
    anew = pictures or _has_pictures(folder)
    outputs = leave(folder, data, page, report=report, anew=anew, **about)
    failures = data.failures.values.ravel().tolist() if "failures" in data else []
    return dataclasses.replace(
        outputs,
        files=(*outputs.files, *written, *([store.folder] if results else [])),
        solved=results.solved,
        reused=len(results) - results.solved,
        failures=tuple(dict.fromkeys(filter(None, failures))),
    )


def report_scene(folder: Path, *, pictures: bool | None = None) -> Outputs:
    """Write tables, figures and report of a run or a sweep again, from its stored dataset alone.

    3-D `pictures` are rendered, if not given, where the scene asks or the folder has some.

    A UsageError for a folder that holds no finished run of this version.
    """
    if pictures is None:
        rendered = record_of(folder).get("asked", {}).get("scene", {}).get("run", {}).get("pictures", False)
        pictures = bool(rendered) or _has_pictures(folder)
    return show(prepare_folder(folder), partial(result_page, pictures=pictures))


def _has_pictures(folder: Path) -> bool:
    return any(folder.glob("figures/*.png"))


def _link_blocks(results: Solves, folder: Path) -> Iterator[Path]:
    """Yield the deformed blocks of this run, named by their grids.

    The store keeps the blocks of every scene that ran in it; here are those that belong to the report.
    """
    for solve in results:
        assert isinstance(solve, Press)
        stored = solve.block_file(results.store.folder)
        if not stored.exists():
            continue
        folder.mkdir(exist_ok=True)
        target = folder / f"{solve.prefix}.vtu"
        target.unlink(missing_ok=True)
        try:
            os.link(stored, target)
        except OSError:  # another file system, or one without links
            with atomic_path(target) as draft:
                shutil.copyfile(stored, draft)
        yield target


def sweep_data(sweep: Sweep, cases: Sequence[ContactProblem], results: Solves) -> xr.Dataset:
    """Gather the numbers of all cases over the swept keys, or over `case` where these run side by side."""
    parts = [_case(*pair, results) for pair in zip(sweep.scenes, cases, strict=True)]
    # Attributes that differ go where the parts are made alike.
    doubts = list(filter(None, (str(part.attrs.get("doubts", "")) for part in parts)))
    parts = _alike(parts)
    if "contact_modulus" not in parts[0]:  # all cases failed
        raise RunFailed("; ".join(dict.fromkeys(part.failures.item() for part in parts)))
    names = [key.name for key in sweep.keys]
    parts = [part.drop_vars(names, errors="ignore") for part in parts]
    if sweep.mode == "zip":
        data = gather(dict(enumerate(parts, 1)), "case")
        data = data.assign_coords({key.name: ("case", list(key.values)) for key in sweep.keys})
    else:
        places = {key.name: key.values for key in sweep.keys}
        every = [place[0] if len(names) == 1 else place for place in itertools.product(*places.values())]
        data = gather(dict(zip(every, parts, strict=True)), **places)
    for key in sweep.keys:
        data[key.name].attrs.update(units=key.unit, long_name=key.key, key=key.key)
        numeric = data[key.name].dtype.kind in "fiu"
        data = data.sortby(key.name) if sweep.mode == "product" and numeric else data
    alike = {"title", "methods", "effects", "theory", "drawn", "adhesive"}
    shared = {name: value for name, value in parts[0].attrs.items() if name in alike}
    told = {"mode": sweep.mode, "cases": len(parts), "keys": " ".join(names)}
    if doubts:
        some = f" (in {len(doubts)} of {len(parts)} cases)" if len(doubts) < len(parts) else ""
        told["doubts"] = "; ".join(dict.fromkeys(doubts)) + some
    return labelled(data, sweep.given).assign_attrs(shared | told)


def _case(scene: Scene, problem: ContactProblem, results: Solves) -> xr.Dataset:
    if not scene.methods.solvers:
        return theory_data(scene, problem).drop_dims("wave").isel(load=0).reset_coords()
    solves, every = run_solves(scene, problem), results.failures
    done = {solve: results[solve] for solve in solves if solve not in every}
    failures = {s: every[s] for s in solves if s in every and not s.problem.variation}
    try:
        return with_treatment(scene_data(scene, problem, done, failures=failures), problem, done)
    except RunFailed as error:
        return xr.Dataset({"failures": str(error)})


def _alike(parts: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Give all cases the same dimensions and variables: what one of them lacks is NaN, or no words."""
    # Cases may have different numbers of positions of the surface.
    parts = [p.assign(shift=np.arange(p.sizes["shift"])) if "shift" in p.dims else p for p in parts]
    how: Any = {"data_vars": "all", "coords": "minimal", "compat": "override", "join": "outer"}
    data = xr.concat(parts, "case", combine_attrs="drop_conflicts", **how)
    texts = [name for name, values in data.data_vars.items() if values.dtype.kind in "OU"]
    data = data.assign({name: data[name].where(data[name].notnull(), "").astype(str) for name in texts})
    return [data.isel(case=k).drop_vars("shift", errors="ignore") for k in range(len(parts))]


# ---- the page ------------------------------------------------------------------------------------

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
    bodies = "Rigid rough" if scene.solid.second_young is None else "Elastic rough"
    if kind == "theory":
        return (
            f"{bodies} surface on an elastic solid, by the theory alone: {data.attrs['theory']}; E* = "
            f"{modulus}, h'_rms = {float(data.rms_gradient):.4g}"
        )
    kinds = [effect.kind.replace("-", " ") for effect in scene.effects]
    effects = "effects: " + ", ".join(kinds) if kinds else "elastic, no adhesion"
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
    if swept := [c for c in data.coords.values() if c.attrs.get("key") == "surface.seed"]:
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


def render_stored(stored: Path, *, label: str) -> tuple[Picture | None, str]:
    """Return a picture of the deformed surface of a stored solve, or None and the reason why there is none.

    It is done in a process of its own: without a display or a graphics driver the renderer may not only fail
    but take its process with it.
    """
    with tempfile.TemporaryDirectory() as folder, Child() as worker:
        image = Path(folder) / "surface-3d.png"
        try:
            worker.call(_render, stored, image, seconds=_PATIENCE)
        except Exception as error:  # its own, or that of the process it takes with it
            return None, f"off-screen rendering does not work here: {error}{worker.last_words()}"
        png = image.read_bytes()
    caption = (
        f"The deformed surface of the elastic body ({label}), coloured by contact pressure: dark is high, "
        "light is low. Displacements are magnified so that the deepest dent is a tenth of the period."
    )
    return Picture(name="surface-3d", png=png, caption=caption), ""


def _render(stored: Path, image: Path) -> None:
    from fem_contact.export import render_surface
    from validation.execution.press import decode_result
    from validation.execution.store import read_numbers

    # The renderer chooses the format by the suffix.
    render_surface(image, read_numbers(stored, decode_result))
