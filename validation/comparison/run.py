"""Running a scene: check everything first, solve what is not stored yet, compare, write the results."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from validation.comparison import theory_alone
from validation.comparison.compare import compare
from validation.comparison.compared import Comparison
from validation.comparison.report import write_outputs
from validation.comparison.theory_alone import TheoryAlone
from validation.errors import UsageError
from validation.files import atomic_path, json_text, prepare_folder, read_record, record_of, write_record
from validation.report.page import Page, clear_page
from validation.scenes.checks import check_scene
from validation.scenes.realised import Realised, realise
from validation.scenes.scene import Scene
from validation.solves.attempt import Progress
from validation.solves.press import solves_of
from validation.solves.running import Execution, Solves, solve_all
from validation.solves.store import Store

__all__ = ["ACCURACY_FILE", "Outputs", "load_run", "report_run", "run_scene"]

_RUN_FILE = "run.json"
_RUN_FORMAT = "fem-contact run 1"

#: What a run to an accuracy reached, in its results folder.
ACCURACY_FILE = "accuracy.json"


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What a run left behind.

    Attributes
    ----------
    comparison : Comparison or TheoryAlone
        The latter for a scene without a solver.
    page : Page
    folder : Path
    files : tuple of Path
        Everything a reader may want to open, the report first.
    solved, reused : int
        Jobs solved now, and solves found finished.
    """

    comparison: Comparison | TheoryAlone
    page: Page
    folder: Path
    files: tuple[Path, ...]
    solved: int
    reused: int


def run_scene(
    scene: Scene,
    folder: Path,
    *,
    realised: Realised | None = None,
    progress: Progress | None = None,
    execution: Execution | None = None,
    store_folder: Path | None = None,
    pictures: bool = False,
    report: bool = True,
    accurate: Mapping[str, Any] | None = None,
) -> Outputs:
    """Run a scene into a folder; finished solves found in the store are used, not repeated.

    Parameters
    ----------
    scene : Scene
    folder : Path
        For tables, figures and report.
    realised : Realised, optional
        What the scene asks for, where it has been made already.
    progress : Progress, optional
    execution : Execution, optional
        Where the solves run; in this process if not given.
    store_folder : Path, optional
        Where the solves are kept, to be shared with other runs and studies; `folder`/solves if not given.
    pictures : bool
        Whether the report gets 3-D pictures, rendered off screen in some seconds.
    report : bool
        Whether to draw figures and write the report, which `report_run` can do later.
    accurate : mapping, optional
        What was reached where the grids were chosen for an accuracy, which is kept beside the report; a
        plain run removes what an earlier such run reached.

    Raises
    ------
    UsageError
        For a scene or folder that cannot be used, before anything is computed.
    RunFailed
        When a solve fails; everything finished is stored.
    """
    realised = realised or realise(scene)
    check_scene(scene, realised)
    prepare_folder(folder)
    store = Store(folder=store_folder or folder / "solves")
    if not scene.methods.solvers:
        _record(scene, folder, store)
        return _without_solver(scene, realised, folder, report=report)
    # What an earlier run to an accuracy reached is not what this one finds.
    (folder / ACCURACY_FILE).unlink(missing_ok=True)
    _record(scene, folder, store)
    results = solve_all(solves_of(scene, realised), store, progress=progress, execution=execution)
    comparison = compare(scene, realised, results, accurate=accurate)
    page, files = write_outputs(comparison, results, folder, pictures=pictures, report=report)
    if accurate is not None:
        with atomic_path(folder / ACCURACY_FILE) as draft:
            draft.write_text(json.dumps(accurate, indent=2) + "\n", encoding="utf-8")
        files = (*files, folder / ACCURACY_FILE)
    return Outputs(
        comparison=comparison,
        page=page,
        folder=folder,
        files=files,
        solved=results.solved,
        reused=len(results) - results.solved,
    )


def report_run(folder: Path, *, pictures: bool | None = None) -> Outputs:
    """Write tables, figures and report of a finished run again, from its stored solves alone.

    Parameters
    ----------
    folder : Path
    pictures : bool, optional
        Whether to render 3-D pictures, too; if not given, where the scene asks or the folder has some.

    Raises
    ------
    UsageError
        For a folder that holds no run.
    RunFailed
        When a solve of the run is missing.
    """
    scene, store = load_run(folder)
    realised = realise(scene)
    if not scene.methods.solvers:
        return _without_solver(scene, realised, prepare_folder(folder))
    results = Solves(solves=solves_of(scene, realised), store=store)
    comparison = compare(scene, realised, results, accurate=_reached(folder))
    if pictures is None:
        pictures = scene.run.pictures or any(folder.glob("figures/*.png"))
    page, files = write_outputs(comparison, results, prepare_folder(folder), pictures=pictures)
    return Outputs(
        comparison=comparison, page=page, folder=folder, files=files, solved=0, reused=len(results)
    )


def _reached(folder: Path) -> dict[str, Any] | None:
    """Return what a run to an accuracy reached; None for a plain run."""
    try:
        found = json.loads((folder / ACCURACY_FILE).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        raise UsageError(f"{folder / ACCURACY_FILE}: cannot be read; run the scene again") from None
    return dict(found)


def _without_solver(scene: Scene, realised: Realised, folder: Path, *, report: bool = True) -> Outputs:
    """Evaluate the theory, which takes a second, and write what it says."""
    found = theory_alone.answer_alone(scene, realised)
    page, files = theory_alone.write_outputs(found, folder, report=report)
    return Outputs(comparison=found, page=page, folder=folder, files=files, solved=0, reused=0)


def _record(scene: Scene, folder: Path, store: Store) -> None:
    """Write down what the folder is a run of, so that its report can be made again without the scene file.

    A report of something else goes first: if this run is interrupted, nothing in the folder belies it.
    """
    said = {
        "format": _RUN_FORMAT,
        "scene": scene.model_dump(mode="json", exclude_none=True),
        "store": os.path.relpath(store.folder.resolve(), folder.resolve()),
    }
    path = folder / _RUN_FILE
    if not (path.exists() and path.read_bytes() == json_text(record_of(said)).encode()):
        clear_page(folder)
    for other in ("study.json", "sweep.json"):
        if (folder / other).exists():  # of which the dataset was, too
            (folder / "data.nc").unlink(missing_ok=True)
            (folder / other).unlink()
    write_record(path, said)


def load_run(folder: Path) -> tuple[Scene, Store]:
    """Return the scene and the store of the run in a folder.

    Raises
    ------
    UsageError
        When the folder holds none.
    """
    path = folder / _RUN_FILE
    try:
        said = read_record(path)
        if said["format"] != _RUN_FORMAT:
            raise ValueError
        scene = Scene.model_validate(said["scene"])
        return scene, Store(folder=(folder / said["store"]).resolve())
    except OSError as error:
        raise UsageError(
            f"{folder}: holds no run ({_RUN_FILE}: {error.strerror}); name a results folder"
        ) from None
    except (ValueError, KeyError, TypeError):
        raise UsageError(f"{path}: is not the record of a run of this version; run the scene again") from None
