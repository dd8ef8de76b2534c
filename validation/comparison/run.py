"""Running a scene: check everything first, solve what is not stored yet, compare, write the results."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from validation.comparison.explain import oblong_grids
from validation.comparison.fields import with_fields
from validation.comparison.numbers import scene_data
from validation.comparison.pages import effects_words, result_page
from validation.comparison.subsurface_stress import write_below
from validation.comparison.theory_alone import theory_data
from validation.comparison.treatment import with_treatment
from validation.execution.bench import Bench
from validation.execution.outputs import Outputs, leave, show
from validation.execution.press import Press, run_solves
from validation.execution.provenance import SOLVES_MADE, made_words
from validation.execution.results import clear_results, record_of
from validation.execution.running import Solves
from validation.files import atomic_path, locked, prepare_folder
from validation.report.page import clear_page
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import Scene


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


def asked_of(scene: Scene, **more: Any) -> dict[str, Any]:
    """Return what a record says was asked: a scene in SI, as it was written, and what else."""
    plain = scene.model_dump(mode="json", exclude_none=True)
    return {"scene": plain, "written": scene.as_written, **more}


def solve_and_write(
    bench: Bench,
    folder: Path,
    solves: Sequence[Press],
    measured: Callable[[Solves], tuple[xr.Dataset, Sequence[Path]]],
    *,
    kind: str,
    settings: Mapping[str, Any],
    report: bool = True,
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
    record: dict[str, Any] = {"kind": kind, "name": settings["scene"]["name"], "settings": settings}
    page = partial(result_page, pictures=pictures)
    outputs = leave(folder, data, page, report=report, store=store.folder, **record)
    failures = data.failures.values.ravel().tolist() if "failures" in data else []
    return replace(
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
        pictures = bool(rendered) or any(folder.glob("figures/*.png"))
    return show(prepare_folder(folder), partial(result_page, pictures=pictures))


def _link_blocks(results: Solves, folder: Path) -> Iterator[Path]:
    """Yield the deformed blocks of this run, named by their grids; those of an earlier run are taken away.

    The store keeps the blocks of every scene that ran in it; here are those that belong to the report.
    """
    for earlier in folder.glob("*.vtu"):
        earlier.unlink(missing_ok=True)
    for solve in results:
        assert isinstance(solve, Press)
        stored = solve.block_file(results.store.folder) if solve.has_block else None
        if stored is None or not stored.exists():
            continue
        folder.mkdir(exist_ok=True)
        target = folder / f"{solve.prefix}.vtu"
        try:
            os.link(stored, target)
        except OSError:  # another file system, or one without links
            with atomic_path(target) as draft:
                shutil.copyfile(stored, draft)
        yield target
